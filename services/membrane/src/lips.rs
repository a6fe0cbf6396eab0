//! Points of a sheet that touch each other: those far apart at rest, or parted by a crack. They
//! repel below a distance. That keeps folds and lips apart and piles from collapsing; it does not
//! stop a fast sheet from going through itself.

use crate::bonds::MembraneBonds;
use crate::vector::length;
use cullet_geometry::Vec3;
use cullet_model::SheetPlace;

/// Distance below which points repel, in spacings, where the sheet is thinner. With 0.7 a point of
/// one layer sinks into the gap between four of another: half the diagonal of a square is 0.71.
const REACH: f64 = 1.0;
/// Points nearer than this at rest, in spacings, repel only where a crack has parted them.
const NEAR: f64 = 2.0;
/// Stiffness by μ/dt², μ being the reduced mass: ωdt is 0.45.
const PENALTY: f64 = 0.2;

/// How far beyond what they need pairs are found, in spacings, so that they last.
const SLACK: f64 = 0.3;

/// Pairs of points that may touch, by point, each from both sides.
#[derive(Clone, Debug, Default)]
pub(crate) struct LipPairs {
    starts: Vec<u32>,
    pairs: Vec<LipPair>,
    /// Where points were when pairs were found, and how much nearer they may have come since \[m\].
    found_at: Vec<Vec3>,
    margin: f64,
}

#[derive(Clone, Copy, Debug)]
struct LipPair {
    other: u32,
    /// Distance below which they repel \[m\].
    distance: f64,
    /// \[N/m\].
    stiffness: f64,
}

/// What pairs are found from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LipSearch<'a> {
    pub(crate) bonds: &'a MembraneBonds,
    pub(crate) reference: &'a [SheetPlace],
    pub(crate) places: &'a [Vec3],
    pub(crate) masses: &'a [[f64; 2]],
    /// d of each bond.
    pub(crate) damage: &'a [f64],
    /// Points that touch nothing.
    pub(crate) gone: &'a [bool],
    pub(crate) spacing: f64,
    pub(crate) thickness: f64,
    /// How far two points may come closer until pairs may be found again \[m\].
    pub(crate) margin: f64,
    pub(crate) dt: f64,
}

impl LipPairs {
    /// Whether points may come nearer than those that were found, if two of them come closer by
    /// `margin` \[m\] from now on.
    pub(crate) fn are_due(&self, places: &[Vec3], margin: f64) -> bool {
        let moved = || places.iter().zip(&self.found_at).map(|(x, before)| x - before);
        let mean = moved().sum::<Vec3>() / places.len() as f64;
        let farthest = moved().map(|off| (off - mean).norm_squared()).fold(0.0, f64::max);
        2.0 * farthest.sqrt() + margin > self.margin
    }

    /// Finds pairs anew.
    pub(crate) fn find(&mut self, search: &LipSearch<'_>) {
        let touching = search.thickness.max(REACH * search.spacing);
        self.margin = search.margin + SLACK * search.spacing;
        self.found_at.clear();
        self.found_at.extend_from_slice(search.places);
        let reach = touching + self.margin;
        let hash = SpaceHash::new(search.places, reach);
        self.starts.clear();
        self.pairs.clear();
        self.starts.push(0);
        let mut near = Vec::new();
        for i in 0..search.places.len() {
            near.clear();
            if search.gone[i] {
                self.starts.push(self.pairs.len() as u32);
                continue;
            }
            hash.around(search.places[i], |j| {
                let off = search.places[j as usize] - search.places[i];
                if j as usize != i && !search.gone[j as usize] && off.norm_squared() < reach * reach
                {
                    near.push(j);
                }
            });
            near.sort_unstable();
            for &j in &near {
                if let Some(pair) = search.pair(i, j as usize, touching) {
                    self.pairs.push(pair);
                }
            }
            self.starts.push(self.pairs.len() as u32);
        }
    }

    /// Whether no points touch.
    pub(crate) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    fn of(&self, i: usize) -> &[LipPair] {
        match self.pairs.is_empty() {
            true => &[],
            false => &self.pairs[self.starts[i] as usize..self.starts[i + 1] as usize],
        }
    }

