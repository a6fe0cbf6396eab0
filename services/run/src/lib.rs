//! One run, from a scene to its recording: steps the world, sends hits to the pool, puts fragments
//! back, writes it all down. Everything that decides happens here in one thread and in one order.

mod again;
mod convert;
mod error;
mod fields;
mod hits;
mod job;
mod jobs;
mod joints;
mod known_joints;
mod moving;
mod notices;
mod retire;
mod settle;
mod sheets;
#[cfg(test)]
mod tests;

pub use again::{RESULTS, RunAgain};
pub use convert::OVERRIDES;
pub use cullet_proto::service::Position;
pub use error::RunError;
pub use jobs::{Idle, JobPool, PoolLoad, WantedJob};

use cullet_geometry::Vec3;
use cullet_geometry::attributes::SurfaceAttributes;
use cullet_model::SolveOutcome as Solved;
use cullet_plan::{Decision, Experience, SolveOrder, decide};
use cullet_proto::{FractureJob, JobId};
use cullet_record::{Event, Level, MessageTap, PoseRow, RecordError, Recorder, Summary, Touch};
use cullet_scene::{Scene, SceneBody, rigid};
use cullet_world::{BodyId, Hit, KeyframedPath, World};
use job::DirectedHit;
use known_joints::KnownJoints;
use moving::{Arrived, RunningSheet, body_id, sheets_of};
use notices::Notices;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How long the run waits for the pool before it looks at whether it was asked to stop.
const PATIENCE: Duration = Duration::from_millis(50);

/// What a run needs beside its scene and its pool.
#[derive(Clone, Copy, Debug)]
pub struct RunOptions<'a> {
    /// Folder for `run.mcap`, `summary.json` and the pictures; it exists.
    pub out: &'a Path,
    /// Set by another thread: finish the recording and return.
    pub stop: &'a AtomicBool,
    /// Gets each message of the recording as it is written; nothing of it decides.
    pub tap: Option<&'a Arc<dyn MessageTap>>,
    /// The earlier run that this one takes up, and what it keeps for later ones.
    pub again: RunAgain<'a>,
}

impl<'a> RunOptions<'a> {
    /// A run by itself.
    #[must_use]
    pub fn new(out: &'a Path, stop: &'a AtomicBool) -> Self {
        Self { out, stop, tap: None, again: RunAgain::default() }
    }
}

/// News for whoever watches a run.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// How far it is.
    At(Position),
    /// A line worth a log.
    Line(String),
    /// A line about results that were taken, or could not be taken, from an earlier run.
    Results(String),
}

/// A run that came to its end, or was asked to stop.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// What the recording says.
    pub summary: Summary,
    /// Expectations of the scene that do not hold, a sentence each.
    pub unmet: Vec<String>,
    /// Whether it was asked to stop before its end.
    pub interrupted: bool,
    /// The recording.
    pub recording: PathBuf,
}

/// A job in the pool and what it is about.
struct Pending {
    id: JobId,
    asked: String,
    body: BodyId,
    hits: Vec<Hit>,
    order: SolveOrder,
    /// Settings of its own that the scene gives the hit.
    directed: Option<Box<DirectedHit>>,
    /// The last solve of the hit that came to an end, kept while a finer one is at work.
    held: Option<(JobId, Solved)>,
    due: u64,
}

impl Pending {
    /// Of its hits \[J\].
    fn energy(&self) -> f64 {
        self.hits.iter().map(|hit| hit.impact.energy).sum()
    }
}

/// What the scene says of an object, kept for all its fragments.
#[derive(Clone)]
struct ObjectOrigin {
    object: String,
    material: String,
    choice: job::Choice,
}

impl ObjectOrigin {
    /// Of a part, whose own origin is at `centre` in the body's frame \[m\].
    fn of_part(&self, centre: &Vec3) -> Self {
        Self { choice: self.choice.of_fragment(centre), ..self.clone() }
    }
}

