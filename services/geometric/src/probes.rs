//! Points inside a body that tell, before anything is cut, what a pattern of cells would cost.

use cullet_geometry::Vec3;
use cullet_geometry::inside::Inside;
use cullet_geometry::math::unit;
use cullet_geometry::voronoi::Cells;
use cullet_model::{BrittleProblem, Impact};
use rayon::prelude::*;

/// The body is probed at about this many points: the crack area of a pattern is then known within
/// a few per cent before anything is cut.
pub(super) const PROBES: f64 = 8000.0;
/// Probes along the thinnest extent of a body's box, at least: a plate is seen as a solid.
const PROBES_ACROSS: f64 = 4.0;
/// Most points of the probing lattice, those outside the body included.
const MAX_LATTICE: f64 = 4e6;
/// Cells grow from the impact with a length of this share of the body's size, or twice the contact
/// radius where that is more.
const CORE: f64 = 0.1;
/// Partners looked at for a single cut that the energy can pay for.
const MATES: usize = 64;

/// Points inside the body on a lattice.
pub(super) struct Probes {
    low: Vec3,
    high: Vec3,
    step: Vec3,
    places: Vec<Vec3>,
    /// For each point and axis, the next point along it if that is inside too.
    next: Vec<[Option<u32>; 3]>,
}

impl Probes {
    pub(super) fn new(problem: &BrittleProblem, volume: f64) -> Self {
        let (low, high) = problem.solid.mesh.bounds().unwrap_or_default();
        let extent = high - low;
        let wanted = PROBES.max(8.0 * f64::from(problem.settings.max_fragments));
        let width = libm::cbrt(volume / wanted);
        let mut counts = extent.map(|x| (x / width).max(PROBES_ACROSS).ceil());
        let total = counts.product();
        if total > MAX_LATTICE {
            let scale = libm::cbrt(MAX_LATTICE / total);
            counts = counts.map(|n| (n * scale).max(1.0).floor());
        }
        let dims = [0, 1, 2].map(|k| counts[k] as usize);
        let step = extent.component_div(&counts);
        let inside = Inside::new(&problem.solid.mesh);
        let place = |i: usize| {
            let row = i / dims[0];
            let node = [i % dims[0], row % dims[1], row / dims[1]].map(|n| n as f64 + 0.5);
            low + Vec3::from(node).component_mul(&step)
        };
        let all: Vec<bool> = (0..dims.iter().product::<usize>())
            .into_par_iter()
            .map(|i| inside.contains(place(i)))
            .collect();
        let (mut number, mut places) = (vec![None; all.len()], Vec::new());
        for i in (0..all.len()).filter(|&i| all[i]) {
            number[i] = Some(places.len() as u32);
            places.push(place(i));
        }
        let strides = [1, dims[0], dims[0] * dims[1]];
        let beside = |i: usize, k: usize| {
            let last = (i / strides[k] + 1).is_multiple_of(dims[k]);
            if last { None } else { number[i + strides[k]] }
        };
        let next = (0..all.len()).filter(|&i| all[i]).map(|i| [0, 1, 2].map(|k| beside(i, k)));
        let next = next.collect();
        Self { low, high, step, places, next }
    }

    /// All probes, each moved within its own cell, sampled without replacement with a chance that
    /// falls with the distance r to the nearest impact as 1/(1 + r/r₀)²: the first n of them are
    /// the sites of a pattern of n cells, dense near the impact.
    pub(super) fn sites(&self, problem: &BrittleProblem) -> Vec<Vec3> {
        let size = (self.high - self.low).norm();
        let chance = |p: Vec3| {
            let from = |impact: &Impact| {
                let core = (2.0 * impact.radius).max(CORE * size);
                1.0 + (p - impact.point).norm() / core
            };
            let nearest = problem.impacts.iter().map(from).fold(f64::INFINITY, f64::min);
            1.0 / (nearest * nearest)
        };
        let draw = |(i, &p): (usize, &Vec3)| {
            let at = |stream| unit(problem.seed, stream, i as u64);
            let shift = Vec3::new(at(1) - 0.5, at(2) - 0.5, at(3) - 0.5).component_mul(&self.step);
            // Weighted draw without replacement: order by u^(1/w), u uniform in (0, 1).
            let lot = -libm::log(at(0).max(f64::MIN_POSITIVE)) / chance(p);
            (lot, i, p + shift * 0.98)
        };
        let mut drawn: Vec<(f64, usize, Vec3)> = self.places.iter().enumerate().map(draw).collect();
        drawn.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        drawn.into_iter().map(|(_, _, site)| site).collect()
    }

    /// How many of the sites, in order, make a pattern of no more crack area than `affordable`
    /// \[m²\]: one if not even two do.
    pub(super) fn most_sites(&self, sites: &[Vec3], affordable: f64) -> usize {
        let (mut good, mut bad) = (1, sites.len() + 1);
        while good + 1 < bad {
            let middle = (good + bad) / 2;
            if self.crack_area(&sites[..middle]) <= affordable {
                good = middle;
            } else {
                bad = middle;
            }
        }
        good
    }

    /// The first site that shares an affordable crack with site 0: a single cut, where the first
    /// two sites lie so that their cut is a long one.
    pub(super) fn cheap_mate(&self, sites: &[Vec3], affordable: f64) -> Option<usize> {
        let mates = 2..sites.len().min(MATES);
        mates.into_iter().find(|&mate| self.crack_area(&[sites[0], sites[mate]]) <= affordable)
    }

    /// The area of the faces between the cells of `sites` inside the body \[m²\], from the lattice
    /// edges that cross one. A face of area A and unit normal n crosses A |n_k| / (s_i s_j) edges
    /// along axis k; |n_x| + |n_y| + |n_z| is 3/2 on average.
    fn crack_area(&self, sites: &[Vec3]) -> f64 {
        let margin = Vec3::repeat(1e-3 * (self.high - self.low).norm());
        let Ok(cells) = Cells::new(sites.to_vec(), self.low - margin, self.high + margin) else {
            return f64::INFINITY;
        };
        let owner: Vec<u32> = self.places.par_iter().map(|&p| cells.nearest(p)).collect();
        let s = self.step;
        let faces = [s.y * s.z, s.z * s.x, s.x * s.y];
        let mut area = 0.0;
        for (i, next) in self.next.iter().enumerate() {
            for k in 0..3 {
                if next[k].is_some_and(|j| owner[j as usize] != owner[i]) {
                    area += faces[k];
                }
            }
        }
        area / 1.5
    }
}
