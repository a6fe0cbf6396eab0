//! The wall that is solved: the midsurface of a body and how thick it is.

use crate::domain::STEP_SHARE;
use crate::midsurface::{Midsurface, StepBounds, placed};
use cullet_geometry::Pose;
use cullet_geometry::inside::Inside;
use cullet_geometry::math::unit;
use cullet_geometry::plate::Plate;
use cullet_geometry::quads::QuadSurface;
use cullet_model::{BrittleProblem, Material, Refusal};

/// How the rows of a plate's cells lie to its sides, by the seed: from this, and up to this more
/// \[rad\].
/// Cracks lean to the rows where little drives them (F22).
const TURN: (f64, f64) = (0.3, 0.3);

/// Stream of the seed's numbers.
const STREAM: u64 = 0x5e11;

/// l_c over the size of a cell: what makes a crack that runs cost G_f  \[measured: K6s\].
pub(crate) const SOFTENING_CELLS: f64 = 1.1;

/// Size of the cells that set the step of a curved wall over that of most  \[1\].
const SMALL: f64 = 0.78;

/// A wall, made discrete.
#[derive(Debug)]
pub(super) struct ThinWall {
    /// t of each point \[m\].
    pub(super) thickness: Vec<f64>,
    /// t of most of it \[m\].
    pub(super) typical: f64,
    /// Size of a cell \[m\].
    pub(super) spacing: f64,
    /// From the frame of the solve to the body's.
    pub(super) pose: Pose,
    /// Whether it is a plate in the plane z = 0.
    pub(super) is_flat: bool,
}

impl ThinWall {
    /// Of a plate, with nine functions a cell.
    pub(super) fn of_plate(
        plate: &Plate,
        problem: &BrittleProblem,
        spacing: f64,
    ) -> Result<(Self, Midsurface), Refusal> {
        let inside = Inside::new(&problem.solid.mesh);
        let turn = TURN.0 + TURN.1 * unit(problem.seed, STREAM, 0);
        let surface = Midsurface::of_plate(plate, &inside, spacing, turn)
            .map_err(|_| Refusal::Unknown { solver: "shell", what: "a body", kind: "solid" })?;
        let wall = Self {
            thickness: vec![plate.thickness; surface.points()],
            typical: plate.thickness,
            spacing,
            pose: plate.pose,
            is_flat: true,
        };
        Ok((wall, surface))
    }

    /// Of a curved wall, with nine functions a cell and more where rows of cells end.
    pub(super) fn of_surface(
        wall: &QuadSurface,
        spacing: f64,
    ) -> Result<(Self, Midsurface), Refusal> {
        let surface = Midsurface::of_quads(&wall.vertices, &wall.quads)
            .map_err(|lack| Refusal::Unfit { solver: "shell", lack: lack.to_string() })?;
        let at = |quad: &[u32; 4]| {
            let corners = quad.map(|v| wall.thickness[v as usize]);
            Midsurface::at_points(&corners)
        };
        let thickness: Vec<f64> = wall.quads.iter().flat_map(at).collect();
        let typical = thickness.iter().sum::<f64>() / thickness.len() as f64;
        let wall = Self { thickness, typical, spacing, pose: Pose::identity(), is_flat: false };
        Ok((wall, surface))
    }

    /// Step of a curved wall: that of cells somewhat smaller than most \[s\].
    pub(super) fn step(&self, bounds: &StepBounds, material: &Material) -> f64 {
        let modulus = material.young / (1.0 - material.poisson * material.poisson);
        let speed = (modulus / material.density).sqrt();
        STEP_SHARE * bounds.step(SMALL * self.spacing, self.typical, speed)
    }

    /// Where a place in the frame of the solve is in the body's.
    pub(super) fn in_body(&self, x: &cullet_geometry::Vec3) -> cullet_geometry::Vec3 {
        placed(&self.pose, x)
    }
}
