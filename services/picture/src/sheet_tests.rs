//! Pictures of a sheet made by hand.

use super::*;
use cullet_geometry::Vec3;
use cullet_proto::recording::{SheetFrame, SheetSurface, surface_hash};
use cullet_record::synthetic::{self, STEP, waving};

const SMALL: (usize, usize) = (160, 120);

fn recorded(dir: &Path) -> Recording {
    let path = dir.join("run.mcap");
    synthetic::run_with_sheet(&path, &synthetic::meta()).expect("records");
    Recording::open(&path).expect("opens")
}

fn moment(track: &Track, time: f64) -> Picture {
    let focus = direct::focus(track, &std::collections::BTreeMap::new(), SMALL);
    Reel::new(track, &focus, SMALL).draw(time)
}

/// How many pixels differ.
fn differing(a: &Picture, b: &Picture) -> usize {
    a.rgb.chunks_exact(3).zip(b.rgb.chunks_exact(3)).filter(|(a, b)| a != b).count()
}

#[test]
fn a_sheet_is_drawn_where_it_is_and_moves() {
    let dir = tempfile::tempdir().expect("folder");
    let recording = recorded(dir.path());
    let track = Track::of(&recording);
    let mut bare = Track::of(&recording);
    bare.sheets.clear();
    // The same view of both.
    let focus = direct::focus(&track, &std::collections::BTreeMap::new(), SMALL);
    let shot = |track: &Track, time: f64| Reel::new(track, &focus, SMALL).draw(time);
    let seen = differing(&shot(&track, 0.1), &shot(&bare, 0.1));
    assert!(seen > SMALL.0 * SMALL.1 / 20, "{seen} pixels show it");
    assert!(track.sheets[0].at(-0.1).is_none(), "not before its first frame");
}

fn places(track: &Track, time: f64) -> Vec<Vec3> {
    track.sheets[0].at(time).expect("is there").places().to_vec()
}

#[test]
fn between_two_frames_it_is_on_the_straight_way_unless_it_tears_there() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let frame = |k: f64| k * waving::EVERY as f64 * STEP;
    let (from, to) = (places(&track, frame(2.0)), places(&track, frame(3.0)));
    assert!(from.iter().zip(&to).any(|(a, b)| (a - b).norm() > 1e-3));
    for share in [0.0, 0.25, 0.5, 0.9] {
        let found = places(&track, frame(2.0 + share));
        for (found, (a, b)) in found.iter().zip(from.iter().zip(&to)) {
            assert!((found - (a + (b - a) * share)).norm() < 1e-9, "at {share}");
        }
    }
    // The last frame of the whole surface holds until the torn one is there.
    let tear = (waving::TEARS / waving::EVERY) as f64;
    assert_eq!(places(&track, frame(tear - 0.1)), places(&track, frame(tear - 1.0)));
    assert_ne!(places(&track, frame(tear)).len(), places(&track, frame(tear - 0.1)).len());
}

/// Of a sheet that is seen from below nothing is missing.
#[test]
fn both_sides_are_seen_and_lit_by_the_normal_that_faces_the_eye() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let seen = |eye: f64| {
        let towards = Vec3::new(0.55, 0.0, 0.7);
        let ends = (towards + Vec3::y() * eye, towards);
        let camera = camera::Camera::look(ends, Vec3::z(), 40.0, SMALL);
        let mut buffers = raster::Buffers::tinted(SMALL.0, SMALL.1);
        let (who, sheet, places) = track.sheets_at(0.1).next().expect("is there");
        sheet.draw(&mut buffers, (&camera, 1e-3), who, &places);
        let mut count = 0_usize;
        for (index, _) in buffers.who.iter().enumerate().filter(|(_, it)| **it == who) {
            let normal = Vec3::from(buffers.normal[index].map(f64::from));
            assert!(normal.dot(&camera.forward) < 0.0, "{normal} faces away");
            assert!((0.0..=1.0).contains(&buffers.tint[index]), "{}", buffers.tint[index]);
            count += 1;
        }
        count
    };
    let (front, back) = (seen(-2.0), seen(2.0));
    assert!(front > 500 && front.abs_diff(back) < front / 10, "{front} and {back}");
}

