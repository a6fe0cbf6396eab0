//! What spreads in a sheet as it moves.

use super::SheetRun;
use crate::diffusion::DiffusionStep;
use crate::state::SheetState;
use std::sync::Arc;

impl SheetRun {
    /// Works out masses and bonds for what the sheet holds now.
    pub(super) fn take_up(&mut self) {
        if let Some(what) = &self.prepared.sheet().diffusion {
            self.table.update(&self.prepared.bonds, what, &self.state.theta, &self.state.exposure);
        }
        self.read_bonds(true);
        let Some(what) = &self.prepared.sheet().diffusion else {
            return;
        };
        let thickness = self.prepared.sheet().thickness;
        for (i, masses) in self.masses.iter_mut().enumerate() {
            let dry = self.prepared.dry(i);
            let held = what.weight * thickness * self.prepared.points.areas[i];
            let gained = (held * (self.state.theta[i] - what.start)).max(-0.5 * dry[0]);
            *masses = dry.map(|mass| mass + gained);
        }
    }

    /// Lets the quantity spread where its time has come.
    pub(super) fn diffuse(&mut self) {
        let prepared = Arc::clone(&self.prepared);
        let (Some(bonds), Some(what)) = (&prepared.diffusion, &prepared.sheet().diffusion) else {
            return;
        };
        let cycles = (prepared.setup.world_step / bonds.step).ceil().max(1.0);
        let share = |k: u32| (cycles * f64::from(k) / f64::from(prepared.substeps)).floor();
        let due = (share(self.substep + 1) - share(self.substep)) as u64;
        if due == 0 {
            return;
        }
        let before = self.energy_input().stretching(&self.state)
            + self.energy_input().bending(&self.state)
            + self.kinetic();
        for _ in 0..due {
            let time = self.time(self.substep);
            let SheetState { theta, exposure, damage, .. } = &mut self.state;
            let step = DiffusionStep {
                what,
                areas: &prepared.points.areas,
                damage,
                time,
                dt: prepared.setup.world_step / cycles,
            };
            self.books.quantity_in += bonds.advance(step, theta, exposure, &mut self.next_theta);
        }
        let old: Vec<f64> = match what.weight > 0.0 {
            true => self.masses.iter().map(|m| m[1]).collect(),
            false => Vec::new(),
        };
        self.take_up();
        // What arrives moves as the sheet does there.
        for (i, old) in old.iter().enumerate() {
            let gained = self.state.velocities[i] * (self.masses[i][1] - old);
            self.books.sums.impulse += gained;
            self.books.sums.exchanged += gained.norm();
        }
        let after = self.energy_input().stretching(&self.state)
            + self.energy_input().bending(&self.state)
            + self.kinetic();
        self.books.quantity_work += after - before;
    }
}
