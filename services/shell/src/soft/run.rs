//! Steps of a soft shell: half a drift, forces, kick, half a drift. One evaluation of forces a
//! step, of second order and symplectic, and places and velocities belong to the same time, so that
//! a state needs nothing else.
//!
//! What damping goes by, the strains of the step before, is worked out anew as each step of the
//! world begins; so is how many steps that takes, from how far the shell is pressed together.

use super::books::SoftBooks;
use super::crumbs::with_crumbs;
use super::held::FREE;
use super::pairs::{MeetingPairs, PairSearch};
use super::prepared::PreparedWall;
use super::state::SoftShellState;
use super::touch::{TouchInput, TouchablePoints};
use cullet_continuum::pieces::renumber;
use cullet_continuum::{RigidProxy, air};
use cullet_geometry::Vec3;
use std::sync::Arc;

/// Most steps of a shell that is pressed together, over those at rest.
const MOST_STEPS: u32 = 6;

/// A soft shell in motion.
#[derive(Clone, Debug)]
pub(super) struct SoftShellRun<const N: usize> {
    pub(super) prepared: Arc<PreparedWall<N>>,
    pub(super) state: SoftShellState<N>,
    pub(super) proxies: Vec<RigidProxy>,
    pub(super) books: SoftBooks,
    /// Mass of each point \[kg\].
    masses: Vec<f64>,
    touchable: TouchablePoints,
    meeting: MeetingPairs,
    /// The grip that holds each control point of the surface, or [`FREE`].
    holders: Vec<u32>,
    /// Points that do not start to break.
    guarded: Vec<bool>,
    /// Control points of pieces at rest, and whether all are.
    frozen: Vec<bool>,
    all_frozen: bool,
    /// Pieces at rest, by their number.
    still: Vec<bool>,
    /// Steps in this step of the world, and those taken so far.
    substeps: u32,
    substep: u32,
    /// Steps of the world since the run began.
    number: usize,
    /// Speed of the fastest control point, and of the fastest beside the mean \[m/s\].
    fastest: [f64; 2],
    /// What bodies do to control points \[N\].
    touch: Vec<Vec3>,
    /// Control points that a body has pushed in this step of the world.
    touched: Vec<bool>,
    /// What the air does \[N·s\].
    blown: Vec<Vec3>,
    /// What points of the shell do to one another \[N\].
    met: Vec<Vec3>,
}

impl<const N: usize> SoftShellRun<N> {
    /// Goes on from a state.
    pub(super) fn new(
        prepared: Arc<PreparedWall<N>>,
        state: SoftShellState<N>,
        proxies: Vec<RigidProxy>,
    ) -> Self {
        let domain = &state.domain;
        let points = domain.points();
        let mass = |p: usize| {
            let point = domain.state(p);
            point.area * point.thickness * domain.density
        };
        let books = SoftBooks {
            held: vec![Vec3::zeros(); prepared.grips.len()],
            stiffest: 1.0,
            ..SoftBooks::default()
        };
        let mut run = Self {
            masses: (0..points).map(mass).collect(),
            books,
            touchable: TouchablePoints::default(),
            meeting: MeetingPairs::default(),
            holders: Vec::new(),
            guarded: vec![false; points],
            frozen: Vec::new(),
            all_frozen: false,
            still: Vec::new(),
            substeps: prepared.substeps,
            substep: 0,
            number: 0,
            fastest: [0.0; 2],
            touch: Vec::new(),
            touched: Vec::new(),
            blown: Vec::new(),
            met: Vec::new(),
            prepared,
            state,
            proxies,
        };
        if run.state.step == 0 {
            run.part();
        }
        run.measure();
        run.freeze();
        run.begin();
        run
    }

    /// Kinetic energy \[J\].
    pub(super) fn kinetic(&self) -> f64 {
        let domain = &self.state.domain;
        let of = |(m, v): (&f64, &Vec3)| 0.5 * m * v.norm_squared();
        domain.mass.iter().zip(&domain.velocity).map(of).sum()
    }

