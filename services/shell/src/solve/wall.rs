//! The wall that is solved: the midsurface of a body and how thick it is.

use crate::midsurface::{Midsurface, placed};
use cullet_geometry::Pose;
use cullet_geometry::inside::Inside;
use cullet_geometry::math::unit;
use cullet_geometry::midsurface::WallSurface;
use cullet_geometry::plate::Plate;
use cullet_model::{BrittleProblem, Refusal};

/// How the rows of a plate's cells lie to its sides, by the seed: from this, and up to this more
/// \[rad\].
/// Cracks lean to the rows where little drives them (F22).
const TURN: (f64, f64) = (0.3, 0.3);

/// Stream of the seed's numbers.
const STREAM: u64 = 0x5e11;

/// Distance of the points of triangles over the length of an edge, √(√3/4)  \[1\].
const POINTS_APART: f64 = 0.658;

/// l_c over the size of a cell: what makes a crack that runs cost G_f  \[measured: K6s\].
pub(crate) const SOFTENING_CELLS: f64 = 1.1;

/// The same of triangles  \[measured: K6s\].
const TRIANGLE_SOFTENING: f64 = 1.0;

/// A wall, made discrete.
#[derive(Debug)]
pub(super) struct ThinWall {
    /// t of each point \[m\].
    pub(super) thickness: Vec<f64>,
    /// t of most of it \[m\].
    pub(super) typical: f64,
    /// Size of a cell \[m\].
    pub(super) spacing: f64,
    /// l_c over the size of a point's cell \[1\].
    pub(super) softening_cells: f64,
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
            softening_cells: SOFTENING_CELLS,
            pose: plate.pose,
            is_flat: true,
        };
        Ok((wall, surface))
    }

    /// Of a curved wall, with sixteen functions a cell.
    pub(super) fn of_surface(
        wall: &WallSurface,
        spacing: f64,
    ) -> Result<(Self, Midsurface), Refusal> {
        let surface = Midsurface::of_triangles(&wall.vertices, &wall.triangles)
            .map_err(|lack| Refusal::Unfit { solver: "shell", lack: lack.to_string() })?;
        let at = |t: &[u32; 3]| t.iter().map(|&v| wall.thickness[v as usize]).sum::<f64>() / 3.0;
        let thickness: Vec<f64> = wall.triangles.iter().map(at).collect();
        let typical = thickness.iter().sum::<f64>() / thickness.len() as f64;
        let wall = Self {
            thickness,
            typical,
            spacing,
            softening_cells: TRIANGLE_SOFTENING,
            pose: Pose::identity(),
            is_flat: false,
        };
        Ok((wall, surface))
    }

    /// Twice the distance of points \[m\].
    pub(super) fn field_spacing(&self) -> f64 {
        if self.is_flat { self.spacing } else { 2.0 * POINTS_APART * self.spacing }
    }

    /// Where a place in the frame of the solve is in the body's.
    pub(super) fn in_body(&self, x: &cullet_geometry::Vec3) -> cullet_geometry::Vec3 {
        placed(&self.pose, x)
    }
}
