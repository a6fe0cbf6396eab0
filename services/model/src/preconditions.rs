//! What the numbers of a problem must be like for every method that takes hits.

use crate::{Impact, Refusal, Support, SurfaceLaw};

/// Refuses what is not a number from `low` to `high`.
///
/// # Errors
/// [`Refusal::OutOfRange`] if it is not.
pub fn within(what: &'static str, value: f64, low: f64, high: f64) -> Result<(), Refusal> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Refusal::OutOfRange { what, value, low, high })
}

/// That there is a hit, and that the numbers of each hold.
///
/// # Errors
/// [`Refusal::OutOfRange`] with the first that does not.
pub fn check_impacts(impacts: &[Impact]) -> Result<(), Refusal> {
    within("the number of impacts", impacts.len() as f64, 1.0, 1e4)?;
    for impact in impacts {
        within("impulse [N s]", impact.impulse, f64::MIN_POSITIVE, 1e12)?;
        within("contact duration [s]", impact.duration, f64::MIN_POSITIVE, 1e6)?;
        within("contact radius [m]", impact.radius, f64::MIN_POSITIVE, 1e6)?;
        within("length of the impact's normal", impact.normal.norm(), 1.0 - 1e-6, 1.0 + 1e-6)?;
        within("distance of the impact [m]", impact.point.norm(), 0.0, 1e6)?;
        within("impact energy [J]", impact.energy, f64::MIN_POSITIVE, 1e18)?;
        within("closing speed [m/s]", impact.closing_speed, f64::MIN_POSITIVE, 1e5)?;
        within("crushing pressure [Pa]", impact.crushing_pressure, 1.0, 1e30)?;
    }
    Ok(())
}

/// That the numbers of a surface hold.
///
/// # Errors
/// [`Refusal::OutOfRange`] with the first that does not.
pub fn check_surface(surface: &SurfaceLaw) -> Result<(), Refusal> {
    within("hardness [Pa]", surface.hardness, 1e-3, 1e13)?;
    within("friction of crack faces", surface.friction, 0.0, 10.0)
}

/// That the numbers of each support hold.
///
/// # Errors
/// [`Refusal::OutOfRange`] with the first that does not.
pub fn check_supports(supports: &[Support]) -> Result<(), Refusal> {
    within("the number of supports", supports.len() as f64, 0.0, 1e4)?;
    for support in supports {
        within("radius of a support [m]", support.radius, f64::MIN_POSITIVE, 1e6)?;
        within("length of a support's normal", support.normal.norm(), 1.0 - 1e-6, 1.0 + 1e-6)?;
        within("distance of a support [m]", support.point.norm(), 0.0, 1e6)?;
        within("mobility of a support [1/kg]", support.mobility, 0.0, 1e12)?;
    }
    Ok(())
}
