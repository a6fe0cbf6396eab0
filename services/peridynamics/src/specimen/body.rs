//! A specimen as points and bonds: its steps, with what supports and loads do in them.

use super::build;
use super::hold::{self, HeldPoints, HeldStep};
use super::mirror::MirrorSet;
use super::push::{self, PushedPoints};
use super::read::ReadBonds;
use crate::domain::PeridynamicDomain;
use cullet_geometry::Vec3;
use cullet_model::Refusal;
use cullet_specimen::{
    BodySums, Discrete, Discretisation, Drive, GridFrame, PointField, PointFields, SpecimenProblem,
    StepTally, idle,
};
use std::collections::BTreeMap;

/// Steps between looks at volumes, each of which takes as long as a step.
const LOOK: u64 = 64;

/// A specimen as points and bonds.
#[derive(Debug)]
struct BondSpecimen {
    domain: PeridynamicDomain,
    frame: GridFrame,
    points: ReadBonds,
    held: Vec<HeldPoints>,
    mirrors: MirrorSet,
    pushed: Vec<PushedPoints>,
    /// Steps taken.
    steps: u64,
}

/// Makes points and bonds of a specimen.
///
/// # Errors
/// The bound that the specimen breaks.
pub(super) fn discrete(specimen: &SpecimenProblem) -> Result<Discrete, Refusal> {
    build::check(specimen)?;
    let frame = GridFrame::new(&specimen.body);
    let mut mirrors = MirrorSet::new(specimen);
    let mut domain = build::domain(specimen, &frame, &mut mirrors)?;
    // So that damage is what notches took.
    domain.strain();
    let points = ReadBonds::new(&domain, build::horizon(specimen), specimen.settings.spacing);
    let places: Vec<Vec3> = points.rest().iter().map(|x| frame.back(x)).collect();
    let held = hold::held(specimen, &mirrors, &places);
    let pushed = push::pushed(specimen, &frame, (&domain, &places));
    let holds_nothing =
        held.iter().enumerate().map(|(k, held)| held.is_empty() && !mirrors.has_support(k));
    idle("support", holds_nothing)?;
    let loads = specimen.loads.iter().zip(&pushed);
    idle("load", loads.map(|(load, on)| on.points.is_empty() && !load.push.is_none()))?;
    build::launch(specimen, &frame, &mut domain);
    Ok(Discrete {
        points: domain.places.len() as u64,
        stable_step: domain.greatest_step(),
        strength_ratio: build::strength_ratio(&domain, specimen),
        frame,
        loads: pushed.iter().map(|pushed| pushed.total).collect(),
        body: Box::new(BondSpecimen { domain, frame, points, held, mirrors, pushed, steps: 0 }),
    })
}

impl Discretisation for BondSpecimen {
    fn step(&mut self, drive: &Drive<'_>) -> StepTally {
        let damped = self.damp(drive);
        let forces = self.push(drive);
        let domain = &self.domain;
        let HeldStep { velocities, work, reactions } =
            hold::hold(domain, &self.frame, (&self.held, &self.mirrors), drive);
        let way = |p: usize| domain.velocities[p] + velocities[p];
        let pushed = forces.iter().map(|(&p, f)| 0.5 * drive.step * f.dot(&way(p as usize))).sum();
        let done = self.domain.advance(drive.step, |p, _| velocities[p]);
        self.steps += 1;
        let limit = match self.steps.is_multiple_of(LOOK) {
            true => self.domain.check().err(),
            false => self.domain.check_flow().err(),
        };
        StepTally {
            dissipated: done.plastic + done.broken + done.unbooked,
            damped: damped + done.damped,
            met: done.friction,
            pushed,
            held: work,
            reactions,
            limit: limit.map(|why| why.to_string()),
        }
    }

    fn sums(&self) -> BodySums {
        let sums = self.domain.sums();
        let stored = |k: usize| {
            let (p, law) = (self.domain.own + k, &self.domain.law);
            let state = &self.domain.states[p];
            self.domain.volumes[p] * law.energy(1.0 - state.damage, state.mean, state.deviation)
        };
        let grips: f64 = self.mirrors.gripped().map(stored).sum();
        let numbers = self.domain.places.iter().chain(&self.domain.velocities);
        BodySums {
            kinetic: sums.kinetic,
            elastic: sums.elastic + sums.contact + grips,
            momentum: sums.momentum,
            angular_momentum: sums.angular,
            finite: numbers.flat_map(|v| v.iter()).all(|number| number.is_finite()),
        }
    }

    fn points(&self, fields: &[PointField]) -> PointFields {
        self.points.fields(&self.domain, fields)
    }

    fn pieces(&self) -> Vec<f64> {
        self.points.shares(&self.domain)
    }
}

impl BondSpecimen {
    /// Slows all points down; the energy that this took \[J\].
    fn damp(&mut self, drive: &Drive<'_>) -> f64 {
        if drive.damping <= 0.0 {
            return 0.0;
        }
        let half = 0.5 * drive.damping * drive.step;
        let share = (1.0 - half) / (1.0 + half);
        let mut kinetic = 0.0;
        for p in 0..self.domain.own {
            kinetic += 0.5 * self.domain.mass(p) * self.domain.velocities[p].norm_squared();
            self.domain.velocities[p] *= share;
        }
        kinetic * (1.0 - share * share)
    }

    /// Adds the loads to the forces of a step; the force on each point \[N\].
    fn push(&mut self, drive: &Drive<'_>) -> BTreeMap<u32, Vec3> {
        let mut sums: BTreeMap<u32, Vec3> = BTreeMap::new();
        let active = self.pushed.iter().zip(drive.loads).filter(|(_, factor)| **factor != 0.0);
        for (pushed, factor) in active {
            for (point, force) in &pushed.points {
                *sums.entry(*point).or_default() += force * *factor;
            }
        }
        for (point, force) in &sums {
            self.domain.forces[*point as usize] += force;
        }
        sums
    }
}
