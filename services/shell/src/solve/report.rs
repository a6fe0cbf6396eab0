//! What a solve of a shell reports, and what it notices and lets pass.

use super::contact::ShellStriker;
use super::run::{NAME, ShellSolve};
use cullet_model::Report;
use cullet_model::outcome::{DAMAGED_FRACTION, DELIVERED_IMPULSE, STRENGTH_RATIO};
use cullet_simd::Real;

/// Speed that a striker keeps, over that at first, above which it has gone through (F98).
const THROUGH: f64 = 0.5;

/// How far the energy may be from what was given before it is worth a word \[1\].
const LEDGER: f64 = 0.02;

impl<R: Real, const N: usize> ShellSolve<R, N> {
    /// Impulse that the strikers have given \[N·s\].
    fn delivered(&self) -> f64 {
        self.strikers.iter().map(ShellStriker::delivered).sum()
    }

    pub(super) fn report(&self, damage: &[f64]) -> Report {
        let tip = self.domain.tip_strength(self.wall.spacing);
        let damaged = damage.iter().filter(|&&c| c > 0.5).count();
        let crushed = self.strikers.iter().map(ShellStriker::crushed).sum();
        let mut report = Report {
            solver: NAME.to_owned(),
            spacing: self.wall.spacing,
            particles: self.domain.live().count() as u64,
            steps: self.record.steps,
            simulated: self.record.time,
            dissipated_energy: self.record.dissipated,
            warnings: self.record.warnings.clone(),
            ..Report::default()
        }
        .with(STRENGTH_RATIO, "1", (tip / self.local.material.failure_stress).min(1.0))
        .with(DAMAGED_FRACTION, "1", damaged as f64 / damage.len().max(1) as f64)
        .with(DELIVERED_IMPULSE, "N·s", self.delivered())
        .with("energy_balance", "1", 1.0 + self.record.energy_off)
        .with("splits", "1", self.domain.splits() as f64)
        .with("energy_of_contact_of_sides", "J", self.record.met)
        .with("energy_of_crushed_contact", "J", crushed);
        self.last_warnings(&mut report);
        report
    }

    fn last_warnings(&self, report: &mut Report) {
        let off = self.record.energy_off;
        if off.abs() > LEDGER {
            report.warnings.push(format!("energy is off by {off:+.3} of what the hits had"));
        }
        if self.is_dicing() {
            // It ends where it starts to dice, whatever moves then.
            return;
        }
        if self.nature.hardening.is_some() {
            return;
        }
        for striker in self.strikers.iter().filter(|striker| striker.left() > THROUGH) {
            report.warnings.push(format!(
                "punched: the striker goes on at {:.2} of its speed (F98)",
                striker.left()
            ));
        }
        let quiet = self.record.time - self.record.last_growth;
        if quiet < self.schedule.quiet {
            report
                .warnings
                .push(format!("still breaking: damage grew {quiet:.2e} s before the end (F12)"));
        }
    }
}
