//! What a problem must be like for the shell family, and how finely it is solved.

use crate::domain::STEP_SHARE;
use crate::midsurface::StepBounds;
use cullet_geometry::midsurface::WallSurface;
use cullet_geometry::plate::{NotPlate, Plate};
use cullet_geometry::quads::QuadSurface;
use cullet_model::{BrittleProblem, Cost, Refusal};

/// Thickness over the smaller extent up to which a body is a shell \[gate 4\].
pub(crate) const SLENDER: f64 = 0.125;

/// Cells over the thickness: below the first a cell is no shell's, above the second bending locks.
const CELLS: (f64, f64) = (0.25, 4.0);

/// Cells of the smaller extent that are wanted at least.
const ACROSS: f64 = 24.0;

/// Size of a cell of what yields over the thickness: what is wanted, and at most. No crack is to be
/// resolved.
const DENTED_CELLS: (f64, f64) = (1.5, 16.0);

/// How far above its bound a size of cells may be that comes from the solve before: the wall is not
/// quite as thick by now.
const ROUGHLY: f64 = 1.1;

/// Cells of the smaller extent of what yields: at least, and what is wanted.
const DENTED: (f64, f64) = (16.0, 40.0);

/// Spacing over √(Rt), the length over which a curved wall bends, for R half of its middle extent.
const BENT: f64 = 0.33;

/// Fewest cells of a curved wall that are wanted.
const FEWEST: f64 = 2500.0;

/// Bytes that a control point needs with its cell and its four points.
const BYTES: f64 = 4000.0;

/// How a problem is solved.
#[derive(Debug)]
pub(super) struct ShellPlan {
    pub(super) body: ThinBody,
    pub(super) spacing: f64,
    pub(super) cost: Cost,
}

/// A body that is a thin wall.
#[derive(Debug)]
pub(super) enum ThinBody {
    /// A flat one, of any outline.
    Plate(Plate),
    /// A curved one, if its walls pair: why it is no flat one.
    Wall(NotPlate),
}

/// What decides about spacing and cost.
struct WallSize {
    thickness: f64,
    /// Length that a quarter of the spacing must resolve at least: the smaller extent of a plate.
    least: f64,
    /// Spacing that resolves how a curved wall bends \[m\]; none of a flat one.
    bent: f64,
    /// Area that is discretised \[m²\].
    area: f64,
}

/// Refuses what is not a number from `low` to `high`.
fn within(what: &'static str, value: f64, [low, high]: [f64; 2]) -> Result<(), Refusal> {
    match (low..=high).contains(&value) {
        true => Ok(()),
        false => Err(Refusal::OutOfRange { what, value, low, high }),
    }
}

impl ShellPlan {
    /// Checks the problem.
    ///
    /// # Errors
    /// The bound that it breaks.
    pub(super) fn new(problem: &BrittleProblem, is_metal: bool) -> Result<Self, Refusal> {
        check(problem)?;
        match Plate::of_mesh(&problem.solid.mesh) {
            Ok(plate) => Self::of_plate(problem, plate, is_metal),
            Err(flat) => Self::of_wall(problem, flat, is_metal),
        }
    }

    fn of_plate(problem: &BrittleProblem, plate: Plate, is_metal: bool) -> Result<Self, Refusal> {
        let (t, least) = (plate.thickness, plate.size[0].min(plate.size[1]));
        within("thickness over the smaller extent of the plate", t / least, [0.0, SLENDER])?;
        let area = plate.size[0] * plate.size[1];
        let size = WallSize { thickness: t, least, bent: 0.0, area };
        let spacing = spacing(problem, &size, is_metal)?;
        let cost = cost(problem, &size, spacing, (StepBounds::PATCH, is_metal))?;
        Ok(Self { body: ThinBody::Plate(plate), spacing, cost })
    }

    fn of_wall(problem: &BrittleProblem, flat: NotPlate, is_metal: bool) -> Result<Self, Refusal> {
        let mesh = &problem.solid.mesh;
        // Both walls and little else: V = tA/2.
        let area = 0.5 * mesh.area();
        let mut extents = mesh.bounds().map_or([0.0; 3], |(low, high)| (high - low).into());
        extents.sort_by(f64::total_cmp);
        let extent = extents[1];
        let t = mesh.signed_volume() / area;
        let ratio = t / area.sqrt();
        if ratio > SLENDER {
            let lack = format!(
                "2V/A is {ratio:.2} of the square root of half its surface A; a \
                                thin wall has at most {SLENDER}"
            );
            return Err(neither("shell", &flat, &lack));
        }
        let bent = (BENT * (t * 0.5 * extent).sqrt()).min((area / FEWEST).sqrt());
        let size = WallSize { thickness: t, least: extent, bent, area };
        let spacing = spacing(problem, &size, is_metal)?;
        let cost = cost(problem, &size, spacing, (StepBounds::EVEN, is_metal))?;
        Ok(Self { body: ThinBody::Wall(flat), spacing, cost })
    }
}

