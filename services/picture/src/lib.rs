//! Pictures of a run, drawn from its recording without a GPU: a contact sheet of eight moments, a
//! short film, and large stills. Equal recordings give equal bytes.

mod camera;
mod change;
mod close;
#[cfg(test)]
mod close_tests;
mod corners;
mod direct;
mod exhibit;
mod film;
mod glimpse;
mod letters;
mod light;
mod moment;
mod moments;
mod occlusion;
mod picture;
pub mod points;
mod raster;
mod reel;
mod ropes;
mod shade;
#[cfg(test)]
mod sheet_tests;
mod sheets;
mod stage;
#[cfg(test)]
mod tests;
mod track;

pub use exhibit::exhibit;
pub use letters::Typeface;
pub use picture::Picture;

use cullet_record::{FragmentOrigin, PieceCount, RecordError, Recording, Shares};
use direct::MOMENTS;
use reel::Reel;
use stage::Focus;
use std::path::{Path, PathBuf};
use track::Track;

/// Pixels of one moment of the contact sheet, and of a frame of the film.
const SIZE: (usize, usize) = (480, 320);
/// Moments in a row of the contact sheet.
const COLUMNS: usize = 4;
/// Pixels between moments.
const GAP: usize = 6;
/// Height of the lines of captions on a contact sheet, at most, and on a film.
const SHEET_LETTERS: usize = 24;
const FILM_LETTERS: usize = 16;
/// Behind the pictures of a sheet, and in the place of one that is not there.
const BEHIND: [u8; 3] = [28, 30, 34];
/// Frames a second.
const FPS: f64 = 12.5;
/// Longest film \[s\]; a longer run plays faster.
const LONGEST: f64 = 4.8;
/// Slowest play \[1\]: a short break is stretched up to this, no further.
const SLOWEST: f64 = 0.25;
/// Most threads that draw frames: the run's own workers may still be about.
const THREADS: usize = 4;

/// The pictures of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pictures {
    /// `preview.png`.
    pub sheet: PathBuf,
    /// `preview.gif`.
    pub film: PathBuf,
}

/// What fills the pictures of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Framing {
    /// What the scene's view names, or else all that breaks, as far as it flies.
    #[default]
    Whole,
    /// The first body that is struck and breaks, and its pieces until a second later. In a still:
    /// what breaks, as it is at that moment.
    Struck,
    /// The same of the body of this name.
    Body(String),
}

impl Framing {
    /// A close view of a body, or without a name of what is struck.
    #[must_use]
    pub fn of_close(name: &str) -> Self {
        if name.is_empty() { Self::Struck } else { Self::Body(name.to_owned()) }
    }
}

/// Draws `preview.png` and `preview.gif` of a recording into a folder.
///
/// # Errors
/// The recording cannot be read or a picture not written; the other one is written all the same.
pub fn from_recording(recording: &Path, folder: &Path) -> Result<Pictures, RecordError> {
    framed(&Recording::open(recording)?, folder, &Framing::Whole)
}

/// The same, with what is wanted in the middle.
///
/// # Errors
/// A picture cannot be written, or the run has no body of the name that is wanted.
pub fn framed(
    recording: &Recording,
    folder: &Path,
    framing: &Framing,
) -> Result<Pictures, RecordError> {
    draw(recording, folder, (framing, SIZE))
}

/// Where the pictures of a run are taken from.
fn focus(
    track: &Track,
    recording: &Recording,
    (framing, size): (&Framing, (usize, usize)),
) -> Result<Focus, RecordError> {
    let focus = direct::focus(track, &recording.meta, size);
    let body = match framing {
        Framing::Whole => return Ok(focus),
        Framing::Struck => None,
        Framing::Body(name) => Some(close::checked(track, name, &recording.path)?),
    };
    Ok(close::focus(track, &focus, body, size))
}

/// Draws only the contact sheet, into a file.
///
/// # Errors
/// The recording cannot be read or the picture not written.
pub fn sheet(recording: &Path, file: &Path) -> Result<(), RecordError> {
    let recording = Recording::open(recording)?;
    let track = Track::of(&recording);
    let focus = direct::focus(&track, &recording.meta, SIZE);
    let moments = direct::outline_run(&track, (&focus.camera, SIZE)).choose_moments(MOMENTS);
    contact_sheet(&draw_all(&track, &focus, &moments, SIZE, SHEET_LETTERS)).save(file)
}

