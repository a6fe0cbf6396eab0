//! Sites with labels: cells of one label around what stays whole, and none that reaches into it.
//!
//! A region is convex, so it lies behind the plane that touches it at its point nearest to a site.
//! A second site on the normal of that plane, inside the region and no farther from it than the
//! first, keeps the first one's cell in front of the plane.

use cullet_geometry::math::unit;
use cullet_geometry::{TriMesh, Vec3};
use cullet_model::BodyRegion;

/// Sites are moved by up to this share of the distance to the nearest other one \[1\]: points that
/// somebody writes lie on lattices and circles, where cells meet in a point.
const SHAKEN: f64 = 5e-3;
/// A site nearer to a region than this share of the region's size is taken to be in it \[1\].
const BESIDE: f64 = 1e-3;
/// Cells of others end this share of a region's size before it, or half way where a site is nearer
/// \[1\]: crack faces have relief.
const CLEAR: f64 = 0.1;
/// A site in a region is this share of the other's distance deep, at least and at most \[1\].
const DEEP: [f64; 2] = [0.9, 0.98];
/// It is at most this share of the way through the region deep, at least and at most \[1\].
const THROUGH: [f64; 2] = [0.35, 0.65];
/// Looks at what keeps sites of one region out of others.
const PASSES: usize = 2;

/// Sites \[m\], and whose they are.
#[derive(Clone, Debug, Default)]
pub(super) struct LabelledSites {
    pub(super) sites: Vec<Vec3>,
    pub(super) labels: Vec<u32>,
}

impl LabelledSites {
    /// How many labels there are.
    pub(super) fn count(&self) -> usize {
        let mut labels = self.labels.clone();
        labels.sort_unstable();
        labels.dedup();
        labels.len()
    }
}

/// The regions that a piece may hold part of, and those of them that share a label.
#[derive(Clone, Debug)]
pub(super) struct HeldRegions {
    regions: Vec<BodyRegion>,
    groups: Vec<u32>,
}

impl HeldRegions {
    /// Those whose boxes touch that of a piece. Where the boxes of two touch, they have one label.
    pub(super) fn new(piece: &TriMesh, whole: &[BodyRegion]) -> Self {
        let (low, high) = piece.bounds().unwrap_or_default();
        let meet = |a: &(Vec3, Vec3), b: &(Vec3, Vec3)| {
            (0..3).all(|k| a.0[k] <= b.1[k] && b.0[k] <= a.1[k])
        };
        let near = |region: &&BodyRegion| meet(&bounds(region), &(low, high));
        let regions: Vec<BodyRegion> = whole.iter().filter(near).copied().collect();
        let mut groups: Vec<u32> = (0..regions.len() as u32).collect();
        for b in 0..regions.len() {
            for a in 0..b {
                if meet(&bounds(&regions[a]), &bounds(&regions[b])) {
                    let (keep, drop) = (groups[a], groups[b]);
                    groups.iter_mut().filter(|group| **group == drop).for_each(|g| *g = keep);
                }
            }
        }
        Self { regions, groups }
    }

    /// Whether a place is in a region, or as good as.
    pub(super) fn has(&self, place: &Vec3) -> bool {
        let slack = |region: &BodyRegion| BESIDE * size(region);
        self.regions.iter().any(|region| (nearest(region, place) - place).norm() <= slack(region))
    }

    /// Whether a place is so far from all regions that relief does not matter.
    pub(super) fn is_clear(&self, place: &Vec3) -> bool {
        let far = |region: &BodyRegion| (nearest(region, place) - place).norm();
        self.regions.iter().all(|region| far(region) > 2.0 * clear(region))
    }

    /// How many fragments they are to be.
    pub(super) fn count(&self) -> usize {
        let mut groups = self.groups.clone();
        groups.sort_unstable();
        groups.dedup();
        groups.len()
    }

    /// The sites, each with a label of its own, and with those that keep their cells out of the
    /// regions, one label a region. None of the sites may be in a region.
    pub(super) fn around(&self, own: &[Vec3], seed: u64) -> LabelledSites {
        let mut sites = shaken(own, seed);
        let mut labels: Vec<u32> = (0..sites.len() as u32).collect();
        let first = sites.len() as u32;
        for pass in 0..PASSES {
            let before = sites.len();
            for (region, group) in self.regions.iter().zip(&self.groups) {
                let label = first + group;
                // The nearest first: what keeps their cells out mostly does for those behind them.
                let mut others: Vec<(f64, usize)> = (0..before)
                    .filter(|&k| labels[k] != label && (pass == 0 || labels[k] >= first))
                    .map(|k| ((nearest(region, &sites[k]) - sites[k]).norm(), k))
                    .collect();
                others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let mut guards: Vec<Vec3> =
                    (0..sites.len()).filter(|&k| labels[k] == label).map(|k| sites[k]).collect();
                for (far, k) in others {
                    let site = sites[k];
                    let region = &grown(region, (0.5 * far).min(clear(region)));
                    if guards.iter().any(|guard| keeps_out(region, &site, guard)) {
                        continue;
                    }
                    let key = sites.len() as u64;
                    let Some(guard) = guard(region, &site, |i| unit(seed, 7 + i, key)) else {
                        continue;
                    };
                    guards.push(guard);
                    sites.push(guard);
                    labels.push(label);
                }
            }
        }
        LabelledSites { sites, labels }
    }
}

