//! What a verdict does to the world and to the recording.

use super::{News, Outcome, Pending, RunError, SceneRun, convert, number};
use cullet_geometry::{Sheet, Vec3};
use cullet_model::outcome::{DAMAGED_FRACTION, DELIVERED_IMPULSE, STRENGTH_RATIO};
use cullet_model::{
    BodyShape, Deformation, Figure, Fragment, FragmentOrigin, Fragmentation, Report,
    SolveOutcome as Solved, SolvedShares,
};
use cullet_plan::{Next, family};
use cullet_pool::{JobEnding, Settlement};
use cullet_proto::recording::{self, JobReport, PoolReport, Vector3};
use cullet_proto::{JobId, Verdict};
use cullet_record::{Event, Level};
use cullet_world::{BodyId, Breakage, HeldContact, Hit, Reaction, Replacement, Reshape};
use std::sync::Arc;

impl SceneRun<'_> {
    /// Records a job's verdict and, if the body broke, puts its fragments into the world.
    pub(super) fn settle(&mut self, mut job: Pending, settled: Settlement) -> Result<(), RunError> {
        let name = self.world.body(job.body).map_or_else(String::new, |view| view.name.to_owned());
        self.recorder.pool(&pool_report(job.id, &settled))?;
        let verdict = match settled.ending {
            JobEnding::Verdict(verdict) => verdict,
            JobEnding::Abandoned(reason) => return self.abandoned(&job, name, reason),
            JobEnding::Cancelled => {
                return self.abandoned(&job, name, "it was cancelled".to_owned());
            }
        };
        let outcome = match &verdict {
            Verdict::Solved(Solved::Broken(fracture) | Solved::Unchanged(fracture)) => {
                Some(&**fracture)
            }
            // A family that deforms bodies has no spacings to compare.
            Verdict::Solved(Solved::Deformed(_)) => None,
            Verdict::Refused { .. }
            | Verdict::Failed { .. }
            | Verdict::Measured(_)
            | Verdict::Moved(_) => None,
        };
        let enough = match job.order.refinement.next(outcome, &mut self.seen) {
            Next::Finer(why) => return self.solve_finer(job, verdict, why),
            Next::Use(why) => why.map(|why| format!("no finer solve: {why}")),
        };
        if let Verdict::Solved(mut solved) = verdict {
            self.note_directed(job.directed.as_deref());
            solved.report_mut().warnings.extend(enough);
            return self.solved(job, solved);
        }
        let held = job.held.take();
        let instead = if held.is_some() { "; the solve before it is used" } else { "" };
        let told = self.declined(&job, verdict, instead)?;
        if let Some((id, solved)) = held {
            self.note_directed(job.directed.as_deref());
            return self.put(Pending { id, ..job }, solved);
        }
        self.notices.kept(job.body, job.energy(), told);
        Ok(())
    }

    /// Records a verdict without fragments; `more` is said after why. Returns what is said.
    fn declined(
        &mut self,
        job: &Pending,
        verdict: Verdict,
        more: &str,
    ) -> Result<String, RunError> {
        let (verdict, solver, text) = match verdict {
            Verdict::Refused { solver, text } => (recording::Verdict::Refused, solver, text),
            Verdict::Failed { solver, text } => (recording::Verdict::Failed, solver, text),
            Verdict::Solved(_) | Verdict::Measured(_) | Verdict::Moved(_) => {
                let name = self.world.body(job.body).map_or("", |view| view.name).to_owned();
                let why = "the result of another kind of job came for it".to_owned();
                return self.abandoned(job, name, why).map(|()| String::new());
            }
        };
        let told = format!("{solver}: {text}{more}");
        let verdict_number = verdict as i32;
        let report = JobReport { refusal: text, verdict: verdict_number, ..about(job, &solver) };
        self.recorder.report(&report)?;
        self.settled(job, verdict, told.clone())?;
        Ok(told)
    }

    /// Records a solve whose fragments are not used unless the finer one that follows comes to
    /// nothing, and opens that.
    fn solve_finer(
        &mut self,
        mut job: Pending,
        verdict: Verdict,
        why: String,
    ) -> Result<(), RunError> {
        if let Verdict::Solved(solved) = verdict {
            let verdict = recording::Verdict::Kept;
            self.recorder
                .report(&JobReport { verdict: verdict as i32, ..reported(&job, &solved) })?;
            let found = solved.bodies();
            let told = format!("{found} fragments, a trial; {}", told(solved.report()));
            self.settled(&job, verdict, told)?;
            job.held = Some((job.id, solved));
        } else {
            self.declined(&job, verdict, "")?;
        }
        let mut reasons: Vec<String> = job.order.choice().into_iter().map(str::to_owned).collect();
        reasons.push(format!("finer than before: {why}"));
        self.dispatch(job, reasons)
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

    fn solved(&mut self, job: Pending, solved: Solved) -> Result<(), RunError> {
        let verdict = match &solved {
            Solved::Broken(_) => recording::Verdict::Broken,
            Solved::Deformed(_) => recording::Verdict::Deformed,
            Solved::Unchanged(_) => recording::Verdict::Kept,
        };
        let report = JobReport { verdict: verdict as i32, ..reported(&job, &solved) };
        self.recorder.report(&report)?;
        self.settled(&job, verdict, told(solved.report()))?;
        self.put(job, solved)
    }

    /// Puts what a solve came to into the world.
    fn put(&mut self, job: Pending, solved: Solved) -> Result<(), RunError> {
        if let Solved::Unchanged(whole) = &solved {
            if let Some(fragment) = whole.fragments.first() {
                self.record_cracks(job.body, &fragment.sheet)?;
            }
            let yields = self.origins.get(&job.body).is_some_and(|o| o.choice.yields());
            let reason = if yields { "no dent was left in it" } else { "no crack separated it" };
            return self.kept(&job, reason.to_owned());
        }
        let early = job.due.saturating_sub(self.world.step_count());
        if early > 0 {
            let steps = if early == 1 { "step" } else { "steps" };
            let reason = format!("the run ended {early} {steps} before its fragments were due");
            return self.kept(&job, reason);
        }
        match solved {
            Solved::Broken(fracture) => self.break_up(job, *fracture),
            Solved::Deformed(deformation) => self.deform(job, *deformation),
            Solved::Unchanged(_) => Ok(()),
        }
    }

    fn break_up(&mut self, job: Pending, mut broken: Fragmentation) -> Result<(), RunError> {
        let sheets: Vec<Sheet> =
            broken.fragments.iter_mut().map(|f| std::mem::take(&mut f.sheet)).collect();
        let middle = |fragment: &Fragment| fragment.solid.mesh.mass_properties().centroid;
        let centres: Vec<Vec3> = broken.fragments.iter().map(middle).collect();
        let moved = sheets.iter().zip(&centres).map(|(sheet, centre)| sheet.translated(-centre));
        let parts: Vec<(Vec3, Sheet)> = centres.iter().copied().zip(moved).collect();
        let shares = broken.shares();
        let Fragmentation { mut fragments, origins, debris, reactions, report } = broken;
        // Crack faces without a parent are those of this fracture.
        fragments.iter_mut().for_each(|f| f.solid.name_parent(job.body.0));
        let breakage = Breakage {
            pieces: fragments,
            grains: debris,
            reactions: reacted(&job.order.supports, &reactions),
            fracture_energy: report.fracture_energy,
            meets_again: report.solver == family::SHELL,
        };
        match self.world.break_up(job.body, &job.hits, breakage) {
            Ok(done) => {
                let made = shares.map(|shares| (done.fragments.clone(), origins, shares));
                self.replaced(&job, &done, &parts, report.spacing)?;
                self.told_of(&job, &done, made)
            }
            Err(error) => self.kept(&job, error.to_string()),
        }
    }

    /// Gives the body the shape that a solve found.
    fn deform(&mut self, job: Pending, deformation: Deformation) -> Result<(), RunError> {
        let Deformation { body, hulls, velocity, spin, work, reactions, report } = deformation;
        let BodyShape::Solid(solid) = body else {
            let reason = format!("the world takes no {}", body.kind());
            return self.kept(&job, reason);
        };
        let solid = Arc::unwrap_or_clone(solid);
        let centre = solid.mesh.mass_properties().centroid;
        let reactions = reacted(&job.order.supports, &reactions);
        let new = Reshape { solid, hulls, velocity, spin, reactions, work };
        let done = match self.world.reshape(job.body, &job.hits, new) {
            Ok(done) => done,
            Err(error) => return self.kept(&job, error.to_string()),
        };
        if let Some(origin) = self.origins.get_mut(&job.body) {
            let direction = origin.choice.direction.take();
            *origin = origin.of_part(&centre);
            job.directed.iter().for_each(|hit| origin.choice.with_flaws_of(&hit.choice));
            // It has not come apart yet.
            let moved = direction.map(|direction| Arc::new(direction.moved(&-centre)));
            origin.choice.direction = moved;
            origin.choice.no_finer_than(report.spacing);
        }
        self.record_shape(job.body)?;
        let ledger = convert::ledger(&done);
        self.event(&Event::Deformed { body: number(job.body), job: job.id.0, ledger })?;
        let object = self.origins.get(&job.body).map_or("", |origin| &origin.object);
        self.notices.deformed();
        self.say(format!("{object} is deformed, which takes {work:.3e} J"));
        Ok(())
    }

    fn kept(&mut self, job: &Pending, reason: String) -> Result<(), RunError> {
        self.notices.kept(job.body, job.energy(), reason.clone());
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
        job.directed.iter().for_each(|hit| origin.choice.with_flaws_of(&hit.choice));
        origin.choice.no_finer_than(spacing);
        for (&id, (centre, sheet)) in done.fragments.iter().zip(parts) {
            self.origins.insert(id, origin.of_part(centre));
            self.record_birth(id)?;
            self.record_cracks(id, sheet)?;
        }
        self.fractures += 1;
        self.joints_changed = true;
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

    /// Says what a body has broken into, and records which of that was sampled and which directed,
    /// if it is known.
    fn told_of(
        &mut self,
        job: &Pending,
        done: &Replacement,
        made: Option<(Vec<BodyId>, Vec<FragmentOrigin>, SolvedShares)>,
    ) -> Result<(), RunError> {
        let (all, grains) = (done.fragments.len(), done.grains.len());
        let first = done.fragments.first().and_then(|id| self.origins.get(id));
        let object = first.map_or_else(String::new, |origin| origin.object.clone());
        let debris = if grains > 0 { format!(" and {grains} grains") } else { String::new() };
        let of = |origin: FragmentOrigin| -> Vec<u64> {
            let (ids, origins) = made.as_ref().map_or((&[][..], &[][..]), |it| (&it.0, &it.1));
            let own = ids.iter().zip(origins).filter(|(_, own)| **own == origin);
            own.map(|(&id, _)| number(id)).collect()
        };
        let (fragments, directed) = (of(FragmentOrigin::Sampled), of(FragmentOrigin::Directed));
        let shares = made.as_ref().map(|_| {
            let (drawn, asked) = (fragments.len(), directed.len());
            let asked_for = if asked > 0 { format!(", {asked} directed") } else { String::new() };
            format!(": {} solved, {drawn} sampled{asked_for}", all - drawn - asked)
        });
        self.say(format!("{object} breaks into {all}{debris}{}", shares.unwrap_or_default()));
        if let Some((.., shares)) = made {
            let SolvedShares { solved, sampled, directed: asked } = shares;
            self.recorder.sampled(&recording::Sampled {
                step: self.world.step_count(),
                time: self.world.time(),
                body: number(job.body),
                fragments,
                job: job.id.0.to_vec(),
                solved_volume: solved.volume,
                sampled_volume: sampled.volume,
                solved_crack_area: solved.crack_area,
                sampled_crack_area: sampled.crack_area,
                directed,
                directed_volume: asked.volume,
                directed_crack_area: asked.crack_area,
            })?;
        }
        Ok(())
    }

    fn record_cracks(&mut self, id: BodyId, sheet: &Sheet) -> Result<(), RunError> {
        let view = self.world.body(id).ok_or(RunError::Lost(id))?;
        let now = (self.world.step_count(), self.world.time());
        Ok(self.recorder.cracks(now, number(id), view.solid, sheet)?)
    }

    fn record_shape(&mut self, id: BodyId) -> Result<(), RunError> {
        let view = self.world.body(id).ok_or(RunError::Lost(id))?;
        let geometry = self.recorder.geometry(view.solid)?;
        let shape = recording::NewShape {
            step: self.world.step_count(),
            time: self.world.time(),
            body: number(id),
            geometry: geometry.to_vec(),
            mass: view.mass,
            volume: view.volume,
        };
        Ok(self.recorder.shape(&shape)?)
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
        self.record_driven()?;
        let breakable = self.scene.bodies.iter().any(|body| body.breakable);
        if !interrupted && self.fractures == 0 && breakable {
            let line = self.notices.unbroken(&self.world);
            self.say(line);
        }
        let mut unmet = Vec::new();
        if !interrupted {
            self.tell_undirected()?;
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
        if let Some(directed) = &finished.summary.directed {
            (self.news)(&News::Line(directed.to_string()));
        }
        if let Some(shares) = finished.summary.shares.as_ref().filter(|_| self.fractures > 0) {
            (self.news)(&News::Line(shares.to_string()));
        }
        let path = self.options.out.join("summary.json");
        cullet_files::output::write_file(&path, finished.summary.to_json().as_bytes())
            .map_err(|source| RunError::File { path, source })?;
        Ok(Outcome { summary: finished.summary, unmet, interrupted, recording: finished.path })
    }
}

/// Who answered a job, for the recording.
pub(super) fn pool_report(job: JobId, settled: &Settlement) -> PoolReport {
    PoolReport {
        job: job.0.to_vec(),
        worker: settled.worker.clone(),
        wall_seconds: settled.wall.as_secs_f64(),
        resent: settled.attempts.saturating_sub(1),
        cached: settled.cached,
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

/// The supports of a job with what the solver says that they gave; nothing where it knows none.
fn reacted(supports: &[HeldContact], impulses: &[f64]) -> Vec<Reaction> {
    let known = supports.len() == impulses.len();
    let held = supports.iter().cloned().zip(impulses).filter(|_| known);
    held.map(|(support, &impulse)| Reaction { support, impulse }).collect()
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

fn reported(job: &Pending, solved: &Solved) -> JobReport {
    let report = solved.report();
    // What the brittle family has reported from the first version on has fields of its own.
    let own = [STRENGTH_RATIO, DAMAGED_FRACTION, DELIVERED_IMPULSE];
    let old = own.map(|name| report.detail(name).unwrap_or_default());
    let rest = report.details.iter().filter(|figure| !own.contains(&figure.name.as_str()));
    JobReport {
        fragments: solved.bodies() as u32,
        refusal: report.refusal.clone().unwrap_or_default(),
        spacing: report.spacing,
        particles: report.particles,
        steps: report.steps,
        simulated: report.simulated,
        crack_area: report.crack_area,
        fracture_energy: report.fracture_energy,
        dissipated_energy: report.dissipated_energy,
        strength_ratio: old[0],
        damaged_fraction: old[1],
        delivered_impulse: old[2],
        warnings: report.warnings.clone(),
        details: rest.map(detail).collect(),
        ..about(job, &report.solver)
    }
}

fn detail(figure: &Figure) -> recording::ReportFigure {
    let Figure { name, unit, value } = figure.clone();
    recording::ReportFigure { name, unit, value }
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
