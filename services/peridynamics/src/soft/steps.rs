//! Steps of a soft solid: half a drift, forces, kick, half a drift. One evaluation of forces a
//! step, of second order and symplectic, and places and velocities belong to the same time.
//!
//! The work of a force is its product with the mean of the velocities before and after the kick:
//! that is exactly what the kinetic energy gains.

use super::air;
use super::grips::{FREE, GripsNow};
use super::pieces::components;
use super::prepared::PreparedSoftSolid;
use super::state::SoftSolidState;
use super::sums::SolidSums;
use super::touch::TouchingPairs;
use crate::law::PartedContact;
use cullet_continuum::air as blowing;
use cullet_continuum::pieces::{frozen_points, gone_points, renumber};
use cullet_continuum::rest::RestCheck;
use cullet_continuum::{RigidProxy, TouchedPoints};
use cullet_geometry::Vec3;
use cullet_model::SheetAir;
use rayon::prelude::*;
use std::sync::Arc;

/// Steps until points that may touch each other are found anew.
const SEARCH: u32 = 10;
/// Points that one task kicks. The split of sums depends on it, and on nothing else.
const TASK: usize = 512;

/// The books of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct SolidBooks {
    pub(super) sums: SolidSums,
    /// Impulse of each grip \[N·s\].
    pub(super) grips: Vec<Vec3>,
    /// Moment of it about the world's origin \[N·m·s\].
    pub(super) moments: Vec<Vec3>,
    /// Steps taken.
    pub(super) steps: u64,
    /// Bonds that broke in one step from being pressed, and the energy that `broken` lacks \[J\].
    pub(super) jumped: (usize, f64),
}

/// A soft solid in motion.
pub(super) struct SolidRun {
    pub(super) prepared: Arc<PreparedSoftSolid>,
    pub(super) state: SoftSolidState,
    pub(super) proxies: Vec<RigidProxy>,
    pub(super) books: SolidBooks,
    /// Mass that weighs, and inertia, of each point \[kg\].
    pub(super) masses: Vec<[f64; 2]>,
    pairs: TouchingPairs,
    grips: GripsNow,
    /// Points of pieces at rest.
    frozen: Vec<bool>,
    /// Points of pieces that have become rigid bodies.
    pub(super) gone: Vec<bool>,
    /// Outer area of each point as it is turned \[m²\]; empty where there is no air.
    areas: Vec<Vec3>,
    /// Steps of the step of the world so far.
    substep: u32,
    /// Steps of the world since the run began.
    number: usize,
    /// Whether bonds may have broken since pieces were found.
    broke: bool,
    inner: Vec<Vec3>,
    touch: Vec<Vec3>,
    /// Points that a rigid body has pushed in this step of the world.
    touched: Vec<bool>,
    after: Vec<Vec3>,
    held: Vec<Vec3>,
    led: Vec<Vec3>,
}

impl SolidRun {
    /// Goes on from a state.
    pub(super) fn new(
        prepared: Arc<PreparedSoftSolid>,
        state: SoftSolidState,
        proxies: Vec<RigidProxy>,
    ) -> Self {
        let count = state.labels.len();
        let none = || vec![Vec3::zeros(); count];
        let gone = gone_points(&state.labels, &state.pieces);
        // What is gone weighs nothing.
        let masses = |p: usize| match (prepared.masses(p), gone[p]) {
            ([_, inertia], true) => [0.0, inertia],
            (masses, false) => masses,
        };
        let mut run = Self {
            masses: (0..count).map(masses).collect(),
            books: SolidBooks {
                grips: vec![Vec3::zeros(); prepared.grips.len()],
                moments: vec![Vec3::zeros(); prepared.grips.len()],
                ..SolidBooks::default()
            },
            pairs: TouchingPairs::default(),
            grips: GripsNow::default(),
            frozen: vec![false; count],
            gone,
            areas: Vec::new(),
            substep: 0,
            number: 0,
            broke: state.step == 0,
            inner: none(),
            touch: none(),
            touched: vec![false; count],
            after: none(),
            held: none(),
            led: none(),
            proxies,
            state,
            prepared,
        };
        run.part();
        run.freeze();
        run.begin();
        run
    }

