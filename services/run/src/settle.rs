//! What a verdict does to the world and to the recording.

use super::ladder::Next;
use super::{News, Origin, Outcome, Pending, Run, RunError, convert, number};
use cullet_geometry::{Sheet, Vec3};
use cullet_pool::{Ending, Settlement};
use cullet_proto::recording::{self, JobReport, PoolReport, Vector3};
use cullet_proto::{BrokenBody, Report, Verdict};
use cullet_record::{Event, Level};
use cullet_world::{BodyId, Breakage, Grain, Hit, Piece, Reaction, Replacement};

impl Run<'_> {
    /// Records a job's verdict and, if the body broke, puts its fragments into the world.
    pub(super) fn settle(&mut self, mut job: Pending, settled: Settlement) -> Result<(), RunError> {
        let name = self.world.body(job.body).map_or_else(String::new, |view| view.name.to_owned());
        self.recorder.pool(&PoolReport {
            job: job.id.0.to_vec(),
            worker: settled.worker,
            wall_seconds: settled.wall.as_secs_f64(),
            resent: settled.attempts.saturating_sub(1),
            cached: settled.cached,
        })?;
        let verdict = match settled.ending {
            Ending::Verdict(verdict) => verdict,
            Ending::Abandoned(reason) => return self.abandoned(&job, name, reason),
            Ending::Cancelled => {
                return self.abandoned(&job, name, "it was cancelled".to_owned());
            }
        };
        let outcome = match &verdict {
            Verdict::Broken(broken) => Some(&**broken),
            Verdict::Refused { .. } | Verdict::Failed { .. } | Verdict::Measured(_) => None,
        };
        let enough = match job.ladder.next(outcome, &mut self.seen) {
            Next::Finer(why) => return self.solve_finer(job, verdict, why),
            Next::Use(why) => why.map(|why| format!("no finer solve: {why}")),
        };
        if let Verdict::Broken(mut broken) = verdict {
            broken.report.warnings.extend(enough);
            return self.broken(job, *broken);
        }
        let held = job.held.take();
        let instead = if held.is_some() { "; the solve before it is used" } else { "" };
        self.declined(&job, verdict, instead)?;
        match held {
            Some((id, broken)) => self.put(Pending { id, ..job }, broken),
            None => Ok(()),
        }
    }

    /// Records a verdict without fragments; `more` is said after why.
    fn declined(&mut self, job: &Pending, verdict: Verdict, more: &str) -> Result<(), RunError> {
        let (verdict, solver, text) = match verdict {
            Verdict::Refused { solver, text } => (recording::Verdict::Refused, solver, text),
            Verdict::Failed { solver, text } => (recording::Verdict::Failed, solver, text),
            Verdict::Broken(_) | Verdict::Measured(_) => {
                let name = self.world.body(job.body).map_or("", |view| view.name).to_owned();
                return self.abandoned(job, name, "a specimen's result came for it".to_owned());
            }
        };
        let told = format!("{solver}: {text}{more}");
        let verdict_number = verdict as i32;
        let report = JobReport { refusal: text, verdict: verdict_number, ..about(job, &solver) };
        self.recorder.report(&report)?;
        self.settled(job, verdict, told)
    }

    /// Records a solve whose fragments are not used unless the finer one that follows comes to
    /// nothing, and opens that.
    fn solve_finer(
        &mut self,
        mut job: Pending,
        verdict: Verdict,
        why: String,
    ) -> Result<(), RunError> {
        if let Verdict::Broken(broken) = verdict {
            let verdict = recording::Verdict::Kept;
            self.recorder.report(&JobReport {
                verdict: verdict as i32,
                fragments: broken.fragments.len() as u32,
                ..reported(&job, &broken.report)
            })?;
            let found = broken.fragments.len();
            let told = format!("{found} fragments, a trial; {}", told(&broken.report));
            self.settled(&job, verdict, told)?;
            job.held = Some((job.id, *broken));
        } else {
            self.declined(&job, verdict, "")?;
        }
        self.dispatch(job, None, vec![format!("finer than before: {why}")])
    }

    fn abandoned(&mut self, job: &Pending, body: String, reason: String) -> Result<(), RunError> {
        self.settled(job, recording::Verdict::Abandoned, reason.clone())?;
        Err(RunError::Abandoned { job: job.id.short(), body, reason })
    }

    fn settled(
        &mut self,
        job: &Pending,
        verdict: recording::Verdict,
        reason: String,
    ) -> Result<(), RunError> {
        self.event(&Event::JobSettled { body: number(job.body), job: job.id.0, verdict, reason })
    }

    fn broken(&mut self, job: Pending, broken: BrokenBody) -> Result<(), RunError> {
        let verdict =
            if broken.is_intact() { recording::Verdict::Kept } else { recording::Verdict::Broken };
        self.recorder.report(&JobReport {
            verdict: verdict as i32,
            fragments: broken.fragments.len() as u32,
            ..reported(&job, &broken.report)
        })?;
        self.settled(&job, verdict, told(&broken.report))?;
        self.put(job, broken)
    }

    /// Puts what a solve came to into the world.
    fn put(&mut self, job: Pending, mut broken: BrokenBody) -> Result<(), RunError> {
        let intact = broken.is_intact();
        let sheets: Vec<Sheet> =
            broken.fragments.iter_mut().map(|f| std::mem::take(&mut f.sheet)).collect();
        if intact {
            if let Some(sheet) = sheets.first() {
                self.record_cracks(job.body, sheet)?;
            }
            let reason = "no crack separated it".to_owned();
            return self.kept(&job, reason);
        }
        let early = job.due.saturating_sub(self.world.step_count());
        if early > 0 {
            let steps = if early == 1 { "step" } else { "steps" };
            let reason = format!("the run ended {early} {steps} before its fragments were due");
            return self.kept(&job, reason);
        }
        let middle =
            |fragment: &cullet_proto::Fragment| fragment.solid.mesh.mass_properties().centroid;
        let centres: Vec<Vec3> = broken.fragments.iter().map(middle).collect();
        let moved = sheets.iter().zip(&centres).map(|(sheet, centre)| sheet.translated(-centre));
        let parts: Vec<(Vec3, Sheet)> = centres.iter().copied().zip(moved).collect();
        let sampled = broken.sampled();
        let told = broken.reactions.len() == job.supports.len();
        let held = job.supports.iter().cloned().zip(broken.reactions);
        let breakage = Breakage {
            pieces: broken.fragments.into_iter().map(|f| piece(f, job.body)).collect(),
            grains: broken.debris.iter().map(grain).collect(),
            reactions: held
                .filter(|_| told)
                .map(|(support, impulse)| Reaction { support, impulse })
                .collect(),
            fracture_energy: broken.report.fracture_energy,
        };
        match self.world.break_up(job.body, &job.hits, breakage) {
            Ok(done) => {
                let drawn = sampled.map(|sampled| drawn(&done, &sampled));
                self.replaced(&job, &done, &parts, broken.report.spacing)?;
                self.told_of(&job, &done, drawn)
            }
            Err(error) => self.kept(&job, error.to_string()),
        }
    }

    fn kept(&mut self, job: &Pending, reason: String) -> Result<(), RunError> {
        let energy = job.hits.iter().map(|hit| hit.impact.energy).sum();
        self.notices.kept(job.body, energy, reason.clone());
        self.event(&Event::KeptWhole { body: number(job.body), job: job.id.0, reason })
    }

    /// `parts`: centres of the fragments, in the body's frame \[m\], and the cracks that end inside
    /// them, in their own. `spacing`: of the solve that made
    /// the fragments; they are solved no finer than that \[m\].
    fn replaced(
        &mut self,
        job: &Pending,
        done: &Replacement,
        parts: &[(Vec3, Sheet)],
        spacing: f64,
    ) -> Result<(), RunError> {
        let mut origin = self.origins.remove(&job.body).ok_or(RunError::Lost(job.body))?;
        origin.choice.no_finer_than(spacing);
        for (&id, (centre, sheet)) in done.fragments.iter().zip(parts) {
            let choice = origin.choice.of_fragment(centre);
            self.origins.insert(id, Origin { choice, ..origin.clone() });
            self.record_birth(id)?;
            self.record_cracks(id, sheet)?;
        }
        self.fractures += 1;
        *self.broken.entry(origin.object.clone()).or_default() += done.fragments.len() as u64;
        self.event(&Event::Fractured {
            parent: number(job.body),
            job: job.id.0,
            fragments: done.fragments.iter().copied().map(number).collect(),
            alpha: done.momentum_scale,
            grains: done.grains.len() as u64,
            grain_mass: done.grain_mass,
            ledger: convert::ledger(done),
        })?;
        let (grains, fragments) = (done.grains.len(), done.fragments.len());
        let (name, all) = (job.id.short(), done.fragments.iter().copied().map(number));
        let (first, last) = (all.clone().min(), all.max());
        let (body, object) = (number(job.body), &origin.object);
        tracing::info!(job = name, body, object, fragments, first, last, grains, "body broken");
        Ok(())
    }

    /// Says what a body has broken into, and records which of that was sampled, if it is known.
    fn told_of(
        &mut self,
        job: &Pending,
        done: &Replacement,
        sampled: Option<Vec<u64>>,
    ) -> Result<(), RunError> {
        let (all, grains) = (done.fragments.len(), done.grains.len());
        let first = done.fragments.first().and_then(|id| self.origins.get(id));
        let object = first.map_or_else(String::new, |origin| origin.object.clone());
        let debris = if grains > 0 { format!(" and {grains} grains") } else { String::new() };
        let shares = sampled.as_ref().map(|sampled| {
            let drawn = sampled.len();
            format!(": {} solved, {drawn} sampled", all - drawn)
        });
        self.say(format!("{object} breaks into {all}{debris}{}", shares.unwrap_or_default()));
        if let Some(fragments) = sampled {
            let (step, time) = (self.world.step_count(), self.world.time());
            let body = number(job.body);
            self.recorder.sampled(&recording::Sampled { step, time, body, fragments })?;
        }
        Ok(())
    }

    fn record_cracks(&mut self, id: BodyId, sheet: &Sheet) -> Result<(), RunError> {
        let view = self.world.body(id).ok_or(RunError::Lost(id))?;
        let now = (self.world.step_count(), self.world.time());
        Ok(self.recorder.cracks(now, number(id), view.solid, sheet)?)
    }

    pub(super) fn record_birth(&mut self, id: BodyId) -> Result<(), RunError> {
        let (Some(view), Some(origin)) = (self.world.body(id), self.origins.get(&id)) else {
            return Err(RunError::Lost(id));
        };
        let geometry = self.recorder.geometry(view.solid)?;
        let body = recording::Body {
            id: number(id),
            name: view.name.to_owned(),
            object: origin.object.clone(),
            parent: view.parent.map(number),
            generation: view.generation,
            tier: tier(view.tier) as i32,
            material: origin.material.clone(),
            geometry: geometry.to_vec(),
            mass: view.mass,
            volume: view.volume,
            fixed: view.fixed,
            birth_step: self.world.step_count(),
        };
        Ok(self.recorder.body(&body)?)
    }

    pub(super) fn finish(mut self, interrupted: bool) -> Result<Outcome, RunError> {
        let (step, time) = (self.world.step_count(), self.world.time());
        for line in self.world.sunk() {
            self.recorder.log(Level::Warning, line.clone())?;
            self.say(line);
        }
        if !interrupted {
            self.tell_unbroken();
        }
        let mut unmet = Vec::new();
        if !interrupted {
            let seen = convert::observed(&self.recorder.summary(), &self.broken);
            unmet = self.scene.expect.check(&seen);
            for text in &unmet {
                self.event(&Event::Expectation { text: text.clone(), held: false })?;
            }
            if unmet.is_empty() {
                let text = "everything the scene expects".to_owned();
                self.event(&Event::Expectation { text, held: true })?;
            }
        }
        let finished = self.recorder.finish(step, time)?;
        if let Some(shares) = finished.summary.shares.as_ref().filter(|_| self.fractures > 0) {
            (self.news)(&News::Line(shares.to_string()));
        }
        let path = self.options.out.join("summary.json");
        cullet_files::output::write_file(&path, finished.summary.to_json().as_bytes())
            .map_err(|source| RunError::File { path, source })?;
        Ok(Outcome { summary: finished.summary, unmet, interrupted, recording: finished.path })
    }
}