#[test]
fn colours_show_the_quantity_and_the_material_where_there_is_none() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = recorded(dir.path());
    let tinted = Track::of(&recording);
    recording.sheet_frames.iter_mut().for_each(|frame| frame.quantity.clear());
    let plain = Track::of(&recording);
    assert_eq!((tinted.sheets[0].is_tinted(), plain.sheets[0].is_tinted()), (true, false));
    // Its lower edge is warm at last, its upper edge never: that looks like paper.
    let count = |picture: &Picture, wanted: fn([u8; 3]) -> bool| {
        let pixels = picture.rgb.as_chunks::<3>().0.iter();
        pixels.filter(|rgb| wanted(**rgb)).count()
    };
    let orange = |[r, g, b]: [u8; 3]| r > 140 && r > g + 30 && g > b;
    let (warm, cold) = (moment(&tinted, 1.0), moment(&plain, 1.0));
    assert!(count(&warm, orange) > 100 + count(&cold, orange), "{}", count(&warm, orange));
    let blue = |[r, _, b]: [u8; 3]| b > r && b > 60 && r < 60;
    assert_eq!(count(&warm, blue), count(&cold, blue), "no cold end of a rainbow");
    // What is the same everywhere and always shows nothing.
    recording.sheet_frames.iter_mut().for_each(|frame| {
        frame.quantity = vec![300.0; frame.offsets.len() / 3];
    });
    assert!(!Track::of(&recording).sheets[0].is_tinted());
}

/// Seen along its plane it is a line half a pixel wide at least, and of its own thickness where
/// that is more.
#[test]
fn edge_on_it_is_still_seen() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = recorded(dir.path());
    let flat = recording.sheet_frames[0].clone();
    let offsets = |frame: &mut SheetFrame| {
        // Without its wave it is flat.
        frame.offsets.iter_mut().skip(1).step_by(3).for_each(|y| *y = 0.0);
    };
    recording.sheet_frames = vec![flat];
    recording.sheet_frames.iter_mut().for_each(offsets);
    let shown = |recording: &Recording| {
        let track = Track::of(recording);
        // A little beside its plane, for lines between pixels belong to none.
        let towards = Vec3::new(0.55, 0.003, 0.7);
        let camera =
            camera::Camera::look((towards + Vec3::x() * 2.0, towards), Vec3::z(), 40.0, SMALL);
        let mut buffers = raster::Buffers::new(SMALL.0, SMALL.1);
        let (who, sheet, places) = track.sheets_at(0.0).next().expect("is there");
        sheet.draw(&mut buffers, (&camera, 1e-3), who, &places);
        buffers.who.iter().filter(|it| **it == who).count()
    };
    let thin = shown(&recording);
    // It is 0.6 m high, 1.7 m away or a little more: some fifty pixels, one wide.
    assert!((30..130).contains(&thin), "{thin} pixels");
    let mut thicker = waving::surface(false);
    thicker.thickness = 0.06;
    let hash = surface_hash(&thicker).to_vec();
    recording.surfaces.insert(hash.clone(), SheetSurface::from(&thicker));
    recording.sheet_frames[0].surface = hash;
    let thick = shown(&recording);
    assert!(thick > 4 * thin, "{thick} pixels");
}

#[test]
fn the_view_takes_it_in() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let none = std::collections::BTreeMap::new();
    let focus = direct::focus(&track, &none, SMALL);
    for focus in [focus, direct::close(&track, &focus, None, (0.4, SMALL))] {
        let (.., at) = track.sheets_at(0.4).next().expect("is there");
        let inside = at.places().iter().filter(|place| {
            let seen = focus.camera.project(focus.camera.local(**place));
            (0.0..SMALL.0 as f64).contains(&seen.x) && (0.0..SMALL.1 as f64).contains(&seen.y)
        });
        let count = inside.count();
        assert!(count as f64 > 0.97 * at.places().len() as f64, "{count}");
    }
}

/// The recording without what its rigid bodies do.
fn alone(dir: &Path) -> Recording {
    let mut recording = recorded(dir);
    recording.events.clear();
    recording.bodies.retain(|body| body.parent.is_none());
    recording
}

