//! What becomes of zones where cracks ran closer than the grid can tell.
//!
//! Farther from any whole piece than half a crack's band no single crack explains the damage. Such
//! a zone is divided at random: the strain rate at the onset of damage asks for the mean size
//! (gate 5), around it masses follow Mott's law, N(>m) = N₀ exp(−√(m/μ)) (G2), from the least that
//! can be given a shape to the greatest that the grid would not have found whole. More pieces than
//! are wanted are fewer and larger from the start: were the smallest joined to their neighbours,
//! all would come to one size. Near the skin pieces are plates along it, as a reflected wave spalls
//! them off; inside they are splinters along the push. Nothing parts that did not break.

mod division;
mod rules;
mod sizes;
#[cfg(test)]
mod tests;
mod zones;

pub use rules::CrushRules;

use super::lattice::KernelLattice;
use crate::particles::Particles;
use cullet_fragment::pieces::{Ball, Pieces, Rubble};
use cullet_geometry::math::scramble;
use division::Division;
use rules::{HALF_BAND, LEAST_SIZE, LEAST_WEIGHT, STREAM};
use sizes::Mott;

/// Fewest points of a piece that the solve resolves: those of a cell (F32).
pub const LEAST_POINTS: usize = 8;

/// Share of a node's points, by weight, in pieces that makes it whole.
const WHOLE_SHARE: f64 = 0.5;

/// Least mean size of pieces sampled in a crushed zone, in cells over their coarseness: finer is
/// not in the solve (gate 5), and with [`LEAST_SIZE`] at the other end the law has room for masses
/// of 1 to 45 from the tenth percentile to the ninetieth, as rubble has.
const LEAST_MEAN: f64 = 2.6;

/// Greatest size of a sampled piece over the mean: one as wide as two half bands has a middle that
/// no crack's band reaches, and the grid would have found it whole.
const MOST_SIZE: f64 = 2.0 * HALF_BAND / LEAST_MEAN;

/// Share of the pieces that are wanted at most which are sampled and found; cuts make more of them.
const BUDGET: f64 = 0.9;

/// Drops from `pieces` (by id) those too small to be resolved, and divides crushed zones.
#[must_use]
pub fn pieces(particles: &Particles, mut pieces: Vec<Option<u32>>, rules: &CrushRules) -> Pieces {
    let count = pieces.iter().flatten().max().map_or(0, |&last| last as usize + 1);
    let mut sizes = vec![0; count];
    pieces.iter().flatten().for_each(|&piece| sizes[piece as usize] += 1);
    for piece in &mut pieces {
        *piece = piece.filter(|&piece| sizes[piece as usize] >= LEAST_POINTS);
    }
    let lattice = KernelLattice::new(&particles.reference, rules.spacing);
    let (mut weights, mut held) = (vec![0.0; lattice.len()], vec![0.0; lattice.len()]);
    for (x, &id) in particles.reference.iter().zip(&particles.id) {
        let share = f64::from(u8::from(pieces[id as usize].is_some()));
        lattice.visit(x, |node, weight, _| {
            weights[node] += weight;
            held[node] += weight * share;
        });
    }
    let whole: Vec<bool> = weights
        .iter()
        .zip(&held)
        .map(|(w, h)| *w >= LEAST_WEIGHT && *h >= WHOLE_SHARE * w)
        .collect();
    let zone = lattice.crushed(&weights, &whole);
    let mut drawn = vec![None; lattice.len()];
    let whole_pieces = sizes.iter().filter(|&&size| size >= LEAST_POINTS).count();
    let most = (BUDGET * f64::from(rules.most) - whole_pieces as f64).max(2.0);
    let sites = divide(&lattice, &mut drawn, &zone, &weights, particles, rules, most);
    if sites.len() < 2 && count > 0 {
        let found = count as u32;
        return Pieces { of: pieces, found, tolerance: rules.tolerance, ..Pieces::default() };
    }
    let mut beside = vec![Vec::new(); lattice.len()];
    for (ball, k) in sites.iter().zip(0..) {
        let place = ball.place.component_mul(&rules.spacing);
        lattice.visit(&place, |node, _, _| beside[node].push(k));
    }
    let rubble = Rubble::new(sites, rules.seed);
    for (x, &id) in particles.reference.iter().zip(&particles.id) {
        let (mut most, mut near) = ((0.0, 0), Vec::new());
        lattice.visit(x, |node, weight, _| {
            if weights[node] >= LEAST_WEIGHT && weight > most.0 {
                most = (weight, node);
            }
            near.extend(drawn[node]);
        });
        if pieces[id as usize].is_none() && drawn[most.1].is_some() {
            // Borders between sampled pieces are smooth, not steps from node to node, and the least
            // pieces lie between nodes.
            near.extend(&beside[most.1]);
            let at = x.component_div(&rules.spacing);
            pieces[id as usize] = rubble.nearest(near, &at).map(|ball| count as u32 + ball);
        }
    }
    let all = weights.iter().filter(|&&w| w >= LEAST_WEIGHT).count();
    let crushed = zone.len() as f64 / all.max(1) as f64;
    Pieces { of: pieces, found: count as u32, rubble, crushed, tolerance: rules.tolerance }
}

/// Gives the nodes of crushed zones to pieces sampled at random, which it returns: balls of their
/// sizes, the largest first, each where there is room.
fn divide(
    lattice: &KernelLattice,
    labels: &mut [Option<u32>],
    zone: &[usize],
    weights: &[f64],
    particles: &Particles,
    rules: &CrushRules,
    most: f64,
) -> Vec<Ball> {
    let mut rates = vec![0.0; lattice.len()];
    for (x, rate) in particles.reference.iter().zip(&particles.onset_rate) {
        lattice.visit(x, |node, weight, _| rates[node] += weight * rate);
    }
    let coarseness = rules.tolerance.coarseness();
    let mean = |n: &usize| {
        let size = rules.material.fragment_size(rates[*n] / weights[*n]);
        (size / lattice.spacing.max()).max(LEAST_MEAN * coarseness)
    };
    let mut order = zone.to_vec();
    order.sort_unstable_by_key(|&n| (scramble(scramble(rules.seed ^ STREAM) ^ n as u64), n));
    let mut means: Vec<f64> = order.iter().map(mean).collect();
    let mut count: f64 = means.iter().map(|mean| 1.0 / (mean * mean * mean)).sum();
    // Volumes are over the mean of where they end up; the least is over the mean of all.
    let least = LEAST_SIZE * coarseness;
    let share = least * least * least / means.len().max(1) as f64;
    let law = |count: f64| Mott::new(share * count, MOST_SIZE * MOST_SIZE * MOST_SIZE);
    let total = count / law(count).mean();
    if total > most {
        let larger = libm::cbrt(total / most);
        means.iter_mut().for_each(|mean| *mean *= larger);
        count *= most / total;
    }
    let law = law(count);
    let volumes = law.volumes((count / law.mean()).clamp(1.0, most) as usize, rules.seed);
    let largest = means.iter().copied().fold(least, f64::max) * libm::cbrt(volumes[0].max(1.0));
    let mut division = Division::new(lattice, order, means, weights, rules);
    for volume in volumes {
        division.put(volume, largest + 2.0);
    }
    division.divided(weights, labels)
}
