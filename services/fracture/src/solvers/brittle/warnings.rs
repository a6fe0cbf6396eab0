//! What the detectors of a brittle solve notice and let pass, a sentence each.

use super::clock::{Clock, PUSH_TRANSITS};
use crate::damage::Softening;
use crate::mpm::load::LEAST_RADIUS;
use crate::mpm::spring::{self, Spring};
use crate::solver::Problem;
use cullet_geometry::Vec3;

/// Strain at which a point is broken through above which the solid is not brittle on this grid.
const DUCTILE: f64 = 0.05;

/// What is known before the first step.
pub(super) fn first(
    problem: &Problem,
    softening: &Softening,
    clock: &Clock,
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
        let (duration, spring) = (spring::duration(impact), Spring::new(impact));
        if duration > clock.push {
            warnings.push(format!(
                "push of {:.3e} s shortened to {:.3e} s, {PUSH_TRANSITS} transits, at the same \
                 peak force (F12)",
                duration, clock.push
            ));
        }
        let least = LEAST_RADIUS * spacing.max();
        let radius = spring.contact(spring.depth(impact.energy));
        if radius < least {
            warnings.push(format!(
                "contact radius {radius:.3e} m widened to {least:.3e} m, {LEAST_RADIUS} cells (F11)"
            ));
        }
        if spring.crushes(impact.energy) {
            warnings.push(format!(
                "the contact crushes at {:.3e} Pa: {:.3} of the Hertz force (F13)",
                impact.crushing_pressure,
                spring.peak(impact.energy) / spring.elastic_peak(impact.energy)
            ));
        }
    }
    warnings
}
