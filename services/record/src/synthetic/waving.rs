//! A sheet made by hand: it waves, and tears in two.

use super::times::STEP;
use crate::{RecordError, Recorder, SheetAbout, SolvedWindow};
use cullet_geometry::Vec3;
use cullet_model::{MovingSurface, SurfaceFrame, TornPiece, WindowLedger, WindowOutcome};

/// Its number.
pub const SHEET: u32 = 3;
/// Points along each side.
pub const POINTS: u32 = 20;
/// Its sides \[m\].
pub const SIDE: f64 = 0.6;
/// Steps between two frames, and of a window.
pub const EVERY: u64 = 4;
/// The step from which on it is in two parts.
pub const TEARS: u64 = 60;
/// What its places are counted from \[m\].
const ORIGIN: [f64; 3] = [0.25, 0.0, 0.4];
/// Its mass \[kg\].
const MASS: f64 = 0.08;

/// Its surface: whole, or torn along the middle, where the points are there twice.
pub fn surface(torn: bool) -> MovingSurface {
    let at = |i: u32, j: u32| j * POINTS + i;
    let middle = POINTS / 2;
    let mut reference: Vec<[f32; 2]> = Vec::new();
    let place = |k: u32| (SIDE * f64::from(k) / f64::from(POINTS - 1)) as f32;
    for j in 0..POINTS {
        reference.extend((0..POINTS).map(|i| [place(i), place(j)]));
    }
    if torn {
        reference.extend((0..POINTS).map(|j| [place(middle), place(j)]));
    }
    // What lies beyond the tear has the second copy of its points.
    let corner = |i: u32, j: u32, beyond: bool| match torn && beyond && i == middle {
        true => POINTS * POINTS + j,
        false => at(i, j),
    };
    let mut triangles = Vec::new();
    for (j, i) in (1..POINTS).flat_map(|j| (1..POINTS).map(move |i| (j, i))) {
        let beyond = i > middle;
        let [a, b] = [corner(i - 1, j - 1, beyond), corner(i, j - 1, beyond)];
        let [c, d] = [corner(i, j, beyond), corner(i - 1, j, beyond)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    MovingSurface { triangles, reference, thickness: 2e-4 }
}

/// Where its points are after a step: it hangs in the plane of x and z and waves along y; once it
/// is torn, its parts drift apart.
pub fn frame(step: u64) -> SurfaceFrame {
    let (torn, time) = (step >= TEARS, step as f64 * STEP);
    let surface = surface(torn);
    let since = time - TEARS as f64 * STEP;
    let grid = (POINTS * POINTS) as usize;
    let place = |(k, &[x, z]): (usize, &[f32; 2])| {
        let wave = 0.06 * libm::sin(9.0 * f64::from(x) - 8.0 * time) * f64::from(z) / SIDE;
        let beyond = k >= grid || f64::from(x) > 0.5 * SIDE + 1e-3 && k % POINTS as usize != 10;
        let apart = if torn { 0.15 * since * if beyond { 1.0 } else { -1.0 } } else { 0.0 };
        [x + apart as f32, (wave + 0.5 * apart) as f32, z]
    };
    let offsets = surface.reference.iter().enumerate().map(place).collect();
    // Warm at its lower edge, and more so with time.
    let warm = |&[_, z]: &[f32; 2]| 293.0 + 40.0 * time as f32 * (1.0 - z / SIDE as f32);
    let quantity = surface.reference.iter().map(warm).collect();
    SurfaceFrame { step, surface: 0, origin: Vec3::from(ORIGIN), offsets, quantity }
}

/// What came of the window that ends with a step.
pub fn outcome(end: u64) -> WindowOutcome {
    let piece = |number: u32, share: f64| TornPiece {
        number,
        parent: 0,
        born: if number == 0 { 0 } else { TEARS },
        mass: share * MASS,
        area: share * SIDE * SIDE,
        frozen: false,
    };
    let torn = end > TEARS;
    let ledger = WindowLedger {
        mass: MASS,
        momentum: [0.0, 0.0, -0.01],
        kinetic: 0.02,
        stretching: 0.005,
        gravity: 1e-3,
        broken: if torn && end <= TEARS + EVERY { 0.004 } else { 0.0 },
        residual: if end == 2 * EVERY { -2e-5 } else { 1e-6 },
        torn_area: if torn { SIDE * 2e-4 } else { 0.0 },
        ..WindowLedger::default()
    };
    let pieces = if torn { vec![piece(1, 0.525), piece(2, 0.475)] } else { vec![piece(0, 1.0)] };
    WindowOutcome { ledger, pieces, ..WindowOutcome::default() }
}

/// Takes note of it.
pub fn begin(recorder: &mut Recorder) {
    let (name, material) = ("towel".to_owned(), "paper".to_owned());
    recorder.sheet(SheetAbout { number: SHEET, name, material });
}

/// What is told of it at a step: a frame and the window that ends there, where these are due.
///
/// # Errors
/// The file cannot be written.
pub fn step(recorder: &mut Recorder, step: u64) -> Result<(), RecordError> {
    if !step.is_multiple_of(EVERY) {
        return Ok(());
    }
    let time = step as f64 * STEP;
    recorder.sheet_frame(SHEET, time, &surface(step >= TEARS), &frame(step))?;
    let Some(first_step) = step.checked_sub(EVERY) else { return Ok(()) };
    let digest = |what: &str| *blake3::hash(format!("{what} {step}").as_bytes()).as_bytes();
    recorder.window(&SolvedWindow {
        sheet: SHEET,
        first_step,
        steps: EVERY as u32,
        time,
        job: digest("job"),
        state: digest("state"),
        gap: if step == 3 * EVERY { 2e-5 } else { 0.0 },
        solved: 1,
        one_way: true,
        outcome: &outcome(step),
    })
}
