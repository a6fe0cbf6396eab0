//! Where a shell is crushed there is no telling which crack went where: its pieces are sampled.

use crate::domain::ShellDomain;
use cullet_fragment::pieces::{Ball, Rubble};
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_simd::Real;

/// Fewest points of a crushed zone.
const LEAST_ZONE: usize = 32;

/// Distance of the middles of sampled pieces, in thicknesses, from this on and up to this more: a
/// piece of rubble is about as long as the wall is thick.
const APART: (f64, f64) = (0.8, 1.0);

/// Least distance of them in cells.
const LEAST_APART: f64 = 1.5;

/// Stream of the seed's numbers.
const STREAM: u64 = 0xc4a5;

/// Points of crushed zones by the ball that they are of.
pub(super) struct CrushedZones {
    /// Middles of the sampled pieces \[m\].
    pub(super) middles: Vec<Vec3>,
    /// Points of crushed zones, ascending.
    pub(super) points: Vec<u32>,
}

impl CrushedZones {
    /// Points that are dead, as all around them are: where they lie side by side.
    pub(super) fn new<R: Real, const N: usize>(
        domain: &ShellDomain<R, N>,
        thickness: f64,
        spacing: f64,
        seed: u64,
    ) -> Self {
        let is_dead = |p: usize| !domain.is_on(p) || domain.state(p).dead;
        let deep = |p: &usize| {
            let around = domain.surface.around(*p).iter();
            domain.state(*p).dead && around.copied().all(|q| is_dead(q as usize))
        };
        let deep: Vec<usize> = domain.live().filter(deep).collect();
        let points = of_zones(domain, &deep);
        let mut order: Vec<u32> = points.clone();
        order.sort_by(|&a, &b| {
            let of = |p: u32| unit(seed, STREAM, u64::from(p));
            of(a).total_cmp(&of(b)).then(a.cmp(&b))
        });
        let mut middles: Vec<Vec3> = Vec::new();
        for p in order {
            let place = domain.surface.surface_point(p as usize).place;
            let share = APART.0 + APART.1 * unit(seed, STREAM + 1, u64::from(p));
            let apart = (share * thickness).max(LEAST_APART * spacing);
            if middles.iter().all(|other| (other - place).norm() >= apart) {
                middles.push(place);
            }
        }
        Self { middles, points }
    }

    /// The sampled pieces, in cells that are `cell` \[m\] along each axis.
    pub(super) fn rubble(&self, cell: &Vec3, thickness: f64, seed: u64) -> Rubble {
        let ball = |place: &Vec3| Ball::round(place.component_div(cell), thickness / cell.x);
        Rubble::new(self.middles.iter().map(ball).collect(), seed)
    }
}

/// Those of `points` (ascending) that lie together with many.
fn of_zones<R: Real, const N: usize>(domain: &ShellDomain<R, N>, points: &[usize]) -> Vec<u32> {
    let mut seen = vec![false; points.len()];
    let mut kept = Vec::new();
    for start in 0..points.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let (mut zone, mut next) = (vec![points[start]], 0);
        while next < zone.len() {
            for &q in domain.surface.around(zone[next]) {
                if let Ok(k) = points.binary_search(&(q as usize))
                    && !std::mem::replace(&mut seen[k], true)
                {
                    zone.push(q as usize);
                }
            }
            next += 1;
        }
        if zone.len() >= LEAST_ZONE {
            kept.extend(zone.into_iter().map(|p| p as u32));
        }
    }
    kept.sort_unstable();
    kept
}
