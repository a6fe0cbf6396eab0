//! Steps of a sheet: half a drift, forces, kick, half a drift. One evaluation of forces a step, of
//! second order and symplectic, and places and velocities belong to the same time, so that a state
//! needs nothing else.
//!
//! The work of a force is its product with the mean of the velocities before and after the kick:
//! that is exactly what the kinetic energy gains. With the old velocity alone the books would miss
//! 5 to 15 % of what dashpots take.

mod driven;
mod quantity;

use crate::base::ClingingBase;
use crate::bending::BendingStencils;
use crate::books::SheetBooks;
use crate::diffusion::ObjectContacts;
use crate::energies::EnergyInput;
use crate::forces::ForceInput;
use crate::grips::GripState;
use crate::kernel::records::length_unit;
use crate::kernel::working::RowSource;
use crate::kernel::{SheetKernel, StepRows};
use crate::lips::{LipPairs, LipSearch};
use crate::prepared::PreparedMembrane;
use crate::state::SheetState;
use crate::table::BondTable;
use crate::watch::{BondsNow, TearWatch};
use cullet_continuum::air;
use cullet_continuum::pieces::gone_points;
use cullet_continuum::{RigidProxy, TouchedPoints};
use cullet_geometry::Vec3;
use std::sync::Arc;

mod parts;

/// Steps until points that may touch each other are found anew.
const SEARCH: u32 = 10;

/// Greatest length of a bond, in horizons. Places wrap around at twice as much.
pub(crate) const MOST_LENGTH: f64 = 16.0;

/// A sheet in motion.
#[derive(Clone, Debug)]
pub(crate) struct SheetRun {
    pub(crate) prepared: Arc<PreparedMembrane>,
    pub(crate) state: SheetState,
    pub(crate) proxies: Vec<RigidProxy>,
    pub(crate) books: SheetBooks,
    pub(crate) watch: TearWatch,
    /// Mass that weighs, and inertia, of each point \[kg\].
    pub(crate) masses: Vec<[f64; 2]>,
    pub(crate) stencils: BendingStencils,
    pub(crate) table: BondTable,
    lips: LipPairs,
    grips: GripState,
    base: Option<ClingingBase>,
    /// Points of pieces at rest.
    frozen: Vec<bool>,
    /// Points of pieces that have become rigid bodies, and whether all have.
    pub(crate) gone: Vec<bool>,
    all_gone: bool,
    /// Steps of the step of the world so far.
    substep: u32,
    /// Steps of the world since the run began.
    number: usize,
    breaks: u32,
    /// Of them, those that there were when lips were looked for.
    looked: u32,
    pub(crate) kernel: SheetKernel,
    after: Vec<Vec3>,
    held: Vec<Vec3>,
    torn: Vec<bool>,
    /// Forces of what the sheet touches \[N\].
    touch: Vec<Vec3>,
    /// Whether others than bodies and a base push.
    is_pushed: bool,
    /// Points that a rigid body has pushed in this step of the world.
    touched: Vec<bool>,
    led: Vec<Vec3>,
    next_theta: Vec<f64>,
    /// Of each quantity.
    contacts: Vec<ObjectContacts>,
}

