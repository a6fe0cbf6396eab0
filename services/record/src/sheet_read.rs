//! Sheets as they are read back, held to what was recorded of them.

use super::{RecordError, Recording};
use cullet_geometry::Vec3;
use cullet_model::{MovingSurface, TornPiece, WindowLedger};
use cullet_proto::recording::{SheetError, SheetFrame, SheetWindow};
use std::collections::BTreeMap;

/// When a frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    /// Steps taken.
    pub step: u64,
    /// Simulated time \[s\].
    pub time: f64,
}

/// A sheet of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedSheet {
    /// Its number.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// Name of its material.
    pub material: String,
    /// When its frames are, in the order in which they were told.
    pub frames: Vec<FrameTime>,
}

/// A sheet at one step.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetMoment {
    /// When.
    pub at: FrameTime,
    /// Its surface then.
    pub surface: MovingSurface,
    /// Where its points are in the world \[m\].
    pub places: Vec<Vec3>,
    /// Of each point: the quantity that diffuses; empty where none does.
    pub quantity: Vec<f32>,
}

/// A window of a recording whose numbers are sound.
#[derive(Clone, Debug, PartialEq)]
pub struct SoundWindow<'a> {
    /// As it was recorded.
    pub window: &'a SheetWindow,
    /// What came and went in it.
    pub ledger: WindowLedger,
    /// The parts that the sheet has come to, by number.
    pub pieces: Vec<TornPiece>,
}

impl Recording {
    /// The sheets that have a frame or a window, by number.
    #[must_use]
    pub fn sheets(&self) -> Vec<RecordedSheet> {
        let mut sheets: BTreeMap<u32, RecordedSheet> = BTreeMap::new();
        let new = |number: u32| RecordedSheet {
            number,
            name: format!("sheet {number}"),
            material: String::new(),
            frames: Vec::new(),
        };
        for frame in &self.sheet_frames {
            let sheet = sheets.entry(frame.sheet).or_insert_with(|| new(frame.sheet));
            sheet.name.clone_from(&frame.name);
            sheet.material.clone_from(&frame.material);
            sheet.frames.push(FrameTime { step: frame.step, time: frame.time });
        }
        for window in &self.windows {
            sheets.entry(window.sheet).or_insert_with(|| new(window.sheet));
        }
        sheets.into_values().collect()
    }

    /// A sheet at its last frame up to a step; nothing where it has none until then.
    ///
    /// # Errors
    /// [`RecordError::Sheet`] for a frame or a surface that is damaged or missing.
    pub fn sheet_at(&self, sheet: u32, step: u64) -> Result<Option<SheetMoment>, RecordError> {
        let frames = self.sheet_frames.iter();
        let own = frames.filter(|frame| frame.sheet == sheet && frame.step <= step);
        own.max_by_key(|frame| frame.step).map(|frame| self.sheet_moment(frame)).transpose()
    }

    /// The surface of a frame.
    ///
    /// # Errors
    /// [`RecordError::Sheet`] for one that is damaged or missing.
    pub fn surface_of(&self, frame: &SheetFrame) -> Result<MovingSurface, RecordError> {
        let surface = self.surfaces.get(&frame.surface).ok_or(SheetError::NoSurface);
        surface.and_then(MovingSurface::try_from).map_err(|source| damaged(frame, source))
    }

    /// A frame with its surface, both checked.
    ///
    /// # Errors
    /// [`RecordError::Sheet`] for a frame or a surface that is damaged or missing.
    pub fn sheet_moment(&self, frame: &SheetFrame) -> Result<SheetMoment, RecordError> {
        let surface = self.surface_of(frame)?;
        let places = frame.places(surface.reference.len());
        let places = places.map_err(|source| damaged(frame, source))?;
        if !frame.time.is_finite() {
            return Err(damaged(frame, SheetError::NotFinite { column: "time", entry: 0 }));
        }
        let at = FrameTime { step: frame.step, time: frame.time };
        Ok(SheetMoment { at, surface, places, quantity: frame.quantity.clone() })
    }

    /// The windows of a sheet, in order of time.
    ///
    /// # Errors
    /// [`RecordError::Sheet`] for one that is damaged, or that begins before the one before it
    /// ends.
    pub fn windows_of(&self, sheet: u32) -> Result<Vec<SoundWindow<'_>>, RecordError> {
        let mut last = 0;
        let own = self.windows.iter().filter(|window| window.sheet == sheet);
        let sound = own.map(|window| {
            let step = window.first_step;
            let bad = |source| RecordError::Sheet { sheet, step, source };
            if step < last {
                return Err(bad(SheetError::Order { last }));
            }
            last = window.end_step();
            let ledger = window.checked_ledger().map_err(bad)?;
            let pieces = window.pieces.iter().map(TornPiece::from).collect();
            Ok(SoundWindow { window, ledger, pieces })
        });
        sound.collect()
    }
}

fn damaged(frame: &SheetFrame, source: SheetError) -> RecordError {
    RecordError::Sheet { sheet: frame.sheet, step: frame.step, source }
}
