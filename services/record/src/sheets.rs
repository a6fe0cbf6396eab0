//! Sheets, that is bodies that move as they deform, as the recorder is told of them.

use super::object::sheet_topic;
use super::sheet_book::{BookedSheet, SheetAbout, ball};
use super::sheet_display::DrawnSheet;
use super::{RecordError, Recorder, SHEET_SURFACE, SHEETS, WINDOWS};
use cullet_model::{MovingSurface, SurfaceFrame, WindowOutcome};
use cullet_proto::recording::{
    SheetError, SheetFrame, SheetSurface, SheetWindow, check_surface, surface_hash,
};
use std::sync::Arc;

/// A window of a sheet's time that was solved, and counts.
#[derive(Clone, Copy, Debug)]
pub struct SolvedWindow<'a> {
    /// The sheet.
    pub sheet: u32,
    /// Steps taken before it.
    pub first_step: u64,
    /// Steps in it.
    pub steps: u32,
    /// Simulated time at its end \[s\].
    pub time: f64,
    /// Digest of the problem.
    pub job: [u8; 32],
    /// Digest of the state at its end.
    pub state: [u8; 32],
    /// How far apart the world and the window have the rigid bodies in its reach at its end, at
    /// most \[m\].
    pub gap: f64,
    /// How often it was solved until that was little.
    pub solved: u32,
    /// Whether the rigid bodies were not given what the sheet did to them.
    pub one_way: bool,
    /// What came of it: ledger, pieces, figures and warnings. Its frames are recorded by
    /// [`Recorder::sheet_frame`].
    pub outcome: &'a WindowOutcome,
}

impl Recorder {
    /// Takes note of a sheet, before its first frame. A number that is known already gets another
    /// name and material from then on.
    pub fn sheet(&mut self, about: SheetAbout) {
        let booked = self.sheets.sheets.entry(about.number);
        booked.or_insert_with(BookedSheet::new).about = about;
    }

    /// Records where the points of a sheet are after a step, its surface first unless it is there
    /// already, and draws it for viewers; hands back the digest of the surface. Frames come by
    /// rising step, before the poses of that step.
    ///
    /// # Errors
    /// A sheet that is not known, a step that is not after that of its last frame, a surface or a
    /// frame that is not sound, or a file that cannot be written.
    pub fn sheet_frame(
        &mut self,
        sheet: u32,
        time: f64,
        surface: &MovingSurface,
        frame: &SurfaceFrame,
    ) -> Result<[u8; 32], RecordError> {
        let step = frame.step;
        let bad = |source| RecordError::Sheet { sheet, step, source };
        let Some(booked) = self.sheets.sheets.get_mut(&sheet) else {
            return Err(RecordError::UnknownSheet { sheet, what: "frame" });
        };
        if let Some(last) = booked.told[0].filter(|&last| last >= step) {
            return Err(bad(SheetError::Order { last }));
        }
        check_surface(surface).map_err(bad)?;
        let hash = surface_hash(surface);
        let SheetAbout { name, material, .. } = booked.about.clone();
        let surface_name = hash.to_vec();
        let own =
            SheetFrame { time, sheet, name, material, surface: surface_name, ..<_>::default() };
        let message = own.with(frame);
        let places = message.places(surface.reference.len()).map_err(bad)?;
        booked.told[0] = Some(step);
        booked.ball = booked.ball.or_else(|| ball(&places));
        self.at(step, time)?;
        if !self.sheets.surfaces.contains_key(&hash) {
            self.deciding(SHEET_SURFACE, &SheetSurface::from(surface))?;
            self.sheets.surfaces.insert(hash, Arc::new(surface.clone()));
        }
        self.deciding(SHEETS, &message)?;
        self.show(sheet, hash, frame)?;
        Ok(hash)
    }

    /// Records what came of a window, once the world has come to its end: log time is that. Windows
    /// of a sheet come in order of time.
    ///
    /// # Errors
    /// A sheet that is not known, a window that begins before its last one ends, a number that is
    /// none, or a file that cannot be written.
    pub fn window(&mut self, window: &SolvedWindow<'_>) -> Result<(), RecordError> {
        let (sheet, step) = (window.sheet, window.first_step);
        let bad = |source| RecordError::Sheet { sheet, step, source };
        let Some(booked) = self.sheets.sheets.get_mut(&sheet) else {
            return Err(RecordError::UnknownSheet { sheet, what: "window" });
        };
        if let Some(last) = booked.told[1].filter(|&last| last > step) {
            return Err(bad(SheetError::Order { last }));
        }
        let own = SheetWindow {
            sheet,
            first_step: step,
            steps: window.steps,
            time: window.time,
            job: window.job.to_vec(),
            state: window.state.to_vec(),
            gap: window.gap,
            solved: window.solved,
            one_way: window.one_way,
            ..SheetWindow::default()
        };
        let message = own.with(window.outcome);
        message.checked_ledger().map_err(bad)?;
        booked.told[1] = Some(message.end_step());
        self.at(message.end_step(), window.time)?;
        self.deciding(WINDOWS, &message)
    }

    /// Draws a frame if the drawings have room for it, or if it is the first of its surface.
    fn show(
        &mut self,
        sheet: u32,
        hash: [u8; 32],
        frame: &SurfaceFrame,
    ) -> Result<(), RecordError> {
        let surface = self.sheets.surfaces.get(&hash).cloned();
        let booked = self.sheets.sheets.get_mut(&sheet);
        let (Some(surface), Some(booked)) = (surface, booked) else { return Ok(()) };
        let values = frame.quantity.iter();
        booked.span = values.fold(booked.span, |(low, high), &v| (low.min(v), high.max(v)));
        if !self.drawing.objects {
            return Ok(());
        }
        let drawn = DrawnSheet { surface, frame: frame.clone(), span: booked.span };
        booked.waiting = Some(drawn);
        if self.drawing.left > 0.0 || booked.drawn != Some(hash) {
            booked.drawn = Some(hash);
            self.draw_waiting(sheet)?;
        }
        Ok(())
    }

    fn draw_waiting(&mut self, sheet: u32) -> Result<(), RecordError> {
        let stamp = self.stamp();
        let Some(booked) = self.sheets.sheets.get_mut(&sheet) else { return Ok(()) };
        let Some(drawn) = booked.waiting.take() else { return Ok(()) };
        let SheetAbout { name, material, .. } = &booked.about;
        let update = drawn.update((name, material), stamp.log);
        let bytes = self.sink.known(&sheet_topic(name), stamp, &update)?;
        self.drawing.left -= bytes as f64;
        Ok(())
    }

    /// Draws the last frames of those sheets whose drawings had no room for them.
    pub(super) fn draw_waiting_sheets(&mut self) -> Result<(), RecordError> {
        let all: Vec<u32> = self.sheets.sheets.keys().copied().collect();
        all.into_iter().try_for_each(|sheet| self.draw_waiting(sheet))
    }
}
