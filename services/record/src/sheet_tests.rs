//! Sheets held to what was told of them.

use super::synthetic::waving::{self, EVERY, POINTS, SHEET, TEARS};
use super::synthetic::{self, STEP, STEPS};
use super::*;
use cullet_geometry::Vec3;
use cullet_model::{Figure, TornPiece, WindowOutcome};
use cullet_proto::recording::{SheetWindow, schema_bytes, sheet_schema_bytes};
use std::collections::BTreeMap;
use std::path::Path;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn recorded(dir: &Path) -> Finished {
    synthetic::run_with_sheet(&dir.join("run.mcap"), &synthetic::meta()).expect("records")
}

fn opened() -> Recording {
    let dir = folder();
    Recording::open(&recorded(dir.path()).path).expect("opens")
}

#[test]
fn a_sheet_is_read_back_to_the_bit() {
    let recording = opened();
    let [sheet] = &recording.sheets()[..] else { panic!("{:?}", recording.sheets()) };
    assert_eq!((sheet.number, &sheet.name[..], &sheet.material[..]), (SHEET, "towel", "paper"));
    assert_eq!(sheet.frames.len() as u64, STEPS / EVERY + 1);
    assert_eq!(sheet.frames[2], FrameTime { step: 8, time: 8.0 * STEP });
    assert_eq!(recording.surfaces.len(), 2, "each surface once");
    for step in [0, 8, TEARS, STEPS] {
        let (torn, told) = (step >= TEARS, waving::frame(step));
        let moment = recording.sheet_at(SHEET, step).expect("is sound").expect("is there");
        assert_eq!(moment.surface, waving::surface(torn));
        assert_eq!(moment.quantity, told.quantity);
        let due = told.offsets.iter().map(|it| told.origin + Vec3::from(it.map(f64::from)));
        assert_eq!(moment.places, due.collect::<Vec<_>>());
    }
    // Between frames the last one holds.
    let moment = recording.sheet_at(SHEET, TEARS - 1).expect("is sound").expect("is there");
    assert_eq!(moment.at.step, TEARS - EVERY);
    assert_eq!(moment.places.len() as u32, POINTS * POINTS);
    assert_eq!(recording.sheet_at(SHEET + 1, 9).expect("no such sheet"), None);
}

#[test]
fn windows_have_their_ledger_and_their_pieces() {
    let recording = opened();
    let windows = recording.windows_of(SHEET).expect("are sound");
    assert_eq!(windows.len() as u64, STEPS / EVERY);
    for (k, sound) in (1..).zip(&windows) {
        let due = waving::outcome(k * EVERY);
        assert_eq!((sound.ledger, &sound.pieces), (due.ledger, &due.pieces));
        assert_eq!((sound.window.end_step(), sound.window.solved), (k * EVERY, 1));
        assert_eq!((sound.window.job.len(), sound.window.state.len()), (32, 32));
        assert!(sound.window.one_way);
    }
    assert_eq!(windows.last().expect("some").pieces[1].born, TEARS);
}

#[test]
fn the_summary_has_sheets_only_where_there_are_some() {
    let (with, without) = (folder(), folder());
    let finished = recorded(with.path());
    let totals = finished.summary.sheets.expect("there is one");
    assert_eq!((totals.sheets, totals.windows, totals.pieces), (1, STEPS / EVERY, 2));
    assert!((totals.torn_area - 0.6 * 2e-4).abs() < 1e-12, "{} m²", totals.torn_area);
    assert_eq!((totals.energy_residual, totals.gap), (2e-5, 2e-5));
    let due = 2e-5 / (0.02 + 0.005 + 1e-3);
    assert!((totals.energy_residual_rel - due).abs() < 1e-9, "{totals:?}");
    let read = inspect(&finished.path).expect("reads");
    assert_eq!(read.summary, finished.summary);
    let line = read.events.last().expect("a line");
    let due = "sheet 3 (towel): 2 pieces, 1.200e-4 m² torn, 31 frames, 30 windows; energy off by \
               2.000e-5 J at most (0.08 %), bodies by 2.000e-5 m; 30 of them one-way: bodies did \
               not feel it";
    assert_eq!(line, due);
    let bare = synthetic::run(&without.path().join("run.mcap"), &synthetic::meta());
    let bare = bare.expect("records").summary;
    assert!(!bare.to_json().contains("sheets") && bare.sheets.is_none());
    let back: Summary = serde_json::from_str(&finished.summary.to_json()).expect("is JSON");
    assert_eq!(back, finished.summary);
}