    /// Stored energy: of bonds, and of points that touch \[J\].
    pub(super) fn stored(&self) -> f64 {
        let domain = &self.state.domain;
        let pairs = TouchingPairs::find(domain, &self.prepared.outer, &self.gone, 0.0);
        let mut none = vec![Vec3::zeros(); self.masses.len()];
        let held = pairs.push(domain, &PartedContact { friction: 0.0 }, 0.0, &mut none).held;
        domain.elastic_of(|p| !self.gone[p]) + held
    }

    /// Kinetic energy \[J\].
    pub(super) fn kinetic(&self) -> f64 {
        let of = |(m, v): (&[f64; 2], &Vec3)| 0.5 * m[1] * v.norm_squared();
        self.masses.iter().zip(&self.state.domain.velocities).map(of).sum()
    }

    /// Momentum \[kg·m/s\].
    pub(super) fn momentum(&self) -> Vec3 {
        self.masses.iter().zip(&self.state.domain.velocities).map(|(m, v)| v * m[1]).sum()
    }

    /// Time \[s\] after some steps of the step of the world.
    fn time(&self, substeps: u32) -> f64 {
        let share = f64::from(substeps) / f64::from(self.prepared.substeps);
        (self.state.step as f64 + share) * self.prepared.setup.world_step
    }

    /// Steps of the world since the run began, with the share of the one that runs.
    pub(super) fn come(&self) -> f64 {
        self.number as f64 + f64::from(self.substep) / f64::from(self.prepared.substeps)
    }

    /// Begins a step of the world.
    fn begin(&mut self) {
        let (time, count) = (self.time(0), self.masses.len());
        if self.grips.update(&self.prepared.grips, count, time) {
            self.state.domain.strengthen(&self.grips.strengths);
        }
        self.touched.fill(false);
        for proxy in &mut self.proxies {
            proxy.begin(self.number, self.prepared.setup.world_step);
        }
        if blowing::acts(&self.prepared.body().air) {
            self.areas = self.areas_now();
        }
    }

    /// Outer areas as they are turned and stretched now \[m²\]: by F's cofactor.
    fn areas_now(&self) -> Vec<Vec3> {
        let domain = &self.state.domain;
        let turns = domain.turns();
        let of = |(p, area): (usize, &Vec3)| {
            if *area == Vec3::zeros() {
                return Vec3::zeros();
            }
            let f = super::surface::gradient(domain, p, &turns[p]);
            let inverse = f.try_inverse().unwrap_or_else(|| turns[p].inverse().into_inner());
            inverse.transpose() * area * f.determinant().abs()
        };
        self.prepared.areas.par_iter().enumerate().map(of).collect()
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
        if blowing::blows(&self.prepared.body().air) {
            return;
        }
        let held: Vec<bool> = self.grips.holders.iter().map(|&holder| holder != FREE).collect();
        let SoftSolidState { domain, labels, pieces, .. } = &mut self.state;
        let pressed = self.pairs.pressed(domain);
        let rest = RestCheck {
            labels,
            places: &domain.places,
            velocities: &domain.velocities,
            held: &held,
            touched: &self.touched,
            pressed: &pressed,
            proxies: &self.proxies,
            spacing: self.prepared.body().spacing,
            world_step: self.prepared.setup.world_step,
        };
        rest.count(pieces);
        self.freeze();
        let sums = &mut self.books.sums;
        for (p, v) in self.state.domain.velocities.iter_mut().enumerate() {
            if self.frozen[p] && *v != Vec3::zeros() {
                // What stops a piece is what it rests on.
                let lost = *v * self.masses[p][1];
                sums.impulse -= lost;
                sums.exchanged += lost.norm();
                sums.damped += 0.5 * lost.dot(v);
                *v = Vec3::zeros();
            }
        }
    }

    /// Marks the points of pieces at rest.
    fn freeze(&mut self) {
        let (state, world_step) = (&self.state, self.prepared.setup.world_step);
        self.frozen = frozen_points(&state.labels, &state.pieces, world_step);
    }

    /// Takes one step. Whether a step of the world has ended with it.
    pub(super) fn advance(&mut self) -> bool {
        if self.substep == 0 && self.number > 0 {
            self.begin();
        }
        let dt = self.prepared.step();
        self.drift(0.5 * dt);
        self.kick(dt);
        self.drift(0.5 * dt);
        self.substep += 1;
        self.books.steps += 1;
        self.lead();
        let ended = self.substep == self.prepared.substeps;
        if ended {
            self.end();
        }
        ended
    }

