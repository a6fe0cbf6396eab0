//! The summary of a run, and the tally that makes it from messages alone: while recording and,
//! with the same code, from a finished file.

use super::directed::{DirectedCensus, DirectedTotals};
use super::shares::{Census, Shares};
use super::sheet_census::{SheetCensus, SheetTotals};
use super::{
    BODIES, BODY, DEBRIS, EVENTS, GEOMETRY, JOBS, JOINTS, POOL, RecordError, RunDigest, SAMPLED,
    SHAPE, SHEETS, WINDOWS,
};
use cullet_geometry::Solid;
use cullet_proto::recording::{
    Body, BodyPoses, EventKind, Geometry, Grains, JobReport, Ledger, NewShape, PoolReport,
    Recorded, RunEvent, SheetFrame, SheetWindow, Verdict,
};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Version of the layout of [`Summary`]: grows when a field changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;

/// What became of the fracture jobs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Jobs {
    /// Handed to the pool.
    pub opened: u64,
    /// Ended with a verdict.
    pub settled: u64,
    /// Of these, declined by every solver asked.
    pub refused: u64,
    /// Of these, ended by numerics that went wrong or by the pool's giving up.
    pub failed: u64,
    /// Handed out again after a worker was lost.
    pub resent: u64,
    /// Jobs, windows counted, whose results were there from an earlier solve.
    #[serde(default)]
    pub taken: u64,
    /// Jobs, windows counted, that went to workers in this run.
    #[serde(default)]
    pub solved: u64,
}

/// What all replacements together kept and cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LedgerTotals {
    /// Worst relative error of mass over all fractures \[1\].
    pub mass_rel_error: f64,
    /// Worst relative error of volume \[1\].
    pub volume_rel_error: f64,
    /// Worst relative error of linear momentum \[1\].
    pub momentum_rel_error: f64,
    /// Worst relative error of angular momentum \[1\].
    pub angular_momentum_rel_error: f64,
    /// Kinetic energy of the pairs before their fractures, summed \[J\].
    pub energy_before: f64,
    /// Kinetic energy of the pairs and fragments after, summed \[J\].
    pub energy_after: f64,
    /// G_f·A, summed \[J\].
    pub fracture_energy: f64,
    /// Worst relative gain of energy \[1\].
    pub energy_gain_rel: f64,
}

impl LedgerTotals {
    fn add(&mut self, ledger: &Ledger) {
        self.mass_rel_error = self.mass_rel_error.max(ledger.mass_rel_error);
        self.volume_rel_error = self.volume_rel_error.max(ledger.volume_rel_error);
        self.momentum_rel_error = self.momentum_rel_error.max(ledger.momentum_rel_error);
        self.angular_momentum_rel_error =
            self.angular_momentum_rel_error.max(ledger.angular_momentum_rel_error);
        self.energy_before += ledger.energy_before;
        self.energy_after += ledger.energy_after;
        self.fracture_energy += ledger.fracture_energy;
        self.energy_gain_rel = self.energy_gain_rel.max(ledger.energy_gain_rel);
    }
}

/// `summary.json`. Keys keep this order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Version of the program that recorded the run.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// Its seed.
    pub seed: u64,
    /// What the recording lacks, in words; nothing, and no key, where it is whole or only ends
    /// early. All that follows is of what is left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub missing: Option<String>,
    /// Steps taken.
    pub steps: u64,
    /// Simulated time \[s\].
    pub sim_seconds: f64,
    /// Wall time \[s\]; zero for a run that was cut off.
    pub wall_seconds: f64,
    /// Bodies of the scene.
    pub bodies_initial: u64,
    /// Bodies left at the end.
    pub bodies_final: u64,
    /// Replacements of a body by fragments.
    pub fractures: u64,
    /// Bodies that were given a new shape and did not break.
    #[serde(default)]
    pub deformed: u64,
    /// Fragments made.
    pub fragments: u64,
    /// Grains of debris made.
    #[serde(default)]
    pub grains: u64,
    /// Their mass \[kg\].
    #[serde(default)]
    pub grain_mass: f64,
    /// How much of the fragments was solved, and how much was sampled; nothing where the recording
    /// does not tell, as old ones do not.
    #[serde(default)]
    pub shares: Option<Shares>,
    /// What came of sheets; nothing, and no key, where there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sheets: Option<SheetTotals>,
    /// What directed the run; nothing, and no key, where nothing did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub directed: Option<DirectedTotals>,
    /// Fracture jobs.
    pub jobs: Jobs,
    /// How many jobs each solver answered.
    pub solvers: BTreeMap<String, u64>,
    /// What the replacements kept and cost.
    pub ledger: LedgerTotals,
    /// Fragments whose boundary is open, inverted or unreadable.
    pub open_fragments: u64,
    /// Least volume of a fragment over the volume of its object \[1\]; 1 if nothing broke.
    pub smallest_volume_ratio: f64,
    /// [`RunDigest`] in hexadecimal.
    pub digest: String,
}

