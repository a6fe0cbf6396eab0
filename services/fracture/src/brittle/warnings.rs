//! What is noticed before a brittle solve begins, and of the faces that it leaves, a sentence each.

use super::schedule::Schedule;
use crate::damage::Softening;
use crate::mpm::load_patch::LEAST_RADIUS;
use cullet_fragment::grid_bias::grid_bias;
use cullet_geometry::{Solid, Vec3};
use cullet_model::BrittleProblem;
use cullet_model::brittle::PUSH_TRANSITS;
use cullet_model::hertz_contact::{self, HertzContact};

/// Strain at which a point is broken through above which the solid is not brittle on this grid.
const DUCTILE: f64 = 0.05;

/// What is known before the first step.
pub(super) fn first(
    problem: &BrittleProblem,
    softening: &Softening,
    schedule: &Schedule,
    spacing: &Vec3,
) -> Vec<String> {
    let mut warnings = Vec::new();
    if spacing.min() < spacing.max() {
        warnings.push(format!(
            "flat: cells of {:.3e} m in the plane and {:.3e} m across (F14)",
            spacing.max(),
            spacing.min()
        ));
    }
    if softening.strength_ratio < 1.0 {
        warnings.push(format!(
            "toughness-controlled: cracks grow at {:.3} of the material's strength at this spacing \
             (F01)",
            softening.strength_ratio
        ));
    }
    let strain = softening.breaking_strain();
    if strain > DUCTILE {
        warnings.push(format!(
            "ductile: points are broken through at a strain of {strain:.3} at this spacing; the \
             strength is low for the fracture energy (F02)"
        ));
    }
    for impact in &problem.impacts {
        let (duration, contact) = (hertz_contact::duration(impact), HertzContact::new(impact));
        if duration > schedule.push {
            warnings.push(format!(
                "push of {:.3e} s shortened to {:.3e} s, {PUSH_TRANSITS} transits, at the same \
                 peak force (F12)",
                duration, schedule.push
            ));
        }
        let least = LEAST_RADIUS * spacing.max();
        let radius = contact.radius(contact.depth(impact.energy));
        if radius < least {
            warnings.push(format!(
                "contact radius {radius:.3e} m widened to {least:.3e} m, {LEAST_RADIUS} cells (F11)"
            ));
        }
        if contact.crushes(impact.energy) {
            warnings.push(format!(
                "the contact crushes at {:.3e} Pa: {:.3} of the Hertz force (F13)",
                impact.crushing_pressure,
                contact.peak(impact.energy) / contact.elastic_peak(impact.energy)
            ));
        }
    }
    warnings
}

/// A warning if new crack faces lie along the planes of the grid ([`grid_bias`], F22).
#[must_use]
pub fn grid_bias_warning<'a>(solids: impl Iterator<Item = &'a Solid>) -> Option<String> {
    let bias = grid_bias(solids, |_| true, &[], [Vec3::x(), Vec3::y(), Vec3::z()]);
    bias.shows().then(|| {
        let times = bias.times;
        format!("crack faces lie along the grid's planes {times:.1} times as often as chance (F22)")
    })
}
