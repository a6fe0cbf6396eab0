//! Balls put down in a zone that is being divided.

use super::rules::{CrushRules, FULL_WEIGHT, LEAST_SIZE, MIDDLE_WEIGHT, STREAM};
use super::sizes::balance;
use crate::mpm::lattice::KernelLattice;
use cullet_fragment::pieces::{Ball, direction};
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use rayon::prelude::*;

/// A plate's thickness over that of a round piece, from the least to the most \[1\].
const PLATE: [f64; 2] = [0.5, 0.8];

/// A splinter's length likewise.
const SPLINTER: [f64; 2] = [1.0, 1.7];

/// How far the direction of a splinter is from the push: as far as this times any direction.
const STRAY: f64 = 0.7;

/// Volume of the cubes of the sizes of sampled pieces over that of their zone: balls of these
/// diameters still find room, put down one by one.
const FILLING: f64 = 0.65;

/// Sizes beyond the least, over it, from which on pieces may be as flat or long as any.
const ROUND: f64 = 1.0;

/// A zone that is being divided.
pub(super) struct Division<'a> {
    lattice: &'a KernelLattice,
    seed: u64,
    /// Its nodes, in the order in which they are tried.
    order: Vec<usize>,
    /// Mean size asked for at each of them, in cells.
    means: Vec<f64>,
    /// Where in `order` each node of the lattice stands.
    rank: Vec<Option<u32>>,
    /// Diameter of the largest ball that has room around each.
    room: Vec<f64>,
    sites: Vec<Ball>,
    /// The volume that each is to have.
    wanted: Vec<f64>,
    /// Of the least \[cells\].
    least: f64,
    /// Out of the body at each node of the lattice that is near its skin; else zero.
    skin: Vec<Vec3>,
    /// Unit vector along the push, or zero, in cells.
    push: Vec3,
}

impl<'a> Division<'a> {
    pub(super) fn new(
        lattice: &'a KernelLattice,
        order: Vec<usize>,
        means: Vec<f64>,
        weights: &[f64],
        rules: &CrushRules,
    ) -> Self {
        let mut rank = vec![None; lattice.len()];
        order.iter().zip(0..).for_each(|(&n, k)| rank[n] = Some(k));
        let inside = |&n: &usize| weights[n] >= MIDDLE_WEIGHT;
        let room = |n| if inside(n) { f64::INFINITY } else { f64::NEG_INFINITY };
        let (room, skin) = (order.iter().map(room).collect(), lattice.skin(weights));
        let (seed, least) = (rules.seed, LEAST_SIZE * rules.tolerance.coarseness());
        let push = rules.push.component_div(&rules.spacing).try_normalize(0.0).unwrap_or_default();
        let (sites, wanted) = (Vec::new(), Vec::new());
        Self { lattice, seed, order, means, rank, room, sites, wanted, least, skin, push }
    }

    /// A ball at a node: a plate along the skin near by, or a splinter along the push.
    fn ball(&self, node: usize, size: f64) -> Ball {
        let place = self.lattice.place(node, self.seed);
        let number = unit(self.seed, STREAM + 4, node as u64);
        // What is hardly seen by the cut's lattice stays round.
        let share = ((size - self.least) / (ROUND * self.least)).clamp(0.0, 1.0);
        let between = |[low, high]: [f64; 2]| 1.0 + share * (low + (high - low) * number - 1.0);
        let skin = self.skin[node];
        if skin != Vec3::zeros() {
            return Ball::drawn_out(place, size, &skin, between(PLATE));
        }
        let stray = direction(self.seed ^ STREAM, node as u64) * STRAY;
        let along = (self.push + stray).try_normalize(0.0).unwrap_or_else(Vec3::x);
        Ball::drawn_out(place, size, &along, between(SPLINTER))
    }

    /// Puts a ball of so many mean volumes at the first node that has room for it. No
    /// two balls are larger than `reach` \[cells\].
    pub(super) fn put(&mut self, factor: f64, reach: f64) {
        let least = self.least * self.least * self.least;
        let volume = |k: usize| {
            let mean = self.means[k];
            (mean * mean * mean * factor).max(least)
        };
        let size = |k: usize| libm::cbrt(FILLING * volume(k));
        let Some(first) = (0..self.order.len()).find(|&k| self.room[k] >= size(k)) else {
            return;
        };
        let (node, size) = (self.order[first], size(first));
        self.wanted.push(volume(first));
        let site = self.ball(node, size);
        let (lattice, seed) = (self.lattice, self.seed);
        lattice.around(node, reach, |near| {
            if let Some(k) = self.rank[near] {
                let apart = (site.place - lattice.place(near, seed)).norm();
                let room = &mut self.room[k as usize];
                *room = room.min(2.0 * apart - size);
            }
        });
        self.sites.push(site);
    }

    /// The balls, and for each node of the lattice which of them it is nearest to, once all have
    /// the volumes that were wanted.
    pub(super) fn divided(mut self, weights: &[f64], labels: &mut [Option<u32>]) -> Vec<Ball> {
        let part = |n: usize| {
            let (at, volume) = (self.lattice.at(n), weights[n] / (8.0 * FULL_WEIGHT));
            (0..8).map(move |k: u32| {
                let off = |bit: u32| if k >> bit & 1 == 0 { -0.25 } else { 0.25 };
                (at + Vec3::new(off(0), off(1), off(2)), volume)
            })
        };
        let samples: Vec<(Vec3, f64)> = self.order.iter().flat_map(|&n| part(n)).collect();
        balance(&mut self.sites, &self.wanted, &samples);
        let found: Vec<Option<u32>> = self.order.par_iter().map(|&n| self.search(n)).collect();
        self.order.iter().zip(found).for_each(|(&n, site)| labels[n] = site);
        self.sites
    }

    fn search(&self, node: usize) -> Option<u32> {
        let x = self.lattice.place(node, self.seed);
        let far = |site: u32| self.sites[site as usize].far(&x);
        (0..self.sites.len() as u32).min_by(|&a, &b| far(a).total_cmp(&far(b)))
    }
}