/// A run of a scene in progress.
struct SceneRun<'a> {
    scene: &'a Scene,
    pool: &'a dyn JobPool,
    options: &'a RunOptions<'a>,
    news: &'a mut dyn FnMut(&News),
    world: World,
    recorder: Recorder,
    origins: BTreeMap<BodyId, ObjectOrigin>,
    pending: VecDeque<Pending>,
    /// Settlements of the first of these that came while a window was waited for.
    arrived: Arrived,
    sheets: Vec<RunningSheet>,
    told_of_sheets: BTreeSet<String>,
    seen: Experience,
    fractures: u64,
    broken: BTreeMap<String, u64>,
    notices: Notices,
    /// The paths of driven bodies.
    driven: BTreeMap<BodyId, Arc<KeyframedPath>>,
    /// Joints that are recorded and not at their end.
    joints: KnownJoints,
    /// Whether there may be other joints than these.
    joints_changed: bool,
    /// Entries of the scene, by place, whose hit was solved: with the settings of which entry.
    directed: BTreeMap<usize, usize>,
    /// Of these, those of which a job came to something.
    effective: BTreeSet<usize>,
}

/// Runs a scene to its end and writes `run.mcap` and `summary.json` into the folder.
///
/// # Errors
/// The world breaks down, the pool abandons a job, or a file cannot be written. The recording then
/// keeps its `.partial` name.
pub fn run(
    scene: &Scene,
    pool: &dyn JobPool,
    options: &RunOptions<'_>,
    news: &mut dyn FnMut(&News),
) -> Result<Outcome, RunError> {
    let world = World::new(rigid::world_settings(scene))?;
    let trail = options.again.trail(scene)?;
    let recorder = Recorder::tapped(
        &options.out.join("run.mcap"),
        &convert::meta(scene),
        options.tap.cloned(),
    );
    let recorder = again::begin(recorder, trail)?;
    let mut run = SceneRun {
        scene,
        pool,
        options,
        news,
        world,
        recorder,
        origins: BTreeMap::new(),
        pending: VecDeque::new(),
        arrived: Arrived::new(),
        sheets: sheets_of(scene),
        told_of_sheets: BTreeSet::new(),
        seen: Experience::default(),
        fractures: 0,
        broken: BTreeMap::new(),
        notices: Notices::of(scene),
        driven: BTreeMap::new(),
        joints: KnownJoints::new(),
        joints_changed: false,
        directed: BTreeMap::new(),
        effective: BTreeSet::new(),
    };
    let interrupted = match run.populate().and_then(|()| run.steps()) {
        Err(RunError::Record(error @ RecordError::Differs { .. })) => {
            run.recorder.discard();
            return Err(error.into());
        }
        ended => ended?,
    };
    if interrupted {
        run.recorder.unfollow();
        // Before what there is is written and drawn, which takes a while.
        pool.cancel();
    }
    let ended = run.finish(interrupted);
    if let Err(RunError::Record(RecordError::Differs { .. })) = ended {
        // As above, of a run that differs in its last step.
        let _it_stays = std::fs::remove_file(options.out.join("run.mcap.partial"));
    }
    ended
}

