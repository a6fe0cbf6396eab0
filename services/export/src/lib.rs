//! A recording as files that other programs read: GLB for Blender, Unreal and browsers, USD for
//! Houdini and everything else, tables, and the pieces by themselves.
//!
//! | format | up | has |
//! |---|---|---|
//! | `.glb` | y | a node a body, its motion as an animation, visible by a scale of 1 or 0 |
//! | `.usda` | z | a prim a body, with time samples, physics, primvars, grains as instances |
//! | `.csv` | z | a table of the bodies, and one of their poses beside it; those of sheets |
//! | pieces | y | a GLB a fragment at rest, one of all of them, a table |
//!
//! Lengths are in metres. A file is whole or not there.

mod error;
mod glb;
mod keys;
mod looks;
mod moving;
mod names;
mod pictures;
mod pieces;
mod sheet_table;
mod sheets;
mod surface;
mod table;
mod timeline;
mod usd;

pub use error::{ExportError, FPS, MOST_FILES};
pub use keys::{PLACE_MOST, PLACE_SHARE, TURN_MOST};

use cullet_record::Recording;
use error::write_error;
use glb::GlbUse;
use serde::Serialize;
use std::path::{Path, PathBuf};
use timeline::{BodyTrack, ExportTimeline, Scenery, TimelineOptions};

/// Which moments are exported.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Moments {
    /// All of them, as one animation.
    #[default]
    Motion,
    /// One \[s\], without animation.
    At(f64),
    /// One each so often \[s\], each as a file of its own without animation.
    Every(f64),
}

/// What is exported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExportOptions {
    /// Frames a second \[1/s\]. Where the steps of the run are longer, there is a sample a step.
    pub fps: f64,
    /// The first moment \[s\]; without it the beginning of the run. It becomes time 0.
    pub start: Option<f64>,
    /// The last moment \[s\]; without it the end of the run.
    pub end: Option<f64>,
    /// Which moments.
    pub moments: Moments,
    /// Whether grains of debris are there.
    pub grains: bool,
}