fn tier(tier: cullet_world::Tier) -> recording::Tier {
    match tier {
        cullet_world::Tier::Tiny => recording::Tier::Tiny,
        cullet_world::Tier::Small => recording::Tier::Small,
        cullet_world::Tier::Large => recording::Tier::Large,
        cullet_world::Tier::Whole => recording::Tier::Whole,
    }
}

/// The fragments that were sampled, by number.
fn drawn(done: &Replacement, sampled: &[bool]) -> Vec<u64> {
    let marked = done.fragments.iter().zip(sampled).filter(|(_, sampled)| **sampled);
    marked.map(|(&id, _)| number(id)).collect()
}

fn grain(grain: &cullet_proto::Grain) -> Grain {
    let cullet_proto::Grain { position, velocity, volume, size } = *grain;
    Grain { position, velocity, volume, size }
}

fn piece(fragment: cullet_proto::Fragment, body: BodyId) -> Piece {
    // Crack faces without a parent are those of this fracture.
    let mut solid = fragment.solid;
    solid.name_parent(body.0);
    Piece { solid, hulls: fragment.hulls, velocity: fragment.velocity, spin: fragment.spin }
}

/// What a report says in one line: which family, why not the one asked, what was noticed.
fn told(report: &Report) -> String {
    let mut parts = vec![report.solver.clone()];
    parts.extend(report.refusal.iter().map(|why| format!("in place of the one asked: {why}")));
    parts.extend(report.warnings.iter().cloned());
    parts.join("; ")
}

