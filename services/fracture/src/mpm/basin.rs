//! Where in its wide band a crack runs, and what becomes of a zone that is all bands.
//!
//! One velocity field breaks every point within two spacings of a crack as the crack opens (F17):
//! on a coarse grid the bands fill the body, and what is left undamaged says little about its
//! pieces. But the crack itself broke first. Nodes join from the last broken to the first; two
//! pieces that were large and stood apart for long when they meet stay apart, and the nodes where
//! they meet, the earliest broken of the band, are the crack.
//!
//! Farther from any unbroken node than half a band no single crack explains the damage: cracks ran
//! there closer than the grid can tell. That zone is divided at random into pieces of the size that
//! the strain rate at the onset of damage asks for (gate 5). Nothing parts that did not break.

use super::lattice::Lattice;
use crate::particles::Particles;
use cullet_geometry::Vec3;
use cullet_geometry::math::{scramble, unit};

/// Share of a node's points, by weight, whose breaking breaks the node.
const BROKEN_SHARE: f64 = 0.4;

/// Points by weight that make a node part of the body; a full one has 8.
const LEAST_WEIGHT: f64 = 2.0;

/// Least size of a piece when it meets another, in cells (F32).
pub const LEAST_CELLS: f64 = 8.0;

/// Least time between the last break of a piece and its meeting another, in h/c_s: shorter ones
/// are noise in the order in which the points of one band break.
pub const LEAST_STANDING: f64 = 2.0;

/// A point belongs to a crack when the weights of the two pieces at it differ by less than this:
/// a layer 1.1 spacings thick, which the extraction sees without gaps.
const LEVEL: f64 = 0.7;

/// Half the width of a crack's band, in spacings; beyond, a broken node belongs to a crushed zone.
const HALF_BAND: f64 = 2.1;

/// Least size of a piece drawn in a crushed zone, in spacings: finer is not in the solve (gate 5).
const LEAST_SIZE: f64 = 2.5;

/// Stream of the seed's numbers.
const STREAM: u64 = 0xf1e5;

/// No piece.
const NONE: u32 = u32::MAX;

/// Points per full cell.
const PER_CELL: f64 = 8.0;

/// What the extraction needs to know of a material and a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Size of a cell along each axis \[m\].
    pub spacing: Vec3,
    /// Speed of shear waves \[m/s\].
    pub shear_speed: f64,
    /// G_f/ρ \[J·m/kg\].
    pub toughness: f64,
    /// The only source of randomness.
    pub seed: u64,
}

/// The cracks of a broken body.
#[derive(Clone, Debug, PartialEq)]
pub struct Cracks {
    /// Membership of each point by id: 1 on a crack between two pieces, 0 elsewhere.
    pub membership: Vec<f64>,
    /// Pieces drawn at random in crushed zones.
    pub drawn: usize,
    /// Share of the body in crushed zones \[1\].
    pub crushed: f64,
}

/// Finds the cracks.
#[must_use]
pub fn cracks(particles: &Particles, rules: &Rules) -> Cracks {
    let lattice = Lattice::new(&particles.reference, rules.spacing);
    let (weights, times) = lattice.times(particles);
    let pause = LEAST_STANDING * rules.spacing.max() / rules.shear_speed;
    let mut labels = lattice.labels(&weights, &times, pause);
    let (drawn, crushed) = lattice.divide(&mut labels, &weights, &times, particles, rules);
    let mut membership = vec![0.0; particles.len()];
    for (p, x) in particles.reference.iter().enumerate() {
        let mut near: Vec<(u32, f64)> = Vec::new();
        lattice.visit(x, |node, weight, _| match near.iter_mut().find(|l| l.0 == labels[node]) {
            Some(entry) => entry.1 += weight,
            None if labels[node] != NONE => near.push((labels[node], weight)),
            None => {}
        });
        near.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let total: f64 = near.iter().map(|l| l.1).sum();
        let crosses = near.len() > 1 && near[0].1 - near[1].1 < LEVEL * total;
        membership[particles.id[p] as usize] = f64::from(u8::from(crosses));
    }
    Cracks { membership, drawn, crushed }
}

