//! The midsurface of a soft shell: quads of about the spacing, along the sides of a rectangle, or
//! laid by the geometry's division into quads on any other wall.

use super::NAME;
use crate::midsurface::Midsurface;
use crate::solve::neither;
use cullet_geometry::Vec3;
use cullet_geometry::midsurface::WallSurface;
use cullet_geometry::plate::Plate;
use cullet_geometry::quads::QuadSurface;
use cullet_model::{Refusal, SoftBody};

/// A plate whose area is this close to that of the rectangle around it is one \[1\].
const RECTANGLE: f64 = 1e-6;

/// Fewest cells along a side.
const FEWEST: usize = 3;

/// Spacing over the thickness: below the first a cell is no shell's.
const LEAST_SPACING: f64 = 0.25;

/// A wall, made discrete in the body's frame.
#[derive(Debug)]
pub(super) struct SoftWall {
    pub(super) surface: Midsurface,
    /// Quadrilaterals: the first control points are theirs.
    pub(super) quads: usize,
    /// t of each point \[m\].
    pub(super) thickness: Vec<f64>,
    /// Whether all cells are alike, so that the smallest one's bound is that of the step.
    pub(super) is_even: bool,
    /// What coordinates of a texture are counted along.
    pub(super) axes: [Vec3; 2],
}

impl SoftWall {
    /// # Errors
    /// What keeps the body from being a thin wall.
    pub(super) fn new(body: &SoftBody, seed: u64) -> Result<Self, Refusal> {
        let (wall, axes) = match Plate::of_mesh(&body.solid.mesh) {
            Ok(plate) => {
                let axes = [Vec3::x(), Vec3::y()].map(|axis| plate.pose.rotation * axis);
                let [a, b] = plate.size;
                match (plate.area / (a * b) - 1.0).abs() < RECTANGLE {
                    true => return Self::of_rectangle(&plate, body.spacing, axes),
                    false => (quads_of(body, seed, &"its outline is no rectangle")?, axes),
                }
            }
            Err(flat) => (quads_of(body, seed, &flat)?, widest(body)),
        };
        let surface = midsurface(&wall.vertices, &wall.quads)?;
        let at = |quad: &[u32; 4]| Midsurface::at_points(&quad.map(|v| wall.thickness[v as usize]));
        let thickness: Vec<f64> = wall.quads.iter().flat_map(at).collect();
        let quads = wall.quads.len();
        Self { surface, quads, thickness, is_even: false, axes }.checked(body.spacing)
    }

    fn of_rectangle(plate: &Plate, spacing: f64, axes: [Vec3; 2]) -> Result<Self, Refusal> {
        let [nx, ny] = plate.size.map(|side| ((side / spacing).round() as usize).max(FEWEST));
        let along = |k: usize, n: usize, size: f64| (k as f64 / n as f64 - 0.5) * size;
        let at = |i: usize, j: usize| {
            let [x, y] = [along(i, nx, plate.size[0]), along(j, ny, plate.size[1])];
            crate::midsurface::placed(&plate.pose, &Vec3::new(x, y, 0.0))
        };
        let vertices: Vec<Vec3> =
            (0..=ny).flat_map(|j| (0..=nx).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect();
        let number = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
        let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
        let quads: Vec<[u32; 4]> = cells
            .map(|(i, j)| [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)])
            .collect();
        let surface = midsurface(&vertices, &quads)?;
        let thickness = vec![plate.thickness; surface.points()];
        let wall = Self { surface, quads: quads.len(), thickness, is_even: true, axes };
        wall.checked(spacing)
    }

    fn checked(self, spacing: f64) -> Result<Self, Refusal> {
        let value = spacing / self.typical();
        if value < LEAST_SPACING {
            let what = "spacing of a soft shell over its thickness";
            return Err(Refusal::OutOfRange { what, value, low: LEAST_SPACING, high: f64::MAX });
        }
        Ok(self)
    }

    /// Mean thickness \[m\].
    pub(super) fn typical(&self) -> f64 {
        self.thickness.iter().sum::<f64>() / self.thickness.len() as f64
    }
}

fn midsurface(vertices: &[Vec3], quads: &[[u32; 4]]) -> Result<Midsurface, Refusal> {
    let surface = Midsurface::of_quads(vertices, quads);
    surface.map_err(|lack| Refusal::Unfit { solver: NAME, lack: lack.to_string() })
}

fn quads_of(
    body: &SoftBody,
    seed: u64,
    flat: &dyn std::fmt::Display,
) -> Result<QuadSurface, Refusal> {
    let wall = WallSurface::of_solid(&body.solid, body.spacing);
    let wall = wall.map_err(|lack| neither(NAME, flat, &lack))?;
    QuadSurface::of_wall(&wall, body.spacing, seed).map_err(|lack| neither(NAME, flat, &lack))
}

/// The two axes of the body's frame that it extends along most.
fn widest(body: &SoftBody) -> [Vec3; 2] {
    let size = body.solid.mesh.bounds().map_or(Vec3::zeros(), |(low, high)| high - low);
    let least = size.iamin();
    let mut axes = (0..3).filter(|&k| k != least).map(|k| Vec3::ith(k, 1.0));
    [axes.next().unwrap_or(Vec3::x()), axes.next().unwrap_or(Vec3::y())]
}
