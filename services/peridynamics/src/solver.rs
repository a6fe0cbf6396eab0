//! The peridynamic family: rigid strikers and supports press on a body of points and bonds, and
//! what comes of it is a dent, or parts.

mod body;
mod components;
mod parts;
mod report;
pub(crate) mod setup;
mod shape;
mod state;
#[cfg(test)]
mod tests;

pub use state::Peridynamics;

use cullet_fragment::press::RigidPress;
use cullet_geometry::Vec3;
use cullet_model::{
    BrittleProblem, Cost, Failure, PointPrecision, Problem, Progress, Refusal, SolveOutcome, Solver,
};
use cullet_simd::SimdLevel;
use state::NO_CHANGE;

/// Point-steps of a slice: some tens of milliseconds.
const SLICE: u64 = 100_000;

/// Steps between checks of the energy and of strains, and of whether the push is over.
const CHECK: u64 = 48;
const LOOK: u64 = 16;

/// How often an unstable solve is begun again with half the step.
const HALVINGS: u32 = 2;

/// Transits L/c_s: that a push may take; that a striker has parted, or that nothing flows or
/// breaks, after which it is over; that cracks may still come of waves; and until it is at rest.
const PUSH_TRANSITS: f64 = 60.0;
const APART_TRANSITS: f64 = 1.0;
const QUIET_TRANSITS: f64 = 4.0;
const CRACK_TRANSITS: f64 = 2.0;
const REST_TRANSITS: f64 = 20.0;

impl Solver for Peridynamics {
    const NAME: &'static str = "peridynamics";
    // Bonds are worked out in f32, whatever is asked for: places and velocities are f64.
    const PRECISIONS: &'static [PointPrecision] = &[PointPrecision::Single, PointPrecision::Double];

    fn accepts(problem: &Problem) -> Result<Cost, Refusal> {
        let (problem, bonds) = BrittleProblem::bonded(problem.clone(), Self::NAME)?;
        setup::estimate_cost(&problem, &bonds)
    }

    fn begin(problem: Problem) -> Result<Self, Refusal> {
        let (problem, bonds) = BrittleProblem::bonded(problem, Self::NAME)?;
        Self::with(problem, bonds, SimdLevel::best())
    }

    fn advance(&mut self) -> Progress {
        let slice = (SLICE / self.body.first.len().max(1) as u64).max(1);
        for _ in 0..slice {
            let done = match self.step() {
                Ok(()) if self.is_over() => self.close(),
                other => other.map(|()| None),
            };
            match done {
                Ok(None) => {}
                Ok(Some(outcome)) => return Progress::Done(outcome),
                Err(failure) => match self.again(&failure) {
                    Some(again) => *self = again,
                    None => return Progress::Failed(failure),
                },
            }
        }
        Progress::Running((self.body.clock.time / (PUSH_TRANSITS * self.transit)).min(0.99))
    }
}

impl Peridynamics {
    /// The solve from its beginning with half the step, where numbers went wrong.
    fn again(&self, failure: &Failure) -> Option<Self> {
        let numbers = matches!(failure, Failure::NotFinite { .. } | Failure::Unstable { .. });
        if !numbers || self.setup.halvings == HALVINGS {
            return None;
        }
        let fresh = Self::with(self.problem.clone(), self.bonds, self.setup.simd_level);
        let mut fresh = fresh.ok()?;
        fresh.setup.halvings = self.setup.halvings + 1;
        fresh.body.clock.step /= f64::from(1_u32 << fresh.setup.halvings);
        let step = fresh.body.clock.step;
        fresh.record.warnings.push(format!("{failure}: solved again with steps of {step:.3e} s"));
        Some(fresh)
    }

    /// Whether the budget of steps is spent.
    fn is_spent(&self) -> bool {
        self.body.clock.steps >= u64::from(self.problem.settings.max_steps)
    }

