//! What holds parts of a soft shell: control points that are led, and the strip around them that
//! does not break.

use super::NAME;
use super::wall::SoftWall;
use cullet_continuum::GripPath;
use cullet_geometry::{Pose, Vec3};
use cullet_model::{BodyGrip, Refusal};

/// No point starts to break within this many spacings of a held control point: a clamp concentrates
/// stress, and the shell would tear along it.
const GUARD: f64 = 2.0;

/// A control point that nothing holds.
pub(super) const FREE: u32 = u32::MAX;

/// A grip and the control points that it holds.
#[derive(Clone, Debug)]
pub(super) struct GrippedNodes {
    /// Rising.
    pub(super) nodes: Vec<u32>,
    /// Points near enough that they do not break.
    pub(super) guarded: Vec<u32>,
    /// Middle of its region in the world \[m\].
    middle: Vec3,
    path: GripPath,
}

impl GrippedNodes {
    /// # Errors
    /// If the grip of that number, from 1 on, holds nothing or its path does not run forwards.
    pub(super) fn new(
        grip: &BodyGrip,
        number: usize,
        wall: &SoftWall,
        (pose, spacing): (&Pose, f64),
    ) -> Result<Self, Refusal> {
        let surface = &wall.surface;
        // All control points that move a cell in the region: then nothing strains there.
        let held = (0..wall.quads).filter(|&quad| grip.region.has(&surface.nodes[quad]));
        let mut nodes: Vec<u32> = held.flat_map(|quad| surface.cells[quad].nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        if nodes.is_empty() {
            return Err(Refusal::Idle { what: "grip", number });
        }
        let reach = (GUARD * spacing) * (GUARD * spacing);
        let near = |&p: &u32| {
            let place = surface.surface_point(p as usize).place;
            let far = |&n: &u32| (surface.nodes[n as usize] - place).norm_squared();
            nodes.iter().any(|n| far(n) <= reach)
        };
        let guarded = (0..surface.points() as u32).filter(near).collect();
        let middle = crate::midsurface::placed(pose, &grip.region.middle());
        let path = GripPath::of(grip, number, NAME)?;
        Ok(Self { nodes, guarded, middle, path })
    }

    /// Whether it holds in a step of the world that begins at this time \[s\].
    pub(super) fn holds(&self, time: f64) -> bool {
        self.path.holds(time)
    }

    /// Where a place \[m\] of the world that it holds is at a time \[s\], and how fast \[m/s\].
    pub(super) fn leads(&self, place: &Vec3, time: f64) -> (Vec3, Vec3) {
        self.path.leads(place, &self.middle, time)
    }
}