impl SheetRun {
    /// Goes on from a state.
    pub(crate) fn new(
        prepared: Arc<PreparedMembrane>,
        state: SheetState,
        proxies: Vec<RigidProxy>,
    ) -> Self {
        let count = state.places.len();
        let gone = gone_points(&state.labels, &state.pieces);
        let mut run = Self {
            table: prepared.table.clone(),
            stencils: prepared.stencils.clone(),
            masses: (0..count).map(|i| prepared.dry(i)).collect(),
            books: SheetBooks {
                grips: vec![Vec3::zeros(); prepared.grips.len()],
                quantities_in: vec![0.0; prepared.diffusion.len()],
                ..SheetBooks::default()
            },
            watch: TearWatch::new(&prepared.bonds, &state.damage),
            lips: LipPairs::default(),
            grips: GripState::default(),
            base: ClingingBase::new(&prepared),
            frozen: vec![false; count],
            all_gone: gone.iter().all(|gone| *gone),
            gone,
            substep: 0,
            number: 0,
            breaks: 0,
            looked: 0,
            kernel: SheetKernel::new(
                Arc::clone(&prepared.rows),
                count,
                length_unit(prepared.sheet().horizon * prepared.sheet().spacing),
            ),
            after: vec![Vec3::zeros(); count],
            held: vec![Vec3::zeros(); count],
            torn: vec![false; count],
            touch: vec![Vec3::zeros(); count],
            is_pushed: false,
            touched: vec![false; count],
            led: vec![Vec3::zeros(); prepared.grips.len()],
            next_theta: Vec::new(),
            contacts: vec![ObjectContacts::default(); prepared.diffusion.len()],
            proxies,
            state,
            prepared,
        };
        run.guard(0);
        run.take_up();
        for i in (0..count).filter(|&i| run.gone[i]) {
            run.masses[i][0] = 0.0;
        }
        for i in 0..count {
            run.kernel.take_curvature(&run.stencils, i);
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
        self.kernel.take_curvature(&self.stencils, i);
    }

    /// Gives the kernel what bonds remember, and their numbers too where those are new.
    fn read_bonds(&mut self, numbers: bool) {
        let sheet = self.prepared.sheet();
        let source = RowSource {
            law: sheet.material.law,
            bonds: &self.prepared.bonds,
            table: &self.table,
            guarded: &self.grips.guarded,
            areas: &self.prepared.points.areas,
            bending: self.prepared.bending,
            coefficient: self.stencils.unit(),
            spacing: sheet.spacing,
            dilates: self.prepared.dilatation != 0.0,
        };
        let state = &self.state;
        match numbers {
            true => self.kernel.take_up(&source, |b| state.memory(b)),
            false => self.kernel.remember(&source, |b| state.memory(b)),
        }
    }

    /// Finds which points grips hold and guard after some steps of the step of the world. Whether
    /// those that they guard have changed.
    fn guard(&mut self, substeps: u32) -> bool {
        let (time, count) = (self.time(substeps), self.state.places.len());
        let before = std::mem::take(&mut self.grips.guarded);
        self.grips.update(&self.prepared.grips, count, time);
        before != self.grips.guarded
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
            gone: &self.gone,
            dilatation: self.prepared.dilatation,
            bending: [self.prepared.bending, material.poisson],
        }
    }

    /// Of stretched bonds, dilated points, pressed lips and a base; of bending \[J\].
    pub(crate) fn energies(&mut self) -> [f64; 2] {
        self.find_lips();
        self.stored()
    }

