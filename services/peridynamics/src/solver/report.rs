//! What is reported of a solve.

use super::Peridynamics;
use cullet_model::outcome::{DAMAGED_FRACTION, DELIVERED_IMPULSE, STRENGTH_RATIO};
use cullet_model::{Report, Solver};

/// How far the energy may be from what was given before it is worth a word \[1\].
const LEDGER: f64 = 0.01;

/// Share of points at edges and in thin places that needs no word \[1\].
const LOOSE: f64 = 0.5;

/// Stress at which bonds break over the strength of the material that needs no word \[1\].
const STRENGTH: std::ops::Range<f64> = 0.7..1.4;

impl Peridynamics {
    /// Stress at which bonds that are drawn along one axis break, over the strength of the
    /// material, where they break and do not yield \[1\].
    fn strength_ratio(&self) -> Option<f64> {
        let material = &self.problem.material;
        let stress = material.young * self.body.domain.critical;
        (self.bonds.breaks && self.bonds.hardening.is_none())
            .then_some(stress / material.failure_stress)
    }

    pub(super) fn report(&self) -> Report {
        let (record, domain) = (&self.record, &self.body.domain);
        let delivered = self.strikers.iter().zip(&self.problem.impacts);
        let delivered: f64 = delivered.map(|(it, hit)| it.given.dot(&hit.normal)).sum();
        let crushed = self.presses().map(|it| it.crushed).sum();
        let strain = domain.states.iter().map(|state| state.plastic).fold(0.0, f64::max);
        let points = domain.states.len() as f64;
        let damaged = domain.states.iter().filter(|state| state.damage > 0.5).count() as f64;
        let loose = domain.bonds.loose as f64;
        let mut report = Report {
            solver: Self::NAME.to_owned(),
            spacing: 2.0 * self.setup.spacing,
            particles: domain.states.len() as u64,
            steps: self.body.clock.steps,
            simulated: self.body.clock.time,
            dissipated_energy: record.plastic + record.broken,
            warnings: record.warnings.clone(),
            ..Report::default()
        }
        .with(DELIVERED_IMPULSE, "N·s", delivered)
        .with(DAMAGED_FRACTION, "1", damaged / points)
        .with("bonds", "1", domain.bonds.count() as f64)
        .with("points_with_loose_bonds", "1", loose)
        .with("plastic_work", "J", record.plastic)
        .with("breaking_work", "J", record.broken)
        .with("damping", "J", record.damped)
        .with("vibration", "J", self.settling.taken)
        .with("greatest_plastic_strain", "1", strain)
        .with("energy_balance", "1", 1.0 + record.energy_off)
        .with("energy_of_crushed_contact", "J", crushed);
        let off = record.energy_off;
        if off.abs() > LEDGER {
            report.warnings.push(format!("energy is off by {off:+.3} of what the hits had"));
        }
        if loose > LOOSE * points {
            report.warnings.push(format!(
                "no weights make the bonds of {loose} of {points} points bear alike in all \
                 directions: edges and thin places are too soft"
            ));
        }
        if self.bonds.breaks {
            let stretch = domain.critical;
            report = report.with("stretch_at_which_bonds_break", "1", stretch);
        }
        if let Some(ratio) = self.strength_ratio() {
            report = report.with(STRENGTH_RATIO, "1", ratio);
            if !STRENGTH.contains(&ratio) {
                report.warnings.push(format!(
                    "bonds break at {ratio:.2} of the material's strength: at this spacing its \
                     toughness decides"
                ));
            }
        }
        let (unbooked, jumped) = record.unbooked;
        if jumped > 0 {
            report.warnings.push(format!(
                "{jumped} bonds were drawn from pressed to broken in one step: {unbooked:.2e} J \
                 are missing from what breaking took"
            ));
        }
        report
    }
}
