//! The body that is cut, and the tags that tell its faces from those of the cut.

use super::partition::{CutPart, CutSettings, Partition};
use crate::error::CutError;
use cullet_geometry::boolean::{BooleanError, Exact, MAX_TAG};
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::{Solid, Surface, Vec3};

/// The tag of a face that was there before any crack.
const OUTER: u32 = MAX_TAG;
/// Tags that the boolean kernel carries from a face to what is cut from it: below, a triangle of
/// the body; from here on, a facet of what cuts it.
pub(super) const FACET: u32 = 1 << 30;

/// The facet that a tag names.
pub(super) fn facet_of(tag: u32) -> Option<u32> {
    (tag < OUTER).then(|| tag.checked_sub(FACET)).flatten()
}

/// Convex stand-ins for a solid.
pub(super) fn hulls(solid: &Solid) -> Vec<Vec<Vec3>> {
    convex_parts(solid, HullSettings::default())
}

/// The body that is cut.
#[derive(Clone, Debug)]
pub(super) struct CutBody {
    pub(super) solid: Solid,
    pub(super) exact: Exact,
    /// \[m³\]
    pub(super) volume: f64,
    /// \[m²\]
    pub(super) area: f64,
    pub(super) low: Vec3,
    pub(super) high: Vec3,
}

impl CutBody {
    pub(super) fn new(solid: &Solid, settings: &CutSettings) -> Result<Self, CutError> {
        if !(0.0..=1.0).contains(&settings.min_volume_ratio) {
            return Err(CutError::NotFinite { what: "least volume ratio in [0, 1]", index: 0 });
        }
        if let Some((what, ..)) = settings.detail.wrong() {
            return Err(CutError::NotFinite { what, index: 0 });
        }
        solid.validate().map_err(BooleanError::Mesh)?;
        let tag =
            |(t, surface): (usize, &Surface)| if surface.is_crack() { t as u32 } else { OUTER };
        let tags: Vec<u32> = solid.surface.iter().enumerate().map(tag).collect();
        let exact = Exact::tagged(&solid.mesh, &tags)?;
        let (low, high) = solid.mesh.bounds().unwrap_or_default();
        let (volume, area) = (solid.mesh.signed_volume(), solid.mesh.area());
        Ok(Self { solid: solid.clone(), exact, volume, area, low, high })
    }

    /// What a face with this tag and these corners was before the cut.
    pub(super) fn surface_of(&self, tag: u32, corners: [Vec3; 3]) -> Surface {
        let Some(old) = self.solid.surface.get(tag as usize) else {
            return Surface::Outer;
        };
        old.within(self.solid.mesh.corners(tag as usize), corners)
    }

    pub(super) fn untouched(self, particles: usize) -> Partition {
        let hulls = hulls(&self.solid);
        let (solid, volume) = (self.solid, self.volume);
        let part = CutPart { solid, hulls, volume, cracks: Vec::new() };
        Partition { parts: vec![part], particle_part: vec![0; particles], ..Default::default() }
    }
}