impl Lattice {
    /// The weight of each node, and when `BROKEN_SHARE` of it was broken.
    fn times(&self, particles: &Particles) -> (Vec<f64>, Vec<f64>) {
        let mut weights = vec![0.0; self.len()];
        let mut order: Vec<usize> = (0..particles.len()).collect();
        let key = |p: usize| (particles.damage_time[p], particles.id[p]);
        order
            .sort_unstable_by(|&a, &b| key(a).0.total_cmp(&key(b).0).then(key(a).1.cmp(&key(b).1)));
        for &p in &order {
            self.visit(&particles.reference[p], |node, weight, _| {
                weights[node] += weight;
            });
        }
        let mut broken = vec![0.0; self.len()];
        let mut times = vec![f64::INFINITY; self.len()];
        for &p in &order {
            let time = particles.damage_time[p];
            if time.is_infinite() {
                break;
            }
            self.visit(&particles.reference[p], |node, weight, _| {
                broken[node] += weight;
                if broken[node] >= BROKEN_SHARE * weights[node] {
                    times[node] = times[node].min(time);
                }
            });
        }
        (weights, times)
    }

    /// The piece of each node; nodes join from the last broken to the first.
    fn labels(&self, weights: &[f64], times: &[f64], pause: f64) -> Vec<u32> {
        let mut order: Vec<u32> =
            (0..self.len() as u32).filter(|&n| weights[n as usize] >= LEAST_WEIGHT).collect();
        order.sort_unstable_by(|&a, &b| {
            times[b as usize].total_cmp(&times[a as usize]).then(a.cmp(&b))
        });
        let mut pieces = Pieces::new(self.len());
        for &node in &order {
            let n = node as usize;
            pieces.raise(n, times[n], weights[n]);
            for other in self.beside(n) {
                if pieces.parent[other] != NONE {
                    pieces.meet(n, other, times[n], pause);
                }
            }
        }
        (0..self.len()).map(|n| pieces.root_or_none(n)).collect()
    }

    /// Gives the nodes of crushed zones to pieces drawn at random; how many, and the zones' share.
    fn divide(
        &self,
        labels: &mut [u32],
        weights: &[f64],
        times: &[f64],
        particles: &Particles,
        rules: &Rules,
    ) -> (usize, f64) {
        let zone = self.crushed(weights, times);
        let all = weights.iter().filter(|&&w| w >= LEAST_WEIGHT).count();
        let mut rates = vec![0.0; self.len()];
        for (x, rate) in particles.reference.iter().zip(&particles.onset_rate) {
            self.visit(x, |node, weight, _| rates[node] += weight * rate);
        }
        // Grady: s = (24 G_f / (ρ ε̇²))^⅓  [gate 5]
        let size = |n: usize| {
            let rate = rates[n] / weights[n];
            let grady = libm::cbrt(24.0 * rules.toughness / (rate * rate).max(f64::MIN_POSITIVE));
            (grady / self.spacing.max()).max(LEAST_SIZE)
        };
        let mut order = zone.clone();
        order.sort_unstable_by_key(|&n| (scramble(scramble(rules.seed ^ STREAM) ^ n as u64), n));
        let mut sites: Vec<(Vec3, f64)> = Vec::new();
        for &n in &order {
            let (x, s) = (self.place(n, rules.seed), size(n));
            if sites.iter().all(|(y, t)| (x - y).norm() >= 0.5 * (s + t)) {
                sites.push((x, s));
            }
        }
        if sites.len() < 2 {
            return (0, 0.0);
        }
        for &n in &zone {
            let x = self.place(n, rules.seed);
            let far = |(y, s): &(Vec3, f64)| (x - y).norm() / s;
            let nearest =
                (0..sites.len()).min_by(|&a, &b| far(&sites[a]).total_cmp(&far(&sites[b])));
            labels[n] = (self.len() + nearest.unwrap_or(0)) as u32;
        }
        (sites.len(), zone.len() as f64 / all.max(1) as f64)
    }

