//! Sheets as a film has them: surfaces whose points move, from frame to frame.

use crate::error::ExportError;
use crate::looks::linear;
use crate::names::UniqueNames;
use cullet_geometry::{Quat, Vec3};
use cullet_proto::recording::SheetWindow;
use cullet_record::palette::{self, Rgb};
use cullet_record::{PlacedSheet, QuantityScale, RecordedSheet, Recording, ThickSheet};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// Times closer than this are one \[s\].
const SAME: f64 = 1e-9;

/// Most frames of a sheet that are shapes of one mesh: programs hold all of them at once.
pub(crate) const MOST_SHAPES: usize = 64;
/// The same where colours show a quantity: they are those of the mesh, whatever its shape.
pub(crate) const MOST_TINTED: usize = 16;

/// A sheet of a run. Up is z.
#[derive(Clone, Debug)]
pub(crate) struct MovingTrack {
    pub(crate) number: u32,
    /// A name that is an identifier and that nothing else has.
    pub(crate) name: String,
    /// The same for each of its stretches.
    pub(crate) parts: Vec<String>,
    /// Frames that are shapes of one mesh, one after another.
    pub(crate) runs: Vec<ShapeRun>,
    /// Name of its material.
    pub(crate) material: String,
    /// Linear red, green and blue where it shows no quantity.
    pub(crate) colour: [f32; 3],
    /// Whether it shines as metals do.
    pub(crate) metal: bool,
    /// What its places are counted from \[m\].
    pub(crate) origin: Vec3,
    /// By rising time.
    pub(crate) frames: Vec<MovingFrame>,
    /// Frames of one surface, one after another.
    pub(crate) stretches: Vec<Range<usize>>,
    /// The quantity that diffuses as colours; nothing where none does, or where it is uniform.
    scale: Option<QuantityScale>,
}

/// Frames of one surface that are shapes of one mesh; the last of them is also the first of the
/// next such mesh, if that has the same surface.
#[derive(Clone, Debug)]
pub(crate) struct ShapeRun {
    /// A name that is an identifier and that nothing else has.
    pub(crate) name: String,
    pub(crate) frames: Range<usize>,
}

/// A sheet at one moment.
#[derive(Clone, Debug)]
pub(crate) struct MovingFrame {
    /// When \[s\].
    pub(crate) time: f64,
    pub(crate) shape: Arc<ThickSheet>,
    /// Where its points are, from the origin of its sheet \[m\].
    points: Vec<Vec3>,
    /// Of each point: the quantity that diffuses; empty where none does.
    quantity: Vec<f32>,
}

impl MovingFrame {
    /// Its vertices and their normals, with both faces and the walls.
    pub(crate) fn placed(&self) -> PlacedSheet {
        self.shape.at(&self.points)
    }

    /// The quantity at each vertex; empty where none diffuses.
    pub(crate) fn values(&self) -> Vec<f32> {
        let value = |point: u32| self.quantity.get(point as usize).copied().unwrap_or_default();
        let vertices = self.shape.vertices.iter().filter(|_| !self.quantity.is_empty());
        vertices.map(|of| value(of.point)).collect()
    }

    /// Between this and a later frame; nothing where they have different surfaces.
    fn between(&self, next: &Self, time: f64) -> Option<Self> {
        let share = (time - self.time) / (next.time - self.time);
        if !(Arc::ptr_eq(&self.shape, &next.shape) && (0.0..=1.0).contains(&share)) {
            return None;
        }
        let points = self.points.iter().zip(&next.points).map(|(a, b)| a.lerp(b, share));
        let (points, part) = (points.collect(), share as f32);
        let mut quantity = self.quantity.clone();
        for (value, to) in quantity.iter_mut().zip(&next.quantity) {
            *value += (to - *value) * part;
        }
        Some(Self { time, shape: Arc::clone(&self.shape), points, quantity })
    }
}

impl MovingTrack {
    /// Whether its colours show a quantity.
    pub(crate) fn is_tinted(&self) -> bool {
        self.scale.is_some()
    }

    /// Linear red, green and blue of each vertex of a frame; nothing where it shows no quantity.
    pub(crate) fn colours(&self, frame: &MovingFrame) -> Option<Vec<[f32; 3]>> {
        let scale = self.scale.as_ref()?;
        let colour = |of: &cullet_record::ThickVertex| {
            let value = frame.quantity.get(of.point as usize);
            linear(scale.colour(value.map_or(0.0, |&value| scale.share(value))))
        };
        Some(frame.shape.vertices.iter().map(colour).collect())
    }

    /// When a stretch is seen: from its first frame to that of the next \[s\].
    pub(crate) fn life(&self, stretch: usize) -> [f64; 2] {
        let first = |k: usize| self.stretches.get(k).map(|of| self.frames[of.start].time);
        [first(stretch).unwrap_or(f64::INFINITY), first(stretch + 1).unwrap_or(f64::INFINITY)]
    }