    fn step(&mut self) -> Result<(), Failure> {
        if self.record.push_over.is_none() {
            let fastest = self.body.fastest();
            for press in self.strikers.iter_mut().chain(&mut self.supports) {
                press.push(&mut self.body, &self.points, fastest);
            }
        }
        let tally = self.body.advance();
        let record = &mut self.record;
        record.plastic += tally.plastic;
        record.broken += tally.broken;
        record.damped += tally.friction + tally.damped;
        record.unbooked.0 += tally.unbooked;
        record.unbooked.1 += tally.jumped;
        let taken = record.plastic + record.broken;
        let (time, energy) = (self.body.clock.time, self.energy());
        if taken > self.record.changed.1 + NO_CHANGE * energy {
            self.record.changed = (time, taken);
        }
        if self.body.clock.steps.is_multiple_of(CHECK) {
            self.check()?;
        }
        Ok(())
    }

    /// Whether nothing is to come from outside any more: each striker has given all, or has parted
    /// for a while and catches up with nothing, and each support has parted, or what presses
    /// changes nothing; or the push took longer than any should.
    fn is_over(&mut self) -> bool {
        if self.record.push_over.is_some() {
            return true;
        }
        let time = self.body.clock.time;
        let late = time > PUSH_TRANSITS * self.transit || self.is_spent();
        if !late && !self.body.clock.steps.is_multiple_of(LOOK) {
            return false;
        }
        let whole = self.body.velocity();
        let (last, work) = self.record.changed;
        let quiet = work > 0.0 && time - last > QUIET_TRANSITS * self.transit;
        let apart =
            |it: &RigidPress| time - it.touched.unwrap_or(0.0) > APART_TRANSITS * self.transit;
        let rests = |it: &RigidPress| apart(it) || quiet;
        let parted = |it: &RigidPress| {
            let comes_on = it.speed > whole.dot(&it.normal) && !self.is_past(it);
            it.left <= 0.0 || if apart(it) { !comes_on } else { quiet }
        };
        let over = self.strikers.iter().all(parted) && self.supports.iter().all(rests);
        if !over && late {
            self.record.warnings.push(format!(
                "still pushed after {:.0} of a wave's ways through the body and {} steps: ended \
                 there",
                time / self.transit,
                self.body.clock.steps
            ));
        }
        if over || late {
            // Springs that are let go of take what they hold with them.
            self.record.push_over = Some(time);
        }
        over || late
    }

    /// Whether a ball has come through: nothing is left ahead that it catches up with.
    fn is_past(&self, press: &RigidPress) -> bool {
        let Some((centre, radius)) = press.ball() else { return false };
        let reach = radius + self.setup.spacing;
        let domain = &self.body.domain;
        let met = |(x, v): (&Vec3, &Vec3)| {
            let arm = x - centre;
            let along = arm.dot(&press.normal);
            let aside = (arm - press.normal * along).norm();
            along > 0.0 && aside < reach && v.dot(&press.normal) < press.speed
        };
        !domain.places.iter().zip(&domain.velocities).any(met)
    }

    /// After the push: what comes of it, or nothing while the body still breaks or swings.
    fn close(&mut self) -> Result<Option<SolveOutcome>, Failure> {
        let time = self.body.clock.time;
        let push = self.record.push_over.unwrap_or(0.0);
        if time - push > REST_TRANSITS * self.transit || self.is_spent() {
            return self.finish().map(Some);
        }
        let breaks = self.bonds.breaks || self.bonds.failure.is_some();
        let quiet = time - self.record.changed.0.max(push) > CRACK_TRANSITS * self.transit;
        if breaks && !quiet {
            return Ok(None);
        }
        let parts = self.record.broken > NO_CHANGE * self.energy();
        if parts || !self.is_dented() || self.settle() {
            return self.finish().map(Some);
        }
        Ok(None)
    }

    /// Lets go of what swings: whether the body is at rest.
    fn settle(&mut self) -> bool {
        let masses = self.body.masses();
        let domain = &mut self.body.domain;
        self.settling.look(&masses, &domain.places, &mut domain.velocities)
    }
}