    /// Broken nodes farther than half a band from any node that did not break.
    fn crushed(&self, weights: &[f64], times: &[f64]) -> Vec<usize> {
        let reach = HALF_BAND.floor() as i32 + 1;
        let [_, y, z] = self.size;
        let near: Vec<[i32; 3]> = (0..(2 * reach + 1).pow(3))
            .map(|o| {
                let side = 2 * reach + 1;
                [o / (side * side) - reach, o / side % side - reach, o % side - reach]
            })
            .filter(|d| f64::from(d.iter().map(|c| c * c).sum::<i32>()) <= HALF_BAND * HALF_BAND)
            .collect();
        let whole = |n: usize, d: &[i32; 3]| {
            let place = [n / (y * z), n / z % y, n % z];
            let at: [i32; 3] = std::array::from_fn(|a| place[a] as i32 + d[a]);
            if (0..3).any(|a| at[a] < 0 || at[a] >= self.size[a] as i32) {
                return false;
            }
            let other = (at[0] as usize * y + at[1] as usize) * z + at[2] as usize;
            weights[other] >= LEAST_WEIGHT && times[other].is_infinite()
        };
        (0..self.len())
            .filter(|&n| weights[n] >= LEAST_WEIGHT && times[n].is_finite())
            .filter(|&n| !near.iter().any(|d| whole(n, d)))
            .collect()
    }

    /// Where a node is, in spacings, moved a little so that no two distances are equal.
    fn place(&self, n: usize, seed: u64) -> Vec3 {
        let [_, y, z] = self.size;
        let off = |axis: u64| unit(seed, STREAM + axis, n as u64) - 0.5;
        let at = Vec3::new((n / (y * z)) as f64, (n / z % y) as f64, (n % z) as f64);
        at + Vec3::new(off(0), off(1), off(2)) * 0.5
    }

    fn beside(&self, n: usize) -> impl Iterator<Item = usize> {
        let [_, y, z] = self.size;
        let place = [n / (y * z), n / z % y, n % z];
        let stride = [y * z, z, 1];
        let size = self.size;
        (0..3).flat_map(move |a| {
            let down = (place[a] > 0).then(|| n - stride[a]);
            let up = (place[a] + 1 < size[a]).then(|| n + stride[a]);
            down.into_iter().chain(up)
        })
    }
}

/// Union-find over nodes, with the last break and the size of each piece.
struct Pieces {
    parent: Vec<u32>,
    last: Vec<f64>,
    size: Vec<f64>,
}

impl Pieces {
    fn new(n: usize) -> Self {
        Self { parent: vec![NONE; n], last: vec![0.0; n], size: vec![0.0; n] }
    }

    fn raise(&mut self, n: usize, time: f64, weight: f64) {
        self.parent[n] = n as u32;
        self.last[n] = time;
        self.size[n] = weight;
    }

    fn root(&mut self, mut n: usize) -> usize {
        while self.parent[n] as usize != n {
            self.parent[n] = self.parent[self.parent[n] as usize];
            n = self.parent[n] as usize;
        }
        n
    }

    fn root_or_none(&mut self, n: usize) -> u32 {
        if self.parent[n] == NONE { NONE } else { self.root(n) as u32 }
    }

    /// Joins the pieces of two nodes unless both were large and stood apart for `pause`.
    fn meet(&mut self, a: usize, b: usize, time: f64, pause: f64) {
        let (a, b) = (self.root(a), self.root(b));
        if a == b {
            return;
        }
        let stands = |p: usize| {
            let apart = self.last[p] > time && self.last[p] - time >= pause;
            apart && self.size[p] >= LEAST_CELLS * PER_CELL
        };
        if stands(a) && stands(b) {
            return;
        }
        // The piece that broke last, and was first to rise, keeps its name.
        let a_first = self.last[a] > self.last[b] || (self.last[a] == self.last[b] && a < b);
        let (keep, join) = if a_first { (a, b) } else { (b, a) };
        self.parent[join] = keep as u32;
        self.size[keep] += self.size[join];
    }
}

