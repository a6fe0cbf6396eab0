//! The run: step by step, whatever the family, with books of what went in and out.

use crate::books::EnergyBooks;
use crate::discretisation::{Discrete, Drive, PointFields};
use crate::family::{SpecimenFamily, Unfit, by_name};
use crate::outcome::{Ending, Frame, SpecimenOutcome};
use crate::probe::{PointField, Probe, TensorPart};
use crate::problem::SpecimenProblem;
use crate::reading::ProbeReader;
use cullet_geometry::Vec3;
use cullet_model::Refusal;

/// Particle-steps of a slice: some tens of milliseconds.
const SLICE: u64 = 200_000;

/// Steps between looks at energy and finiteness (F04, F76).
const LOOK: u64 = 64;

/// Energy over what was there and was put in that counts as instability (F04).
const GROWTH: f64 = 1.5;

/// Most points of a frame, and of all frames together; of more, every second, third … is taken.
const MOST_POINTS: (usize, usize) = (60_000, 1 << 26);

/// A specimen at work.
#[derive(Debug)]
pub struct SpecimenRun {
    problem: SpecimenProblem,
    discrete: Discrete,
    books: EnergyBooks,
    /// Simulated time \[s\], the step \[s\], steps taken and steps there are.
    time: f64,
    step: f64,
    steps: u64,
    total: u64,
    /// Impulse of each support since the last sample \[N·s\], and since when \[s\].
    impulses: Vec<Vec3>,
    since: f64,
    taken: SampleRows,
    ending: Option<Ending>,
}

/// Samples and pictures so far.
#[derive(Debug, Default)]
struct SampleRows {
    times: Vec<f64>,
    rows: Vec<Vec<f64>>,
    frames: Vec<Frame>,
}

impl SpecimenRun {
    /// Has a family of the table make a specimen discrete and takes the first sample.
    ///
    /// # Errors
    /// There is no such family, it has not what the specimen asks for, or a bound is broken.
    pub fn begin(problem: SpecimenProblem, table: &[SpecimenFamily]) -> Result<Self, Unfit> {
        let family = by_name(table, &problem.family)?;
        family.check(&problem)?;
        check(&problem)?;
        let discrete = (family.build)(&problem)?;
        let (end, settings) = (problem.output.end, &problem.settings);
        let step = settings.step_factor * discrete.stable_step;
        at_most("the number of steps", end / step, settings.max_steps)?;
        // The last step ends at the end.
        let total = (end / step).ceil().max(1.0);
        let rows = vec![Vec::new(); problem.output.probes.len()];
        let mut run = Self {
            books: EnergyBooks::new(&problem, &discrete.body.sums()),
            time: 0.0,
            step: end / total,
            steps: 0,
            total: total as u64,
            impulses: vec![Vec3::zeros(); problem.holds.len()],
            since: 0.0,
            taken: SampleRows { rows, ..SampleRows::default() },
            ending: None,
            problem,
            discrete,
        };
        run.books.reactions.clone_from(&run.impulses);
        run.note_applied();
        run.sample();
        run.picture();
        Ok(run)
    }

    /// Takes some tens of milliseconds of steps; what came out once the end is reached.
    pub fn advance(&mut self) -> Option<SpecimenOutcome> {
        let slice = (SLICE / self.discrete.points.max(1)).max(1);
        for _ in 0..slice {
            if self.ending.is_none() && self.steps >= self.total {
                self.ending = Some(Ending::Ok);
            }
            if let Some(ending) = self.ending.take() {
                return Some(self.finish(ending));
            }
            self.step();
        }
        None
    }

    /// All of it: steps until something came out.
    pub fn finished(mut self) -> SpecimenOutcome {
        loop {
            if let Some(outcome) = self.advance() {
                return outcome;
            }
        }
    }

    fn step(&mut self) {
        let (start, step) = (self.time, self.step);
        let end = start + step;
        let settings = &self.problem.settings;
        let damped = settings.damped_until.is_none_or(|until| start < until);
        let loads: Vec<f64> = self.problem.loads.iter().map(|load| load.course.at(start)).collect();
        let holds = self.problem.holds.iter().map(|hold| {
            let holds = hold.until.is_none_or(|until| end <= until);
            holds.then(|| hold.course.at(end))
        });
        let holds: Vec<Option<f64>> = holds.collect();
        let damping = if damped { settings.damping } else { 0.0 };
        let drive = Drive { step, loads: &loads, holds: &holds, damping };
        let tally = self.discrete.body.step(&drive);
        self.time = end;
        self.steps += 1;
        self.books.add(&tally);
        let frame = &self.discrete.frame;
        let rows = self.impulses.iter_mut().zip(&tally.reactions).zip(&holds);
        for ((impulse, force), _) in rows.filter(|(_, holds)| holds.is_some()) {
            *impulse += frame.unturned(force) * step;
        }
        self.look();
        if let Some(why) = tally.limit {
            let (time, step, total) = (self.time, self.steps, self.total);
            let text = format!("at {time:.4e} s, step {step} of {total}: {why}");
            self.ending = Some(Ending::Refused(text));
        }
        self.record();
    }

