//! What spreads in a sheet as it moves.

use super::SheetRun;
use crate::diffusion::{DiffusionStep, ObjectContacts};
use crate::state::SheetState;
use cullet_continuum::TouchedPoints;
use std::sync::Arc;

impl SheetRun {
    /// Works out masses and bonds for what the sheet holds now.
    pub(super) fn take_up(&mut self) {
        let prepared = Arc::clone(&self.prepared);
        let sheet = prepared.sheet();
        let quantities = &sheet.diffusion.all;
        if !quantities.is_empty() {
            let SheetState { theta, exposure, .. } = &self.state;
            self.table.update(&prepared.bonds, quantities, theta, exposure);
        }
        self.read_bonds(true);
        if quantities.is_empty() {
            return;
        }
        for (i, masses) in self.masses.iter_mut().enumerate() {
            let dry = prepared.dry(i);
            let area = prepared.points.areas[i];
            let gain = quantities.iter().zip(self.state.thetas_at(i)).map(|(what, theta)| {
                let held = what.weight * sheet.thickness * area;
                held * (theta - what.start)
            });
            let gained = gain.sum::<f64>().max(-0.5 * dry[0]);
            *masses = dry.map(|mass| mass + gained);
        }
    }

    /// Lets each quantity spread where its time has come.
    pub(super) fn diffuse(&mut self) {
        self.count_contacts();
        let prepared = Arc::clone(&self.prepared);
        let quantities = &prepared.sheet().diffusion.all;
        let cycles = |k: usize| {
            let step = prepared.diffusion[k].step;
            (prepared.setup.world_step / step).ceil().max(1.0)
        };
        let due = |k: usize| {
            let substeps = f64::from(prepared.substeps);
            let share = |n: u32| (cycles(k) * f64::from(n) / substeps).floor();
            (share(self.substep + 1) - share(self.substep)) as u64
        };
        let due: Vec<u64> = (0..quantities.len()).map(due).collect();
        if due.iter().all(|&steps| steps == 0) {
            return;
        }
        let before = self.mechanical();
        let count = self.state.places.len();
        for (k, what) in quantities.iter().enumerate() {
            let time = self.time(self.substep);
            let SheetState { theta, exposure, damage, .. } = &mut self.state;
            let own = k * count..(k + 1) * count;
            let (theta, exposure) = (&mut theta[own.clone()], &mut exposure[own]);
            let step = DiffusionStep {
                what,
                areas: &prepared.points.areas,
                contacts: &self.contacts[k],
                damage,
                time,
                dt: prepared.setup.world_step / cycles(k),
            };
            for _ in 0..due[k] {
                let bonds = &prepared.diffusion[k];
                self.books.quantities_in[k] +=
                    bonds.advance(step, theta, exposure, &mut self.next_theta);
            }
            if due[k] > 0 {
                self.contacts[k].clear();
            }
        }
        let old: Vec<f64> = match quantities.iter().any(|what| what.weight > 0.0) {
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
        self.books.quantity_work += self.mechanical() - before;
    }

    /// Energy of bonds, bending and motion \[J\].
    fn mechanical(&self) -> f64 {
        self.energy_input().stretching(&self.state)
            + self.energy_input().bending(&self.state)
            + self.kinetic()
    }

    /// Counts which objects of the scene touch which points, where a quantity comes from them.
    fn count_contacts(&mut self) {
        if !self.prepared.sheet().diffusion.asks_for_objects() {
            return;
        }
        let points = TouchedPoints {
            places: &self.state.places,
            velocities: &self.state.velocities,
            masses: &self.masses,
            frozen: &self.frozen,
            distance: self.prepared.contact(),
            dt: self.prepared.step(),
        };
        let count = self.state.places.len();
        self.contacts.iter_mut().for_each(ObjectContacts::count_step);
        for proxy in &mut self.proxies {
            let Some(object) = proxy.object() else { continue };
            let touching: Vec<usize> = proxy.touching_points(&points).collect();
            for contacts in &mut self.contacts {
                contacts.note(object, count, touching.iter().copied());
            }
        }
    }
}