#[cfg(test)]
mod tests {
    use super::{Cracks, Rules, cracks};
    use crate::particles::Particles;
    use cullet_geometry::Vec3;

    const RULES: Rules =
        Rules { spacing: Vec3::new(1.0, 1.0, 1.0), shear_speed: 1.0, toughness: 1.0, seed: 5 };

    /// A bar of 20 × 6 × 6 cells, eight points a cell; `time` says when a point broke.
    fn bar(time: impl Fn(&Vec3) -> Option<f64>) -> (Particles, Cracks) {
        let point = |i: usize| {
            let at = Vec3::new((i / 144) as f64, (i / 12 % 12) as f64, (i % 12) as f64);
            (at + Vec3::repeat(0.5)) * 0.5 - Vec3::new(10.0, 3.0, 3.0)
        };
        let points: Vec<Vec3> = (0..40 * 144).map(point).collect();
        let mut particles = Particles::at_rest(&points, 720.0, 1.0);
        for (p, x) in points.iter().enumerate() {
            if let Some(t) = time(x) {
                particles.damage[p] = 1.0;
                particles.damage_time[p] = t;
                particles.onset_rate[p] = 10.0;
            }
        }
        let cracks = cracks(&particles, &RULES);
        (particles, cracks)
    }

    fn members<'a>(
        particles: &'a Particles,
        cracks: &'a Cracks,
    ) -> impl Iterator<Item = Vec3> + 'a {
        let pairs = particles.reference.iter().zip(&cracks.membership);
        pairs.filter(|&(_, &c)| c > 0.5).map(|(x, _)| *x)
    }

    #[test]
    fn a_wide_band_is_one_thin_crack_where_it_broke_first() {
        let (particles, cracks) = bar(|x| (x.x.abs() < 1.6).then(|| 1.0 + (x.x - 0.8).abs()));
        let all: Vec<Vec3> = members(&particles, &cracks).collect();
        assert!(all.len() > 144, "{} members", all.len());
        for x in &all {
            assert!((x.x - 0.8).abs() < 1.6, "{x}");
        }
        assert_eq!(cracks.drawn, 0);
    }

    #[test]
    fn what_did_not_break_does_not_part() {
        let (particles, cracks) = bar(|_| None);
        assert_eq!(members(&particles, &cracks).count(), 0);
        // A crack that stops halfway leaves one piece.
        let half = |x: &Vec3| (x.x.abs() < 1.0 && x.y < 0.0).then_some(1.0);
        let (particles, cracks) = bar(half);
        assert_eq!(members(&particles, &cracks).count(), 0);
    }

    /// Two cracks whose bands have grown together: the strip between them stood apart for long.
    #[test]
    fn bands_that_meet_keep_the_piece_between_them() {
        let near = |x: f64| (x + 2.5).abs().min((x - 2.5).abs());
        let (particles, cracks) = bar(|x| (x.x.abs() < 4.0).then(|| 1.0 + 4.0 * near(x.x)));
        let left = members(&particles, &cracks).filter(|x| x.x < -1.0).count();
        let right = members(&particles, &cracks).filter(|x| x.x > 1.0).count();
        assert!(left > 100 && right > 100, "{left} and {right}");
        assert!(members(&particles, &cracks).all(|x| x.x.abs() > 1.0 || cracks.drawn > 0));
    }

    #[test]
    fn a_crushed_end_is_divided() {
        let (particles, cracks) = bar(|x| (x.x < 0.0).then_some(1.0));
        assert!(cracks.drawn > 4, "{cracks:?}");
        assert!((cracks.crushed - 0.45).abs() < 0.15, "{}", cracks.crushed);
        assert!(members(&particles, &cracks).all(|x| x.x < 1.0));
        let again = bar(|x| (x.x < 0.0).then_some(1.0));
        assert_eq!(cracks, again.1);
    }
}