/// The midsurface of a body that may be a curved wall, in cells of about `spacing` \[m\]. `flat` is
/// why it is no plate.
pub(super) fn wall_surface(
    problem: &BrittleProblem,
    flat: &NotPlate,
    spacing: f64,
) -> Result<QuadSurface, Refusal> {
    let wall = WallSurface::of_solid(&problem.solid, spacing);
    let wall = wall.map_err(|lack| neither("shell", flat, &lack))?;
    QuadSurface::of_wall(&wall, spacing, problem.seed).map_err(|lack| neither("shell", flat, &lack))
}

/// That a body is neither a plate nor a wall, to the family `solver`.
pub(crate) fn neither(
    solver: &'static str,
    flat: &dyn std::fmt::Display,
    lack: &dyn std::fmt::Display,
) -> Refusal {
    let lack = format!("it is no flat plate ({flat}) and no curved wall ({lack})");
    Refusal::Unfit { solver, lack }
}

/// Size of a cell \[m\].
fn spacing(problem: &BrittleProblem, size: &WallSize, is_metal: bool) -> Result<f64, Refusal> {
    let t = size.thickness;
    let settings = &problem.settings;
    let most = f64::from(settings.max_particles.max(1));
    // Cracks are resolved by the thickness, dents by the extent.
    let (fine, across, coarse) = match is_metal {
        true => ((size.least / DENTED.1).max(DENTED_CELLS.0 * t), DENTED.0, DENTED_CELLS.1),
        false => (0.5 * t, ACROSS, CELLS.1),
    };
    let wanted = fine.max(size.bent).min(size.least / across).max((size.area / most).sqrt());
    let spacing = settings.spacing.unwrap_or(wanted.clamp(CELLS.0 * t, coarse * t));
    within("cells over the thickness", spacing / t, [CELLS.0, ROUGHLY * coarse])?;
    let points = size.area / (spacing * spacing);
    if points > 1.1 * most {
        let what = "the number of control points";
        return Err(Refusal::TooLarge { what, value: points, limit: most });
    }
    Ok(spacing)
}

/// What the solve takes.
fn cost(
    problem: &BrittleProblem,
    size: &WallSize,
    spacing: f64,
    (bounds, is_metal): (StepBounds, bool),
) -> Result<Cost, Refusal> {
    let material = &problem.material;
    let modulus = material.young / (1.0 - material.poisson * material.poisson);
    let speed = (modulus / material.density).sqrt();
    let step = STEP_SHARE * bounds.step(spacing, size.thickness, speed);
    let steps = super::schedule::ShellSchedule::new(problem, is_metal).end / step;
    let limit = f64::from(problem.settings.max_steps);
    if steps > limit {
        return Err(Refusal::TooLarge { what: "the number of steps", value: steps, limit });
    }
    let points = size.area / (spacing * spacing);
    Ok(Cost { particles: points, steps, bytes: points * BYTES })
}

/// What a body lacks that is no plate.
pub(crate) fn refusal(why: &NotPlate) -> Refusal {
    Refusal::Unfit { solver: "shell", lack: why.to_string() }
}

fn check(problem: &BrittleProblem) -> Result<(), Refusal> {
    let m = &problem.material;
    within("density [kg/m^3]", m.density, [1e-3, 1e6])?;
    within("Young's modulus [Pa]", m.young, [1.0, 1e14])?;
    within("Poisson's ratio", m.poisson, [-0.5, 0.49])?;
    within("fracture energy [J/m^2]", m.fracture_energy, [1e-9, 1e9])?;
    within("failure stress over Young's modulus", m.failure_stress / m.young, [1e-5, 1e-1])?;
    within("the number of impacts", problem.impacts.len() as f64, [1.0, 1e4])?;
    for hit in &problem.impacts {
        within("impulse [N s]", hit.impulse, [f64::MIN_POSITIVE, 1e12])?;
        within("contact duration [s]", hit.duration, [f64::MIN_POSITIVE, 1e6])?;
        within("contact radius [m]", hit.radius, [f64::MIN_POSITIVE, 1e6])?;
        within("length of the impact's normal", hit.normal.norm(), [1.0 - 1e-6, 1.0 + 1e-6])?;
        within("distance of the impact [m]", hit.point.norm(), [0.0, 1e6])?;
        within("impact energy [J]", hit.energy, [f64::MIN_POSITIVE, 1e18])?;
        within("closing speed [m/s]", hit.closing_speed, [f64::MIN_POSITIVE, 1e5])?;
        within("crushing pressure [Pa]", hit.crushing_pressure, [1.0, 1e30])?;
    }
    for support in &problem.supports {
        within("radius of a support [m]", support.radius, [f64::MIN_POSITIVE, 1e6])?;
        within("length of a support's normal", support.normal.norm(), [1.0 - 1e-6, 1.0 + 1e-6])?;
        within("distance of a support [m]", support.point.norm(), [0.0, 1e6])?;
        within("mobility of a support [1/kg]", support.mobility, [0.0, 1e12])?;
    }
    if let Some(plane) = problem.strength.weak_plane {
        within("strength across a weak plane, of a shell", plane.ratio, [1.0, 1.0])?;
    }
    within("angular velocity of a shell [rad/s]", problem.spin.norm(), [0.0, 0.0])
}