impl Summary {
    /// The summary as JSON with a line a key and a line break at the end.
    #[must_use]
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.unwrap_or_else(|error| format!("{{\"error\": \"{error}\"}}")) + "\n"
    }
}

/// Adds up messages into a [`Summary`].
#[derive(Clone, Debug, Default)]
pub struct Tally {
    summary: Summary,
    digest: RunDigest,
    alive: BTreeSet<u64>,
    /// Whether each recorded geometry is closed and right side out.
    sound: BTreeMap<Vec<u8>, bool>,
    /// Volume of each object of the scene \[m³\].
    volumes: BTreeMap<String, f64>,
    smallest: Option<f64>,
    census: Census,
    sheets: SheetCensus,
    directed: DirectedCensus,
}

impl Tally {
    /// Takes in one recorded message. Topics that say nothing about the summary are passed over.
    ///
    /// # Errors
    /// Bytes that do not decode as the message of their topic.
    pub fn message(
        &mut self,
        topic: &str,
        log_time: u64,
        payload: &[u8],
    ) -> Result<(), RecordError> {
        self.digest.update(topic, payload);
        match topic {
            GEOMETRY => self.geometry(&decode(topic, log_time, payload)?),
            BODY => self.body(&decode(topic, log_time, payload)?),
            BODIES => {
                let poses: BodyPoses = decode(topic, log_time, payload)?;
                self.at(poses.step, poses.time);
            }
            SHAPE => {
                let shape: NewShape = decode(topic, log_time, payload)?;
                self.at(shape.step, shape.time);
                self.census.reshaped(&shape);
                let sound = self.sound.get(&shape.geometry).copied().unwrap_or(false);
                self.summary.open_fragments += u64::from(!sound);
            }
            DEBRIS => {
                let grains: Grains = decode(topic, log_time, payload)?;
                self.at(grains.step, grains.time);
                self.summary.grains += grains.masses.len() as u64;
                self.summary.grain_mass += grains.masses.iter().sum::<f64>();
            }
            JOINTS => self.directed.joint(&decode(topic, log_time, payload)?),
            EVENTS => self.event(&decode(topic, log_time, payload)?),
            JOBS => {
                let report: JobReport = decode(topic, log_time, payload)?;
                self.directed.report(&report);
                if !report.solver.is_empty() {
                    *self.summary.solvers.entry(report.solver).or_default() += 1;
                }
            }
            SHEETS => {
                let frame: SheetFrame = decode(topic, log_time, payload)?;
                self.at(frame.step, frame.time);
                self.sheets.frame(&frame);
            }
            WINDOWS => {
                let window: SheetWindow = decode(topic, log_time, payload)?;
                self.at(window.end_step(), window.time);
                self.sheets.window(&window);
            }
            SAMPLED => {
                let told = decode(topic, log_time, payload)?;
                self.census.mark(&told);
                self.directed.pieces(&told);
            }
            POOL => {
                let report: PoolReport = decode(topic, log_time, payload)?;
                let jobs = &mut self.summary.jobs;
                jobs.resent += u64::from(report.resent);
                jobs.taken += u64::from(report.cached);
                jobs.solved += u64::from(!report.cached);
            }
            _ => {}
        }
        Ok(())
    }

    fn at(&mut self, step: u64, time: f64) {
        self.summary.steps = self.summary.steps.max(step);
        self.summary.sim_seconds = self.summary.sim_seconds.max(time);
    }

    fn geometry(&mut self, geometry: &Geometry) {
        let sound = Solid::try_from(geometry).is_ok_and(|solid| is_sound(&solid));
        self.sound.insert(geometry.hash.clone(), sound);
    }