    /// When the mesh of a run is seen: from its first frame to that of the next \[s\].
    pub(crate) fn run_life(&self, run: usize) -> [f64; 2] {
        let first = |k: usize| self.runs.get(k).map(|of| self.frames[of.frames.start].time);
        [first(run).unwrap_or(f64::INFINITY), first(run + 1).unwrap_or(f64::INFINITY)]
    }

    /// As it is at a time \[s\]: between two frames of one surface on the straight way, and before
    /// another surface as it was last.
    pub(crate) fn at(&self, time: f64) -> Option<MovingFrame> {
        let next = self.frames.partition_point(|frame| frame.time <= time + SAME);
        let last = self.frames.get(next.checked_sub(1)?)?;
        let way = self.frames.get(next).and_then(|next| last.between(next, time));
        Some(way.unwrap_or_else(|| last.clone()))
    }

    /// Its stretches, cut where a mesh has enough shapes.
    fn cut(&self) -> Vec<Range<usize>> {
        let most = if self.is_tinted() { MOST_TINTED } else { MOST_SHAPES };
        let mut runs = Vec::new();
        for stretch in &self.stretches {
            let mut first = stretch.start;
            while first == stretch.start || first + 1 < stretch.end {
                runs.push(first..(first + most).min(stretch.end));
                first += most - 1;
            }
        }
        runs
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
            let cut = track.cut();
            let single = cut.len() == 1;
            let named = cut.into_iter().map(|frames| {
                let of = track.stretches.iter().position(|it| it.contains(&frames.start));
                let of = of.unwrap_or_default();
                let name = match frames.start == track.stretches[of].start {
                    _ if single => track.name.clone(),
                    true => track.parts[of].clone(),
                    false => names.give(&format!("{}_from_{}", track.parts[of], frames.start + 1)),
                };
                ShapeRun { name, frames }
            });
            track.runs = named.collect();
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
    let own = || recording.sheet_frames.iter().filter(|frame| frame.sheet == sheet.number);
    let mut told: Vec<_> = own().collect();
    told.sort_by_key(|frame| frame.step);
    // What leads to the end is the first frame after it; what is there at first, the last before.
    let inside = told.iter().filter(|frame| frame.time <= end + SAME).count();
    told.truncate(if inside > 0 { inside + 1 } else { 0 });
    let before = told.iter().filter(|frame| frame.time <= start + SAME).count();
    told.drain(..before.saturating_sub(1));
    let mut surfaces: BTreeMap<&[u8], Arc<ThickSheet>> = BTreeMap::new();
    let (mut frames, mut origin) = (Vec::new(), None);
    for frame in told {
        let moment = recording.sheet_moment(frame)?;
        let shape = surfaces.entry(&frame.surface[..]);
        let shape = shape.or_insert_with(|| Arc::new(ThickSheet::of(&moment.surface))).clone();
        let origin = *origin.get_or_insert_with(|| {
            let (low, high) = cullet_geometry::mesh::bounds(&moment.places).unwrap_or_default();
            (low + high) / 2.0
        });
        let points = moment.places.iter().map(|place| up * (place - origin)).collect();
        let (time, quantity) = (moment.at.time, moment.quantity);
        frames.push(MovingFrame { time, shape, points, quantity });
    }
    let Some(origin) = origin else { return Ok(None) };
    clip(&mut frames, [start, end]);
    let stretches = stretches(&frames);
    let (name, parts, runs) = (String::new(), Vec::new(), Vec::new());
    let skin: Rgb = palette::colours(&sheet.material, &sheet.name, 0).0;
    let none = (f32::INFINITY, f32::NEG_INFINITY);
    let values = own().flat_map(|frame| &frame.quantity);
    let span = values.fold(none, |(low, high), &v| (low.min(v), high.max(v)));
    Ok(Some(MovingTrack {
        number: sheet.number,
        name,
        parts,
        runs,
        material: sheet.material.clone(),
        colour: linear(skin),
        metal: palette::is_metal(&sheet.material),
        origin: up * origin,
        frames,
        stretches,
        scale: QuantityScale::of(skin, span),
    }))
}

/// Cuts the first and the last frame to the times between which something is exported \[s\].
fn clip(frames: &mut Vec<MovingFrame>, [start, end]: [f64; 2]) {
    if let Some(after) = frames.pop_if(|last| last.time > end + SAME)
        && let Some(last) = frames.last()
        && last.time < end - SAME
        && let Some(cut) = last.between(&after, end)
    {
        frames.push(cut);
    }
    if let [first, next, ..] = &frames[..]
        && first.time < start - SAME
        && let Some(cut) = first.between(next, start)
    {
        frames[0] = cut;
    }
    for frame in frames.iter_mut() {
        frame.time = frame.time.max(start);
    }
    // What the end cut may lie on what the start cut.
    frames.dedup_by(|later, first| later.time <= first.time + SAME);
}

/// Frames of one surface, one after another.
fn stretches(frames: &[MovingFrame]) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for (k, frame) in frames.iter().enumerate() {
        match stretches.last_mut() {
            Some(last) if Arc::ptr_eq(&frames[last.start].shape, &frame.shape) => {
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
