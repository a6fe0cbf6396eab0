//! What a brittle solve reports, and what its detectors notice and let pass.

use super::Brittle;
use super::crushing::CrushedZone;
use crate::mpm::diagnostics;
use crate::mpm::load::ImpactLoad;
use cullet_geometry::Vec3;
use cullet_model::outcome::{DAMAGED_FRACTION, DELIVERED_IMPULSE, STRENGTH_RATIO};
use cullet_model::{Report, Solver};

impl Brittle {
    pub(super) fn report(&self, damage: &[f64]) -> Report {
        let particles = self.domain.particles.len();
        let damaged = damage.iter().filter(|&&c| c > 0.5).count();
        let mut report = Report {
            solver: Self::NAME.to_owned(),
            spacing: self.domain.grid.spacing.max(),
            particles: particles as u64,
            steps: self.domain.steps,
            simulated: self.schedule.spin_up + self.domain.time,
            dissipated_energy: self.record.total.dissipated,
            warnings: self.record.warnings.clone(),
            ..Report::default()
        }
        .with(STRENGTH_RATIO, "1", self.setup.strength_ratio)
        .with(DAMAGED_FRACTION, "1", damaged as f64 / particles as f64)
        .with(DELIVERED_IMPULSE, "N·s", self.delivered())
        .with("energy_balance", "1", 1.0 + self.record.balance.off)
        .with("work", "J", self.work())
        .with("energy_of_contact_of_sides", "J", self.record.total.collided)
        .with("energy_of_crushed_contact", "J", self.crushing_energy());
        let zones = || self.zones.iter().flatten();
        if let Some(length) = zones().map(|zone| zone.length).reduce(f64::max) {
            let energy = zones().map(CrushedZone::starting_energy).sum();
            let wedge = zones().map(|zone| zone.work).sum();
            report = report
                .with("starting_crack", "m", length)
                .with("energy_of_starting_cracks", "J", energy)
                .with("energy_of_wedge", "J", wedge);
            report.warnings.push(format!(
                "crushed: cracks of up to {length:.3e} m start under the contact, for \
                 {energy:.3e} J, and {wedge:.3e} J push apart what is around, of {:.3e} J that \
                 crushing took (F13)",
                self.crushing_energy()
            ));
        }
        self.last_warnings(&mut report);
        report
    }

    /// Energy that crushing of the contacts took \[J\].
    fn crushing_energy(&self) -> f64 {
        self.loads.iter().map(ImpactLoad::crushing_energy).sum()
    }

    /// Impulse that the loads have put into the body \[N·s\].
    fn delivered(&self) -> f64 {
        self.loads.iter().map(|load| load.delivered).sum()
    }

    /// What is known after the last step.
    pub(super) fn last_warnings(&self, report: &mut Report) {
        let warnings = &mut report.warnings;
        let impulse: f64 = self.problem.impacts.iter().map(|hit| hit.impulse).sum();
        let share = self.delivered() / impulse;
        if share < 1.0 - 1e-9 {
            warnings
                .push(format!("{share:.3} of the impulse was taken; the striker keeps the rest"));
        }
        let crushed = self.record.total.crushed;
        if crushed > 0 {
            warnings.push(format!("crushed: {crushed} points were at J = 0.2 at one time (F07)"));
        }
        let quiet = self.domain.time - self.record.activity.last;
        if quiet < self.schedule.transit {
            warnings.push(format!(
                "still breaking: damage grew {quiet:.2e} s before the end, a transit is {:.2e} s \
                 (F12)",
                self.schedule.transit
            ));
        }
        warnings.extend(self.record.diagnostics.warnings());
        let (ahead, furthest) = self.ahead();
        if ahead > 0 {
            warnings.push(format!(
                "{ahead} points broke before sound came to them, by up to {furthest:.3e} m (F06)"
            ));
        }
        let drift = self.record.fastest.sqrt() * self.domain.step / self.domain.grid.spacing.min();
        if drift > 0.2 {
            warnings.push(format!("fast: a point moved {drift:.2} cells in a step (F04)"));
        }
        warnings.extend(self.record.balance.tell());
    }

    /// [`diagnostics::ahead`] of the contacts (F06). A spin stresses all of a body before the push.
    pub(super) fn ahead(&self) -> (u32, f64) {
        if self.schedule.spin_up > 0.0 {
            return (0, 0.0);
        }
        let discs: Vec<(Vec3, f64)> = self.loads.iter().map(|l| (l.point, l.radius)).collect();
        diagnostics::ahead(&self.domain, &discs, self.problem.material.pressure_speed())
    }
}
