//! A specimen as a sheet: its steps, with what supports and loads do in them.

use super::build;
use super::hold::{self, HeldRow};
use super::outline::AlignedSheet;
use super::push::{self, PushedRow};
use super::read::ReadSheet;
use crate::steps::SheetRun;
use cullet_geometry::Vec3;
use cullet_model::Refusal;
use cullet_specimen::{
    BodySums, Discrete, Discretisation, Drive, GridFrame, PointField, PointFields, SpecimenProblem,
    StepTally, idle,
};
use std::sync::Arc;

/// Steps between looks at what has parted (F84).
const LOOK: u64 = 20;

/// A specimen as a sheet.
#[derive(Debug)]
struct SheetSpecimen {
    run: SheetRun,
    points: ReadSheet,
    held: Vec<HeldRow>,
    pushed: Vec<PushedRow>,
    /// Velocities before a step \[m/s\].
    before: Vec<Vec3>,
    /// Steps taken.
    steps: u64,
}

/// Makes a sheet of a specimen.
///
/// # Errors
/// The bound that the specimen breaks.
pub(super) fn discrete(specimen: &SpecimenProblem) -> Result<Discrete, Refusal> {
    let shape = AlignedSheet::new(&specimen.body.mesh)?;
    build::check(specimen, &shape)?;
    let mut prepared = build::prepared(specimen, &shape)?;
    let places = &prepared.points.places;
    let rest: Vec<Vec3> = places.iter().map(|&p| shape.place(p, 0.0)).collect();
    let masses: Vec<[f64; 2]> = (0..rest.len()).map(|i| prepared.dry(i)).collect();
    let pushed = push::pushed(specimen, &shape, places, &masses);
    let loads = specimen.loads.iter().zip(&pushed);
    idle("load", loads.map(|(load, on)| on.points.is_empty() && !load.push.is_none()))?;
    let state = build::started(specimen, &prepared, &rest)?;
    let held = hold::held(specimen, &shape, &rest);
    idle("support", held.iter().map(HeldRow::is_empty))?;
    let stiffer = hold::stiffen(&mut prepared.stencils, &held);
    let stable_step = build::stable_step(&prepared, stiffer);
    build::choose_steps(specimen, &mut prepared, stable_step)?;
    let ratio = prepared.limits().first / prepared.strength;
    let mut run = SheetRun::new(Arc::new(prepared), state, Vec::new());
    run.guard_points(hold::guarded(specimen, &shape, &held, &rest));
    Ok(Discrete {
        points: rest.len() as u64,
        stable_step,
        strength_ratio: if specimen.settings.breaks { ratio.min(1.0) } else { 1.0 },
        frame: GridFrame::default(),
        loads: pushed.iter().map(|row| row.total).collect(),
        body: Box::new(SheetSpecimen {
            points: ReadSheet::new(&run, &shape, rest),
            before: Vec::new(),
            run,
            held,
            pushed,
            steps: 0,
        }),
    })
}

impl Discretisation for SheetSpecimen {
    fn step(&mut self, drive: &Drive<'_>) -> StepTally {
        let mut tally = StepTally { damped: self.damp(drive), ..StepTally::default() };
        self.before.clone_from(&self.run.state.velocities);
        self.push(drive);
        let sums = self.run.books.sums;
        self.run.advance_whole();
        hold::apply(&mut self.run, &self.held, &self.before, drive, &mut tally);
        let way = |i: usize| self.before[i] + self.run.state.velocities[i];
        let rows = self.pushed.iter().zip(drive.loads);
        let work = |(row, factor): (&PushedRow, &f64)| {
            let own = row.points.iter().map(|(i, force)| force.dot(&way(*i as usize)));
            0.5 * drive.step * factor * own.sum::<f64>()
        };
        tally.pushed = rows.map(work).sum();
        self.steps += 1;
        if self.steps.is_multiple_of(LOOK) {
            self.run.part();
        }
        let done = self.run.books.sums;
        tally.dissipated = done.broken - sums.broken + done.plastic - sums.plastic;
        tally.damped += done.damped - sums.damped;
        tally
    }

    fn sums(&self) -> BodySums {
        let (state, masses) = (&self.run.state, &self.run.masses);
        let momentum = |i: usize| state.velocities[i] * masses[i][1];
        let numbers = state.places.iter().chain(&state.velocities);
        BodySums {
            kinetic: self.run.kinetic(),
            elastic: self.run.stored().iter().sum(),
            momentum: (0..masses.len()).map(momentum).sum(),
            angular_momentum: (0..masses.len()).map(|i| state.places[i].cross(&momentum(i))).sum(),
            finite: numbers.flatten().all(|number| number.is_finite()),
        }
    }

    fn points(&self, fields: &[PointField]) -> PointFields {
        self.points.fields(&self.run, fields)
    }

    fn pieces(&self) -> Vec<f64> {
        self.points.shares(&self.run)
    }
}

impl SheetSpecimen {
    /// Slows all points down; the energy that this took \[J\].
    fn damp(&mut self, drive: &Drive<'_>) -> f64 {
        if drive.damping <= 0.0 {
            return 0.0;
        }
        let half = 0.5 * drive.damping * drive.step;
        let share = (1.0 - half) / (1.0 + half);
        let kinetic = self.run.kinetic();
        self.run.state.velocities.iter_mut().for_each(|v| *v *= share);
        kinetic * (1.0 - share * share)
    }

    /// Sets the loads of a step.
    fn push(&mut self, drive: &Drive<'_>) {
        if self.pushed.is_empty() {
            return;
        }
        let forces = self.run.loads();
        for (row, factor) in self.pushed.iter().zip(drive.loads) {
            for (i, force) in &row.points {
                forces[*i as usize] += force * *factor;
            }
        }
    }
}