impl Default for ExportOptions {
    fn default() -> Self {
        Self { fps: 24.0, start: None, end: None, moments: Moments::Motion, grains: true }
    }
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ExportReport {
    /// The files.
    pub files: Vec<PathBuf>,
    /// Their bytes.
    pub bytes: u64,
    /// Bodies, of all shapes.
    pub bodies: usize,
    /// Grains of debris.
    pub grains: usize,
    /// Grains that were left out, for the format has room for fewer.
    pub grains_left_out: usize,
    /// Frames from the first moment to the last; 1 without animation.
    pub frames: usize,
    /// Keys of animations, of all bodies.
    pub keys: usize,
    /// Triangles of all bodies.
    pub triangles: usize,
    /// Pictures of the materials of artists' meshes.
    pub pictures: usize,
    /// Those that are not written, each with the reason in words.
    pub pictures_left_out: Vec<String>,
    /// Sheets: bodies that move as they deform.
    #[serde(skip_serializing_if = "is_none")]
    pub sheets: usize,
    /// What the reader should know of the files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// Whether there are none: nothing is then said of them.
fn is_none(count: &usize) -> bool {
    *count == 0
}

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ExportFormat {
    Glb,
    Usda,
    Csv,
}

/// What is said of a format that is not written.
const ADVICE: &[(&str, &str)] = &[
    ("usdc", "USD is written as text; export x.usda, then: usdcat x.usda -o x.usdc"),
    ("usd", "USD is written as text; export x.usda, then: usdcat x.usda -o x.usd"),
    ("usdz", "USD is written as text; export x.usda, then: usdzip x.usdz x.usda"),
    (
        "abc",
        "no maintained library writes Alembic from Rust; export .usda, which the same programs \
         read",
    ),
    ("gltf", "glTF is written as one file; export .glb"),
    ("fbx", "the format of FBX is not public; export .glb or .usda, which the same programs read"),
];

fn format_of(path: &Path) -> Result<ExportFormat, ExportError> {
    let end = path.extension().map(|end| end.to_string_lossy().to_lowercase());
    let end = end.unwrap_or_default();
    match &end[..] {
        "glb" => Ok(ExportFormat::Glb),
        "usda" => Ok(ExportFormat::Usda),
        "csv" => Ok(ExportFormat::Csv),
        other => {
            let known = ADVICE.iter().find(|(name, _)| *name == other);
            let advice = known.map_or("a run is exported as .glb, .usda or .csv", |of| of.1);
            Err(ExportError::Format { path: path.to_owned(), advice })
        }
    }
}

/// Exports a recording to `output`, whose ending says as what: `.glb`, `.usda` or `.csv`. A
/// sequence gets the numbers of its files before the ending: `x_0001.glb`.
///
/// # Errors
/// Options out of bounds, a format that is not written, a mesh that is damaged, or a file that
/// cannot be written.
pub fn export(
    recording: &Recording,
    options: &ExportOptions,
    output: &Path,
) -> Result<ExportReport, ExportError> {
    let format = format_of(output)?;
    if !FPS.contains(&options.fps) {
        return Err(ExportError::Fps { fps: options.fps });
    }
    let mut report = written(recording, (format, options), output)?;
    report.notes.extend(tell_holes(recording));
    Ok(report)
}

/// What a reader of files must know of a recording with holes.
fn tell_holes(recording: &Recording) -> Option<String> {
    let missing = recording.summary().missing?;
    let path = recording.path.display();
    Some(format!("{path} has holes, and what is missing there is missing here: {missing}"))
}

fn written(
    recording: &Recording,
    (format, options): (ExportFormat, &ExportOptions),
    output: &Path,
) -> Result<ExportReport, ExportError> {
    let ExportOptions { fps, start, end, grains, .. } = *options;
    let wanted = TimelineOptions { fps, start, end, grains };
    let pictures = &pictures_folder(output);
    match options.moments {
        Moments::Motion => {
            let timeline = ExportTimeline::of(recording, &wanted)?;
            write(&timeline, format, Scenery::Motion, (output, pictures))
        }
        Moments::At(time) => {
            let wanted = TimelineOptions { start: Some(time), end: Some(time), ..wanted };
            let timeline = ExportTimeline::of(recording, &wanted)?;
            write(&timeline, format, Scenery::Moment(time), (output, pictures))
        }
        Moments::Every(every) => {
            let timeline = ExportTimeline::of(recording, &wanted)?;
            let span = timeline.range.end - timeline.range.start;
            let count = (span / every).floor() + 1.0;
            if !(every > 0.0 && count <= MOST_FILES as f64) {
                return Err(ExportError::Sequence { every });
            }
            let mut report = ExportReport::default();
            for k in 0..count as usize {
                let time = timeline.range.start + k as f64 * every;
                let scenery = Scenery::Moment(time.min(timeline.range.end));
                let file = numbered(output, k);
                report = report.and(write(&timeline, format, scenery, (&file, pictures))?);
            }
            Ok(report)
        }
    }
}

/// The whole run as a GLB for a page that shows it: normals are rounded to bytes, crack faces have
/// no texture coordinates, and motions fewer keys than in [`export`].
///
/// # Errors
/// A mesh that is damaged.
pub fn page_glb(recording: &Recording) -> Result<Vec<u8>, ExportError> {
    let ExportOptions { fps, start, end, grains, .. } = ExportOptions::default();
    let timeline = ExportTimeline::of(recording, &TimelineOptions { fps, start, end, grains })?;
    Ok(glb::write(&timeline, Scenery::Motion, GlbUse::Page, |_| true)?.bytes)
}

/// Writes the pieces of what broke into a folder: each in a file of its own, all of them in
/// `pieces.glb`, and a table of them, `pieces.csv`. They lie at rest, where they are in the whole
/// object.
///
/// # Errors
/// Nothing broke, a mesh is damaged, or a file cannot be written.
pub fn export_pieces(recording: &Recording, folder: &Path) -> Result<ExportReport, ExportError> {
    let fps = ExportOptions::default().fps;
    let wanted = TimelineOptions { fps, start: None, end: None, grains: false };
    let timeline = ExportTimeline::of(recording, &wanted)?;
    let files = pieces::files(&timeline)?;
    std::fs::create_dir_all(folder).map_err(write_error(folder))?;
    let mut report = ExportReport { frames: 1, ..ExportReport::default() };
    for (name, content) in &files.contents {
        report.put(&folder.join(name), content)?;
    }
    (report.bodies, report.triangles) = (files.pieces, files.triangles);
    (report.pictures, report.pictures_left_out) = (files.pictures, timeline.pictures_left_out);
    report.notes.extend(tell_holes(recording));
    Ok(report)
}

/// The folder of pictures beside a stage: of a sequence, one for all.
fn pictures_folder(output: &Path) -> String {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    // The path of an asset ends with an @, and has no escapes.
    let fits = |c: char| if c == '@' || c.is_control() { '_' } else { c };
    stem.chars().map(fits).chain("_pictures".chars()).collect()
}

/// The name of one file of a sequence.
fn numbered(output: &Path, k: usize) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let end = output.extension().unwrap_or_default().to_string_lossy();
    output.with_file_name(format!("{stem}_{:04}.{end}", k + 1))
}

fn write(
    timeline: &ExportTimeline,
    format: ExportFormat,
    scenery: Scenery,
    (output, pictures): (&Path, &str),
) -> Result<ExportReport, ExportError> {
    let frames = if scenery == Scenery::Motion { timeline.range.frames() } else { 1 };
    let mut report = ExportReport { frames, ..ExportReport::default() };
    let born = |birth: f64| match scenery {
        Scenery::Moment(time) => birth <= time,
        Scenery::Motion | Scenery::Rest => true,
    };
    let all = timeline.grains.iter().filter(|grain| born(grain.birth)).count();
    match format {
        ExportFormat::Glb => {
            let there = |track: &BodyTrack| match scenery {
                Scenery::Moment(time) => track.is_there(time),
                Scenery::Motion | Scenery::Rest => true,
            };
            let content = glb::write(timeline, scenery, GlbUse::Work, there)?;
            report.put(output, &content.bytes)?;
            (report.bodies, report.grains) = (content.bodies, content.grains);
            (report.keys, report.triangles) = (content.keys, content.triangles);
            report.grains_left_out = all - content.grains;
            report.pictures = content.pictures;
            report.pictures_left_out.clone_from(&timeline.pictures_left_out);
            (report.sheets, report.notes) = (content.sheets, content.notes);
        }
        ExportFormat::Usda => {
            let content = usd::write(timeline, scenery, pictures);
            report.put_pictures(timeline, &output.with_file_name(pictures))?;
            report.put(output, content.text.as_bytes())?;
            (report.bodies, report.grains) = (content.bodies, all);
            (report.keys, report.triangles) = (content.keys, content.triangles);
            report.sheets = content.sheets;
        }
        ExportFormat::Csv => {
            let tables = table::write(timeline, scenery);
            let stem = output.file_stem().unwrap_or_default().to_string_lossy();
            let beside = output.with_file_name(format!("{stem}_poses.csv"));
            report.put(&beside, tables.poses.as_bytes())?;
            if scenery == Scenery::Motion && !timeline.windows.is_empty() {
                let [windows, pieces] = sheet_table::write(timeline);
                for (kind, text) in [("windows", windows), ("sheet_pieces", pieces)] {
                    let beside = output.with_file_name(format!("{stem}_{kind}.csv"));
                    report.put(&beside, text.as_bytes())?;
                }
                report.sheets = timeline.moving.len();
            }
            report.put(output, tables.bodies.as_bytes())?;
            (report.bodies, report.keys) = (tables.count, tables.rows);
            report.grains_left_out = all;
        }
    }
    Ok(report)
}

impl ExportReport {
    fn put(&mut self, path: &Path, content: &[u8]) -> Result<(), ExportError> {
        cullet_files::output::write_file(path, content).map_err(write_error(path))?;
        self.files.push(path.to_owned());
        self.bytes += content.len() as u64;
        Ok(())
    }