    /// Force of others on a point, and the part of it that is from frozen ones \[N\].
    #[inline(always)]
    pub(crate) fn force(&self, i: usize, places: &[Vec3], frozen: &[bool]) -> (Vec3, Vec3) {
        let (mut force, mut propped) = (Vec3::zeros(), Vec3::zeros());
        for pair in self.of(i) {
            let off = places[pair.other as usize] - places[i];
            let apart = length(&off);
            if apart < pair.distance && apart > 0.0 {
                let push = off * (pair.stiffness * (pair.distance - apart) / apart);
                force -= push;
                if frozen[pair.other as usize] {
                    propped -= push;
                }
            }
        }
        (force, propped)
    }

    /// Pairs of points that press on each other, each once.
    pub(crate) fn pressed(&self, places: &[Vec3]) -> Vec<[u32; 2]> {
        let presses = |i: usize, pair: &LipPair| {
            pair.other as usize > i
                && (places[pair.other as usize] - places[i]).norm() < pair.distance
        };
        let of = |i: usize| {
            let own = self.of(i).iter().filter(move |pair| presses(i, pair));
            own.map(move |pair| [i as u32, pair.other])
        };
        (0..places.len()).flat_map(of).collect()
    }

    /// Energy of all pairs \[J\].
    pub(crate) fn energy(&self, places: &[Vec3]) -> f64 {
        let of = |i: usize| {
            let pressed = |pair: &LipPair| {
                let length = (places[pair.other as usize] - places[i]).norm();
                let depth = (pair.distance - length).max(0.0);
                0.25 * pair.stiffness * depth * depth
            };
            self.of(i).iter().map(pressed).sum::<f64>()
        };
        (0..places.len()).map(of).sum()
    }
}

impl LipSearch<'_> {
    fn pair(&self, i: usize, j: usize, touching: f64) -> Option<LipPair> {
        let (a, b) = (self.reference[i], self.reference[j]);
        let rest = ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])).sqrt();
        if rest <= NEAR * self.spacing {
            let own = self.bonds.of(i);
            if let Ok(slot) = self.bonds.ends[own.clone()].binary_search(&(j as u32))
                && self.damage[own.start + slot] < 1.0
            {
                return None;
            }
        }
        let (m, n) = (self.masses[i][1], self.masses[j][1]);
        let stiffness = PENALTY * (m * n / (m + n)) / (self.dt * self.dt);
        // Lips of a crack are pressed apart only where they overlap.
        Some(LipPair { other: j as u32, distance: touching.min(rest), stiffness })
    }
}

/// Points sorted by the cell of space that they are in.
struct SpaceHash {
    width: f64,
    low: Vec3,
    /// Key and number of each, rising.
    sorted: Vec<([i32; 3], u32)>,
}

impl SpaceHash {
    fn new(places: &[Vec3], width: f64) -> Self {
        let low = places.iter().fold(Vec3::from([f64::INFINITY; 3]), |low, p| low.inf(p));
        let mut hash = Self { width, low, sorted: Vec::new() };
        hash.sorted = places.iter().enumerate().map(|(i, p)| (hash.key(p), i as u32)).collect();
        hash.sorted.sort_unstable();
        hash
    }

    fn key(&self, p: &Vec3) -> [i32; 3] {
        // A place that has run away is found with the farthest.
        let at = ((p - self.low) / self.width).map(|c| c.clamp(-1e9, 1e9));
        [at.z as i32, at.y as i32, at.x as i32]
    }

    /// All points in the cells around a place.
    fn around(&self, place: Vec3, mut f: impl FnMut(u32)) {
        let [z, y, x] = self.key(&place);
        for (dz, dy) in (-1..=1).flat_map(|dz| (-1..=1).map(move |dy| (dz, dy))) {
            let from = [z + dz, y + dy, x - 1];
            let first = self.sorted.partition_point(|(key, _)| *key < from);
            let last = [z + dz, y + dy, x + 1];
            let row = self.sorted[first..].iter().take_while(|(key, _)| *key <= last);
            row.for_each(|&(_, i)| f(i));
        }
    }
}