fn draw(
    recording: &Recording,
    folder: &Path,
    (framing, size): (&Framing, (usize, usize)),
) -> Result<Pictures, RecordError> {
    let track = Track::of(recording);
    let pictures = Pictures { sheet: folder.join("preview.png"), film: folder.join("preview.gif") };
    let focus = focus(&track, recording, (framing, size))?;
    let outline = direct::outline_run(&track, (&focus.camera, size));
    let drawn = draw_all(&track, &focus, &outline.choose_moments(MOMENTS), size, SHEET_LETTERS);
    let sheet = contact_sheet(&drawn).save(&pictures.sheet);
    let times = film_times(outline.find_shown_span());
    let frames = draw_all(&track, &focus, &times, size, FILM_LETTERS);
    film::gif(&frames, FPS, &pictures.film)?;
    sheet.map(|()| pictures)
}

/// Which moment a still shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StillTime {
    /// That one \[s\].
    At(f64),
    /// A moment after the first break, or of sheets when half of what tears is torn, or when they
    /// are farthest from where they were first.
    Telling,
    /// The last that is recorded.
    Last,
}

/// What a still shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Still {
    /// When.
    pub time: StillTime,
    /// Pixels across and down.
    pub size: (usize, usize),
    /// What fills the picture: a body, or what breaks, is seen as it is at that moment.
    pub framing: Framing,
}

/// Draws a still of a recording into a file; hands back the moment that it shows \[s\].
///
/// # Errors
/// The recording has no such moment or body, or the picture is not written.
pub fn still(recording: &Recording, wanted: &Still, file: &Path) -> Result<f64, RecordError> {
    let track = Track::of(recording);
    if let StillTime::At(time) = wanted.time
        && time > track.end + track.step
    {
        return Err(RecordError::Beyond { path: recording.path.clone(), time, end: track.end });
    }
    let mut focus = direct::focus(&track, &recording.meta, wanted.size);
    let time = match wanted.time {
        StillTime::At(time) => time.clamp(0.0, track.end),
        StillTime::Telling => moment::shown(&track).clamp(0.0, track.end),
        StillTime::Last => track.end,
    };
    let body = match &wanted.framing {
        Framing::Body(name) => Some(close::checked(&track, name, &recording.path)?),
        Framing::Whole | Framing::Struck => None,
    };
    if wanted.framing != Framing::Whole {
        focus = direct::close(&track, &focus, body, (time, wanted.size));
    }
    let mut picture = Reel::fine(&track, &focus, wanted.size).draw(time);
    let (text, width) = (caption(&track, time), wanted.size.0);
    let largest = FILM_LETTERS * width.div_ceil(SIZE.0);
    let face = Picture::choose_face(largest, std::slice::from_ref(&text), width);
    picture.caption(&text, face);
    picture.save(file)?;
    Ok(time)
}

/// What the contact sheet of several runs shows of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SheetView {
    /// When \[s\]: a run has a row, and each of these a column. Without any each run is there once,
    /// at the moment that a still of it shows.
    pub times: Vec<f64>,
    /// What fills the pictures.
    pub framing: Framing,
}

/// Draws several recordings side by side into a file, with their captions. A run that ends before
/// one of the times has an empty place there.
///
/// # Errors
/// A recording cannot be read, it has no body of the name that is wanted, or the picture is not
/// written.
pub fn side_by_side(
    runs: &[(PathBuf, String)],
    view: &SheetView,
    file: &Path,
) -> Result<(), RecordError> {
    let mut pictures = Vec::new();
    for (recording, text) in runs {
        let recording = Recording::open(recording)?;
        let track = Track::of(&recording);
        let focus = focus(&track, &recording, (&view.framing, SIZE))?;
        let mut reel = Reel::new(&track, &focus, SIZE);
        let mut place = |time: f64| {
            if time > track.end + track.step {
                let mut picture = Picture::filled(SIZE.0, SIZE.1, BEHIND);
                picture.caption(&format!("{text}  ends at {:.3} s", track.end), Typeface::SMALL);
                return picture;
            }
            let time = time.clamp(0.0, track.end);
            let mut picture = reel.draw(time);
            picture.caption(&format!("{text}  {}", caption(&track, time)), Typeface::SMALL);
            picture
        };
        // At their ends what broke may have flown out of all pictures.
        match &view.times[..] {
            [] => pictures.push(place(moment::shown(&track))),
            times => pictures.extend(times.iter().map(|&time| place(time))),
        }
    }
    let columns = if view.times.is_empty() { COLUMNS } else { view.times.len() };
    sheet_of(&pictures, columns).save(file)
}