    /// Energy of the stretched midsurface and of points that are pressed together; of bending
    /// \[J\].
    pub(super) fn energies(&mut self) -> [f64; 2] {
        if self.meeting.wears(0.0) {
            self.find_pairs();
        }
        let met = self.meeting.energy(&self.state.domain);
        let domain = &self.state.domain;
        let (mut stretching, mut whole) = (met, met);
        for (p, strain) in domain.live().zip(&domain.strains()) {
            let state = domain.state(p);
            stretching += state.area * domain.law.stretching(state, strain);
            whole += state.area * domain.law.energy(state, strain);
        }
        [stretching, whole - stretching]
    }

    /// Time \[s\] after some steps of the step of the world.
    fn time(&self, substeps: u32) -> f64 {
        let share = f64::from(substeps) / f64::from(self.substeps);
        (self.state.step as f64 + share) * self.prepared.setup.world_step
    }

    /// Steps of the world since the run began, with the share of the one that runs.
    pub(super) fn come(&self) -> f64 {
        self.number as f64 + f64::from(self.substep) / f64::from(self.substeps)
    }

    /// Begins a step of the world.
    fn begin(&mut self) {
        self.hold();
        for proxy in &mut self.proxies {
            proxy.begin(self.number, self.prepared.setup.world_step);
        }
        let domain = &mut self.state.domain;
        let strains = domain.strains();
        let live = domain.live().zip(&strains);
        let stiffness = |(p, strain)| domain.law.stiffening(domain.state(p), strain);
        let stiffest = live.map(stiffness).fold(1.0, f64::max);
        self.books.stiffest = self.books.stiffest.max(stiffest);
        self.substeps = self.prepared.substeps_for(stiffest, MOST_STEPS);
        self.books.crushed |= stiffest > f64::from(MOST_STEPS * MOST_STEPS);
        let dt = self.prepared.setup.world_step / f64::from(self.substeps);
        domain.step = dt;
        let damping = self.prepared.body.damping;
        if let Some(soft) = &mut domain.law.soft {
            soft.viscosity = damping * self.prepared.stable / dt;
        }
        if damping > 0.0 {
            let back = |(u, v): (&[f64; 4], &Vec3)| {
                let at = |k: usize| u[k] - 0.5 * dt * v[k];
                [at(0), at(1), at(2), 0.0]
            };
            let before: Vec<[f64; 4]> =
                domain.displacement.iter().zip(&domain.velocity).map(back).collect();
            domain.kernel.remember(&domain.law, &before);
        }
    }

    /// Finds what grips hold and keep whole now.
    fn hold(&mut self) {
        let (time, prepared) = (self.time(0), Arc::clone(&self.prepared));
        self.holders.clear();
        self.holders.resize(prepared.rest.len(), FREE);
        let mut guarded = vec![false; self.guarded.len()];
        let holding = prepared.grips.iter().enumerate().rev();
        for (number, grip) in holding.filter(|(_, grip)| grip.holds(time)) {
            grip.nodes.iter().for_each(|&n| self.holders[n as usize] = number as u32);
            grip.guarded.iter().for_each(|&p| guarded[p as usize] = true);
        }
        let domain = &mut self.state.domain;
        for (p, &is_guarded) in guarded.iter().enumerate() {
            if is_guarded != self.guarded[p] && domain.is_on(p) {
                let flaw = prepared.domain.state(p).flaw;
                let flaw = if is_guarded { f64::INFINITY } else { flaw };
                domain.change(p, |state| state.flaw = flaw);
            }
        }
        self.guarded = guarded;
    }

    /// Ends a step of the world.
    fn end(&mut self) {
        for proxy in &mut self.proxies {
            proxy.end(self.number);
        }
        self.state.step += 1;
        self.number += 1;
        self.substep = 0;
        if std::mem::take(&mut self.books.breaks) > 0 {
            self.part();
        }
        self.books.broken += self.state.domain.heal();
        self.rest();
    }