    /// The pictures of a stage as files of a folder; none where there are no pictures.
    fn put_pictures(
        &mut self,
        timeline: &ExportTimeline,
        folder: &Path,
    ) -> Result<(), ExportError> {
        if !timeline.pictures.is_empty() {
            std::fs::create_dir_all(folder).map_err(write_error(folder))?;
        }
        for picture in &timeline.pictures {
            self.put(&folder.join(picture.file()), &picture.bytes)?;
        }
        self.pictures = timeline.pictures.len();
        self.pictures_left_out.clone_from(&timeline.pictures_left_out);
        Ok(())
    }

    /// This and another file of one sequence.
    fn and(mut self, other: Self) -> Self {
        self.files.extend(other.files);
        self.files.sort_unstable();
        self.files.dedup();
        self.bytes += other.bytes;
        self.frames += other.frames;
        self.bodies = self.bodies.max(other.bodies);
        self.grains = self.grains.max(other.grains);
        self.grains_left_out = self.grains_left_out.max(other.grains_left_out);
        self.keys += other.keys;
        self.triangles = self.triangles.max(other.triangles);
        self.pictures = self.pictures.max(other.pictures);
        self.pictures_left_out = other.pictures_left_out;
        self.sheets = self.sheets.max(other.sheets);
        self.notes.extend(other.notes);
        self.notes.sort_unstable();
        self.notes.dedup();
        self
    }
}