impl SceneRun<'_> {
    fn say(&mut self, line: impl Into<String>) {
        (self.news)(&News::Line(line.into()));
    }

    /// Puts the scene's bodies into the world and into the recording.
    fn populate(&mut self) -> Result<(), RunError> {
        let scene = self.scene;
        for line in &scene.warnings {
            self.recorder.log(Level::Warning, line.clone())?;
            self.say(line);
        }
        let mut bodies = Vec::with_capacity(scene.bodies.len());
        for body in &scene.bodies {
            let id = self.world.insert(rigid::spec(body))?;
            let origin = ObjectOrigin {
                object: body.name.clone(),
                material: body.material.name.clone(),
                choice: job::Choice::of(body, &scene.fracture, job::seed_of(id, scene.world.seed)),
            };
            self.origins.insert(id, origin);
            self.driven.extend(body.drive.clone().map(|path| (id, path)));
            self.record_birth(id)?;
            bodies.push((number(id), body));
            self.tell_position();
            if self.options.stop.load(Ordering::Relaxed) {
                break;
            }
        }
        self.record_appearances(&bodies)?;
        if bodies.len() == scene.bodies.len() {
            let ids: Vec<BodyId> = bodies.iter().map(|(id, _)| body_id(*id)).collect();
            self.join_bodies(&ids)?;
        }
        self.announce_sheets();
        Ok(())
    }

    /// Records what mesh files have beside their shapes, once for all bodies of one mesh.
    fn record_appearances(&mut self, bodies: &[(u64, &SceneBody)]) -> Result<(), RunError> {
        let mut users: Vec<(&Arc<SurfaceAttributes>, &str, Vec<u64>)> = Vec::new();
        let mut known: BTreeMap<usize, usize> = BTreeMap::new();
        for (id, body) in bodies {
            let Some(surface) = &body.surface else { continue };
            let next = users.len();
            let place = *known.entry(Arc::as_ptr(surface) as usize).or_insert(next);
            if place == next {
                users.push((surface, body.mesh_file.as_deref().unwrap_or_default(), Vec::new()));
            }
            users[place].2.push(*id);
        }
        for (surface, file, ids) in users {
            self.recorder.appearance(ids, file, surface)?;
        }
        Ok(())
    }

    fn steps(&mut self) -> Result<bool, RunError> {
        let last = self.scene.steps();
        if !self.open_windows()? {
            return Ok(true);
        }
        self.record_poses()?;
        while self.world.step_count() < last {
            if self.options.stop.load(Ordering::Relaxed) {
                return Ok(true);
            }
            self.push_bodies();
            self.apply_fields();
            let hits = self.world.step()?;
            self.lead_bodies();
            self.record_breaks()?;
            self.judge(hits)?;
            if !self.settle_until(self.world.step_count())? || !self.close_windows()? {
                return Ok(true);
            }
            self.remove_bodies()?;
            self.follow_joints()?;
            self.record_poses()?;
            if self.world.step_count() < last && !self.open_windows()? {
                return Ok(true);
            }
            let fallen = self.notices.fallen(&self.world);
            for line in fallen.into_iter().chain(self.notices.pressed(&self.world)) {
                self.say(line);
            }
            self.tell_position();
        }
        // What the end of the run overtook settles too, and breaks nothing.
        Ok(!self.settle_until(u64::MAX)?)
    }

    /// Records the hits of a step, decides about them, and opens a job for each body that may
    /// break.
    fn judge(&mut self, hits: Vec<Hit>) -> Result<(), RunError> {
        let mut by_body: BTreeMap<BodyId, Vec<Hit>> = BTreeMap::new();
        for hit in hits {
            self.event(&Event::Impact {
                body: number(hit.body),
                striker: number(hit.other),
                point: hit.point,
                impulse: hit.impact.impulse,
                closing_speed: hit.impact.closing_speed,
                energy: hit.impact.energy,
                contact: Touch {
                    duration: hit.impact.duration,
                    radius: hit.impact.radius,
                    peak_force: hit.peak_force,
                    dissipated: hit.dissipated,
                },
            })?;
            by_body.entry(hit.body).or_default().push(hit);
        }
        for (body, hits) in by_body {
            if self.pending.iter().any(|pending| pending.body == body) {
                let reason = "it is being solved for an earlier hit".to_owned();
                self.event(&Event::Gate { body: number(body), reason })?;
                continue;
            }
            self.decide(body, hits)?;
        }
        Ok(())
    }

    /// Decides about the hits of a body, and opens the first job if it is to be solved.
    fn decide(&mut self, body: BodyId, hits: Vec<Hit>) -> Result<(), RunError> {
        let origin = self.origins.get(&body).ok_or(RunError::Lost(body))?;
        let target = convert::target(&self.scene.fidelity);
        let directed = self.directed_hit(body);
        let choice = directed.as_ref().map_or(&origin.choice, |hit| &hit.choice);
        let policy = choice.policy(target, &origin.material);
        let order = match decide(&self.world, body, &hits, &policy) {
            None => return Err(RunError::Lost(body)),
            Some(Decision::Keep(reasons)) => {
                let all: f64 = hits.iter().map(|hit| hit.impact.energy).sum();
                for reason in reasons {
                    let reason = reason.to_string();
                    let event = Event::Gate { body: number(body), reason: reason.clone() };
                    self.event(&event)?;
                    self.notices.kept(body, all, reason);
                }
                return Ok(());
            }
            Some(Decision::Solve(order)) => *order,
        };
        self.take_directed(directed.as_deref());
        let due = self.world.step_count() + u64::from(self.scene.world.latency_steps);
        let (id, asked, reasons) = (JobId::of(&[]), String::new(), order.reasons.clone());
        let pending = Pending { id, asked, body, hits, order, directed, held: None, due };
        self.dispatch(pending, reasons)
    }

    /// Opens the next job of a hit.
    fn dispatch(&mut self, mut pending: Pending, mut reasons: Vec<String>) -> Result<(), RunError> {
        let body = pending.body;
        let lost = RunError::Lost(body);
        let (Some(view), Some(origin)) = (self.world.body(body), self.origins.get(&body)) else {
            return Err(lost);
        };
        let error = self.scene.fidelity.error;
        let told = self.directed_reason(pending.directed.as_mut());
        let directed = told.is_some();
        reasons.extend(told);
        let order = &mut pending.order;
        let hit = pending.directed.as_ref();
        let own = hit.map_or(&origin.choice, |hit| &hit.choice);
        let choice = order.refinement.climb().map(|spacing| own.on_grid(spacing, error));
        let choice = choice.as_ref().unwrap_or(own);
        if order.spin != Vec3::zeros() {
            reasons.push(format!("spins at {:.3e} rad/s", order.spin.norm()));
        }
        // What came to an end on a coarser grid is better than what stands in for any solve.
        let last = !order.refinement.goes_on() && pending.held.is_none();
        let fallback = order.fallback.filter(|_| last);
        let seed = hit.map_or(self.scene.world.seed, |hit| hit.seed);
        let problem = job::problem(&view, &pending.hits, order, choice, seed);
        let fallback = fallback.map(str::to_owned);
        let direction = choice.direction.as_deref().cloned();
        let job = FractureJob { solver: order.family.clone(), fallback, problem, direction };
        pending.asked = job.solver.clone();
        pending.id = self.pool.open(WantedJob::Fracture(&job));
        let (solver, reason) = (pending.asked.clone(), reasons.join("; "));
        let (body, job) = (number(body), pending.id.0);
        self.event(&Event::JobOpened { body, job, solver, reason, directed })?;
        self.pending.push_back(pending);
        Ok(())
    }

    /// Waits for the jobs that are due by a step and settles them. False: asked to stop.
    fn settle_until(&mut self, step: u64) -> Result<bool, RunError> {
        while self.pending.front().is_some_and(|p| p.due <= step) {
            let settled = match self.arrived.pop_front() {
                Some(settled) => settled,
                None => match self.next_settlement()? {
                    Some(settled) => settled,
                    None => return Ok(false),
                },
            };
            let Some(pending) = self.pending.pop_front() else {
                break;
            };
            let (id, settlement) = settled;
            if id != pending.id {
                return Err(RunError::OutOfOrder { got: id.short(), due: pending.id.short() });
            }
            self.settle(pending, settlement)?;
        }
        Ok(true)
    }

    fn event(&mut self, event: &Event) -> Result<(), RunError> {
        let (step, time) = (self.world.step_count(), self.world.time());
        Ok(self.recorder.event(step, time, event)?)
    }

    fn record_poses(&mut self) -> Result<(), RunError> {
        let rows: Vec<PoseRow> = self
            .world
            .bodies()
            .map(|view| PoseRow {
                id: number(view.id),
                pose: view.pose,
                velocity: view.velocity,
                spin: view.spin,
            })
            .collect();
        let (step, time) = (self.world.step_count(), self.world.time());
        self.recorder.grains(step, time, self.world.grains())?;
        Ok(self.recorder.poses(step, time, &rows)?)
    }

    fn tell_position(&mut self) {
        let load = self.pool.load();
        let asked = self.pending.front().map_or("", |pending| &pending.asked);
        if let Some(line) = self.notices.idle(&load, asked) {
            self.say(line);
        }
        (self.news)(&News::At(Position {
            time: self.world.time(),
            end: self.scene.world.duration,
            bodies: self.world.len() as u64,
            fractures: self.fractures,
            jobs: load.jobs,
            permille: load.permille,
            step: self.world.step_count(),
            steps: self.scene.steps(),
        }));
    }
}

fn number(id: BodyId) -> u64 {
    u64::from(id.0)
}
