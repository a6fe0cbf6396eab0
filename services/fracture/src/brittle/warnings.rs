//! What the detectors of a brittle solve notice and let pass, a sentence each.

use super::Brittle;
use super::clock::{Clock, PUSH_TRANSITS};
use crate::damage::Softening;
use crate::mpm::load::LEAST_RADIUS;
use crate::mpm::spring::{self, Spring};
use crate::mpm::watch;
use cullet_fragment::grid_bias::grid_bias;
use cullet_geometry::{Solid, Vec3};
use cullet_model::{BrittleProblem, Report};

/// Strain at which a point is broken through above which the solid is not brittle on this grid.
const DUCTILE: f64 = 0.05;

/// What is known before the first step.
pub(super) fn first(
    problem: &BrittleProblem,
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

impl Brittle {
    /// What is known after the last step.
    pub(super) fn last_warnings(&self, report: &mut Report) {
        let warnings = &mut report.warnings;
        let impulse: f64 = self.problem.impacts.iter().map(|hit| hit.impulse).sum();
        let share = self.delivered() / impulse;
        if share < 1.0 - 1e-9 {
            warnings
                .push(format!("{share:.3} of the impulse was taken; the striker keeps the rest"));
        }
        let crushed = self.total.crushed;
        if crushed > 0 {
            warnings.push(format!("crushed: {crushed} points were at J = 0.2 at one time (F07)"));
        }
        let quiet = self.domain.time - self.growth.last;
        if quiet < self.clock.transit {
            warnings.push(format!(
                "still breaking: damage grew {quiet:.2e} s before the end, a transit is {:.2e} s \
                 (F12)",
                self.clock.transit
            ));
        }
        warnings.extend(self.watch.warnings());
        let (ahead, furthest) = self.ahead();
        if ahead > 0 {
            warnings.push(format!(
                "{ahead} points broke before sound came to them, by up to {furthest:.3e} m (F06)"
            ));
        }
        let drift = self.fastest.sqrt() * self.domain.step / self.domain.grid.spacing.min();
        if drift > 0.2 {
            warnings.push(format!("fast: a point moved {drift:.2} cells in a step (F04)"));
        }
        let energy = self.problem.impacts.iter().map(|impact| impact.energy).sum::<f64>()
            + self.domain.spin.map_or(0.0, |spin| spin.work(&self.domain.grid));
        if self.total.dissipated > energy {
            warnings.push(format!(
                "damage cost {:.3e} J, approach and spin had {energy:.3e} J",
                self.total.dissipated
            ));
        }
    }

    /// [`watch::ahead`] of the contacts (F06). A spin stresses all of a body before the push.
    pub(super) fn ahead(&self) -> (u32, f64) {
        if self.clock.spin_up > 0.0 {
            return (0, 0.0);
        }
        let discs: Vec<(Vec3, f64)> = self.loads.iter().map(|l| (l.point, l.radius)).collect();
        watch::ahead(&self.domain, &discs, self.problem.material.pressure_speed())
    }
}

/// Whether new crack faces lie along the planes of the grid ([`grid_bias`], F22).
#[must_use]
pub fn lean<'a>(solids: impl Iterator<Item = &'a Solid>) -> Option<String> {
    let bias = grid_bias(solids, &[], [Vec3::x(), Vec3::y(), Vec3::z()]);
    bias.shows().then(|| {
        let times = bias.times;
        format!("crack faces lie along the grid's planes {times:.1} times as often as chance (F22)")
    })
}
