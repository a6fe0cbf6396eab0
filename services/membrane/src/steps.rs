//! Steps of a sheet: half a drift, forces, kick, half a drift. One evaluation of forces a step, of
//! second order and symplectic, and places and velocities belong to the same time, so that a state
//! needs nothing else.
//!
//! The work of a force is its product with the mean of the velocities before and after the kick:
//! that is exactly what the kinetic energy gains. With the old velocity alone the books would miss
//! 5 to 15 % of what dashpots take.

use crate::air;
use crate::bending::BendingStencils;
use crate::books::SheetBooks;
use crate::diffusion::DiffusionStep;
use crate::energies::EnergyInput;
use crate::forces::{ForceInput, ForceRows, PointTerms, StepSums, find_terms, kick, pass};
use crate::grips::{FREE, GripState};
use crate::lips::{LipPairs, LipSearch};
use crate::pieces::{components, renumber};
use crate::prepared::PreparedMembrane;
use crate::proxies::{RigidProxy, TouchedPoints};
use crate::rest::{RestCheck, patience};
use crate::state::SheetState;
use crate::table::BondTable;
use cullet_geometry::Vec3;
use std::sync::Arc;

/// Steps until points that may touch each other are found anew.
const SEARCH: u32 = 10;

/// A sheet in motion.
#[derive(Clone, Debug)]
pub(crate) struct SheetRun {
    pub(crate) prepared: Arc<PreparedMembrane>,
    pub(crate) state: SheetState,
    pub(crate) proxies: Vec<RigidProxy>,
    pub(crate) books: SheetBooks,
    /// Mass that weighs, and inertia, of each point \[kg\].
    pub(crate) masses: Vec<[f64; 2]>,
    pub(crate) stencils: BendingStencils,
    table: BondTable,
    lips: LipPairs,
    grips: GripState,
    /// Points of pieces at rest.
    frozen: Vec<bool>,
    /// Steps of the step of the world so far.
    substep: u32,
    /// Steps of the world since the run began.
    number: usize,
    breaks: u32,
    terms: Vec<PointTerms>,
    after: Vec<Vec3>,
    held: Vec<Vec3>,
    torn: Vec<bool>,
    touch: Vec<Vec3>,
    led: Vec<Vec3>,
    next_theta: Vec<f64>,
}

impl SheetRun {
    /// Goes on from a state.
    pub(crate) fn new(
        prepared: Arc<PreparedMembrane>,
        state: SheetState,
        proxies: Vec<RigidProxy>,
    ) -> Self {
        let count = state.places.len();
        let mut run = Self {
            table: prepared.table.clone(),
            stencils: prepared.stencils.clone(),
            masses: (0..count).map(|i| prepared.dry(i)).collect(),
            books: SheetBooks {
                grips: vec![Vec3::zeros(); prepared.grips.len()],
                ..SheetBooks::default()
            },
            lips: LipPairs::default(),
            grips: GripState::default(),
            frozen: vec![false; count],
            substep: 0,
            number: 0,
            breaks: 0,
            terms: vec![PointTerms::default(); count],
            after: vec![Vec3::zeros(); count],
            held: vec![Vec3::zeros(); count],
            torn: vec![false; count],
            touch: vec![Vec3::zeros(); count],
            led: vec![Vec3::zeros(); prepared.grips.len()],
            next_theta: Vec::new(),
            proxies,
            state,
            prepared,
        };
        run.take_up();
        for i in 0..count {
            let lost = |b: usize| run.state.damage[b] >= 1.0 && !run.prepared.bonds.cut[b];
            if run.stencils.of(i).any(|n| lost(run.stencils.bonds[n] as usize)) {
                run.refit(i);
            }
        }
        if run.state.step == 0 {
            run.breaks = 1;
            run.part();
        }
        run.freeze();
        run.begin();
        run
    }

    /// Fits the curvature of a point to the bonds that are left.
    fn refit(&mut self, i: usize) {
        let damage = &self.state.damage;
        self.stencils.fit(i, &self.prepared.points.places, |b| damage[b] < 1.0);
    }