    /// Finds the pieces after points have broken.
    fn part(&mut self) {
        let domain = &mut self.state.domain;
        let found = domain.components();
        let crumbs = domain.crumble_parts(&found);
        let found = with_crumbs(found, &crumbs, &self.state.labels);
        let areas: Vec<f64> = (0..found.len()).map(|p| self.state.domain.state(p).area).collect();
        let SoftShellState { labels, pieces, step, .. } = &mut self.state;
        renumber(&found, &areas, labels, pieces, *step);
        self.meeting.forget();
        self.touchable.forget();
    }

    /// Takes one step. Whether a step of the world has ended with it.
    pub(super) fn advance(&mut self) -> bool {
        if self.substep == 0 && self.number > 0 {
            self.begin();
        }
        let half = 0.5 * self.state.domain.step;
        self.drift(half);
        if !self.all_frozen {
            self.crack();
        }
        self.push();
        self.kick();
        self.drift(half);
        self.substep += 1;
        self.books.steps += 1;
        self.lead();
        let ended = self.substep == self.substeps;
        if ended {
            self.end();
        }
        ended
    }

    fn drift(&mut self, time: f64) {
        let domain = &mut self.state.domain;
        for (u, v) in domain.displacement.iter_mut().zip(&domain.velocity) {
            (0..3).for_each(|c| u[c] += time * v[c]);
        }
        self.proxies.iter_mut().for_each(|proxy| proxy.drift(time));
    }

    /// Lets cracks go on, and takes stresses.
    fn crack(&mut self) {
        let domain = &mut self.state.domain;
        let (splits, added) = (domain.splits(), domain.added_energy());
        let momentum = |mass: &[f64], velocity: &[Vec3]| -> Vec3 {
            mass.iter().zip(velocity).map(|(m, v)| v * *m).sum()
        };
        let before = momentum(&domain.mass, &domain.velocity);
        domain.go_on();
        if domain.splits() != splits {
            // Mass that light copies need moves as they do.
            let gained = momentum(&domain.mass, &domain.velocity) - before;
            self.books.give(&gained);
            self.books.broken -= domain.added_energy() - added;
            self.frozen.resize(domain.mass.len(), false);
            self.meeting.forget();
            self.touchable.forget();
        }
        let tally = domain.strain();
        self.books.broken += tally.dissipated;
        self.books.plastic += tally.plastic;
        self.books.damped += tally.damped;
        self.books.breaks += u64::from(tally.broken);
        if tally.broken > 0 {
            domain.note_broken();
        }
    }

    fn find_pairs(&mut self) {
        let body = &self.prepared.body;
        let search = PairSearch {
            vicinity: &self.prepared.vicinity,
            masses: &self.masses,
            spacing: body.spacing,
            thickness: self.prepared.thickness,
            dt: self.prepared.step(),
        };
        self.meeting.find(&self.state.domain, &search);
    }

    /// Finds what acts on control points from outside and from other parts of the shell.
    fn push(&mut self) {
        let dt = self.state.domain.step;
        let count = self.state.domain.mass.len();
        for list in [&mut self.touch, &mut self.blown, &mut self.met] {
            list.clear();
            list.resize(count, Vec3::zeros());
        }
        let input = TouchInput {
            masses: &self.masses,
            gravity: self.prepared.setup.gravity,
            distance: self.prepared.contact(),
            spacing: self.prepared.body.spacing,
            dt,
            fastest: self.fastest[0],
        };
        let (still, labels) = (&self.still, &self.state.labels);
        let frozen = |p: u32| still[labels[p as usize] as usize];
        let (domain, proxies) = (&self.state.domain, &mut self.proxies);
        self.touchable.touch(domain, proxies, frozen, &input, &mut self.touch);
        if self.all_frozen {
            return;
        }
        if self.meeting.wears(2.0 * self.fastest[1] * dt) {
            self.find_pairs();
        }
        let (still, labels) = (&self.still, &self.state.labels);
        let frozen = |p: u32| still[labels[p as usize] as usize];
        let mut propped = Vec3::zeros();
        self.meeting.push(&self.state.domain, frozen, &mut self.met, &mut propped);
        self.books.give(&(propped * dt));
        self.blow(dt);
    }

