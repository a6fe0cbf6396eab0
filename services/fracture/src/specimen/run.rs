//! The run: step by step, with books of what went in and out.

use super::build::{self, Frame as Place};
use super::hold::{self, Held, Mirror};
use super::probe::{Probe, Reading, shares};
use super::push::{self, Pushed};
use super::{Field, Specimen};
use crate::mpm::Domain;
use crate::mpm::contact::Shove;
use crate::mpm::stencil::{packed, vector};
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

/// What has gone in and out.
#[derive(Clone, Debug, Default)]
pub(super) struct Books {
    /// Energy at the start \[J\].
    pub(super) first: f64,
    /// Energy that is rounding \[J\]: of a body all of which is strained by what its precision
    /// cannot tell from nothing.
    pub(super) noise: f64,
    /// By loads and supports \[J\].
    pub(super) work: f64,
    /// Sum of the sizes of all works \[J\].
    pub(super) traffic: f64,
    /// By damage \[J\].
    pub(super) dissipated: f64,
    /// By damping \[J\].
    pub(super) damped: f64,
    /// Where sides met \[J\].
    pub(super) met: f64,
    /// Force of each support on the body \[N\], mean since the last sample.
    pub(super) reactions: Vec<Vec3>,
    /// Force of each load now \[N\].
    pub(super) applied: Vec<Vec3>,
}

impl Books {
    pub(super) fn balance(&self, domain: &Domain) -> f64 {
        let there = domain.kinetic_energy() + domain.elastic_energy();
        there + self.dissipated + self.damped + self.met - self.first - self.work
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// At its end.
    Done,
    /// A number stopped being one (F76).
    NotFinite {
        /// At which step.
        step: u64,
    },
    /// Energy appeared from nowhere (F04).
    Unstable {
        /// Energy over what was there and was put in \[1\].
        ratio: f64,
        /// At which step.
        step: u64,
    },
}

/// All points at one time, in the specimen's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// When \[s\].
    pub time: f64,
    /// Where they are \[m\] and what colours them.
    pub points: Vec<[f32; 4]>,
}

/// What came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub ending: Ending,
    /// Times of the samples \[s\].
    pub times: Vec<f64>,
    /// A row of samples for each probe.
    pub rows: Vec<Vec<f64>>,
    /// Shares of the body that its pieces have at the end, the largest first \[1\].
    pub pieces: Vec<f64>,
    /// Pictures.
    pub frames: Vec<Frame>,
    /// Time step \[s\].
    pub step: f64,
    /// Steps taken.
    pub steps: u64,
    /// Points.
    pub points: u64,
    /// Stress at which cracks grow over σ_f \[1\].
    pub strength_ratio: f64,
}

/// What a slice came to.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Share of the time that has gone.
    Running(f64),
    /// All.
    Done(Box<Outcome>),
}

/// A specimen at work.
#[derive(Debug)]
pub struct SpecimenRun {
    specimen: Specimen,
    domain: Domain,
    frame: Place,
    held: Vec<Held>,
    mirrors: Vec<Mirror>,
    pushed: Vec<Pushed>,
    /// The velocity that held nodes shall have, by node.
    wanted: Vec<Vec3>,
    /// Nodes that a load may push, and their velocity before the step.
    pushed_nodes: Vec<u32>,
    before: Vec<Vec3>,
    books: Books,
    /// Impulse of each support since the last sample \[N·s\], and since when \[s\].
    impulses: Vec<Vec3>,
    since: f64,
    /// Where points are in the specimen, by place in the arrays.
    places: Vec<Vec3>,
    times: Vec<f64>,
    rows: Vec<Vec<f64>>,
    frames: Vec<Frame>,
    total: u64,
    ending: Option<Ending>,
}