    /// The same with the lips that the last search found \[J\].
    pub(crate) fn stored(&self) -> [f64; 2] {
        let input = self.energy_input();
        let places = &self.state.places;
        let base = self.base.as_ref().map_or(0.0, |base| base.energy(places, &self.gone));
        let beside = self.lips.energy(places) + base;
        [input.stretching(&self.state) + beside, input.bending(&self.state)]
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
        if self.guard(0) {
            self.read_bonds(false);
        }
        self.held.fill(Vec3::zeros());
        self.touched.fill(false);
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

    /// Whether some bond is longer than the kernel can hold: it reckons places in whole numbers.
    pub(crate) fn is_overstretched(&self) -> bool {
        let (bonds, state) = (&self.prepared.bonds, &self.state);
        let sheet = self.prepared.sheet();
        let most = MOST_LENGTH * sheet.horizon * sheet.spacing;
        let beyond = |i: usize, b: usize| {
            let off = state.places[bonds.ends[b] as usize] - state.places[i];
            state.damage[b] < 1.0 && off.norm_squared() > most * most
        };
        (0..state.places.len()).any(|i| bonds.of(i).any(|b| beyond(i, b)))
    }

    /// Takes one step. Whether a step of the world has ended with it.
    pub(crate) fn advance(&mut self) -> bool {
        if self.substep == 0 && self.number > 0 {
            self.begin();
        }
        if self.all_gone {
            return self.move_bodies_alone();
        }
        let dt = self.prepared.step();
        let half = 0.5 * dt;
        if self.substep == 0 {
            self.kernel.drift(&mut self.state.places, &self.state.velocities, half);
        }
        self.proxies.iter_mut().for_each(|proxy| proxy.drift(half));
        if self.substep.is_multiple_of(SEARCH) {
            self.look_for_lips();
        }
        self.diffuse();
        self.kick(dt);
        std::mem::swap(&mut self.state.velocities, &mut self.after);
        self.proxies.iter_mut().for_each(|proxy| proxy.drift(half));
        self.substep += 1;
        self.books.steps += 1;
        let ended = self.substep == self.prepared.substeps;
        if ended {
            self.kernel.drift(&mut self.state.places, &self.state.velocities, half);
            self.lead(0.0);
            self.end();
        } else {
            // To the end of this step, and on to the middle of the next.
            self.lead(-half);
            self.kernel.drift(&mut self.state.places, &self.state.velocities, dt);
        }
        ended
    }

    /// How much closer two points may come until lips are looked for again \[m\].
    fn lip_margin(&self) -> f64 {
        let count = self.state.velocities.len() as f64;
        let mean = self.state.velocities.iter().sum::<Vec3>() / count;
        let speed = |v: &Vec3| (v - mean).norm_squared();
        let fastest = self.state.velocities.iter().map(speed).fold(0.0, f64::max).sqrt();
        let spacing = self.prepared.sheet().spacing;
        let way = 2.0 * fastest * self.prepared.step() * f64::from(SEARCH);
        way.min(2.0 * spacing) + 0.05 * spacing
    }

    /// Finds which points may touch each other, unless those that were found before are still all.
    fn look_for_lips(&mut self) {
        let margin = self.lip_margin();
        let parted = std::mem::replace(&mut self.looked, self.breaks) != self.breaks;
        if self.substep == 0 || parted || self.lips.are_due(&self.state.places, margin) {
            self.find_lips();
        }
    }

    /// Finds which points may touch each other in the next steps.
    fn find_lips(&mut self) {
        let margin = self.lip_margin();
        let sheet = self.prepared.sheet();
        self.lips.find(&LipSearch {
            bonds: &self.prepared.bonds,
            reference: &self.prepared.points.places,
            places: &self.state.places,
            masses: &self.masses,
            damage: &self.state.damage,
            gone: &self.gone,
            spacing: sheet.spacing,
            thickness: sheet.thickness,
            margin,
            dt: self.prepared.step(),
        });
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
        for (touched, force) in self.touched.iter_mut().zip(&self.touch) {
            *touched |= *force != Vec3::zeros();
        }
    }

    /// Adds the forces of a base.
    fn cling(&mut self) {
        let Some(base) = &self.base else {
            return;
        };
        if self.proxies.is_empty() {
            self.touch.fill(Vec3::zeros());
        }
        base.pull(&self.state.places, &mut self.touch);
    }

    /// Forces and kicks of one step.
    fn kick(&mut self, dt: f64) {
        let prepared = Arc::clone(&self.prepared);
        let sheet = prepared.sheet();
        self.touch_bodies(dt);
        self.cling();
        let end = self.time(self.substep + 1);
        for (led, grip) in self.led.iter_mut().zip(&prepared.grips) {
            *led = grip.at(end).1;
        }
        let middle = end - 0.5 * dt;
        let wind = || air::wind(&sheet.air, prepared.setup.seed, middle);
        let state = &mut self.state;
        let untouched = self.proxies.is_empty() && self.base.is_none() && !self.is_pushed;
        let input = ForceInput {
            law: sheet.material.law,
            bonds: &prepared.bonds,
            table: &self.table,
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
            touch: if untouched { &[] } else { &self.touch },
            holders: &self.grips.holders,
            frozen: &self.frozen,
            guarded: &self.grips.guarded,
            led: &self.led,
            dt,
        };
        let rows = StepRows {
            damage: &mut state.damage,
            plastic: &mut state.plastic,
            flowed: &mut state.flowed,
            after: &mut self.after,
            held: &mut self.held,
            torn: &mut self.torn,
        };
        let mut sums = self.kernel.step(&input, rows);
        if let Some(base) = &self.base {
            // It is counted with what touches, but stores what it takes.
            sums.bodies -= base.work(&state.places, &state.velocities, &self.after, dt);
        }
        self.books.sums = self.books.sums.plus(sums);
        for (booked, grip) in self.books.grips.iter_mut().zip(&prepared.grips) {
            *booked += grip.points.iter().map(|&i| self.held[i as usize]).sum::<Vec3>();
        }
        self.breaks += sums.breaks;
        if sums.breaks > 0 {
            let (state, table) = (&self.state, &self.table);
            self.watch.note(&BondsNow { prepared: &prepared, state, table, time: end }, &self.torn);
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

    /// Puts held points where their grips are, and on along their velocity for a time \[s\].
    fn lead(&mut self, on: f64) {
        let time = self.time(self.substep);
        let prepared = &self.prepared;
        for (number, grip) in prepared.grips.iter().enumerate() {
            let (moved, _) = grip.at(time);
            for &i in &grip.points {
                let i = i as usize;
                if self.grips.holders[i] == number as u32 {
                    let [x, y] = prepared.points.places[i];
                    let rest = prepared.sheet().pose * nalgebra::Point3::new(x, y, 0.0);
                    self.state.places[i] = rest.coords + moved + self.state.velocities[i] * on;
                }
            }
        }
    }
}