#[test]
fn a_still_shows_half_of_the_tear() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = alone(dir.path());
    // It tears on, evenly, from one time to the end.
    let tears = waving::TEARS as f64 * STEP;
    for window in &mut recording.windows {
        let ledger = window.ledger.as_mut().expect("has one");
        ledger.torn_area = (window.time - tears).max(0.0);
    }
    let track = Track::of(&recording);
    let half = 0.5 * (tears + track.end);
    let shown = moment::shown(&track);
    assert!((half..half + 1.1 * waving::EVERY as f64 * STEP).contains(&shown), "{shown} s");
    assert_eq!(direct::window(&track), (0.0, track.end));
    let moments = direct::moments(&track);
    let even = |k: usize| (moments[k] - track.end * k as f64 / 7.0).abs() < 1e-9;
    assert!([0, 1, 2, 3, 5, 6, 7].into_iter().all(even), "{moments:?}");
    let late = moments[4] - tears - waving::EVERY as f64 * STEP;
    assert!((0.0..2.0 * STEP).contains(&late), "just after the first tear: {moments:?}");
    let (before, after) = (caption(&track, tears - 0.01), caption(&track, tears + 0.1));
    assert_eq!((&before[..], &after[..]), ("0.490 s", "0.600 s  in 2 pieces"));
    let crumb = cullet_proto::recording::SheetPiece { area: 0.0, ..Default::default() };
    recording.windows.iter_mut().for_each(|window| window.pieces.extend([crumb; 2]));
    recording.windows.iter_mut().for_each(|window| {
        let (name, unit) = ("points".to_owned(), "1".to_owned());
        window.figures.push(cullet_proto::recording::ReportFigure { name, unit, value: 1000.0 });
    });
    recording.holes.parts = 1;
    let counted = caption(&Track::of(&recording), tears + 0.1);
    let due = "0.600 s  in 4 pieces, 2 of them crumbs  (the recording has holes)";
    assert_eq!(counted, due, "as `sheet_pieces` counts them");
}

#[test]
fn a_still_shows_its_pieces_or_its_farthest_way_where_nothing_tears() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = alone(dir.path());
    let nothing_torn = |recording: &mut Recording| {
        for window in &mut recording.windows {
            window.ledger.as_mut().expect("has one").torn_area = 0.0;
        }
    };
    nothing_torn(&mut recording);
    let due = (waving::TEARS + waving::EVERY) as f64 * STEP;
    let shown = moment::shown(&Track::of(&recording));
    assert!((shown - due).abs() < 1e-9, "{shown} s: the window after it came apart");
    let first_tear = |recording: &Recording| Track::of(recording).sheets[0].find_first_tear();
    assert!(first_tear(&recording).is_some_and(|time| (time - due).abs() < 1e-9));
    let parts = recording.windows.last().expect("a window").pieces.clone();
    recording.windows.iter_mut().for_each(|window| window.pieces.clone_from(&parts));
    assert_eq!(first_tear(&recording), None, "what is in parts from the start does not tear");
    recording.windows.clear();
    // It swings out and back.
    for frame in &mut recording.sheet_frames {
        let way = 0.5 - (frame.time - 0.7).abs();
        frame.offsets.iter_mut().skip(1).step_by(3).for_each(|y| *y = way as f32);
    }
    let shown = moment::shown(&Track::of(&recording));
    assert!((shown - 0.7).abs() < 0.7 * waving::EVERY as f64 * STEP, "{shown} s");
    // Where a rigid body breaks, that is the moment.
    let whole = recorded(dir.path());
    recording.events = whole.events;
    recording.bodies = whole.bodies;
    let broke = synthetic::BREAK as f64 * STEP;
    let shown = moment::shown(&Track::of(&recording));
    assert!((broke..broke + 0.05).contains(&shown), "{shown} s");
}

#[test]
fn what_is_kept_of_the_last_moment_is_what_would_be_drawn_anew() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = recorded(dir.path());
    // It stands still, and only its colours change.
    let still = recording.sheet_frames[0].offsets.clone();
    recording.sheet_frames.truncate(10);
    recording.sheet_frames.iter_mut().for_each(|frame| frame.offsets.clone_from(&still));
    let track = Track::of(&recording);
    let focus = direct::focus(&track, &std::collections::BTreeMap::new(), SMALL);
    let mut reel = Reel::new(&track, &focus, SMALL);
    let mut last: Option<Picture> = None;
    for time in [0.0, 0.1, 0.2, 0.3] {
        let anew = Reel::new(&track, &focus, SMALL).draw(time);
        assert!(reel.draw(time) == anew, "the moment at {time} s hangs on the one before it");
        assert!(last.is_none_or(|last| last != anew), "{time} s: its colours changed");
        last = Some(anew);
    }
}

#[test]
fn a_frame_that_is_damaged_is_left_out() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = recorded(dir.path());
    recording.sheet_frames[3].offsets.truncate(5);
    let track = Track::of(&recording);
    let frame = |k: f64| places(&track, k * waving::EVERY as f64 * STEP);
    let (from, to, found) = (frame(2.0), frame(4.0), frame(3.0));
    let off = |k: usize| (found[k] - (from[k] + to[k]) / 2.0).norm();
    assert!((0..found.len()).all(|k| off(k) < 1e-9), "its neighbours lead across it");
    recording.surfaces.clear();
    assert!(Track::of(&recording).sheets.is_empty());
    draw(&recording, dir.path(), (&Framing::Whole, SMALL)).expect("draws what is left");
}