    /// Works out masses and bonds for what the sheet holds now.
    fn take_up(&mut self) {
        let Some(what) = &self.prepared.sheet().diffusion else {
            return;
        };
        self.table.update(&self.prepared.bonds, what, &self.state.theta, &self.state.exposure);
        let thickness = self.prepared.sheet().thickness;
        for (i, masses) in self.masses.iter_mut().enumerate() {
            let dry = self.prepared.dry(i);
            let held = what.weight * thickness * self.prepared.points.areas[i];
            let gained = (held * (self.state.theta[i] - what.start)).max(-0.5 * dry[0]);
            *masses = dry.map(|mass| mass + gained);
        }
    }

    /// What energies depend on.
    fn energy_input(&self) -> EnergyInput<'_> {
        let material = &self.prepared.sheet().material;
        EnergyInput {
            law: material.law,
            bonds: &self.prepared.bonds,
            table: &self.table,
            stencils: &self.stencils,
            areas: &self.prepared.points.areas,
            dilatation: self.prepared.dilatation,
            bending: [self.prepared.bending, material.poisson],
        }
    }

    /// Of stretched bonds, dilated points and pressed lips; of bending \[J\].
    pub(crate) fn energies(&mut self) -> [f64; 2] {
        self.find_lips();
        let input = self.energy_input();
        let lips = self.lips.energy(&self.state.places);
        [input.stretching(&self.state) + lips, input.bending(&self.state)]
    }

    /// Tension of a bond at a length \[N\], as it is: nothing is remembered.
    #[cfg(test)]
    pub(crate) fn tension(&self, b: usize, length: f64) -> f64 {
        let law = self.prepared.sheet().material.law;
        let (rest, k) = (self.table.rest[b], self.table.stiffness[b]);
        let mut memory = self.state.memory(b);
        let g = crate::law::generalised(law, length * rest);
        let limits = self.table.limits[b];
        let tension = crate::law::stretched(law, g, &mut memory, limits, true).tension;
        k * tension * crate::law::generalised_slope(law, length * rest) * rest
    }

    /// Kinetic energy \[J\].
    pub(crate) fn kinetic(&self) -> f64 {
        let of = |(m, v): (&[f64; 2], &Vec3)| 0.5 * m[1] * v.norm_squared();
        self.masses.iter().zip(&self.state.velocities).map(of).sum()
    }

    /// Time \[s\] after some steps of the step of the world.
    fn time(&self, substeps: u32) -> f64 {
        let share = f64::from(substeps) / f64::from(self.prepared.substeps);
        (self.state.step as f64 + share) * self.prepared.setup.world_step
    }

    /// Steps of the world since the run began, with the share of the one that runs.
    pub(crate) fn come(&self) -> f64 {
        self.number as f64 + f64::from(self.substep) / f64::from(self.prepared.substeps)
    }

    /// Begins a step of the world.
    fn begin(&mut self) {
        let (time, count) = (self.time(0), self.state.places.len());
        self.grips.update(&self.prepared.grips, count, time);
        self.held.fill(Vec3::zeros());
        for proxy in &mut self.proxies {
            proxy.begin(self.number, self.prepared.setup.world_step);
        }
    }

    /// Ends a step of the world.
    fn end(&mut self) {
        for proxy in &mut self.proxies {
            proxy.end(self.number);
        }
        self.state.step += 1;
        self.number += 1;
        self.substep = 0;
        self.part();
        self.rest();
    }

    /// Finds which pieces are at rest, and stops those that have been for long.
    fn rest(&mut self) {
        let sheet = self.prepared.sheet();
        let blows =
            air::acts(&sheet.air) && (sheet.air.wind != Vec3::zeros() || sheet.air.pressure != 0.0);
        // What still spreads may move it again.
        if blows || self.prepared.diffusion.is_some() {
            return;
        }
        let held: Vec<bool> = self.grips.holders.iter().map(|&holder| holder != FREE).collect();
        let check = RestCheck {
            labels: &self.state.labels,
            places: &self.state.places,
            velocities: &self.state.velocities,
            held: &held,
            proxies: &self.proxies,
            spacing: sheet.spacing,
            world_step: self.prepared.setup.world_step,
        };
        check.count(&mut self.state.pieces);
        self.freeze();
        for i in 0..self.frozen.len() {
            let v = self.state.velocities[i];
            if self.frozen[i] && v != Vec3::zeros() {
                // What stops a piece is what it rests on.
                let lost = v * self.masses[i][1];
                self.books.sums.impulse -= lost;
                self.books.sums.exchanged += lost.norm();
                self.books.sums.damped += 0.5 * lost.dot(&v);
                self.state.velocities[i] = Vec3::zeros();
            }
        }
    }

    /// Marks the points of pieces at rest.
    fn freeze(&mut self) {
        let patience = patience(self.prepared.setup.world_step);
        let mut still: Vec<u32> = Vec::new();
        for piece in &self.state.pieces {
            let number = piece.number as usize;
            still.resize(still.len().max(number + 1), 0);
            still[number] = piece.still;
        }
        for (frozen, &label) in self.frozen.iter_mut().zip(&self.state.labels) {
            *frozen = still[label as usize] >= patience;
        }
    }

    /// Takes one step. Whether a step of the world has ended with it.
    pub(crate) fn advance(&mut self) -> bool {
        if self.substep == 0 && self.number > 0 {
            self.begin();
        }
        let dt = self.prepared.step();
        let half = 0.5 * dt;
        for (x, v) in self.state.places.iter_mut().zip(&self.state.velocities) {
            *x += v * half;
        }
        self.proxies.iter_mut().for_each(|proxy| proxy.drift(half));
        if self.substep.is_multiple_of(SEARCH) {
            self.find_lips();
        }
        self.diffuse();
        self.kick(dt);
        std::mem::swap(&mut self.state.velocities, &mut self.after);
        for (x, v) in self.state.places.iter_mut().zip(&self.state.velocities) {
            *x += v * half;
        }
        self.proxies.iter_mut().for_each(|proxy| proxy.drift(half));
        self.substep += 1;
        self.books.steps += 1;
        self.lead();
        let ended = self.substep == self.prepared.substeps;
        if ended {
            self.end();
        }
        ended
    }

    /// Finds which points may touch each other in the next steps.
    fn find_lips(&mut self) {
        let sheet = self.prepared.sheet();
        let count = self.state.velocities.len() as f64;
        let mean = self.state.velocities.iter().sum::<Vec3>() / count;
        let speed = |v: &Vec3| (v - mean).norm_squared();
        let fastest = self.state.velocities.iter().map(speed).fold(0.0, f64::max).sqrt();
        let dt = self.prepared.step();
        let margin = (2.0 * fastest * dt * f64::from(SEARCH)).min(2.0 * sheet.spacing);
        self.lips.find(&LipSearch {
            bonds: &self.prepared.bonds,
            reference: &self.prepared.points.places,
            places: &self.state.places,
            masses: &self.masses,
            damage: &self.state.damage,
            spacing: sheet.spacing,
            thickness: sheet.thickness,
            margin: margin + 0.05 * sheet.spacing,
            dt,
        });
    }

    /// Lets the quantity spread where its time has come.
    fn diffuse(&mut self) {
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

    /// Finds the forces of rigid bodies, and kicks those.
    fn touch_bodies(&mut self, dt: f64) {
        if self.proxies.is_empty() {
            return;
        }
        let gravity = self.prepared.setup.gravity;
        self.touch.fill(Vec3::zeros());
        let points = TouchedPoints {
            places: &self.state.places,
            velocities: &self.state.velocities,
            masses: &self.masses,
            frozen: &self.frozen,
            distance: self.prepared.contact(),
            dt,
        };
        for proxy in &mut self.proxies {
            proxy.touch(&points, gravity, &mut self.touch);
        }
    }

    /// Forces and kicks of one step.
    fn kick(&mut self, dt: f64) {
        let prepared = Arc::clone(&self.prepared);
        let sheet = prepared.sheet();
        self.touch_bodies(dt);
        let end = self.time(self.substep + 1);
        for (led, grip) in self.led.iter_mut().zip(&prepared.grips) {
            *led = grip.at(end).1;
        }
        let middle = end - 0.5 * dt;
        let wind = || air::wind(&sheet.air, prepared.setup.seed, middle);
        let state = &mut self.state;
        let input = ForceInput {
            law: sheet.material.law,
            bonds: &prepared.bonds,
            table: &self.table,
            stencils: &self.stencils,
            lips: &self.lips,
            places: &state.places,
            velocities: &state.velocities,
            masses: &self.masses,
            areas: &prepared.points.areas,
            bending: [prepared.bending, sheet.material.poisson],
            dilatation: prepared.dilatation,
            damping: sheet.material.damping * prepared.stable,
            gravity: prepared.setup.gravity,
            air: air::acts(&sheet.air).then(|| (&sheet.air, wind())),
            touch: &self.touch,
            holders: &self.grips.holders,
            frozen: &self.frozen,
            guarded: &self.grips.guarded,
            led: &self.led,
            dt,
        };
        let mut rows = ForceRows {
            first: 0,
            damage: &mut state.damage,
            plastic: &mut state.plastic,
            flowed: &mut state.flowed,
            terms: &mut self.terms,
            after: &mut self.after,
            held: &mut self.held,
            torn: &mut self.torn,
        };
        let mut sums = StepSums::default();
        let terms_used =
            prepared.bending > 0.0 || prepared.dilatation != 0.0 || input.air.is_some();
        if terms_used {
            sums = pass(&prepared.bonds, rows.again(), &|rows| find_terms(&input, rows));
        }
        // The second pass reads the terms of all points.
        let terms = std::mem::take(&mut rows.terms);
        let terms: &[PointTerms] = terms;
        sums = sums.plus(pass(&prepared.bonds, rows, &|rows| kick(&input, terms, rows)));
        self.books.sums = self.books.sums.plus(sums);
        for (booked, grip) in self.books.grips.iter_mut().zip(&prepared.grips) {
            *booked += grip.points.iter().map(|&i| self.held[i as usize]).sum::<Vec3>();
        }
        self.breaks += sums.breaks;
        if sums.breaks > 0 {
            self.refit_torn();
        }
    }

    /// Fits curvatures anew where bonds have broken in a step. What that takes from the energy of
    /// bending, or adds to it, is part of the work of separation.
    fn refit_torn(&mut self) {
        for i in 0..self.torn.len() {
            if std::mem::take(&mut self.torn[i]) {
                let before = self.energy_input().bending_at(&self.state, i);
                self.refit(i);
                let after = self.energy_input().bending_at(&self.state, i);
                self.books.sums.broken += before - after;
            }
        }
    }

    /// Puts held points where their grips are.
    fn lead(&mut self) {
        let time = self.time(self.substep);
        let prepared = &self.prepared;
        for (number, grip) in prepared.grips.iter().enumerate() {
            let (moved, _) = grip.at(time);
            for &i in &grip.points {
                let i = i as usize;
                if self.grips.holders[i] == number as u32 {
                    let [x, y] = prepared.points.places[i];
                    let rest = prepared.sheet().pose * nalgebra::Point3::new(x, y, 0.0);
                    self.state.places[i] = rest.coords + moved;
                }
            }
        }
    }

    /// Finds the pieces after bonds have broken, and drops ties between them.
    fn part(&mut self) {
        if std::mem::take(&mut self.breaks) == 0 {
            return;
        }
        let prepared = Arc::clone(&self.prepared);
        let found = components(&prepared.bonds, &self.state.damage, prepared.sheet().spacing);
        let ends = &prepared.bonds.ends;
        let tie = |i: usize, b: usize| found[i] != found[ends[b] as usize];
        let mut parted: Vec<usize> = Vec::new();
        let mut ties = Vec::new();
        for i in 0..found.len() {
            let before = ties.len();
            let live = |b: &usize| self.state.damage[*b] < 1.0 && tie(i, *b);
            ties.extend(prepared.bonds.of(i).filter(live));
            if ties.len() > before {
                parted.push(i);
            }
        }
        if !ties.is_empty() {
            let stored = |run: &Self| {
                run.energy_input().stretching(&run.state) + run.energy_input().bending(&run.state)
            };
            let before = stored(self);
            ties.iter().for_each(|&b| self.state.damage[b] = 1.0);
            parted.iter().for_each(|&i| self.refit(i));
            self.books.sums.broken += before - stored(self);
            self.books.sums.breaks += ties.len() as u32;
        }
        let SheetState { labels, pieces, step, .. } = &mut self.state;
        renumber(&found, &prepared.points.areas, labels, pieces, *step);
    }
}
