//! What a problem must be like for the shell family, and how finely it is solved.

use crate::domain::{STEP_SHARE, stable_step};
use cullet_geometry::plate::{NotPlate, Plate, SLENDER as SQUARE, VOLUME};
use cullet_model::{BrittleProblem, Cost, Refusal};

/// Thickness over the smaller extent up to which a body is a shell \[gate 4\].
pub(crate) const SLENDER: f64 = 0.125;

/// Cells over the thickness: below the first a cell is no shell's, above the second bending locks.
const CELLS: (f64, f64) = (0.25, 4.0);

/// Cells of the smaller extent that are wanted at least.
const ACROSS: f64 = 24.0;

/// Bytes that a control point needs with its cell and its four points.
const BYTES: f64 = 4000.0;

/// A plate and its spacing.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlatePlan {
    pub(super) plate: Plate,
    pub(super) spacing: f64,
    pub(super) cost: Cost,
}

/// Refuses what is not a number from `low` to `high`.
fn within(what: &'static str, value: f64, [low, high]: [f64; 2]) -> Result<(), Refusal> {
    match (low..=high).contains(&value) {
        true => Ok(()),
        false => Err(Refusal::OutOfRange { what, value, low, high }),
    }
}

impl PlatePlan {
    /// Checks the problem.
    ///
    /// # Errors
    /// The bound that it breaks.
    pub(super) fn new(problem: &BrittleProblem) -> Result<Self, Refusal> {
        check(problem)?;
        let plate = Plate::of_mesh(&problem.solid.mesh).map_err(refusal)?;
        let (t, least) = (plate.thickness, plate.size[0].min(plate.size[1]));
        within("thickness over the smaller extent of the plate", t / least, [0.0, SLENDER])?;
        let settings = &problem.settings;
        let most = f64::from(settings.max_particles.max(1));
        let wanted = (0.5 * t).max((plate.area / most).sqrt()).min(least / ACROSS);
        let spacing = settings.spacing.unwrap_or(wanted.clamp(CELLS.0 * t, CELLS.1 * t));
        within("cells over the thickness", spacing / t, [CELLS.0, CELLS.1])?;
        let points = plate.size[0] * plate.size[1] / (spacing * spacing);
        if points > 1.1 * most {
            let what = "the number of control points";
            return Err(Refusal::TooLarge { what, value: points, limit: most });
        }
        let material = &problem.material;
        let modulus = material.young / (1.0 - material.poisson * material.poisson);
        let speed = (modulus / material.density).sqrt();
        let step = STEP_SHARE * stable_step(spacing, t, speed);
        let steps = super::schedule::ShellSchedule::new(problem).end / step;
        let limit = f64::from(settings.max_steps);
        if steps > limit {
            return Err(Refusal::TooLarge { what: "the number of steps", value: steps, limit });
        }
        let cost = Cost { particles: points, steps, bytes: points * BYTES };
        Ok(Self { plate, spacing, cost })
    }
}

/// What a body lacks that is no plate.
pub(crate) fn refusal(why: NotPlate) -> Refusal {
    let (what, value, low, high) = match why {
        NotPlate::Volume { share } => {
            let what = "volume over that between the two largest parallel faces";
            (what, share, 1.0 - VOLUME, 1.0 + VOLUME)
        }
        NotPlate::Thick { ratio } => {
            ("thickness over the square root of a face's area", ratio, 0.0, SQUARE)
        }
        NotPlate::NoFaces => ("the number of parallel faces", 0.0, 2.0, 2.0),
    };
    Refusal::OutOfRange { what, value, low, high }
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