#[test]
fn crumbs_are_told_from_pieces() {
    let outcome = waving::outcome(TEARS + EVERY);
    let (mut window, one) = (SheetWindow::default().with(&outcome), outcome.pieces[1]);
    let area: f64 = outcome.pieces.iter().map(|piece| piece.area).sum();
    let mut told = |points: f64, shares: &[f64]| {
        let piece = |&share: &f64| TornPiece { area: share * area, ..one };
        let pieces = shares.iter().map(piece).collect();
        let name = "points".to_owned();
        let figures = vec![Figure { name, unit: "1".to_owned(), value: points }];
        window = window.clone().with(&WindowOutcome { pieces, figures, ..outcome.clone() });
        let mut census = SheetCensus::default();
        census.window(&window);
        let line = census.lines()[0].split(" m²").next().expect("a part").to_owned();
        (PieceCount::of(&window), line)
    };
    // Of 100 points six are no crumb, and five are one.
    assert_eq!(told(100.0, &[0.94, 0.06]).0, PieceCount { pieces: 2, crumbs: 0 });
    let (count, line) = told(100.0, &[0.83, 0.11, 0.05, 0.01]);
    let due = "sheet 0 (without a frame): 4 pieces, 2 of them crumbs, ";
    assert_eq!(count, PieceCount { pieces: 4, crumbs: 2 });
    assert!(line.starts_with(due), "{line}");
    assert_eq!(told(0.0, &[0.5, 0.5]).0.crumbs, 0, "of how many points is not known");
}

/// The digest of a run by hand whose sheet is told so.
fn digest(tell: impl Fn(&mut Recorder)) -> String {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    let mut recorder = synthetic::begin(&path, &synthetic::meta()).expect("begins");
    waving::begin(&mut recorder);
    tell(&mut recorder);
    recorder.finish(8, 8.0 * STEP).expect("finishes").summary.digest
}

#[test]
fn the_digest_covers_frames_states_and_surfaces() {
    let surface = waving::surface(false);
    let frame = |bit: u32| {
        let (surface, mut frame) = (surface.clone(), waving::frame(4));
        let number = &mut frame.offsets[7][1];
        *number = f32::from_bits(number.to_bits() ^ bit);
        digest(move |it| {
            it.sheet_frame(SHEET, 4.0 * STEP, &surface, &frame).expect("records");
        })
    };
    assert_eq!(frame(0), frame(0));
    assert_ne!(frame(0), frame(1));
    let window = |state: u8| {
        let outcome = waving::outcome(4);
        digest(move |it| {
            it.window(&solved(&outcome, [state; 32])).expect("records");
        })
    };
    assert_eq!(window(1), window(1));
    assert_ne!(window(1), window(2));
    assert_ne!(window(1), frame(0));
    // A sheet of which nothing was told is none.
    let none = digest(|_| ());
    let dir = folder();
    let recorder = synthetic::begin(&dir.path().join("run.mcap"), &synthetic::meta());
    let bare = recorder.expect("begins").finish(8, 8.0 * STEP).expect("finishes");
    assert_eq!(none, bare.summary.digest);
}

fn solved(outcome: &cullet_model::WindowOutcome, state: [u8; 32]) -> SolvedWindow<'_> {
    SolvedWindow {
        sheet: SHEET,
        first_step: 0,
        steps: 4,
        time: 4.0 * STEP,
        job: [9; 32],
        state,
        gap: 0.0,
        solved: 1,
        one_way: false,
        outcome,
    }
}

#[test]
fn what_is_told_is_held_to_its_order_and_its_numbers() {
    let dir = folder();
    let mut recorder =
        synthetic::begin(&dir.path().join("run.mcap"), &synthetic::meta()).expect("begins");
    let (surface, frame) = (waving::surface(false), waving::frame(4));
    let refused = |told: Result<[u8; 32], RecordError>| told.expect_err("refuses").to_string();
    let early = recorder.sheet_frame(SHEET, 4.0 * STEP, &surface, &frame);
    assert_eq!(refused(early), "sheet 3 was not recorded before its frame");
    waving::begin(&mut recorder);
    let mut wild = frame.clone();
    wild.offsets[3][2] = f32::NAN;
    let told = recorder.sheet_frame(SHEET, 4.0 * STEP, &surface, &wild);
    assert_eq!(refused(told), "sheet 3 at step 4: entry 11 of offsets is not finite");
    recorder.sheet_frame(SHEET, 4.0 * STEP, &surface, &frame).expect("is sound");
    let again = recorder.sheet_frame(SHEET, 4.0 * STEP, &surface, &frame);
    assert_eq!(refused(again), "sheet 3 at step 4: the one before it goes to step 4");
    let torn = recorder.sheet_frame(SHEET, 8.0 * STEP, &waving::surface(true), &waving::frame(8));
    let due = "sheet 3 at step 8: offsets has 1200 entries, 1260 are needed";
    assert_eq!(refused(torn), due);
    let outcome = waving::outcome(4);
    recorder.window(&solved(&outcome, [1; 32])).expect("is sound");
    let before = SolvedWindow { first_step: 3, ..solved(&outcome, [1; 32]) };
    let told = recorder.window(&before).expect_err("begins too early").to_string();
    assert_eq!(told, "sheet 3 at step 3: the one before it goes to step 4");
    let mut wild = waving::outcome(8);
    wild.ledger.air = f64::INFINITY;
    let after = SolvedWindow { first_step: 4, ..solved(&wild, [1; 32]) };
    let told = recorder.window(&after).expect_err("is no number").to_string();
    assert_eq!(told, "sheet 3 at step 4: entry 16 of the ledger is not finite");
}

