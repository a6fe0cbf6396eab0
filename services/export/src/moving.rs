//! Sheets as a film has them: surfaces whose points move, from frame to frame.

use crate::error::ExportError;
use crate::looks::linear;
use crate::names::UniqueNames;
use cullet_geometry::{Quat, Vec3};
use cullet_proto::recording::SheetWindow;
use cullet_record::palette;
use cullet_record::{RecordedSheet, Recording, scale};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// Times closer than this are one \[s\].
const SAME: f64 = 1e-9;

/// A sheet of a run. Up is z.
#[derive(Clone, Debug)]
pub(crate) struct MovingTrack {
    pub(crate) number: u32,
    /// A name that is an identifier and that nothing else has.
    pub(crate) name: String,
    /// The same for each of its stretches.
    pub(crate) parts: Vec<String>,
    /// Name of its material.
    pub(crate) material: String,
    /// Linear red, green and blue where it shows no quantity.
    pub(crate) colour: [f32; 3],
    /// What its places are counted from \[m\].
    pub(crate) origin: Vec3,
    /// By rising time.
    pub(crate) frames: Vec<MovingFrame>,
    /// Frames of one surface, one after another.
    pub(crate) stretches: Vec<Range<usize>>,
    /// Least and greatest value of the quantity that diffuses; nothing where none does.
    span: Option<(f32, f32)>,
}

/// A sheet at one moment.
#[derive(Clone, Debug)]
pub(crate) struct MovingFrame {
    /// When \[s\].
    pub(crate) time: f64,
    pub(crate) triangles: Arc<Vec<[u32; 3]>>,
    /// Where its points are, from the origin of its sheet \[m\].
    pub(crate) places: Vec<Vec3>,
    /// Of each point: the quantity that diffuses; empty where none does.
    pub(crate) quantity: Vec<f32>,
}

impl MovingFrame {
    /// The unit normal at each point, on the upper side.
    pub(crate) fn normals(&self) -> Vec<Vec3> {
        let mut areas = vec![Vec3::zeros(); self.places.len()];
        for corners in &*self.triangles {
            let [a, b, c] = corners.map(|v| self.places[v as usize]);
            let area = (b - a).cross(&(c - a));
            corners.iter().for_each(|&v| areas[v as usize] += area);
        }
        areas.iter().map(|area| area.try_normalize(1e-300).unwrap_or_else(Vec3::z)).collect()
    }
}

impl MovingTrack {
    /// Whether its colours show a quantity.
    pub(crate) fn is_tinted(&self) -> bool {
        self.span.is_some()
    }

    /// Linear red, green and blue of each point of a frame; nothing where it shows no quantity.
    pub(crate) fn colours(&self, frame: &MovingFrame) -> Option<Vec<[f32; 3]>> {
        let span = self.span?;
        let colour = |k: usize| {
            let value = frame.quantity.get(k).copied().unwrap_or(span.0);
            linear(scale::colour(value, span).map(|byte| f32::from(byte) / 255.0))
        };
        Some((0..frame.places.len()).map(colour).collect())
    }

    /// When a stretch is seen: from its first frame to that of the next \[s\].
    pub(crate) fn life(&self, stretch: usize) -> [f64; 2] {
        let first = |k: usize| self.stretches.get(k).map(|of| self.frames[of.start].time);
        [first(stretch).unwrap_or(f64::INFINITY), first(stretch + 1).unwrap_or(f64::INFINITY)]
    }

    /// Its last frame up to a time \[s\].
    pub(crate) fn at(&self, time: f64) -> Option<&MovingFrame> {
        let next = self.frames.partition_point(|frame| frame.time <= time + SAME);
        self.frames.get(next.checked_sub(1)?)
    }
}

/// A window of a sheet's time, as tables have it.
#[derive(Clone, Debug)]
pub(crate) struct ExportWindow {
    /// Name of the sheet.
    pub(crate) sheet: String,
    pub(crate) window: SheetWindow,
}

