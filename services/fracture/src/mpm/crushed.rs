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
mod sizes;
#[cfg(test)]
mod tests;

use super::lattice::Lattice;
use crate::particles::Particles;
use cullet_fragment::pieces::{Ball, Pieces, Rubble};
use cullet_geometry::Vec3;
use cullet_geometry::math::{scramble, unit};
use cullet_model::{Material, Tolerance};
use division::Division;
use sizes::Mott;

/// Points by weight that make a node part of the body ...
const LEAST_WEIGHT: f64 = 2.0;

/// ... and those of a full one.
const FULL_WEIGHT: f64 = 8.0;

/// Below this sum of what is missing around a node, in weights times cells, it is inside.
const EVEN: f64 = 60.0;

/// Fewest points of a piece that the solve resolves: those of a cell (F32).
pub const LEAST_POINTS: usize = 8;

/// Points by weight that a drawn piece's middle needs around it: none is put outside the body.
const MIDDLE_WEIGHT: f64 = 4.0;

/// Share of a node's points, by weight, in pieces that makes it whole.
const WHOLE_SHARE: f64 = 0.5;

/// Half the width of a crack's band, in cells; a broken node beyond belongs to a crushed zone.
const HALF_BAND: f64 = 2.1;

/// Least mean size of pieces drawn in a crushed zone, in cells over their coarseness: finer is not
/// in the solve (gate 5), and with [`LEAST_SIZE`] at the other end the law has room for masses of
/// 1 to 45 from the tenth percentile to the ninetieth, as rubble has.
const LEAST_MEAN: f64 = 2.6;

/// Greatest size of a drawn piece over the mean: one as wide as two half bands has a middle that no
/// crack's band reaches, and the grid would have found it whole.
const MOST_SIZE: f64 = 2.0 * HALF_BAND / LEAST_MEAN;

/// Least size of a drawn piece, likewise: what the cut's lattice can still give a shape.
const LEAST_SIZE: f64 = 0.7;

/// Share of the pieces that are wanted at most which are drawn and found; cuts make more of them.
const BUDGET: f64 = 0.9;

/// Stream of the seed's numbers.
const STREAM: u64 = 0xf1e5;

/// Cells below the skin to which pieces are plates along it.
const SKIN: f64 = 2.5;

/// What the division needs to know of a material and a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Size of a cell along each axis \[m\].
    pub spacing: Vec3,
    /// What it is made of.
    pub material: Material,
    /// The only source of randomness.
    pub seed: u64,
    /// How true the pieces have to be.
    pub tolerance: Tolerance,
    /// Pieces that are wanted at most.
    pub most: u32,
    /// Unit vector along the push; zero where there is none.
    pub push: Vec3,
}

/// Drops from `pieces` (by id) those too small to be resolved, and divides crushed zones.
#[must_use]
pub fn pieces(particles: &Particles, mut pieces: Vec<Option<u32>>, rules: &Rules) -> Pieces {
    let count = pieces.iter().flatten().max().map_or(0, |&last| last as usize + 1);
    let mut sizes = vec![0; count];
    pieces.iter().flatten().for_each(|&piece| sizes[piece as usize] += 1);
    for piece in &mut pieces {
        *piece = piece.filter(|&piece| sizes[piece as usize] >= LEAST_POINTS);
    }
    let lattice = Lattice::new(&particles.reference, rules.spacing);
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
    let sites = lattice.divide(&mut drawn, &zone, &weights, particles, rules, most);
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
            // Borders between drawn pieces are smooth, not steps from node to node, and the least
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

impl Lattice {
    /// Gives the nodes of crushed zones to pieces drawn at random, which are told: balls of their
    /// sizes, the largest first, each where there is room.
    fn divide(
        &self,
        labels: &mut [Option<u32>],
        zone: &[usize],
        weights: &[f64],
        particles: &Particles,
        rules: &Rules,
        most: f64,
    ) -> Vec<Ball> {
        let mut rates = vec![0.0; self.len()];
        for (x, rate) in particles.reference.iter().zip(&particles.onset_rate) {
            self.visit(x, |node, weight, _| rates[node] += weight * rate);
        }
        let coarseness = rules.tolerance.coarseness();
        let mean = |n: &usize| {
            let size = rules.material.fragment_size(rates[*n] / weights[*n]);
            (size / self.spacing.max()).max(LEAST_MEAN * coarseness)
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
        let mut division = Division::new(self, order, means, weights, rules);
        for volume in volumes {
            division.put(volume, largest + 2.0);
        }
        division.divided(weights, labels)
    }

    /// Which way is out of the body at the nodes that are near its skin; zero elsewhere.
    fn skin(&self, weights: &[f64]) -> Vec<Vec3> {
        let out = |node: usize| {
            let mut way = Vec3::zeros();
            if weights[node] >= LEAST_WEIGHT {
                self.around(node, SKIN, |near| {
                    let arm = self.at(near) - self.at(node);
                    let within = arm.norm_squared() <= SKIN * SKIN;
                    if within {
                        way += arm * (FULL_WEIGHT - weights[near]).max(0.0);
                    }
                });
            }
            way.try_normalize(EVEN).unwrap_or_default()
        };
        (0..self.len()).map(out).collect()
    }

    /// Calls `visit(node)` for the nodes at most `reach` cells from one, along each axis.
    fn around(&self, node: usize, reach: f64, mut visit: impl FnMut(usize)) {
        let [sx, y, z] = self.size;
        let reach = reach.ceil() as usize;
        let range = |at: usize, size: usize| at.saturating_sub(reach)..size.min(at + reach + 1);
        for i in range(node / (y * z), sx) {
            for j in range(node / z % y, y) {
                for k in range(node % z, z) {
                    visit((i * y + j) * z + k);
                }
            }
        }
    }

    /// Nodes of the body farther than half a band from any whole node.
    fn crushed(&self, weights: &[f64], whole: &[bool]) -> Vec<usize> {
        let reach = HALF_BAND.floor() as i32 + 1;
        let [_, y, z] = self.size;
        let near: Vec<[i32; 3]> = (0..(2 * reach + 1).pow(3))
            .map(|o| {
                let side = 2 * reach + 1;
                [o / (side * side) - reach, o / side % side - reach, o % side - reach]
            })
            .filter(|d| f64::from(d.iter().map(|c| c * c).sum::<i32>()) <= HALF_BAND * HALF_BAND)
            .collect();
        let holds = |n: usize, d: &[i32; 3]| {
            let place = [n / (y * z), n / z % y, n % z];
            let at: [i32; 3] = std::array::from_fn(|a| place[a] as i32 + d[a]);
            if (0..3).any(|a| at[a] < 0 || at[a] >= self.size[a] as i32) {
                return false;
            }
            let other = (at[0] as usize * y + at[1] as usize) * z + at[2] as usize;
            whole[other]
        };
        (0..self.len())
            .filter(|&n| weights[n] >= LEAST_WEIGHT && !whole[n])
            .filter(|&n| !near.iter().any(|d| holds(n, d)))
            .collect()
    }

    /// Where a node is, in cells, moved a little so that no two distances are equal.
    fn place(&self, n: usize, seed: u64) -> Vec3 {
        let off = |axis: u64| unit(seed, STREAM + axis, n as u64) - 0.5;
        self.at(n) + Vec3::new(off(0), off(1), off(2))
    }
}
