//! When and how fast the crack front passed a place.

use crate::crack::LatticeNodes;
use crate::region::Mosaic;
use cullet_geometry::Vec3;
use cullet_geometry::voronoi::WALL;
use rayon::prelude::*;
use std::sync::Arc;

/// Times and speeds of a front are fitted over this many spacings.
const FRONT: f64 = 1.5;

/// The lattice that a cut was found on, and how its fronts are measured.
#[derive(Clone, Debug)]
pub(super) struct Ground {
    pub(super) nodes: Arc<LatticeNodes>,
    /// As in [`crate::field::DamageField`].
    pub(super) scale: Vec3,
    pub(super) top_speed: f64,
}

/// When the front passed \[s\], and how fast \[m/s\].
pub(super) type FrontMark = [f32; 2];

impl Ground {
    /// When and how fast the front passed a place; `time` where the lattice does not tell.
    pub(super) fn mark(&self, place: Vec3, time: f64) -> FrontMark {
        let Some(front) = self.nodes.front(place, FRONT) else {
            return [time as f32, 0.0];
        };
        let slope = front.slope.component_div(&self.scale).norm();
        let speed = if slope * self.top_speed > 1.0 { 1.0 / slope } else { self.top_speed };
        [front.time.max(0.0) as f32, speed as f32]
    }
}

/// The mark of each corner of a mosaic that lies on a face between cells: where there is no ground,
/// or it does not tell, the mean time of the facets there. Both sides of a crack read them.
pub(super) fn marks(mosaic: &Mosaic, ground: Option<&Ground>) -> Vec<FrontMark> {
    let mut sums = vec![(0.0, 0u32); mosaic.places.len()];
    for facet in mosaic.facets.iter().filter(|facet| facet.cells.1 < WALL) {
        for &corner in mosaic.of(facet).as_flattened() {
            sums[corner as usize].0 += facet.time;
            sums[corner as usize].1 += 1;
        }
    }
    let mark = |(&place, (sum, count)): (&Vec3, (f64, u32))| {
        let time = sum / f64::from(count.max(1));
        match ground {
            Some(ground) if count > 0 => ground.mark(place, time),
            _ => [time as f32, 0.0],
        }
    };
    mosaic.places.par_iter().zip(sums).map(mark).collect()
}
