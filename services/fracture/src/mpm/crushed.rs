//! What becomes of zones where cracks ran closer than the grid can tell.
//!
//! Farther from any whole piece than half a crack's band no single crack explains the damage. Such
//! a zone is divided at random: the strain rate at the onset of damage asks for the mean size
//! (gate 5), around it masses follow Mott's law, N(>m) = N₀ exp(−√(m/μ)) (G2). Nothing parts that
//! did not break.

use super::lattice::Lattice;
use crate::material::Material;
use crate::particles::Particles;
use crate::pieces::{Ball, Pieces, Rubble};
use crate::tolerance::Tolerance;
use cullet_geometry::Vec3;
use cullet_geometry::math::{scramble, unit};

/// Points by weight that make a node part of the body; a full one has 8.
const LEAST_WEIGHT: f64 = 2.0;

/// Fewest points of a piece that the solve resolves: those of a cell (F32).
pub const LEAST_POINTS: usize = 8;

/// Share of a node's points, by weight, in pieces that makes it whole.
const WHOLE_SHARE: f64 = 0.5;

/// Half the width of a crack's band, in cells; a broken node beyond belongs to a crushed zone.
const HALF_BAND: f64 = 2.1;

/// Least mean size of pieces drawn in a crushed zone, in cells over their coarseness: finer is not
/// in the solve (gate 5).
const LEAST_MEAN: f64 = 1.15;

/// Least size of a drawn piece, likewise: what the cut's lattice can still give a shape.
const LEAST_SIZE: f64 = 0.85;

/// Volume of the cubes of the sizes of drawn pieces over that of their zone: balls of these
/// diameters still find room, put down one by one.
const FILLING: f64 = 0.65;

/// Stream of the seed's numbers.
const STREAM: u64 = 0xf1e5;

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
    let sites = lattice.divide(&mut drawn, &zone, &weights, particles, rules);
    if sites.len() < 2 && count > 0 {
        let found = count as u32;
        return Pieces { of: pieces, found, tolerance: rules.tolerance, ..Pieces::default() };
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
            // Borders between drawn pieces are smooth, not steps from node to node.
            let at = x.component_div(&rules.spacing);
            pieces[id as usize] = rubble.nearest(near, &at).map(|ball| count as u32 + ball);
        }
    }
    let all = weights.iter().filter(|&&w| w >= LEAST_WEIGHT).count();
    let crushed = zone.len() as f64 / all.max(1) as f64;
    Pieces { of: pieces, found: count as u32, rubble, crushed, tolerance: rules.tolerance }
}

/// Sizes over the mean whose cubes follow Mott's law, N(>m) = N₀ exp(−√(m/μ)) with a mean of 2μ,
/// the largest first.
fn mott(count: usize, seed: u64) -> Vec<f64> {
    let size = |k: usize| {
        let log = libm::log(1.0 - unit(seed, STREAM + 3, k as u64));
        libm::cbrt(0.5 * log * log)
    };
    let mut sizes: Vec<f64> = (0..count).map(size).collect();
    sizes.sort_unstable_by(|a, b| b.total_cmp(a));
    sizes
}

/// A zone that is being divided.
struct Division<'a> {
    lattice: &'a Lattice,
    seed: u64,
    /// Its nodes, in the order in which they are tried.
    order: Vec<usize>,
    /// Mean size asked for at each of them, in cells.
    means: Vec<f64>,
    /// Where in `order` each node of the lattice stands.
    rank: Vec<Option<u32>>,
    /// Diameter of the largest ball that has room around each.
    room: Vec<f64>,
    /// Power distance and number of the nearest site of each.
    nearest: Vec<(f64, Option<u32>)>,
    sites: Vec<Ball>,
    /// Of the least \[cells\].
    least: f64,
}

impl<'a> Division<'a> {
    fn new(lattice: &'a Lattice, order: Vec<usize>, means: Vec<f64>, rules: &Rules) -> Self {
        let mut rank = vec![None; lattice.len()];
        order.iter().zip(0..).for_each(|(&n, k)| rank[n] = Some(k));
        let count = order.len();
        let (room, nearest) = (vec![f64::INFINITY; count], vec![(f64::INFINITY, None); count]);
        let (seed, least) = (rules.seed, LEAST_SIZE * rules.tolerance.coarseness());
        Self { lattice, seed, order, means, rank, room, nearest, sites: Vec::new(), least }
    }

    /// Puts a ball at the first node that has room for one of its mean size times `factor`.
    fn put(&mut self, factor: f64, reach: f64) {
        let size = |k: usize| (self.means[k] * factor).max(self.least);
        let Some(first) = (0..self.order.len()).find(|&k| self.room[k] >= size(k)) else {
            return;
        };
        let (node, size) = (self.order[first], size(first));
        let site = Ball { place: self.lattice.place(node, self.seed), size };
        let number = self.sites.len() as u32;
        let (lattice, seed) = (self.lattice, self.seed);
        lattice.around(node, reach, |near| {
            let Some(k) = self.rank[near].map(|k| k as usize) else {
                return;
            };
            let place = lattice.place(near, seed);
            self.room[k] = self.room[k].min(2.0 * (site.place - place).norm() - size);
            let far = site.far(&place);
            if far < self.nearest[k].0 {
                self.nearest[k] = (far, Some(number));
            }
        });
        self.sites.push(site);
    }

