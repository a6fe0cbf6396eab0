//! What a problem must be like for this method, and the grid that its budget allows.

use cullet_fragment::cut::slit::WIDEST;
use cullet_geometry::Vec3;
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::sample::{self, SampleError};
use cullet_model::brittle::{CELLS_ACROSS, CELLS_ACROSS_CHOSEN, POINTS_PER_CELL};
pub(crate) use cullet_model::preconditions::{check_impacts, check_supports, within};
use cullet_model::{BrittleProblem, Refusal};

/// Strength over stiffness that the method holds for \[1\].
const STRENGTH_RANGE: (f64, f64) = (1e-5, 1e-1);

/// Poisson's ratio \[1\]: towards ½ pressure waves have no bound; towards −1 a solid resists every
/// shear and no change of volume, and a hard blow ends unstable.
pub(crate) const POISSON_RANGE: (f64, f64) = (-0.5, 0.49);

/// A body whose least extent is at most this share of the next is flat.
const FLAT: f64 = 0.25;

/// Greatest ratio of a flat body's cells in its plane to those across it: a crack needs the plane
/// as much as bending needs the thickness.
const FLATTEST: f64 = 3.0;

/// The spacing asked for, or the finest that the particle budget allows: N = 8V/h³ \[m\]. Where
/// that leaves a flat body along an axis with fewer than three cells across, cells are flattened:
/// as many points, finer across and coarser in the plane (F14).
pub(crate) fn choose_spacing(problem: &BrittleProblem) -> Result<Vec3, Refusal> {
    let volume = problem.solid.mesh.signed_volume();
    within("the body's volume [m^3]", volume, 1e-18, 1e12)?;
    let finest =
        libm::cbrt(POINTS_PER_CELL * volume / f64::from(problem.settings.max_particles.max(1)));
    let spacing = problem.settings.spacing.unwrap_or(finest);
    within("the spacing [m]", spacing, 1e-9, 1e6)?;
    let (low, high) = problem.solid.mesh.bounds().unwrap_or_default();
    let extent = high - low;
    let (axis, thickness) = extent.argmin();
    let next = (0..3).filter(|&a| a != axis).fold(f64::INFINITY, |m, a| m.min(extent[a]));
    let across = thickness / CELLS_ACROSS_CHOSEN;
    let plane = (spacing * spacing * spacing / across).sqrt();
    if across < spacing && thickness <= FLAT * next && plane <= FLATTEST * across {
        let mut cell = Vec3::repeat(plane);
        cell[axis] = across;
        return Ok(cell);
    }
    Ok(Vec3::repeat(spacing))
}

/// Refuses blows on the face of a plate whose contact, widened to `least` cells of the plane, would
/// be wider than the plate is thick: it would punch out a disc instead of bending the plate (F11,
/// F14).
pub(crate) fn check_contacts(
    problem: &BrittleProblem,
    spacing: &Vec3,
    least: f64,
) -> Result<(), Refusal> {
    let (low, high) = problem.solid.mesh.bounds().unwrap_or_default();
    let axis = spacing.imin();
    let (thickness, plane) = ((high - low)[axis], spacing.max());
    let across = problem.impacts.iter().any(|impact| impact.normal[axis].abs() > 0.5);
    if spacing.min() < plane && across && thickness < least * plane {
        return Err(Refusal::TooThin { thickness, cells: thickness / plane, minimum: least });
    }
    Ok(())
}

/// The body and its frame stretched so that cells are cubes of the largest spacing.
pub(crate) fn stretch(spacing: &Vec3) -> Vec3 {
    spacing.map(|h| spacing.max() / h)
}

pub(crate) fn sample_points(
    problem: &BrittleProblem,
    spacing: &Vec3,
) -> Result<Vec<Vec3>, Refusal> {
    let stretch = stretch(spacing);
    let mut mesh = problem.solid.mesh.clone();
    mesh.vertices.iter_mut().for_each(|x| x.component_mul_assign(&stretch));
    let inside = Inside::new(&mesh);
    // Eight points a cell: each stands for (h/2)³.
    let points = sample::poisson(&inside, 0.5 * spacing.max(), problem.seed).map_err(|error| {
        let value = match error {
            SampleError::TooMany { candidates, .. } => candidates,
            SampleError::Spacing { spacing } => spacing,
        };
        let limit = sample::MAX_CANDIDATES;
        Refusal::TooLarge { what: "the number of points in the body's box", value, limit }
    })?;
    Ok(points.into_iter().map(|x| x.component_div(&stretch)).collect())
}

pub(crate) fn check_material(problem: &BrittleProblem) -> Result<(), Refusal> {
    let m = &problem.material;
    within("density [kg/m^3]", m.density, 1e-3, 1e6)?;
    within("Young's modulus [Pa]", m.young, 1.0, 1e14)?;
    within("Poisson's ratio", m.poisson, POISSON_RANGE.0, POISSON_RANGE.1)?;
    within("fracture energy [J/m^2]", m.fracture_energy, 1e-9, 1e9)?;
    let ratio = m.failure_stress / m.young;
    within("failure stress over Young's modulus", ratio, STRENGTH_RANGE.0, STRENGTH_RANGE.1)
}

/// Refuses hairlines wider than what is thin beside the grid.
pub(crate) fn check_hairline(problem: &BrittleProblem, spacing: &Vec3) -> Result<(), Refusal> {
    let Some(width) = problem.settings.brittle.hairline else {
        return Ok(());
    };
    within("width of hairlines [m]", width, f64::MIN_POSITIVE, WIDEST * spacing.min())
}

/// Refuses a spin whose rim outruns the sound: the stress would be beyond any strength.
pub(crate) fn check_spin(problem: &BrittleProblem) -> Result<(), Refusal> {
    let rim = problem.solid.mesh.vertices.iter().map(|x| problem.spin.cross(x).norm());
    within(
        "rim speed of the spin [m/s]",
        rim.fold(0.0, f64::max),
        0.0,
        problem.material.shear_speed(),
    )
}

/// The section in which four fifths of the body lie is at least three cells thick.
pub(crate) fn check_thickness(
    problem: &BrittleProblem,
    points: &[Vec3],
    spacing: &Vec3,
) -> Result<(), Refusal> {
    let thickness = Nearest::new(&problem.solid.mesh).thickness(points);
    // Cells are flattened only across a flat body.
    let cells = thickness / spacing.min();
    if cells < CELLS_ACROSS {
        return Err(Refusal::TooThin { thickness, cells, minimum: CELLS_ACROSS });
    }
    Ok(())
}
