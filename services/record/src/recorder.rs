//! The recorder: the run loop tells it what happens, it writes the file and keeps the tally.

use super::display::{self, Live};
use super::draw_budget::DrawBudget;
use super::grains::{GrainMessage, GrainRows};
use super::meta::{RunMeta, interior_of, meta_map, up};
use super::object::{self, Object};
use super::pose_row::PoseRow;
use super::sheet_book::SheetBook;
use super::sink::{MessageTap, Sink, Stamp};
use super::trail::Following;
use super::{
    BODIES, BODY, CRACKS, DEBRIS, EVENTS, Event, GEOMETRY, JOBS, JOINTS, POOL, RecordError,
    SAMPLED, SHAPE, Summary, Tally, event,
};
use cullet_geometry::{Sheet, Solid, Vec3};
use cullet_proto::recording::{
    Body, BodyJoint, BodyPoses, Cracks, Geometry, JobReport, NewShape, PoolReport, Recorded,
    Sampled, geometry_hash,
};
use cullet_world::DebrisParticle;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

pub use foxglove::messages::log::Level;

/// Wall time between two flushes \[s\]: what a killed run can lose at most.
const FLUSH_WALL: f64 = 1.0;
/// Simulated time between two flushes of a deterministic recording \[s\].
const FLUSH_SIMULATED: f64 = 0.25;
/// The same after a fracture: soon, but a wall of bricks that breaks at once is one flush.
const FLUSH_FRACTURE_WALL: f64 = 0.1;
/// The same in a deterministic recording \[s\].
const FLUSH_FRACTURE_SIMULATED: f64 = 0.02;

/// A recording that is complete.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished {
    /// The file.
    pub path: PathBuf,
    /// What it says, as [`super::inspect`] will read it.
    pub summary: Summary,
}

/// When the recording was last brought onto the disk.
#[derive(Default)]
struct Flushed {
    /// Wall time since the start \[s\].
    wall: f64,
    /// Simulated time \[s\].
    time: f64,
    /// Something broke since.
    wanted: bool,
}

/// Writes one run. It writes `<path>.partial` and gives it its name when the run is over.
pub struct Recorder {
    pub(super) sink: Sink,
    path: PathBuf,
    pub(super) partial: PathBuf,
    pub(super) meta: BTreeMap<String, String>,
    deterministic: bool,
    up: Vec3,
    pub(super) tally: Tally,
    /// The run that this one is to be as, up to a step.
    pub(super) following: Option<Following>,
    solids: BTreeMap<[u8; 32], Arc<display::Shape>>,
    pub(super) bodies: BTreeMap<u64, Live>,
    names: BTreeMap<u64, String>,
    /// The number of each material: its place among their names, from 1 on; and of each body's.
    materials: (Vec<String>, BTreeMap<u64, u32>),
    /// The grains told of.
    grains: GrainRows,
    pub(super) objects: BTreeMap<String, Object>,
    /// The sheets told of.
    pub(super) sheets: SheetBook,
    pub(super) drawing: DrawBudget,
    laid_out: bool,
    started: Instant,
    flushed: Flushed,
    now: u64,
    pub(super) step: u64,
    pub(super) time: f64,
}

fn partial_path(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".partial");
    path.with_file_name(name)
}

impl Recorder {
    /// Starts a recording that will be `path`, such as `runs/pot-1/run.mcap`.
    ///
    /// # Errors
    /// The file cannot be created or written.
    pub fn create(path: &Path, meta: &RunMeta) -> Result<Self, RecordError> {
        Self::tapped(path, meta, None)
    }

    /// Starts a recording as [`Recorder::create`] does, whose messages also go to `tap`.
    ///
    /// # Errors
    /// As [`Recorder::create`].
    pub fn tapped(
        path: &Path,
        meta: &RunMeta,
        tap: Option<Arc<dyn MessageTap>>,
    ) -> Result<Self, RecordError> {
        let partial = partial_path(path);
        let (mut sink, map) = (Sink::create(&partial, tap)?, meta_map(meta));
        sink.metadata("run", &map)?;
        sink.metadata("materials", &meta.materials)?;
        sink.attach("scene.toml", "application/toml", meta.scene_text.as_bytes())?;
        for (name, data) in &meta.files {
            let json = name.ends_with(".json");
            let kind = if json { "application/json" } else { "application/octet-stream" };
            sink.attach(name, kind, data)?;
        }
        sink.known("/tf", Stamp::default(), &display::frames(0, up(meta.gravity)))?;
        Ok(Self {
            sink,
            path: path.to_owned(),
            partial,
            grains: GrainRows::of(&map),
            meta: map,
            deterministic: meta.deterministic,
            up: up(meta.gravity),
            tally: Tally::default(),
            following: None,
            solids: BTreeMap::new(),
            bodies: BTreeMap::new(),
            names: BTreeMap::new(),
            materials: (meta.materials.keys().cloned().collect(), BTreeMap::new()),
            objects: BTreeMap::new(),
            sheets: SheetBook::default(),
            drawing: DrawBudget::new(meta),
            laid_out: false,
            started: Instant::now(),
            flushed: Flushed::default(),
            now: 0,
            step: 0,
            time: 0.0,
        })
    }