/// Sites in general position.
fn shaken(sites: &[Vec3], seed: u64) -> Vec<Vec3> {
    let shake = |(k, site): (usize, &Vec3)| {
        let others = sites.iter().enumerate().filter(|(j, _)| *j != k);
        let near = others.map(|(_, other)| (other - site).norm()).fold(f64::INFINITY, f64::min);
        let reach = if near.is_finite() { SHAKEN * near } else { 0.0 };
        site + Vec3::from_fn(|axis, _| unit(seed, 4 + axis as u64, k as u64) - 0.5) * reach
    };
    sites.iter().enumerate().map(shake).collect()
}

fn bounds(region: &BodyRegion) -> (Vec3, Vec3) {
    match *region {
        BodyRegion::Ball { centre, radius } => {
            (centre.add_scalar(-radius), centre.add_scalar(radius))
        }
        BodyRegion::Box { low, high } => (low, high),
    }
}

/// A length of a region \[m\].
fn size(region: &BodyRegion) -> f64 {
    match region {
        BodyRegion::Ball { radius, .. } => *radius,
        BodyRegion::Box { low, high } => libm::cbrt((high - low).product()),
    }
}

/// How far from a region the cells of others end \[m\].
fn clear(region: &BodyRegion) -> f64 {
    CLEAR * size(region)
}

/// A region and what lies so near to it \[m\], or a little more.
fn grown(region: &BodyRegion, by: f64) -> BodyRegion {
    match *region {
        BodyRegion::Ball { centre, radius } => BodyRegion::Ball { centre, radius: radius + by },
        BodyRegion::Box { low, high } => {
            BodyRegion::Box { low: low.add_scalar(-by), high: high.add_scalar(by) }
        }
    }
}

/// The place of a region that is nearest to one \[m\].
fn nearest(region: &BodyRegion, place: &Vec3) -> Vec3 {
    match *region {
        BodyRegion::Ball { centre, radius } => {
            let off = place - centre;
            if off.norm() <= radius { *place } else { centre + off.normalize() * radius }
        }
        BodyRegion::Box { low, high } => place.sup(&low).inf(&high),
    }
}

/// A place in a region that keeps the cell of a site out of it, at a random depth.
fn guard(region: &BodyRegion, site: &Vec3, random: impl Fn(u64) -> f64) -> Option<Vec3> {
    let on = nearest(region, site);
    let far = (on - site).norm();
    let way = (on - site).try_normalize(0.0)?;
    let through = match *region {
        BodyRegion::Ball { radius, .. } => 2.0 * radius,
        BodyRegion::Box { low, high } => (0..3)
            .filter(|&k| way[k] != 0.0)
            .map(|k| (high - low)[k] / way[k].abs())
            .fold(f64::INFINITY, f64::min),
    };
    let between = |[least, most]: [f64; 2], at: f64| least + (most - least) * at;
    let deep = (far * between(DEEP, random(0))).min(through * between(THROUGH, random(1)));
    Some(on + way * deep)
}

/// Whether all of a region is nearer to a guard than to a site.
fn keeps_out(region: &BodyRegion, site: &Vec3, guard: &Vec3) -> bool {
    let way = site - guard;
    // The greatest x·way over the region.
    let most = match *region {
        BodyRegion::Ball { centre, radius } => centre.dot(&way) + radius * way.norm(),
        BodyRegion::Box { low, high } => {
            (0..3).map(|k| (low[k] * way[k]).max(high[k] * way[k])).sum()
        }
    };
    most < 0.5 * (site + guard).dot(&way)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sites all round a ball and a box, close by and far off: whatever place of a region is taken,
    /// the nearest site is one of the region's.
    #[test]
    fn no_cell_of_another_reaches_into_a_region() {
        let regions = vec![
            BodyRegion::Ball { centre: Vec3::new(0.3, 0.2, 0.1), radius: 0.2 },
            BodyRegion::Box { low: Vec3::new(-0.5, -0.4, -0.02), high: Vec3::new(0.0, 0.4, 0.03) },
        ];
        let held = HeldRegions { regions, groups: vec![0, 1] };
        let random = |stream: u64, i: u64| {
            Vec3::from_fn(|k, _| 1.4 * (unit(11, 3 * stream + k as u64, i) - 0.5))
        };
        let own: Vec<Vec3> =
            (0..80).map(|i| random(0, i)).filter(|place| !held.has(place)).collect();
        let LabelledSites { sites, labels } = held.around(&own, 5);
        assert!(own.len() > 40 && sites.len() < 3 * own.len(), "{} sites", sites.len());
        let mut looked = 0;
        for place in (0..20_000).map(|i| random(1, i)) {
            let far = |k: &usize| (sites[*k] - place).norm();
            let cell = (0..sites.len()).min_by(|a, b| far(a).total_cmp(&far(b))).expect("a site");
            if held.regions.iter().any(|region| region.has(&place)) {
                looked += 1;
                assert!(labels[cell] as usize >= own.len(), "{place} is the cell of {cell}");
            }
        }
        assert!(looked > 200, "{looked}");
        // Each other site has its own cell all the same.
        for place in &own {
            let far = |k: &usize| (sites[*k] - place).norm();
            let cell = (0..sites.len()).min_by(|a, b| far(a).total_cmp(&far(b))).expect("a site");
            assert!((labels[cell] as usize) < own.len(), "{place}");
        }
    }
}