/// The sheets that are there at some moment between two times \[s\]. `up`: the turn that makes up
/// z.
///
/// # Errors
/// A frame or a surface that is damaged.
pub(crate) fn tracks(
    recording: &Recording,
    up: Quat,
    between: [f64; 2],
    names: &mut UniqueNames,
) -> Result<Vec<MovingTrack>, ExportError> {
    let mut tracks = Vec::new();
    for sheet in recording.sheets() {
        if let Some(mut track) = track(recording, &sheet, up, between)? {
            track.name = names.give(&sheet.name);
            let part = |k: usize| format!("{}_surface_{}", track.name, k + 1);
            track.parts = (0..track.stretches.len()).map(|k| names.give(&part(k))).collect();
            tracks.push(track);
        }
    }
    Ok(tracks)
}

fn track(
    recording: &Recording,
    sheet: &RecordedSheet,
    up: Quat,
    [start, end]: [f64; 2],
) -> Result<Option<MovingTrack>, ExportError> {
    let own = recording.sheet_frames.iter().filter(|frame| frame.sheet == sheet.number);
    let mut told: Vec<_> = own.filter(|frame| frame.time <= end + SAME).collect();
    told.sort_by_key(|frame| frame.step);
    // What is there at first is the last frame of before.
    let before = told.iter().filter(|frame| frame.time <= start + SAME).count();
    told.drain(..before.saturating_sub(1));
    let mut surfaces: BTreeMap<&[u8], Arc<Vec<[u32; 3]>>> = BTreeMap::new();
    let (mut frames, mut origin, mut span) = (Vec::new(), None, None);
    for frame in told {
        let moment = recording.sheet_moment(frame)?;
        let triangles = surfaces.entry(&frame.surface[..]);
        let triangles = triangles.or_insert_with(|| Arc::new(moment.surface.triangles)).clone();
        let origin = *origin.get_or_insert_with(|| {
            let (low, high) = cullet_geometry::mesh::bounds(&moment.places).unwrap_or_default();
            (low + high) / 2.0
        });
        for &value in &moment.quantity {
            let (low, high) = span.unwrap_or((value, value));
            span = Some((value.min(low), value.max(high)));
        }
        let places = moment.places.iter().map(|place| up * (place - origin)).collect();
        let (time, quantity) = (moment.at.time.max(start), moment.quantity);
        frames.push(MovingFrame { time, triangles, places, quantity });
    }
    let Some(origin) = origin else { return Ok(None) };
    let stretches = stretches(&frames);
    let (name, parts) = (String::new(), Vec::new());
    let colour = linear(palette::colours(&sheet.material, &sheet.name, 0).0);
    let (number, material, origin) = (sheet.number, sheet.material.clone(), up * origin);
    let track =
        MovingTrack { number, name, parts, material, colour, origin, frames, stretches, span };
    Ok(Some(track))
}

/// Frames of one surface, one after another.
fn stretches(frames: &[MovingFrame]) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for (k, frame) in frames.iter().enumerate() {
        match stretches.last_mut() {
            Some(last) if Arc::ptr_eq(&frames[last.start].triangles, &frame.triangles) => {
                last.end = k + 1;
            }
            _ => stretches.push(k..k + 1),
        }
    }
    stretches
}

/// The windows that end between two times \[s\], sheet by sheet.
///
/// # Errors
/// One that is damaged.
pub(crate) fn windows(
    recording: &Recording,
    [start, end]: [f64; 2],
) -> Result<Vec<ExportWindow>, ExportError> {
    let mut windows = Vec::new();
    for sheet in recording.sheets() {
        let all = recording.windows_of(sheet.number)?.into_iter();
        let inside = |time: f64| (start..=end + SAME).contains(&time);
        let ended = all.filter(|sound| inside(sound.window.time));
        windows.extend(
            ended.map(|sound| ExportWindow {
                sheet: sheet.name.clone(),
                window: sound.window.clone(),
            }),
        );
    }
    Ok(windows)
}
