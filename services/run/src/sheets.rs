//! Sheets and what else moves as it deforms: their windows are opened when the last ones end, the
//! world takes what they gave, and a window is solved again where the world put a body elsewhere.

use super::jobs::WantedJob;
use super::moving::{SheetWindowRun, body_id, touched};
use super::settle::pool_report;
use super::{RunError, SceneRun};
use cullet_geometry::Vec3;
use cullet_model::{Figure, Proxy, ProxyMotion, SurfaceFrame, Window, WindowOutcome};
use cullet_pool::{JobEnding, Settlement};
use cullet_proto::ids::digest;
use cullet_proto::window::MAX_PROXIES;
use cullet_proto::{JobId, Verdict};
use cullet_record::{SheetAbout, SolvedWindow};
use cullet_world::{BodyId, Exchange};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A gap above this share of the distance of points makes a window be solved again \[1\] (F90m).
const GAP: f64 = 0.5;
/// Most times that a window is solved.
const MOST_SOLVED: u32 = 3;
impl SceneRun<'_> {
    /// Tells the recorder of the sheets.
    pub(super) fn announce_sheets(&mut self) {
        for (number, sheet) in (0..).zip(&self.scene.moving) {
            let (name, material) = (sheet.name.clone(), sheet.material.name.clone());
            self.recorder.sheet(SheetAbout { number, name, material });
        }
    }

    /// Number in the scene of the object that a body is, or of which it is a fragment.
    fn object_number(&self, body: BodyId) -> Option<u32> {
        let origin = self.origins.get(&body)?;
        let number = self.scene.bodies.iter().position(|own| own.name == origin.object)?;
        u32::try_from(number).ok()
    }

    /// Opens the windows that begin with the next step and waits for them. False: asked to stop.
    pub(super) fn open_windows(&mut self) -> Result<bool, RunError> {
        let step = self.world.step_count();
        let gravity = Vec3::from(self.scene.world.gravity).norm();
        let mut opened = Vec::new();
        for index in 0..self.sheets.len() {
            let sheet = &self.sheets[index];
            if sheet.open.is_some() {
                continue;
            }
            let object = |body: BodyId| self.object_number(body);
            let mut proxies = sheet.proxies(&self.world, gravity, object);
            if proxies.len() > MAX_PROXIES {
                let (sheet, bodies) = (self.scene.moving[index].name.clone(), proxies.len());
                return Err(RunError::TooManyNear { sheet, bodies, most: MAX_PROXIES });
            }
            let left = self.scene.steps() - step;
            let steps = sheet.window.min(u32::try_from(left).unwrap_or(u32::MAX));
            for proxy in &mut proxies {
                if let Some(path) = self.driven.get(&body_id(proxy.body)) {
                    let time = |k: u32| (step + u64::from(k)) as f64 * self.setup_step();
                    let poses = (1..=steps).map(|k| path.at(time(k)));
                    proxy.motion = ProxyMotion::Led(poses.collect());
                }
            }
            let frame_every = sheet.frame_every;
            let retired = sheet.retire.then(|| sheet.retired.clone());
            let window = Window { first_step: step, steps, frame_every, proxies, retired };
            let job = sheet.job(sheet.state.clone(), window.clone());
            let id = self.pool.open(WantedJob::Window { job: &job, after: sheet.made_by });
            opened.push((index, id, window));
        }
        for (index, job, window) in opened {
            let Some(outcome) = self.window_settled(index, job)? else { return Ok(false) };
            let sheet = &mut self.sheets[index];
            let (state, seen, given) = (sheet.state.clone(), BTreeMap::new(), BTreeMap::new());
            let first = sheet.state.is_none();
            sheet.open =
                Some(SheetWindowRun { job, window, state, outcome, solved: 1, given, seen });
            if first {
                self.record_sheet_frames(index, 0, 0)?;
            }
        }
        Ok(true)
    }

    /// Waits for a window; what settles before it is kept. `None`: asked to stop.
    fn window_settled(
        &mut self,
        index: usize,
        job: JobId,
    ) -> Result<Option<WindowOutcome>, RunError> {
        while self.arrived.len() < self.pending.len() {
            match self.next_settlement()? {
                Some(settled) => self.arrived.push_back(settled),
                None => return Ok(None),
            }
        }
        let Some((id, settlement)) = self.next_settlement()? else { return Ok(None) };
        if id != job {
            return Err(RunError::OutOfOrder { got: id.short(), due: job.short() });
        }
        self.recorder.pool(&pool_report(job, &settlement))?;
        let sheet = self.scene.moving[index].name.clone();
        let reason = match settlement.ending {
            JobEnding::Verdict(Verdict::Moved(outcome)) => return Ok(Some(*outcome)),
            JobEnding::Verdict(Verdict::Refused { text, .. } | Verdict::Failed { text, .. }) => {
                text
            }
            JobEnding::Verdict(_) => "the result of another kind of job came for it".to_owned(),
            JobEnding::Abandoned(reason) => {
                return Err(RunError::Abandoned { job: id.short(), body: sheet, reason });
            }
            JobEnding::Cancelled => "it was cancelled".to_owned(),
        };
        let time = self.world.time();
        Err(RunError::Window { sheet, job: id.short(), time, reason })
    }

    /// Gives bodies what windows have for them in the next step.
    pub(super) fn push_bodies(&mut self) {
        let step = self.world.step_count();
        for sheet in self.sheets.iter_mut().filter(|sheet| sheet.two_way) {
            let Some(run) = &mut sheet.open else { continue };
            let at = (step - run.window.first_step) as usize;
            for handed in &run.outcome.handed {
                if let Some(&[linear, torque]) = handed.impulses.get(at)
                    && self.world.push(body_id(handed.body), &Exchange { linear, torque })
                {
                    *run.given.entry(handed.body).or_default() += linear;
                }
            }
        }
    }

    /// Puts bodies where windows have them after the step just taken, and looks where they are.
    pub(super) fn lead_bodies(&mut self) {
        let step = self.world.step_count();
        let mut met: BTreeMap<u64, u32> = BTreeMap::new();
        let runs = self.sheets.iter().filter(|sheet| sheet.two_way);
        for run in runs.filter_map(|sheet| sheet.open.as_ref()) {
            for handed in run.outcome.handed.iter().filter(|handed| touched(handed)) {
                *met.entry(handed.body).or_default() += 1;
            }
        }
        for sheet in &mut self.sheets {
            let Some(run) = &mut sheet.open else { continue };
            let at = (step - run.window.first_step - 1) as usize;
            for handed in &run.outcome.handed {
                let free = |proxy: &Proxy| {
                    proxy.body == handed.body && matches!(proxy.motion, ProxyMotion::Free { .. })
                };
                let alone =
                    met.get(&handed.body) == Some(&1) && run.window.proxies.iter().any(free);
                if let Some(pose) = handed.poses.get(at).filter(|_| alone && touched(handed)) {
                    self.world.lead(body_id(handed.body), pose);
                }
                if let Some(view) = self.world.body(body_id(handed.body)) {
                    run.seen.entry(handed.body).or_default().push(view.pose);
                }
            }
        }
    }

    /// Ends the windows whose last step was just taken: those in which the world put a body
    /// elsewhere are solved again. False: asked to stop.
    pub(super) fn close_windows(&mut self) -> Result<bool, RunError> {
        let step = self.world.step_count();
        for index in 0..self.sheets.len() {
            let ends =
                |run: &SheetWindowRun| run.window.first_step + u64::from(run.window.steps) == step;
            if !self.sheets[index].open.as_ref().is_some_and(ends) {
                continue;
            }
            let spacing = self.sheets[index].extent.spacing;
            let first = self.sheets[index].open.as_ref().map_or(0.0, SheetWindowRun::gap);
            let stray =
                |run: &Self| run.sheets[index].open.as_ref().map_or(0.0, SheetWindowRun::stray);
            while stray(self) > GAP * spacing {
                let again = self.solve_again(index)?;
                match again {
                    None => return Ok(false),
                    Some(false) => break,
                    Some(true) => {}
                }
            }
            self.record_window(index, first)?;
        }
        Ok(true)
    }

    /// Solves a window again with bodies led as the world had them. `Some(false)`: often enough;
    /// `None`: asked to stop.
    fn solve_again(&mut self, index: usize) -> Result<Option<bool>, RunError> {
        let sheet = &self.sheets[index];
        let Some(run) = sheet.open.as_ref().filter(|run| run.solved < MOST_SOLVED) else {
            return Ok(Some(false));
        };
        let mut window = run.window.clone();
        for proxy in &mut window.proxies {
            let fixed = self.world.body(body_id(proxy.body)).is_none_or(|view| view.fixed);
            if let Some(seen) = run.seen.get(&proxy.body)
                && seen.len() == window.steps as usize
                && !fixed
            {
                proxy.motion = ProxyMotion::Led(seen.clone());
            }
        }
        if window == run.window {
            return Ok(Some(false));
        }
        let job = sheet.job(run.state.clone(), window.clone());
        let id = self.pool.open(WantedJob::Window { job: &job, after: sheet.made_by });
        let Some(outcome) = self.window_settled(index, id)? else { return Ok(None) };
        if let Some(run) = &mut self.sheets[index].open {
            (run.job, run.window, run.outcome) = (id, window, outcome);
            run.solved += 1;
        }
        Ok(Some(true))
    }

    /// Records a window that counts, with its frames, and makes its end the sheet's state.
    fn record_window(&mut self, index: usize, gap: f64) -> Result<(), RunError> {
        let (step, time) = (self.world.step_count(), self.world.time());
        self.record_sheet_frames(index, 1, step)?;
        let sheet = &mut self.sheets[index];
        let Some(mut run) = sheet.open.take() else { return Ok(()) };
        let kept_back = run.kept_back(&self.world);
        run.outcome.figures.push(Figure {
            name: "impulse that bodies were not given".to_owned(),
            unit: "N·s".to_owned(),
            value: kept_back,
        });
        let state = Arc::new(run.outcome.state.clone());
        self.recorder.window(&SolvedWindow {
            sheet: sheet.number,
            first_step: run.window.first_step,
            steps: run.window.steps,
            time,
            job: run.job.0,
            state: digest(&state),
            gap,
            solved: run.solved,
            one_way: !sheet.two_way,
            outcome: &run.outcome,
        })?;
        (sheet.state, sheet.extent) = (Some(state), run.outcome.extent);
        sheet.made_by = Some(run.job);
        let retired = self.retire_pieces(index, &run.outcome.settled)?;
        self.sheets[index].retired = retired;
        let name = self.scene.moving[index].name.clone();
        for warning in &run.outcome.warnings {
            // The same with other figures is not said again; the recording has them all.
            let words = warning.split(|c: char| c.is_ascii_digit()).next().unwrap_or_default();
            if self.told_of_sheets.insert(format!("{name}: {words}")) {
                self.say(format!("{name}: {warning}"));
            }
        }
        Ok(())
    }

    /// Records the frames of a window's outcome from one step to another.
    fn record_sheet_frames(&mut self, index: usize, from: u64, to: u64) -> Result<(), RunError> {
        let sheet = &self.sheets[index];
        let Some(run) = &sheet.open else { return Ok(()) };
        let within = |frame: &&SurfaceFrame| (from..=to).contains(&frame.step);
        for frame in run.outcome.frames.iter().filter(within) {
            let time = frame.step as f64 * self.setup_step();
            let Some(surface) = run.outcome.surfaces.get(frame.surface as usize) else { continue };
            self.recorder.sheet_frame(sheet.number, time, surface, frame)?;
        }
        Ok(())
    }

    fn setup_step(&self) -> f64 {
        self.scene.world.step
    }

    /// What settles next, in opening order. `None`: asked to stop.
    pub(super) fn next_settlement(&mut self) -> Result<Option<(JobId, Settlement)>, RunError> {
        use std::sync::atomic::Ordering;
        loop {
            if self.options.stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            if let Some(settled) = self.pool.settled(super::PATIENCE) {
                return Ok(Some(settled));
            }
            self.recorder.flush_if_due()?;
            self.tell_position();
        }
    }
}