    fn drift(&mut self, time: f64) {
        let domain = &mut self.state.domain;
        for (x, v) in domain.places.iter_mut().zip(&domain.velocities) {
            *x += v * time;
        }
        self.proxies.iter_mut().for_each(|proxy| proxy.drift(time));
    }

    /// Finds which points may touch each other in the next steps.
    fn find_pairs(&mut self, dt: f64) {
        let domain = &self.state.domain;
        let count = domain.velocities.len() as f64;
        let mean = domain.velocities.iter().sum::<Vec3>() / count;
        let speed = |v: &Vec3| (v - mean).norm_squared();
        let fastest = domain.velocities.iter().map(speed).fold(0.0, f64::max).sqrt();
        let spacing = self.prepared.body().spacing;
        let margin = (2.0 * fastest * dt * f64::from(SEARCH)).min(0.5 * spacing);
        let margin = margin + 0.05 * spacing;
        self.pairs = TouchingPairs::find(domain, &self.prepared.outer, &self.gone, margin);
    }

    /// Forces of bonds and of points that touch each other.
    fn find_inner(&mut self, dt: f64) {
        let tally = self.state.domain.strain_after(dt);
        let sums = &mut self.books.sums;
        sums.plastic += tally.plastic;
        sums.broken += tally.broken;
        self.books.jumped.0 += tally.jumped;
        self.books.jumped.1 += tally.unbooked;
        self.broke |= tally.broken != 0.0;
        let domain = &self.state.domain;
        self.inner.copy_from_slice(&domain.forces);
        let pairs = self.pairs.push(domain, &self.prepared.contact, dt, &mut self.inner);
        sums.damped += pairs.friction;
    }

    /// Finds the forces of rigid bodies, and kicks those.
    fn touch_bodies(&mut self, dt: f64) {
        if self.proxies.is_empty() {
            return;
        }
        let gravity = self.prepared.setup.gravity;
        self.touch.fill(Vec3::zeros());
        let points = TouchedPoints {
            places: &self.state.domain.places,
            velocities: &self.state.domain.velocities,
            masses: &self.masses,
            frozen: &self.frozen,
            distance: self.prepared.contact_distance(),
            dt,
        };
        for proxy in &mut self.proxies {
            proxy.touch(&points, gravity, &mut self.touch);
        }
        for (touched, force) in self.touched.iter_mut().zip(&self.touch) {
            *touched |= *force != Vec3::zeros();
        }
    }

    /// Forces and kicks of one step.
    fn kick(&mut self, dt: f64) {
        self.touch_bodies(dt);
        if self.frozen.iter().all(|frozen| *frozen) {
            return;
        }
        if self.substep.is_multiple_of(SEARCH) {
            self.find_pairs(dt);
        }
        self.find_inner(dt);
        let prepared = Arc::clone(&self.prepared);
        let end = self.time(self.substep + 1);
        for (number, grip) in prepared.grips.iter().enumerate() {
            for (k, &p) in grip.points.iter().enumerate() {
                if self.grips.holders[p as usize] == number as u32 {
                    self.led[p as usize] = grip.leads(k, end).1;
                }
            }
        }
        let body = prepared.body();
        let input = KickInput {
            run: self,
            dt,
            gravity: prepared.setup.gravity,
            air: blowing::acts(&body.air).then(|| {
                (&body.air, blowing::wind(&body.air, prepared.setup.seed, end - 0.5 * dt))
            }),
            kept: libm::exp(-prepared.pace.bonds.air_damping * dt),
        };
        let tasks = self.masses.len().div_ceil(TASK);
        let found: Vec<KickedPoints> =
            (0..tasks).into_par_iter().map(|task| input.kick(task * TASK)).collect();
        let mut start = 0;
        for KickedPoints { after, held, sums } in found {
            let end = start + after.len();
            self.after[start..end].copy_from_slice(&after);
            self.held[start..end].copy_from_slice(&held);
            self.books.sums = self.books.sums.plus(sums);
            start = end;
        }
        for (number, grip) in prepared.grips.iter().enumerate() {
            for &p in &grip.points {
                let p = p as usize;
                if self.grips.holders[p] == number as u32 {
                    self.books.grips[number] += self.held[p];
                    self.books.moments[number] += self.state.domain.places[p].cross(&self.held[p]);
                }
            }
        }
        std::mem::swap(&mut self.state.domain.velocities, &mut self.after);
    }