    fn body(&mut self, body: &Body) {
        self.alive.insert(body.id);
        self.census.born(body);
        if body.parent.is_none() {
            self.summary.bodies_initial += 1;
            self.volumes.insert(body.object.clone(), body.volume);
            return;
        }
        self.summary.fragments += 1;
        if !self.sound.get(&body.geometry).copied().unwrap_or(false) {
            self.summary.open_fragments += 1;
        }
        if let Some(whole) = self.volumes.get(&body.object) {
            let ratio = body.volume / whole;
            self.smallest = Some(self.smallest.map_or(ratio, |least| least.min(ratio)));
        }
    }

    fn event(&mut self, event: &RunEvent) {
        self.at(event.step, event.time);
        self.directed.event(event);
        let jobs = &mut self.summary.jobs;
        match event.kind() {
            EventKind::JobOpened => jobs.opened += 1,
            EventKind::JobSettled => {
                jobs.settled += 1;
                match event.verdict() {
                    Verdict::Refused => jobs.refused += 1,
                    Verdict::Failed | Verdict::Abandoned => jobs.failed += 1,
                    Verdict::Broken | Verdict::Deformed | Verdict::Kept | Verdict::Unspecified => {}
                }
            }
            EventKind::Fractured => {
                self.summary.fractures += 1;
                self.summary.ledger.add(&event.ledger.unwrap_or_default());
                self.gone(event);
            }
            EventKind::Deformed => {
                self.summary.deformed += 1;
                self.summary.ledger.add(&event.ledger.unwrap_or_default());
            }
            EventKind::Removed => self.gone(event),
            EventKind::Impact
            | EventKind::Gate
            | EventKind::KeptWhole
            | EventKind::JointBroken
            | EventKind::JointGone
            | EventKind::Driven
            | EventKind::Expectation
            | EventKind::Finished
            | EventKind::Unspecified => {}
        }
    }

    fn gone(&mut self, event: &RunEvent) {
        let body = event.body.unwrap_or(u64::MAX);
        self.alive.remove(&body);
        self.census.gone(body);
    }

    /// What the windows of each sheet came to.
    pub(super) fn sheets(&self) -> &SheetCensus {
        &self.sheets
    }

    /// Jobs opened and not settled.
    #[must_use]
    pub fn jobs_open(&self) -> u64 {
        self.summary.jobs.opened.saturating_sub(self.summary.jobs.settled)
    }

    /// The summary so far. `meta` and `end` are the metadata records `run` and `end`.
    #[must_use]
    pub fn summary(
        &self,
        meta: &BTreeMap<String, String>,
        end: &BTreeMap<String, String>,
    ) -> Summary {
        let text = |key: &str| meta.get(key).cloned().unwrap_or_default();
        Summary {
            schema_version: SCHEMA_VERSION,
            version: text("version"),
            scene: text("scene"),
            seed: text("seed").parse().unwrap_or_default(),
            wall_seconds: end.get("wall_seconds").and_then(|s| s.parse().ok()).unwrap_or_default(),
            bodies_final: self.alive.len() as u64,
            smallest_volume_ratio: self.smallest.unwrap_or(1.0),
            digest: self.digest.hex(),
            sheets: self.sheets.totals(),
            directed: self.directed.totals(text("painted").parse().unwrap_or_default()),
            shares: self.census.shares(self.summary.fractures, self.summary.grain_mass),
            ..self.summary.clone()
        }
    }
}

pub(crate) fn decode<M: Recorded>(
    topic: &str,
    log_time: u64,
    payload: &[u8],
) -> Result<M, RecordError> {
    M::from_bytes(payload).map_err(|error| RecordError::Decode {
        topic: topic.to_owned(),
        log_time,
        reason: error.to_string(),
    })
}

/// Closed and right side out: every directed edge has as many opposites, the volume is positive.
fn is_sound(solid: &Solid) -> bool {
    let mut edges: BTreeMap<(u32, u32), i64> = BTreeMap::new();
    let mut volume = 0.0;
    for (t, &[a, b, c]) in solid.mesh.triangles.iter().enumerate() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (key, sign) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
            *edges.entry(key).or_default() += sign;
        }
        let [p, q, r] = solid.mesh.corners(t);
        volume += p.dot(&q.cross(&r)) / 6.0;
    }
    volume > 0.0 && edges.values().all(|&balance| balance == 0)
}