    /// Ends a run whose numbers mean nothing any more.
    fn look(&mut self) {
        let step = self.steps;
        if !step.is_multiple_of(LOOK) && step != self.total {
            return;
        }
        let sums = self.discrete.body.sums();
        if !sums.finite {
            let text = format!("a value is not finite at step {step}");
            self.ending = Some(Ending::NotFinite(text));
        } else if self.books.exceeds(&sums, GROWTH) {
            let ratio = self.books.growth(&sums);
            let text = format!("{ratio:.3} of the energy put in at step {step}");
            self.ending = Some(Ending::Unstable(text));
        }
    }

    /// Whether the `count` even parts of the run have one that ends with this step.
    fn is_due(&self, count: u32) -> bool {
        let part = |step: u64| u128::from(step) * u128::from(count) / u128::from(self.total);
        part(self.steps) > part(self.steps - 1)
    }

    fn record(&mut self) {
        if self.is_due(self.problem.output.samples.max(1)) || self.ending.is_some() {
            let span = self.time - self.since;
            self.books.reactions = self.impulses.iter().map(|sum| sum / span).collect();
            self.impulses.fill(Vec3::zeros());
            self.since = self.time;
            self.note_applied();
            self.sample();
        }
        if self.problem.output.frames > 0 && self.is_due(self.problem.output.frames) {
            self.picture();
        }
    }

    fn note_applied(&mut self) {
        let loads = self.discrete.loads.iter().zip(&self.problem.loads);
        let (time, frame) = (self.time, &self.discrete.frame);
        let force =
            |(total, load): (&Vec3, &crate::Load)| frame.unturned(total) * load.course.at(time);
        self.books.applied = loads.map(force).collect();
    }

    /// What is read off the body now, with those fields of its points.
    fn reader(&self, fields: &[PointField], with_sums: bool) -> ProbeReader<'_> {
        let body = &*self.discrete.body;
        let points = if fields.is_empty() { PointFields::default() } else { body.points(fields) };
        let frame = &self.discrete.frame;
        ProbeReader {
            body,
            frame,
            books: &self.books,
            sums: with_sums.then(|| body.sums()),
            spacing: self.problem.settings.spacing,
            places: points.places.iter().map(|x| frame.back(x)).collect(),
            points,
        }
    }

    fn sample(&mut self) {
        let probes = &self.problem.output.probes;
        let mut fields: Vec<PointField> = probes.iter().filter_map(Probe::field).collect();
        fields.sort_unstable();
        fields.dedup();
        let summed = |probe: &Probe| {
            matches!(
                probe,
                Probe::Kinetic
                    | Probe::Elastic
                    | Probe::Balance
                    | Probe::Momentum(_)
                    | Probe::AngularMomentum(_)
            )
        };
        let reader = self.reader(&fields, probes.iter().any(summed));
        let values: Vec<f64> = probes.iter().map(|probe| reader.value(probe)).collect();
        self.taken.rows.iter_mut().zip(values).for_each(|(row, value)| row.push(value));
        self.taken.times.push(self.time);
    }

    fn picture(&mut self) {
        let output = &self.problem.output;
        if output.frames == 0 {
            return;
        }
        let (field, part) = output.colour;
        let reader = self.reader(&[PointField::Displacement, field], false);
        let numbers = &reader.points.numbers;
        let mut order: Vec<usize> = (0..numbers.len()).collect();
        order.sort_unstable_by_key(|&p| numbers[p]);
        let most = MOST_POINTS.0.min(MOST_POINTS.1 / (output.frames as usize + 1)).max(1);
        let stride = order.len().div_ceil(most).max(1);
        let none = Vec3::zeros();
        let points = order.into_iter().step_by(stride).map(|p| {
            let moved = |k| reader.at(p, PointField::Displacement, TensorPart::Axis(k), &none);
            let x = reader.places[p] + Vec3::new(moved(0), moved(1), moved(2));
            [x.x as f32, x.y as f32, x.z as f32, reader.at(p, field, part, &none) as f32]
        });
        let points = points.collect();
        self.taken.frames.push(Frame { time: self.time, points });
    }

    fn finish(&mut self, ending: Ending) -> SpecimenOutcome {
        let taken = std::mem::take(&mut self.taken);
        SpecimenOutcome {
            ending,
            step: self.step,
            steps: self.steps,
            points: self.discrete.points,
            strength_ratio: self.discrete.strength_ratio,
            pieces: self.discrete.body.pieces(),
            times: taken.times,
            rows: taken.rows,
            frames: taken.frames,
        }
    }
}

/// Refuses what no family can solve, with the bound.
fn check(problem: &SpecimenProblem) -> Result<(), Refusal> {
    let s = &problem.settings;
    within("the spacing [m]", s.spacing, 1e-9, 1e6)?;
    within("the step over its bound", s.step_factor, 1e-6, 100.0)?;
    within("the end [s]", problem.output.end, f64::MIN_POSITIVE, 1e9)?;
    within("the body's volume [m^3]", problem.body.mesh.signed_volume(), 1e-18, 1e12)
}

fn within(what: &'static str, value: f64, low: f64, high: f64) -> Result<(), Refusal> {
    let holds = (low..=high).contains(&value);
    if holds { Ok(()) } else { Err(Refusal::OutOfRange { what, value, low, high }) }
}

fn at_most(what: &'static str, value: f64, limit: f64) -> Result<(), Refusal> {
    if value <= limit { Ok(()) } else { Err(Refusal::TooLarge { what, value, limit }) }
}