    /// Puts held points where their grips are.
    fn lead(&mut self) {
        let time = self.time(self.substep);
        let prepared = Arc::clone(&self.prepared);
        for (number, grip) in prepared.grips.iter().enumerate() {
            for (k, &p) in grip.points.iter().enumerate() {
                if self.grips.holders[p as usize] == number as u32 {
                    self.state.domain.places[p as usize] = grip.leads(k, time).0;
                }
            }
        }
    }

    /// Finds the pieces after bonds have broken, and drops ties between them.
    fn part(&mut self) {
        if !std::mem::take(&mut self.broke) {
            return;
        }
        let spacing = self.prepared.body().spacing;
        let SoftSolidState { domain, labels, pieces, step } = &mut self.state;
        let found = components(domain, spacing);
        let mut ties = Vec::new();
        for p in 0..found.len() {
            let bonds = domain.bonds.of(p);
            let tie =
                |b: &crate::bonds::BondSlot| found[p] != found[b.end] && domain.left(*b) > 0.0;
            ties.extend(bonds.filter(tie));
        }
        if !ties.is_empty() {
            let before = domain.elastic_now();
            ties.iter().for_each(|bond| domain.left[bond.group].0[bond.lane] = 0.0);
            self.books.sums.broken += before - domain.elastic_now();
        }
        renumber(&found, &domain.volumes, labels, pieces, *step);
        domain.move_apart(labels);
    }
}

/// What kicks points.
struct KickInput<'a> {
    run: &'a SolidRun,
    dt: f64,
    gravity: Vec3,
    /// The air, where it acts, and its wind now.
    air: Option<(&'a SheetAir, Vec3)>,
    /// Share of its velocity that a point keeps in still air \[1\].
    kept: f64,
}

/// Points after a kick.
struct KickedPoints {
    /// Velocities \[m/s\].
    after: Vec<Vec3>,
    /// Impulses of grips \[N·s\].
    held: Vec<Vec3>,
    sums: SolidSums,
}

impl KickInput<'_> {
    /// Kicks a task's points, from the first of them on.
    fn kick(&self, first: usize) -> KickedPoints {
        let last = (first + TASK).min(self.run.masses.len());
        let mut kicked = KickedPoints {
            after: Vec::with_capacity(last - first),
            held: Vec::with_capacity(last - first),
            sums: SolidSums::default(),
        };
        for p in first..last {
            let (after, held) = self.kick_point(p, &mut kicked.sums);
            kicked.after.push(after);
            kicked.held.push(held);
        }
        kicked
    }

    /// The velocity of a point after the kick, and what a grip gave it.
    #[inline]
    fn kick_point(&self, p: usize, sums: &mut SolidSums) -> (Vec3, Vec3) {
        let (run, dt, none) = (self.run, self.dt, Vec3::zeros());
        let (inner, [weighs, mass]) = (run.inner[p] * dt, run.masses[p]);
        if run.frozen[p] {
            // What it rests on bears what presses it.
            sums.impulse -= inner;
            sums.exchanged += inner.norm();
            return (none, none);
        }
        let before = run.state.domain.velocities[p];
        let gravity = self.gravity * (weighs * dt);
        let touch = if run.proxies.is_empty() { none } else { run.touch[p] * dt };
        let mut blown = none;
        if let Some((air, wind)) = self.air {
            let mean = before + (inner + gravity + touch) / mass;
            blown = air::impulse(air, run.areas[p], mean - wind, mass, dt);
        }
        let mut after = before + (inner + gravity + touch + blown) / mass;
        if self.kept < 1.0 {
            let slowed = after * (self.kept - 1.0);
            after += slowed;
            blown += slowed * mass;
        }
        let mut held = none;
        if run.grips.holders[p] != FREE {
            after = run.led[p];
            held = (after - before) * mass - inner - gravity - touch - blown;
        }
        let mean = 0.5 * (before + after);
        sums.gravity += gravity.dot(&mean);
        sums.bodies += touch.dot(&mean);
        sums.air += blown.dot(&mean);
        sums.grips += held.dot(&mean);
        if let Some(drag) = run.state.domain.drags.get(p) {
            sums.damped -= drag.dot(&mean) * dt;
        }
        sums.impulse += gravity + touch + blown + held;
        sums.exchanged += inner.norm() + gravity.norm() + touch.norm() + held.norm();
        (after, held)
    }
}