fn about(job: &Pending, solver: &str) -> JobReport {
    JobReport {
        job: job.id.0.to_vec(),
        body: number(job.body),
        hits: job.hits.iter().map(hit).collect(),
        asked: job.asked.clone(),
        solver: solver.to_owned(),
        ..Default::default()
    }
}

fn reported(job: &Pending, report: &Report) -> JobReport {
    JobReport {
        refusal: report.refusal.clone().unwrap_or_default(),
        spacing: report.spacing,
        particles: report.particles,
        steps: report.steps,
        simulated: report.simulated,
        crack_area: report.crack_area,
        fracture_energy: report.fracture_energy,
        dissipated_energy: report.dissipated_energy,
        strength_ratio: report.strength_ratio,
        damaged_fraction: report.damaged_fraction,
        delivered_impulse: report.delivered_impulse,
        warnings: report.warnings.clone(),
        ..about(job, &report.solver)
    }
}

fn hit(hit: &Hit) -> recording::Hit {
    let vector = |v: Vec3| Some(Vector3 { x: v.x, y: v.y, z: v.z });
    let i = &hit.impact;
    recording::Hit {
        point: vector(i.point),
        normal: vector(i.normal),
        impulse: i.impulse,
        duration: i.duration,
        radius: i.radius,
        energy: i.energy,
        closing_speed: i.closing_speed,
    }
}