    fn wall(&self) -> f64 {
        if self.deterministic { 0.0 } else { self.started.elapsed().as_secs_f64() }
    }

    pub(super) fn stamp(&self) -> Stamp {
        let publish = if self.deterministic { self.now } else { (self.wall() * 1e9) as u64 };
        Stamp { log: self.now, publish }
    }

    pub(super) fn at(&mut self, step: u64, time: f64) -> Result<(), RecordError> {
        if !time.is_finite() {
            return Err(RecordError::NotFinite { what: "simulated time", value: time });
        }
        (self.step, self.time) = (step, time);
        self.now = self.now.max((time.max(0.0) * 1e9).round() as u64);
        Ok(())
    }

    pub(super) fn deciding<M: Recorded>(
        &mut self,
        topic: &str,
        message: &M,
    ) -> Result<(), RecordError> {
        let stamp = self.stamp();
        let payload = self.sink.own(topic, stamp, message)?;
        self.count(topic, stamp.log, &payload)
    }

    /// Records a solid unless it is there already; hands back its digest.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn geometry(&mut self, solid: &Solid) -> Result<[u8; 32], RecordError> {
        let hash = geometry_hash(solid);
        if !self.solids.contains_key(&hash) {
            // A crack face names the body that broke there plus one.
            let number = |parent: u32| {
                let body = u64::from(parent).checked_sub(1);
                body.and_then(|body| self.materials.1.get(&body)).copied().unwrap_or(0)
            };
            let geometry = Geometry::with_materials(solid, number);
            self.deciding(GEOMETRY, &geometry)?;
            self.solids.insert(hash, Arc::new(display::Shape::of(solid)));
        }
        Ok(hash)
    }

    /// Records a body at its birth. Its geometry comes first, its first pose after.
    ///
    /// # Errors
    /// Its geometry is not recorded, or the file cannot be written.
    pub fn body(&mut self, body: &Body) -> Result<(), RecordError> {
        let hash = <[u8; 32]>::try_from(&body.geometry[..]).ok();
        let Some(shape) = hash.and_then(|hash| self.solids.get(&hash)).cloned() else {
            return Err(RecordError::UnknownGeometry { body: body.id });
        };
        self.deciding(BODY, body)?;
        self.names.insert(body.id, body.name.clone());
        if let Ok(place) = self.materials.0.binary_search(&body.material) {
            self.materials.1.insert(body.id, place as u32 + 1);
        }
        let object = self.objects.entry(body.object.clone()).or_default();
        object.parts.insert(body.id);
        object.changed = true;
        let interior = interior_of(&self.meta, &body.object).map(|look| look.colour);
        let traces = Vec::new();
        self.bodies
            .insert(body.id, Live { body: body.clone(), shape, row: None, traces, interior });
        Ok(())
    }

    /// Records the new shape of a body. Its geometry comes first.
    ///
    /// # Errors
    /// A body or geometry that is not recorded, or a file that cannot be written.
    pub fn shape(&mut self, shape: &NewShape) -> Result<(), RecordError> {
        self.at(shape.step, shape.time)?;
        let hash = <[u8; 32]>::try_from(&shape.geometry[..]).ok();
        let Some(drawn) = hash.and_then(|hash| self.solids.get(&hash)).cloned() else {
            return Err(RecordError::UnknownGeometry { body: shape.body });
        };
        let Some(live) = self.bodies.get_mut(&shape.body) else {
            return Err(RecordError::UnknownBody { body: shape.body, what: "shape" });
        };
        live.shape = drawn;
        // They lay in the old frame, on the old surface.
        live.traces.clear();
        (live.body.geometry, live.body.mass) = (shape.geometry.clone(), shape.mass);
        live.body.volume = shape.volume;
        if let Some(object) = self.objects.get_mut(&live.body.object) {
            object.changed = true;
        }
        self.flushed.wanted = true;
        self.deciding(SHAPE, shape)
    }

    /// Records the cracks that end inside a body of this solid; nothing if there are none.
    ///
    /// # Errors
    /// A body that is not recorded, a time that is not finite, or a file that cannot be written.
    pub fn cracks(
        &mut self,
        (step, time): (u64, f64),
        body: u64,
        solid: &Solid,
        sheet: &Sheet,
    ) -> Result<(), RecordError> {
        if sheet.is_empty() {
            return Ok(());
        }
        self.at(step, time)?;
        let Some(live) = self.bodies.get_mut(&body) else {
            return Err(RecordError::UnknownBody { body, what: "cracks" });
        };
        live.traces.extend(super::traces(&solid.mesh, sheet));
        if let Some(object) = self.objects.get_mut(&live.body.object) {
            object.changed = true;
        }
        self.deciding(CRACKS, &Cracks::of(body, step, time, sheet))
    }

    /// Records where bodies are after `step`: rows whose bits did not change are left out.
    /// Then draws what is due and flushes what is due.
    ///
    /// # Errors
    /// A body that is not recorded or is no more, a time that is not finite, or a file that cannot
    /// be written.
    pub fn poses(&mut self, step: u64, time: f64, rows: &[PoseRow]) -> Result<(), RecordError> {
        self.at(step, time)?;
        let mut message = BodyPoses { step, time, ..Default::default() };
        for row in rows {
            let Some(live) = self.bodies.get_mut(&row.id) else {
                return Err(RecordError::UnknownBody { body: row.id, what: "pose" });
            };
            if live.row.is_some_and(|last| bits(&last) == bits(row)) {
                continue;
            }
            live.row = Some(*row);
            if let Some(object) = self.objects.get_mut(&live.body.object) {
                object.moved = true;
            }
            push_row(&mut message, row);
        }
        if !message.ids.is_empty() {
            self.deciding(BODIES, &message)?;
        }
        if !self.laid_out {
            self.laid_out = true;
            self.lay_out()?;
        }
        self.draw(false)?;
        self.flush_if_due()
    }

    fn lay_out(&mut self) -> Result<(), RecordError> {
        let balls = self.sheets.balls();
        let (centre, radius) = display::surroundings(self.bodies.values(), balls, self.up);
        let objects = self.objects.keys().map(|object| object::scene_topic(object));
        let drawn = objects.chain(self.sheets.topics()).filter(|_| self.drawing.objects);
        let layout = super::layout::layout(drawn.collect(), centre, radius);
        self.sink.attach("layout.json", "application/json", layout.as_bytes())
    }

    /// Records grains of debris: all of a new one, and where those that fly are. `grains`: all that
    /// there are, as the world keeps them.
    ///
    /// # Errors
    /// A time that is not finite, or a file that cannot be written.
    pub fn grains(
        &mut self,
        step: u64,
        time: f64,
        grains: &[DebrisParticle],
    ) -> Result<(), RecordError> {
        if self.grains.lie(grains) {
            return Ok(());
        }
        self.at(step, time)?;
        for GrainMessage { all, told } in self.grains.tell(step, time, grains) {
            let stamp = self.stamp();
            self.sink.own(DEBRIS, stamp, &told)?;
            self.count(DEBRIS, stamp.log, &all.to_bytes())?;
        }
        Ok(())
    }

    /// Records an event, and a line of it in the viewers' log.
    ///
    /// # Errors
    /// A time that is not finite, or a file that cannot be written.
    pub fn event(&mut self, step: u64, time: f64, event: &Event) -> Result<(), RecordError> {
        self.at(step, time)?;
        let message = event.to_message(step, time);
        self.deciding(EVENTS, &message)?;
        let names = &self.names;
        let name = |id: u64| names.get(&id).cloned().unwrap_or_else(|| format!("body {id}"));
        let line = event::line(&message, &name);
        self.log(level_of(event), line)?;
        match event {
            Event::Fractured { parent, .. } => {
                self.bury(*parent);
                self.flushed.wanted = true;
            }
            Event::Removed { body, .. } => self.bury(*body),
            _ => {}
        }
        Ok(())
    }

    fn bury(&mut self, id: u64) {
        if let Some(live) = self.bodies.remove(&id)
            && let Some(object) = self.objects.get_mut(&live.body.object)
        {
            object.parts.remove(&id);
            object.changed = true;
        }
    }

    /// Records a joint when it is made.
    ///
    /// # Errors
    /// A body that is not recorded, a time that is not finite, or a file that cannot be written.
    pub fn joint(&mut self, joint: &BodyJoint) -> Result<(), RecordError> {
        self.at(joint.step, joint.time)?;
        for body in std::iter::once(joint.body).chain(joint.other) {
            if !self.bodies.contains_key(&body) {
                return Err(RecordError::UnknownBody { body, what: "joint" });
            }
        }
        self.deciding(JOINTS, joint)
    }

    /// Records how a job came out: the part that decides.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn report(&mut self, report: &JobReport) -> Result<(), RecordError> {
        self.deciding(JOBS, report)
    }

    /// Records which fragments of a fracture were sampled.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn sampled(&mut self, sampled: &Sampled) -> Result<(), RecordError> {
        self.deciding(SAMPLED, sampled)
    }

    /// Records who computed a job, and for how long. A deterministic recording leaves it out.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn pool(&mut self, report: &PoolReport) -> Result<(), RecordError> {
        if self.deterministic { Ok(()) } else { self.deciding(POOL, report) }
    }

    /// Writes a line to the viewers' log.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn log(&mut self, level: Level, text: String) -> Result<(), RecordError> {
        let stamp = self.stamp();
        self.sink.known("/log", stamp, &display::log_line(stamp.log, level, text)).map(|_| ())
    }

    /// Brings the recording onto the disk if a second has passed or something broke.
    /// [`Recorder::poses`] does so too; call this where the run waits for its workers.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn flush_if_due(&mut self) -> Result<(), RecordError> {
        let wall = self.wall();
        let (passed, calm, broken) = if self.deterministic {
            (self.time - self.flushed.time, FLUSH_SIMULATED, FLUSH_FRACTURE_SIMULATED)
        } else {
            (wall - self.flushed.wall, FLUSH_WALL, FLUSH_FRACTURE_WALL)
        };
        if passed >= if self.flushed.wanted { broken } else { calm } {
            (self.flushed.wall, self.flushed.time) = (wall, self.time);
            self.flushed.wanted = false;
            self.sink.flush()?;
        }
        Ok(())
    }

    /// The summary so far.
    #[must_use]
    pub fn summary(&self) -> Summary {
        let end = BTreeMap::from([("wall_seconds".to_owned(), self.wall().to_string())]);
        self.tally.summary(&self.meta, &end)
    }

    /// Ends the recording after `steps` steps and `time` \[s\] and gives the file its name.
    ///
    /// # Errors
    /// The file cannot be written or renamed; what was flushed stays in the partial file.
    pub fn finish(mut self, steps: u64, time: f64) -> Result<Finished, RecordError> {
        self.at(steps, time)?;
        self.draw(true)?;
        self.event(steps, time, &Event::Finished)?;
        let end = BTreeMap::from([("wall_seconds".to_owned(), self.wall().to_string())]);
        self.sink.metadata("end", &end)?;
        self.sink.finish()?;
        std::fs::rename(&self.partial, &self.path).map_err(RecordError::io(&self.path))?;
        let summary = self.tally.summary(&self.meta, &end);
        Ok(Finished { path: self.path, summary })
    }
}

fn level_of(event: &Event) -> Level {
    match event {
        Event::Expectation { held: false, .. } => Level::Error,
        Event::Fractured { .. }
        | Event::Deformed { .. }
        | Event::JobSettled { .. }
        | Event::JointBroken { .. } => Level::Warning,
        _ => Level::Info,
    }
}

/// The numbers of a row in the order of the columns of [`BodyPoses`].
fn numbers(row: &PoseRow) -> [f64; 13] {
    let (p, q) = (row.pose.translation.vector, row.pose.rotation);
    let (v, w) = (row.velocity, row.spin);
    [p.x, p.y, p.z, q.i, q.j, q.k, q.w, v.x, v.y, v.z, w.x, w.y, w.z]
}

fn bits(row: &PoseRow) -> [u64; 13] {
    numbers(row).map(f64::to_bits)
}

fn push_row(message: &mut BodyPoses, row: &PoseRow) {
    let n = numbers(row);
    message.ids.push(row.id);
    message.positions.extend(&n[0..3]);
    message.rotations.extend(&n[3..7]);
    message.velocities.extend(&n[7..10]);
    message.spins.extend(&n[10..13]);
}