impl SpecimenRun {
    /// Puts a specimen on its grid and takes the first sample.
    ///
    /// # Errors
    /// The bound that the specimen breaks.
    pub fn begin(specimen: Specimen) -> Result<Self, Refusal> {
        build::check(&specimen)?;
        let mut domain = build::domain(&specimen)?;
        // The last step ends at the end.
        let total = (specimen.end / domain.step).ceil().max(1.0);
        domain.step = specimen.end / total;
        let frame = Place::new(&specimen);
        let mut run = Self {
            held: Vec::new(),
            wanted: Vec::new(),
            mirrors: Vec::new(),
            pushed: Vec::new(),
            pushed_nodes: Vec::new(),
            before: Vec::new(),
            books: Books::default(),
            impulses: vec![Vec3::zeros(); specimen.holds.len()],
            since: 0.0,
            places: Vec::new(),
            times: Vec::new(),
            rows: vec![Vec::new(); specimen.probes.len()],
            frames: Vec::new(),
            total: total as u64,
            ending: None,
            specimen,
            domain,
            frame,
        };
        run.attach()?;
        let energy = run.domain.kinetic_energy() + run.domain.elastic_energy();
        run.books.first = energy;
        run.books.noise = noise(&run.specimen);
        run.books.reactions = run.impulses.clone();
        run.note_applied();
        run.sample();
        run.picture();
        Ok(run)
    }

    /// The body on its grid as it is now.
    #[must_use]
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Takes some tens of milliseconds of steps.
    pub fn advance(&mut self) -> Step {
        let slice = (SLICE / self.domain.particles.len().max(1) as u64).max(1);
        for _ in 0..slice {
            if self.ending.is_none() && self.domain.steps >= self.total {
                self.ending = Some(Ending::Done);
            }
            if let Some(ending) = self.ending.take() {
                return Step::Done(Box::new(self.finish(ending)));
            }
            self.step();
        }
        Step::Running(self.domain.steps as f64 / self.total as f64)
    }

    /// Finds the nodes of supports, loads and planes of symmetry.
    fn attach(&mut self) -> Result<(), Refusal> {
        self.held = hold::held(&self.specimen, &self.frame, &self.domain.grid);
        self.mirrors = hold::mirrors(&self.specimen, &self.frame, &self.domain.grid)?;
        self.pushed = push::pushed(&self.specimen, &self.frame, &self.domain);
        build::idle("support", self.held.iter().map(|held| held.nodes.is_empty()))?;
        let loads = self.specimen.loads.iter().zip(&self.pushed);
        build::idle("load", loads.map(|(load, on)| on.nodes.is_empty() && !load.push.is_none()))?;
        self.note_pushed();
        Ok(())
    }

    /// Hands supports, loads and planes of symmetry on to the nodes from `first` on, which a crack
    /// has just made of others.
    fn follow(&mut self, first: u32) {
        let nodes = &self.domain.grid.nodes;
        self.held.iter_mut().for_each(|held| held.follow(nodes, first));
        self.mirrors.iter_mut().for_each(|mirror| mirror.follow(nodes, first));
        let groups = push::groups(nodes, first);
        self.pushed.iter_mut().for_each(|pushed| pushed.follow(nodes, &groups));
        self.note_pushed();
    }

    fn note_pushed(&mut self) {
        let all = self.pushed.iter().flat_map(|pushed| pushed.nodes.iter().map(|node| node.0));
        self.pushed_nodes = all.collect();
        self.pushed_nodes.sort_unstable();
        self.pushed_nodes.dedup();
    }

    fn step(&mut self) {
        let (time, step) = (self.domain.time, self.domain.step);
        self.damp(time, step);
        let velocity = |domain: &Domain, n: u32| vector(domain.grid.nodes.velocity[n as usize]);
        self.before =
            (0..self.domain.grid.nodes.len() as u32).map(|n| velocity(&self.domain, n)).collect();
        let mut forces = self.push(time, step);
        let nodes = self.domain.grid.nodes.len();
        let tally = self.domain.advance();
        self.books.dissipated += tally.dissipated;
        if self.domain.grid.nodes.len() != nodes {
            let origins = &self.domain.grid.nodes.origin[nodes..];
            let more: Vec<Vec3> = origins.iter().map(|&n| self.before[n as usize]).collect();
            self.before.extend(more);
            self.follow(nodes as u32);
            // What a node took its copies now carry; its own share is all that is accounted for.
            forces.retain(|(n, _)| self.pushed_nodes.binary_search(n).is_ok());
        }
        let worked = self.hold(step);
        self.mirrors.iter().for_each(|mirror| mirror.apply(&mut self.domain.grid, step));
        self.books.met += self.met();
        let pushed: f64 = forces
            .iter()
            .map(|(n, f)| {
                let mean = (self.before[*n as usize] + velocity(&self.domain, *n)) / 2.0;
                f.dot(&mean) * step
            })
            .sum();
        self.books.work += pushed + worked;
        self.books.traffic += pushed.abs() + worked.abs();
        self.look();
        self.record();
    }

