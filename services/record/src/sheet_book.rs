//! What the recorder keeps in mind of sheets.

use super::object::sheet_topic;
use super::sheet_display::DrawnSheet;
use cullet_geometry::Vec3;
use cullet_model::MovingSurface;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A sheet, before anything is told of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SheetAbout {
    /// Its number, never reused in a run.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// Name of its material.
    pub material: String,
}

/// What the recorder knows of sheets.
#[derive(Default)]
pub(super) struct SheetBook {
    pub(super) sheets: BTreeMap<u32, BookedSheet>,
    pub(super) surfaces: BTreeMap<[u8; 32], Arc<MovingSurface>>,
}

/// What it knows of one.
pub(super) struct BookedSheet {
    pub(super) about: SheetAbout,
    /// Step of its last frame, and the last step of its last window.
    pub(super) told: [Option<u64>; 2],
    /// Least and greatest value of the quantity so far.
    pub(super) span: (f32, f32),
    /// The surface that was drawn last.
    pub(super) drawn: Option<[u8; 32]>,
    /// A frame for which the drawings had no room.
    pub(super) waiting: Option<DrawnSheet>,
    /// A ball around its first frame: centre and radius \[m\].
    pub(super) ball: Option<(Vec3, f64)>,
}

impl BookedSheet {
    pub(super) fn new() -> Self {
        let about = SheetAbout { number: 0, name: String::new(), material: String::new() };
        let span = (f32::INFINITY, f32::NEG_INFINITY);
        Self { about, told: [None; 2], span, drawn: None, waiting: None, ball: None }
    }
}

impl SheetBook {
    /// The viewers' topics.
    pub(super) fn topics(&self) -> impl Iterator<Item = String> {
        self.sheets.values().map(|sheet| sheet_topic(&sheet.about.name))
    }

    /// Balls around the first frames: centre and radius \[m\].
    pub(super) fn balls(&self) -> Vec<(Vec3, f64)> {
        self.sheets.values().filter_map(|sheet| sheet.ball).collect()
    }
}

/// A ball around places \[m\].
pub(super) fn ball(places: &[Vec3]) -> Option<(Vec3, f64)> {
    let (low, high) = cullet_geometry::mesh::bounds(places)?;
    Some(((low + high) / 2.0, (high - low).norm() / 2.0))
}