    /// Finds what the air does.
    fn blow(&mut self, dt: f64) {
        let air = &self.prepared.body.air;
        if !air::acts(air) {
            return;
        }
        let time = self.time(self.substep + 1) - 0.5 * dt;
        let wind = air::wind(air, self.prepared.setup.seed, time);
        let domain = &self.state.domain;
        for p in domain.live().filter(|&p| !domain.state(p).dead) {
            let relative = domain.interpolate(p, &domain.velocity) - wind;
            let given = air::impulse(air, domain.area_vector(p), relative, self.masses[p], dt);
            let (nodes, shares) = domain.functions(p);
            for (&node, share) in nodes.iter().zip(shares) {
                self.blown[node as usize] += given * *share;
            }
        }
    }

    /// Kicks control points.
    fn kick(&mut self) {
        let prepared = Arc::clone(&self.prepared);
        let end = self.time(self.substep + 1);
        let domain = &mut self.state.domain;
        let dt = domain.step;
        let fall = prepared.setup.gravity * (dt / prepared.pace.inertia);
        self.touched.resize(domain.mass.len(), false);
        for n in 0..domain.mass.len() {
            if self.frozen[n] {
                continue;
            }
            let (v, mass) = (domain.velocity[n], domain.mass[n]);
            let inner = Vec3::from(domain.kernel.force(n)) + self.met[n];
            let touched = self.touch[n] * dt;
            let fell = fall * mass;
            let given = inner * dt + touched + fell + self.blown[n];
            let holder = self.holders[domain.origin[n] as usize];
            let after = match prepared.grips.get(holder as usize) {
                Some(grip) => grip.leads(&prepared.rest[domain.origin[n] as usize], end).1,
                None => v + given / mass,
            };
            let mean = 0.5 * (v + after);
            let books = &mut self.books;
            books.give(&fell);
            books.gravity += fell.dot(&mean);
            if touched != Vec3::zeros() {
                self.touched[n] = true;
                books.give(&touched);
                books.bodies += touched.dot(&mean);
            }
            if self.blown[n] != Vec3::zeros() {
                books.give(&self.blown[n]);
                books.air += self.blown[n].dot(&mean);
            }
            if holder != FREE {
                let held = (after - v) * mass - given;
                books.give(&held);
                books.grips += held.dot(&mean);
                books.held[holder as usize] += held;
            }
            domain.velocity[n] = after;
        }
        self.measure();
    }

    /// Finds how fast control points are.
    fn measure(&mut self) {
        let all = &self.state.domain.velocity;
        let mean = all.iter().sum::<Vec3>() / all.len() as f64;
        let (mut fastest, mut apart) = (0.0_f64, 0.0_f64);
        for v in all {
            fastest = fastest.max(v.norm_squared());
            apart = apart.max((v - mean).norm_squared());
        }
        self.fastest = [fastest.sqrt(), apart.sqrt()];
    }

    /// Puts held control points where their grips are.
    fn lead(&mut self) {
        if self.prepared.grips.is_empty() {
            return;
        }
        let (time, prepared) = (self.time(self.substep), Arc::clone(&self.prepared));
        let domain = &mut self.state.domain;
        for n in 0..domain.mass.len() {
            let base = domain.origin[n] as usize;
            if let Some(grip) = prepared.grips.get(self.holders[base] as usize) {
                let moved = grip.leads(&prepared.rest[base], time).0 - domain.surface.nodes[base];
                domain.displacement[n] = [moved.x, moved.y, moved.z, 0.0];
            }
        }
    }
}

mod rest;