    /// The nearest site of each node. A site that did not look as far as a node is at least
    /// `reach` less half a cell's jitter away.
    fn labels(&self, reach: f64, labels: &mut [Option<u32>]) {
        let largest = self.sites.iter().map(|site| site.size).fold(0.0, f64::max);
        let sure = (reach - 1.0).powi(2) - 0.25 * largest * largest;
        for (&n, &(far, site)) in self.order.iter().zip(&self.nearest) {
            labels[n] = if far <= sure { site } else { self.search(n) };
        }
    }

    fn search(&self, node: usize) -> Option<u32> {
        let x = self.lattice.place(node, self.seed);
        let far = |site: u32| self.sites[site as usize].far(&x);
        (0..self.sites.len() as u32).min_by(|&a, &b| far(a).total_cmp(&far(b)))
    }
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
    ) -> Vec<Ball> {
        let mut rates = vec![0.0; self.len()];
        for (x, rate) in particles.reference.iter().zip(&particles.onset_rate) {
            self.visit(x, |node, weight, _| rates[node] += weight * rate);
        }
        let least = LEAST_MEAN * rules.tolerance.coarseness();
        let mean = |n: &usize| {
            let size = rules.material.fragment_size(rates[*n] / weights[*n]);
            (size / self.spacing.max()).max(least)
        };
        let mut order = zone.to_vec();
        order.sort_unstable_by_key(|&n| (scramble(scramble(rules.seed ^ STREAM) ^ n as u64), n));
        let means: Vec<f64> = order.iter().map(mean).collect();
        let count = FILLING * means.iter().map(|mean| 1.0 / (mean * mean * mean)).sum::<f64>();
        let factors = mott((count as usize).max(1), rules.seed);
        let largest = means.iter().copied().fold(0.0, f64::max) * factors[0];
        let mut division = Division::new(self, order, means, rules);
        let reach = largest.max(division.least) + 2.0;
        for factor in factors {
            division.put(factor, reach);
        }
        division.labels(reach, labels);
        division.sites
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

#[cfg(test)]
mod tests {
    use super::{LEAST_SIZE, Lattice, Rules, Tolerance, mott, pieces};
    use crate::material::Material;
    use crate::particles::Particles;
    use crate::pieces::{Ball, Pieces};
    use cullet_geometry::Vec3;

    /// Fragments are finer than a cell at any rate.
    const CHALK: Material = Material {
        density: 1000.0,
        young: 1e9,
        poisson: 0.2,
        failure_stress: 1e6,
        fracture_energy: 1.0,
    };
    const RULES: Rules = Rules {
        spacing: Vec3::new(1.0, 1.0, 1.0),
        material: CHALK,
        seed: 5,
        tolerance: Tolerance(None),
    };

    /// A bar of 20 × 6 × 6 cells, eight points a cell; `piece` says what a point belongs to.
    fn bar(piece: impl Fn(&Vec3) -> Option<u32>) -> (Vec<Vec3>, Pieces) {
        asked_of_bar(None, piece)
    }

    /// Where an error is good enough.
    fn asked_of_bar(
        error: Option<f64>,
        piece: impl Fn(&Vec3) -> Option<u32>,
    ) -> (Vec<Vec3>, Pieces) {
        let point = |i: usize| {
            let at = Vec3::new((i / 144) as f64, (i / 12 % 12) as f64, (i % 12) as f64);
            (at + Vec3::repeat(0.5)) * 0.5 - Vec3::new(10.0, 3.0, 3.0)
        };
        let points: Vec<Vec3> = (0..40 * 144).map(point).collect();
        let mut particles = Particles::at_rest(&points, 720.0, 1.0);
        particles.onset_rate.fill(10.0);
        let rules = Rules { tolerance: Tolerance(error), ..RULES };
        let found = pieces(&particles, points.iter().map(&piece).collect(), &rules);
        (points, found)
    }

    #[test]
    fn the_band_of_a_crack_is_not_a_crushed_zone() {
        let sides = |x: &Vec3| (x.x.abs() > 1.6).then(|| u32::from(x.x > 0.0));
        let (points, found) = bar(sides);
        assert_eq!((found.rubble.balls.len(), found.crushed), (0, 0.0));
        assert!(points.iter().zip(&found.of).all(|(x, piece)| *piece == sides(x)));
    }

    #[test]
    fn crumbs_are_no_pieces() {
        let crumb = |x: &Vec3| Some(u32::from((x - Vec3::repeat(0.5)).amax() < 0.6));
        let (_, found) = bar(|x| crumb(x).filter(|&p| p == 0 || x.z > 0.4));
        assert!(found.of.iter().flatten().all(|&piece| piece == 0));
    }

    #[test]
    fn a_crushed_end_is_divided() {
        let (points, found) = bar(|x| (x.x > 0.0).then_some(0));
        assert!(found.rubble.balls.len() > 4, "{found:?}");
        assert!((found.crushed - 0.42).abs() < 0.15, "{}", found.crushed);
        for (x, piece) in points.iter().zip(&found.of) {
            match piece {
                Some(0) => assert!(x.x > 0.0),
                Some(_) => assert!(x.x < -1.0, "{x}"),
                None => assert!((-3.5..0.0).contains(&x.x), "{x}"),
            }
        }
        assert_eq!(found, bar(|x| (x.x > 0.0).then_some(0)).1);
    }

    #[test]
    fn a_body_that_is_crushed_whole_is_divided_whole() {
        let (_, found) = bar(|_| None);
        assert!(found.rubble.balls.len() > 10 && found.of.iter().all(Option::is_some));
        assert_eq!(found.crushed, 1.0);
    }

    /// G2: Mott's law has a share of 1 − e^(−√2) of its pieces below the mean mass, and half of
    /// all mass in the heaviest 1 − (1 + x + x²/2) e^(−x) = ½ at x = √(m/μ) = 2.674.
    #[test]
    fn drawn_sizes_follow_mott() {
        let masses: Vec<f64> = mott(40_000, 3).iter().map(|size| size * size * size).collect();
        let mean = masses.iter().sum::<f64>() / masses.len() as f64;
        assert!((mean - 1.0).abs() < 0.03, "{mean}");
        let below = masses.iter().filter(|&&m| m < 1.0).count() as f64 / masses.len() as f64;
        assert!((below - 0.7569).abs() < 0.01, "{below}");
        let half = 0.5 * 2.674 * 2.674;
        let heavy: f64 = masses.iter().filter(|&&m| m > half).sum();
        assert!((heavy / masses.iter().sum::<f64>() - 0.5).abs() < 0.02, "{heavy}");
    }

    /// Pieces drawn in a crushed zone are of many sizes, as those of real rubble are.
    #[test]
    fn drawn_pieces_are_large_and_small() {
        let (_, found) = bar(|_| None);
        let mut points = vec![0.0; found.rubble.balls.len()];
        found.of.iter().flatten().for_each(|&piece| points[piece as usize] += 1.0);
        let mean = points.iter().sum::<f64>() / points.len() as f64;
        let variance = points.iter().map(|n| (n - mean).powi(2)).sum::<f64>() / points.len() as f64;
        assert!(variance.sqrt() > 0.6 * mean, "{} around {mean}", variance.sqrt());
        // Borders are bent: a small piece at the edge may be left without a point.
        let empty = points.iter().filter(|&&n| n == 0.0).count();
        assert!(empty * 25 < points.len(), "{empty} of {} without a point", points.len());
    }

    /// An error buys fewer and larger pieces, as many lattice nodes across: 1.6³ in the mean.
    #[test]
    fn an_error_draws_larger_pieces() {
        let drawn = |error| asked_of_bar(error, |_| None).1.rubble.balls;
        let (fine, coarse) = (drawn(None), drawn(Some(0.5)));
        let ratio = fine.len() as f64 / coarse.len() as f64;
        assert!((3.0..5.5).contains(&ratio), "{} and {}", fine.len(), coarse.len());
        let least = |balls: &[Ball]| balls.iter().map(|b| b.size).fold(f64::INFINITY, f64::min);
        assert_eq!((least(&fine), least(&coarse)), (LEAST_SIZE, LEAST_SIZE * 1.6));
        assert_eq!(drawn(Some(1.0)), coarse);
    }

    /// The pieces are those of all sites, though each looks at the nodes around it only.
    #[test]
    fn every_node_goes_to_the_nearest_of_all_sites() {
        let points: Vec<Vec3> = (0..30 * 30 * 30)
            .map(|i| Vec3::new((i / 900) as f64, (i / 30 % 30) as f64, (i % 30) as f64) * 0.5)
            .collect();
        let mut particles = Particles::at_rest(&points, 3375.0, 1.0);
        // One corner asks for pieces of many cells.
        for (rate, x) in particles.onset_rate.iter_mut().zip(&points) {
            *rate = if x.amax() < 5.0 { 1e-2 } else { 10.0 };
        }
        let lattice = Lattice::new(&points, RULES.spacing);
        let (weights, zone) = (vec![8.0; lattice.len()], (0..lattice.len()).collect::<Vec<_>>());
        let mut labels = vec![None; lattice.len()];
        let sites = lattice.divide(&mut labels, &zone, &weights, &particles, &RULES);
        assert!(sites.len() > 100 && sites[0].size > 3.0 * sites[sites.len() / 2].size);
        for (n, label) in labels.iter().enumerate() {
            let x = lattice.place(n, RULES.seed);
            let far = |site: u32| sites[site as usize].far(&x);
            let nearest = (0..sites.len() as u32).min_by(|&a, &b| far(a).total_cmp(&far(b)));
            assert_eq!(*label, nearest);
        }
        for (k, one) in sites.iter().enumerate() {
            for two in &sites[..k] {
                let room = (one.place - two.place).norm() - 0.5 * (one.size + two.size);
                assert!(room > -1e-9, "two balls overlap by {}", -room);
            }
        }
    }
}
