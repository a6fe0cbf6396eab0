//! Contact of points that no bond holds together: sides of cracks and cuts, pieces, and parts of a
//! body that were never bonded. And the cores of points: bonds get no stiffer as they are pressed,
//! and nothing else would keep a crushed corner from turning inside out.

use super::grid::PointCells;
use crate::PeridynamicDomain;
use crate::domain::contact::{REACH, STIFFNESS};
use crate::law::PartedContact;
use cullet_geometry::Vec3;

/// Distance, in spacings, within which the cores of bonded points push each other apart: relaxed
/// points are no nearer at rest than 0.6.
const CORE: f64 = 0.5;
/// Extension of a bond at which its ends may come so near \[1\], and how much farther than the
/// deviation of its point one may be.
const PRESSED: f64 = -0.15;
const FARTHER: f64 = 6.0;

/// Pairs of points that may touch in the next steps.
#[derive(Clone, Debug, Default)]
pub(super) struct TouchingPairs {
    pairs: Vec<[u32; 2]>,
    /// Bonded pairs whose cores may.
    cores: Vec<[u32; 2]>,
}

/// What pairs did to points, in sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PairSums {
    /// Energy that they hold \[J\].
    pub(super) held: f64,
    /// What friction took \[J\].
    pub(super) friction: f64,
}

impl TouchingPairs {
    /// Finds those that come as near as `margin` \[m\] to touching: of points that lie at the
    /// surface or have lost bonds, and of bonded ones that are pressed. What is gone touches none.
    pub(super) fn find(
        domain: &PeridynamicDomain,
        outer: &[bool],
        gone: &[bool],
        margin: f64,
    ) -> Self {
        let spacing = libm::cbrt(domain.volumes[0]);
        let exposed = |p: usize| !gone[p] && (outer[p] || domain.states[p].damage > 0.0);
        let pressed = |p: usize| {
            let state = &domain.states[p];
            !gone[p] && state.mean - FARTHER * state.deviation.sqrt() < PRESSED
        };
        Self {
            pairs: near(domain, exposed, REACH * spacing + margin, false),
            cores: near(domain, pressed, CORE * spacing + margin, true),
        }
    }

    /// Those of different parts that press on each other now.
    pub(super) fn pressed(&self, domain: &PeridynamicDomain) -> Vec<[u32; 2]> {
        let reach = REACH * libm::cbrt(domain.volumes[0]);
        let apart = |p: u32, q: u32| domain.places[p as usize] - domain.places[q as usize];
        let near = |&&[p, q]: &&[u32; 2]| apart(p, q).norm() < reach;
        self.pairs.iter().filter(near).copied().collect()
    }

    /// Adds their forces \[N\] in a step of `dt` \[s\].
    pub(super) fn push(
        &self,
        domain: &PeridynamicDomain,
        contact: &PartedContact,
        dt: f64,
        forces: &mut [Vec3],
    ) -> PairSums {
        let mut sums = PairSums::default();
        for &[p, q] in &self.pairs {
            let [p, q] = [p as usize, q as usize];
            let push = domain.pushed(Default::default(), [p, q], contact, dt);
            forces[p] += push.force;
            forces[q] -= push.force;
            sums.held += 2.0 * push.held;
            sums.friction += 2.0 * push.friction;
        }
        let spacing = libm::cbrt(domain.volumes[0]);
        let stiffness = STIFFNESS * domain.law.bulk * spacing;
        for &[p, q] in &self.cores {
            let [p, q] = [p as usize, q as usize];
            let apart = domain.places[p] - domain.places[q];
            let distance = apart.norm();
            let depth = CORE * spacing - distance;
            if depth > 0.0 && distance > 0.0 {
                let force = apart * (stiffness * depth / distance);
                forces[p] += force;
                forces[q] -= force;
                sums.held += 0.5 * stiffness * depth * depth;
            }
        }
        sums
    }
}

/// Pairs of some points up to `reach` \[m\] from each other that are bonded, or are not.
fn near(
    domain: &PeridynamicDomain,
    which: impl Fn(usize) -> bool,
    reach: f64,
    bonded: bool,
) -> Vec<[u32; 2]> {
    let all: Vec<u32> = (0..domain.places.len()).filter(|&p| which(p)).map(|p| p as u32).collect();
    let places: Vec<Vec3> = all.iter().map(|&p| domain.places[p as usize]).collect();
    let mut pairs = Vec::new();
    if !places.iter().flatten().all(|c| c.is_finite()) {
        return pairs;
    }
    let cells = PointCells::new(&places, reach);
    for (k, x) in places.iter().enumerate() {
        cells.around(x, 1, |n| {
            let n = n as usize;
            let near = n > k && (places[n] - x).norm_squared() <= reach * reach;
            if near && is_bonded(domain, [all[k], all[n]]) == bonded {
                pairs.push([all[k], all[n]]);
            }
        });
    }
    // Sums are in an order that does not depend on where cells begin.
    pairs.sort_unstable();
    pairs
}

/// Whether something is left of a bond between two points.
fn is_bonded(domain: &PeridynamicDomain, [p, q]: [u32; 2]) -> bool {
    domain.bonds.find(p as usize, q as usize).is_some_and(|bond| domain.left(bond) > 0.0)
}