/// Puts pictures of one size side by side, at most four in a row.
#[must_use]
pub fn contact_sheet(pictures: &[Picture]) -> Picture {
    sheet_of(pictures, COLUMNS)
}

/// The same, with so many in a row.
fn sheet_of(pictures: &[Picture], columns: usize) -> Picture {
    let (width, height) = pictures.first().map_or(SIZE, |p| (p.width, p.height));
    let rows = pictures.len().div_ceil(columns).max(1);
    let across = pictures.len().clamp(1, columns) * (width + GAP) + GAP;
    let mut sheet = Picture::filled(across, rows * (height + GAP) + GAP, BEHIND);
    for (k, picture) in pictures.iter().enumerate() {
        let (column, row) = (k % columns, k / columns);
        sheet.paste(picture, GAP + column * (width + GAP), GAP + row * (height + GAP));
    }
    sheet
}

/// When the frames of a film of a span of time are.
fn film_times((start, end): (f64, f64)) -> Vec<f64> {
    let shown = (end - start).max(0.0);
    let play = (shown / SLOWEST).clamp(0.1, LONGEST);
    let count = (play * FPS).round().max(2.0) as u32;
    let time = |k: u32| start + shown * f64::from(k) / f64::from(count - 1);
    (0..count).map(time).collect()
}

/// Draws moments, each on whatever thread is free: none depends on another. The letters of their
/// captions are equally large, and their lines at most so high.
fn draw_all(
    track: &Track,
    focus: &Focus,
    times: &[f64],
    size: (usize, usize),
    largest: usize,
) -> Vec<Picture> {
    let captions: Vec<String> = times.iter().map(|&time| caption(track, time)).collect();
    let face = Picture::choose_face(largest, &captions, size.0);
    let cores = std::thread::available_parallelism().map_or(1, usize::from).min(THREADS);
    let some = |times: &[f64]| {
        let mut reel = Reel::new(track, focus, size);
        let one = |&time: &f64| {
            let mut picture = reel.draw(time);
            picture.caption(&caption(track, time), face);
            picture
        };
        times.iter().map(one).collect::<Vec<_>>()
    };
    let batch = times.len().div_ceil(cores).max(1);
    std::thread::scope(|scope| {
        let batches: Vec<_> =
            times.chunks(batch).map(|batch| scope.spawn(move || some(batch))).collect();
        let drawn = batches.into_iter().map(|batch| match batch.join() {
            Ok(pictures) => pictures,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        drawn.flatten().collect()
    })
}

fn caption(track: &Track, time: f64) -> String {
    let each = track.sheets.iter().map(|it| it.pieces(time));
    let count = each.fold(PieceCount::default(), PieceCount::and);
    let torn = match track.sheets.len() {
        sheets if count.pieces <= sheets as u64 => String::new(),
        1 => format!("  in {count}"),
        bodies => format!("  {bodies} bodies in {count}"),
    };
    let holes = if track.holes { "  (the recording has holes)" } else { "" };
    bodies_caption(track, time) + &torn + holes
}

fn bodies_caption(track: &Track, time: f64) -> String {
    let fragments = || track.present(time).filter(|(_, actor, _)| actor.fragment);
    let shares: Option<Vec<(f64, FragmentOrigin)>> =
        fragments().map(|(_, actor, _)| actor.share).collect();
    match (fragments().count(), shares) {
        (0, _) => format!("{time:.3} s"),
        (n, None) => format!("{time:.3} s  {n} fragments"),
        (n, Some(shares)) => {
            let of = |kind| shares.iter().filter(move |(_, origin)| *origin == kind);
            let drawn = || of(FragmentOrigin::Sampled).map(|(mass, _)| mass);
            let asked = of(FragmentOrigin::Directed).count() as u64;
            let mass: f64 = shares.iter().map(|(mass, _)| mass).sum();
            let all = Shares::of((n as u64, drawn().count() as u64), (mass, drawn().sum()));
            let drawn = all.sampled_pieces;
            let solved = all.pieces - drawn - asked;
            let by_mass = 100.0 * all.sampled_mass;
            let sampled = format!("{solved} solved, {drawn} sampled, {by_mass:.0} % of mass");
            match asked {
                0 => format!("{time:.3} s  {sampled}"),
                asked => format!("{time:.3} s  {sampled}, {asked} directed"),
            }
        }
    }
}