    fn damp(&mut self, time: f64, step: f64) {
        let settings = &self.specimen.settings;
        if settings.damping <= 0.0 || time >= settings.damped_until {
            return;
        }
        let half = 0.5 * settings.damping * step;
        let share = (1.0 - half) / (1.0 + half);
        let kinetic = self.domain.kinetic_energy();
        for v in &mut self.domain.grid.nodes.velocity {
            *v *= wide::f64x4::splat(share);
        }
        self.books.damped += kinetic * (1.0 - share * share);
    }

    /// Applies the loads for one step; the force on each node \[N\].
    fn push(&mut self, time: f64, step: f64) -> Vec<(u32, Vec3)> {
        let mut forces: Vec<(u32, Vec3)> =
            self.pushed_nodes.iter().map(|&n| (n, Vec3::zeros())).collect();
        for (pushed, load) in self.pushed.iter().zip(&self.specimen.loads) {
            let factor = load.course.at(time);
            if factor != 0.0 {
                for (node, force) in &pushed.nodes {
                    if let Ok(at) = forces.binary_search_by_key(node, |row| row.0) {
                        forces[at].1 += force * factor;
                    }
                }
            }
        }
        let nodes = &mut self.domain.grid.nodes;
        for (node, force) in &forces {
            let n = *node as usize;
            nodes.velocity[n] += packed(force * (step / nodes.mass[n]));
        }
        forces
    }

    /// Energy that went where sides met in this step: what their pushes did on the way of both
    /// \[J\].
    fn met(&self) -> f64 {
        let velocities = &self.domain.grid.nodes.velocity;
        let way = |n: u32| self.before[n as usize] + vector(velocities[n as usize]);
        let gain = |shove: &Shove| {
            let [first, second] = shove.nodes;
            0.5 * shove.impulse.dot(&(way(second) - way(first)))
        };
        -self.domain.shoves().iter().map(gain).sum::<f64>()
    }

    /// Gives held nodes their velocities; the work that this took \[J\].
    ///
    /// The first of several supports that hold a node along an axis has the whole force.
    fn hold(&mut self, step: f64) -> f64 {
        let (time, mut work) = (self.domain.time, 0.0);
        self.wanted.resize(self.domain.grid.nodes.len(), Vec3::zeros());
        hold::add_up(&self.held, &self.specimen.holds, time, &mut self.wanted);
        let rows = self.held.iter_mut().zip(&self.specimen.holds).zip(&mut self.impulses);
        for ((held, hold), impulse) in rows.filter(|((_, hold), _)| time <= hold.until) {
            let mut sum = Vec3::zeros();
            for &(node, _) in &held.nodes {
                let n = node as usize;
                let free = vector(self.domain.grid.nodes.velocity[n]);
                let mut local = self.frame.unturned(&free);
                for axis in (0..3).filter(|&a| hold.axes[a]) {
                    local[axis] = self.wanted[n][axis];
                }
                let now = self.frame.turned(&local);
                let push = (now - free) * self.domain.grid.nodes.mass[n];
                work += push.dot(&(self.before[n] + now)) / 2.0;
                sum += push;
                hold::set(&mut self.domain.grid, node, &now, step);
            }
            held.force = self.frame.unturned(&(sum / step));
            *impulse += held.force * step;
        }
        work
    }