#[test]
fn damage_is_an_error_that_names_its_sheet_and_step() {
    let good = opened();
    let refused = |damage: fn(&mut Recording)| {
        let mut bad = good.clone();
        damage(&mut bad);
        bad.sheet_at(SHEET, 8).expect_err("is damaged").to_string()
    };
    let text = refused(|it| it.surfaces.clear());
    assert_eq!(text, "sheet 3 at step 8: its surface was not recorded");
    let text = refused(|it| it.surfaces.values_mut().for_each(|it| it.reference[0] += 1.0));
    assert_eq!(text, "sheet 3 at step 8: the content does not match its digest");
    let text = refused(|it| it.sheet_frames[2].quantity.truncate(9));
    assert_eq!(text, "sheet 3 at step 8: quantity has 9 entries, 400 are needed");
    let text = refused(|it| it.sheet_frames[2].time = f64::NAN);
    assert_eq!(text, "sheet 3 at step 8: entry 0 of time is not finite");
    let mut bad = good.clone();
    bad.windows.swap(3, 4);
    let text = bad.windows_of(SHEET).expect_err("runs back").to_string();
    assert_eq!(text, "sheet 3 at step 12: the one before it goes to step 20");
    bad.windows[5].state.pop();
    bad.windows.swap(3, 4);
    let text = bad.windows_of(SHEET).expect_err("is short").to_string();
    assert_eq!(text, "sheet 3 at step 20: state has 31 entries, 32 are needed");
}

/// Schema and number of the messages of each topic.
type Topics = BTreeMap<String, (Vec<u8>, u64)>;

/// What is in the file, and which topics the layout shows.
fn topics(path: &Path) -> (Topics, Vec<String>) {
    let bytes = std::fs::read(path).expect("reads");
    let mut topics = Topics::new();
    for message in mcap::MessageStream::new(&bytes).expect("is MCAP") {
        let channel = message.expect("is whole").channel;
        let schema = channel.schema.as_ref().map(|it| it.data.to_vec()).unwrap_or_default();
        topics.entry(channel.topic.clone()).or_insert((schema, 0)).1 += 1;
    }
    let recording = Recording::open(path).expect("opens");
    let layout: serde_json::Value =
        serde_json::from_slice(&recording.attachments["layout.json"]).expect("is JSON");
    let shown = layout["configById"]["3D!scene"]["topics"].as_object().expect("topics");
    let visible = shown.iter().filter(|(_, it)| it["visible"] == true);
    (topics, visible.map(|(name, _)| name.clone()).collect())
}

#[test]
fn other_messages_keep_their_schema_and_sheets_have_one_of_theirs() {
    let dir = folder();
    let (topics, _) = topics(&recorded(dir.path()).path);
    assert_eq!(topics[BODY].0, schema_bytes());
    for (topic, count) in
        [(SHEETS, STEPS / EVERY + 1), (SHEET_SURFACE, 2), (WINDOWS, STEPS / EVERY)]
    {
        assert!(topics[topic].0 == sheet_schema_bytes(), "{topic}");
        assert_eq!(topics[topic].1, count, "{topic}");
    }
}

#[test]
fn viewers_get_a_drawing_a_frame_if_drawings_are_on() {
    let dir = folder();
    let (drawn, shown) = topics(&recorded(dir.path()).path);
    assert_eq!(drawn["/scene/sheets/towel"].1, STEPS / EVERY + 1);
    assert!(shown.contains(&"/scene/sheets/towel".to_owned()), "{shown:?}");
    let mut meta = synthetic::meta();
    meta.drawings = false;
    let path = dir.path().join("bare.mcap");
    let bare = synthetic::run_with_sheet(&path, &meta).expect("records");
    let (drawn, shown) = topics(&path);
    assert!(!drawn.keys().any(|topic| topic.starts_with("/scene/")), "{drawn:?}");
    assert!(!shown.iter().any(|topic| topic.starts_with("/scene/")), "{shown:?}");
    assert_eq!(bare.summary.digest, recorded(dir.path()).summary.digest);
}

#[test]
fn a_recording_with_a_sheet_that_was_cut_off_is_recovered() {
    let dir = folder();
    let path = dir.path().join("run.mcap");
    let mut recorder = synthetic::begin(&path, &synthetic::meta()).expect("begins");
    waving::begin(&mut recorder);
    for step in 0..=2 * EVERY {
        waving::step(&mut recorder, step).expect("records");
        synthetic::step(&mut recorder, step).expect("records");
    }
    recorder.sink.flush().expect("flushes");
    drop(recorder);
    let saved = dir.path().join("saved.mcap");
    recover(&path, &saved).expect("recovers");
    let recording = Recording::open(&saved).expect("opens");
    assert_eq!((recording.sheet_frames.len(), recording.windows.len()), (3, 2));
    assert!(recording.sheet_at(SHEET, 99).expect("is sound").is_some());
}
