//! A specimen as a plate: its steps, with what supports and loads do in them.

use super::build::{self, AlignedPlate, PlateDomain};
use super::hold::{self, HeldNodes, TakenStep};
use super::push::{self, PlateLoad};
use super::read::ReadPoints;
use cullet_geometry::Vec3;
use cullet_model::{PointPrecision, Refusal};
use cullet_simd::Real;
use cullet_specimen::{
    BodySums, Discrete, Discretisation, Drive, PointField, PointFields, SpecimenProblem, StepTally,
    idle,
};
use std::collections::BTreeMap;

/// A specimen as a plate.
#[derive(Debug)]
struct PlateSpecimen<R: Real> {
    domain: PlateDomain<R>,
    points: ReadPoints,
    held: Vec<HeldNodes>,
    loads: Vec<PlateLoad>,
    /// The force of each load by control point, and the splits that there had been \[N\].
    forces: (u64, Vec<BTreeMap<u32, Vec3>>),
    /// Whether points ahead of notches have yet to feel them.
    has_to_wake: bool,
}

/// Makes a plate of a specimen.
///
/// # Errors
/// The bound that the specimen breaks.
pub(super) fn discrete(specimen: &SpecimenProblem) -> Result<Discrete, Refusal> {
    match specimen.settings.precision {
        PointPrecision::Single => plate::<f32>(specimen),
        PointPrecision::Double => plate::<f64>(specimen),
    }
}

fn plate<R: Real + 'static>(specimen: &SpecimenProblem) -> Result<Discrete, Refusal> {
    let shape = AlignedPlate::new(specimen)?;
    build::check(specimen, &shape)?;
    let domain = build::domain::<R>(specimen, &shape)?;
    let held = hold::held(specimen, &shape, &domain);
    idle("support", held.iter().map(HeldNodes::is_empty))?;
    let loads = push::pushed(specimen, &shape, &domain);
    let rows = specimen.loads.iter().zip(&loads);
    idle("load", rows.map(|(load, on)| on.is_empty() && !load.push.is_none()))?;
    let points = ReadPoints::new(&domain);
    Ok(Discrete {
        points: points.len() as u64,
        stable_step: domain.stable_step(),
        strength_ratio: build::strength_ratio(&domain, specimen),
        frame: shape.frame,
        loads: loads.iter().map(|load| load.total).collect(),
        body: Box::new(PlateSpecimen {
            forces: (0, loads.iter().map(|load| load.by_node(&domain)).collect()),
            has_to_wake: specimen.settings.breaks,
            domain,
            points,
            held,
            loads,
        }),
    })
}

impl<R: Real + 'static> Discretisation for PlateSpecimen<R> {
    fn step(&mut self, drive: &Drive<'_>) -> StepTally {
        self.domain.step = drive.step;
        if std::mem::take(&mut self.has_to_wake) {
            self.domain.wake_tips();
        }
        let mut tally = StepTally { damped: self.damp(drive), ..StepTally::default() };
        let mut before = self.domain.velocity.clone();
        let forces = self.push(drive);
        let nodes = self.domain.mass.len();
        let done = self.domain.advance(|_, v| v);
        tally.dissipated = done.points.dissipated;
        tally.met = done.met;
        // Copies had the velocity of what they were parted from.
        let origin = &self.domain.origin[nodes..];
        let more: Vec<Vec3> = origin.iter().map(|&n| before[n as usize]).collect();
        before.extend(more);
        if before.len() > nodes {
            self.held.iter_mut().for_each(|held| held.follow(&self.domain.origin, nodes));
        }
        let taken = TakenStep { step: drive.step, factors: drive.holds, before: &before };
        hold::apply(&mut self.domain, &self.held, &taken, &mut tally);
        let way = |n: u32| before[n as usize] + self.domain.velocity[n as usize];
        tally.pushed = forces.iter().map(|(n, force)| 0.5 * drive.step * force.dot(&way(*n))).sum();
        tally
    }

    fn sums(&self) -> BodySums {
        let sums = self.domain.sums();
        let moved = self.domain.displacement.iter().flat_map(|u| u[..3].iter());
        let speeds = self.domain.velocity.iter().flat_map(|v| v.iter());
        BodySums {
            kinetic: sums.kinetic,
            elastic: sums.elastic,
            momentum: sums.momentum,
            angular_momentum: sums.angular_momentum,
            finite: moved.chain(speeds).all(|number| number.is_finite()),
        }
    }

    fn points(&self, fields: &[PointField]) -> PointFields {
        self.points.fields(&self.domain, fields)
    }

    fn pieces(&self) -> Vec<f64> {
        self.points.shares(&self.domain)
    }
}

impl<R: Real> PlateSpecimen<R> {
    /// Slows all control points down; the energy that this took \[J\].
    fn damp(&mut self, drive: &Drive<'_>) -> f64 {
        if drive.damping <= 0.0 {
            return 0.0;
        }
        let half = 0.5 * drive.damping * drive.step;
        let share = (1.0 - half) / (1.0 + half);
        let rows = self.domain.velocity.iter_mut().zip(&self.domain.mass);
        let slow = |(v, mass): (&mut Vec3, &f64)| {
            let kinetic = 0.5 * mass * v.norm_squared();
            *v *= share;
            kinetic
        };
        rows.map(slow).sum::<f64>() * (1.0 - share * share)
    }

    /// Applies the loads for one step; the force on each control point \[N\].
    fn push(&mut self, drive: &Drive<'_>) -> BTreeMap<u32, Vec3> {
        let splits = self.domain.splits();
        if splits != self.forces.0 {
            let forces = self.loads.iter().map(|load| load.by_node(&self.domain)).collect();
            self.forces = (splits, forces);
        }
        let mut sums: BTreeMap<u32, Vec3> = BTreeMap::new();
        let active = self.forces.1.iter().zip(drive.loads).filter(|(_, factor)| **factor != 0.0);
        for (forces, factor) in active {
            for (node, force) in forces {
                *sums.entry(*node).or_default() += force * *factor;
            }
        }
        for (node, force) in &sums {
            self.domain.external[*node as usize] += force;
        }
        sums
    }
}