    /// Ends a run whose numbers mean nothing any more.
    fn look(&mut self) {
        let step = self.domain.steps;
        if !step.is_multiple_of(LOOK) && step != self.total {
            return;
        }
        if !self.domain.is_finite() {
            self.ending = Some(Ending::NotFinite { step });
            return;
        }
        let energy = self.domain.kinetic_energy() + self.domain.elastic_energy();
        let most = self.books.first + self.books.traffic + self.books.noise;
        if energy > GROWTH * most {
            self.ending = Some(Ending::Unstable { ratio: energy / most, step });
        }
    }

    /// Whether the `count` even parts of the run have one that ends with this step.
    fn is_due(&self, count: u32) -> bool {
        let part = |step: u64| u128::from(step) * u128::from(count) / u128::from(self.total);
        part(self.domain.steps) > part(self.domain.steps - 1)
    }

    fn record(&mut self) {
        if self.is_due(self.specimen.samples.max(1)) || self.ending.is_some() {
            let span = self.domain.time - self.since;
            self.books.reactions = self.impulses.iter().map(|sum| sum / span).collect();
            self.impulses.fill(Vec3::zeros());
            self.since = self.domain.time;
            self.note_applied();
            self.sample();
        }
        if self.specimen.frames > 0 && self.is_due(self.specimen.frames) {
            self.picture();
        }
    }

    fn note_applied(&mut self) {
        let loads = self.pushed.iter().zip(&self.specimen.loads);
        let time = self.domain.time;
        self.books.applied =
            loads.map(|(pushed, load)| pushed.total * load.course.at(time)).collect();
    }

    fn sample(&mut self) {
        let stress = self
            .specimen
            .probes
            .iter()
            .any(|probe| matches!(probe, Probe::Points(Field::Stress, _, _)));
        // Cracks put points in another order.
        let reference = &self.domain.particles.reference;
        self.places = reference.iter().map(|x| self.frame.back(x)).collect();
        let reading = Reading::new(&self.domain, &self.frame, &self.books, &self.places, stress);
        for (row, probe) in self.rows.iter_mut().zip(&self.specimen.probes) {
            row.push(reading.value(probe));
        }
        self.times.push(self.domain.time);
    }

    fn picture(&mut self) {
        if self.specimen.frames == 0 {
            return;
        }
        let (field, part) = self.specimen.colour;
        let stress = field == Field::Stress;
        let reading = Reading::new(&self.domain, &self.frame, &self.books, &self.places, stress);
        let count = self.domain.particles.len();
        let most = MOST_POINTS.0.min(MOST_POINTS.1 / (self.specimen.frames as usize + 1)).max(1);
        let stride = count.div_ceil(most).max(1);
        let none = Vec3::zeros();
        let points = (0..count as u32).step_by(stride).map(|id| {
            let p = self.domain.slot(id);
            let moved = |k| reading.at(p, Field::Displacement, super::Part::Axis(k), &none);
            let x = self.places[p] + Vec3::new(moved(0), moved(1), moved(2));
            [x.x as f32, x.y as f32, x.z as f32, reading.at(p, field, part, &none) as f32]
        });
        let points = points.collect();
        self.frames.push(Frame { time: self.domain.time, points });
    }

    fn finish(&mut self, ending: Ending) -> Outcome {
        Outcome {
            ending,
            times: std::mem::take(&mut self.times),
            rows: std::mem::take(&mut self.rows),
            pieces: shares(&self.domain),
            frames: std::mem::take(&mut self.frames),
            step: self.domain.step,
            steps: self.domain.steps,
            points: self.domain.particles.len() as u64,
            strength_ratio: build::strength_ratio(&self.specimen),
        }
    }
}

fn noise(specimen: &Specimen) -> f64 {
    let zones = specimen.zones.iter().map(|zone| zone.material.young);
    let young = zones.fold(specimen.material.young, f64::max);
    let strain = specimen.settings.precision.epsilon();
    0.5 * young * strain * strain * specimen.mesh.signed_volume()
}
