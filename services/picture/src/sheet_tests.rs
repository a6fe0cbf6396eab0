//! Pictures of a sheet made by hand.

use super::*;
use cullet_geometry::Vec3;
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
    // Between two frames the first of them holds.
    let frame = waving::EVERY as f64 * STEP;
    let at = |share: f64| track.sheets[0].at((2.0 + share) * frame).expect("is there").places();
    assert_eq!(at(0.1), at(0.9));
    assert_ne!(at(0.9), at(1.1));
    assert!(track.sheets[0].at(-0.1).is_none(), "not before its first frame");
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
        sheet.draw(&mut buffers, (&camera, 1e-3), who, places);
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
    // Its lower edge is warm at last, its upper edge never.
    let reds = |picture: &Picture| {
        let red = |rgb: &&[u8]| rgb[0] > 2 * rgb[2].max(20);
        picture.rgb.chunks_exact(3).filter(red).count()
    };
    let shot = moment(&tinted, 1.0);
    assert!(reds(&shot) > 40 + reds(&moment(&plain, 1.0)), "{}", reds(&shot));
}

#[test]
fn the_view_takes_it_in() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let none = std::collections::BTreeMap::new();
    let focus = direct::focus(&track, &none, SMALL);
    for focus in [focus, direct::close(&track, &focus, 0.4, SMALL)] {
        let (.., at) = track.sheets_at(0.4).next().expect("is there");
        let inside = at.places().iter().filter(|place| {
            let seen = focus.camera.project(focus.camera.local(**place));
            (0.0..SMALL.0 as f64).contains(&seen.x) && (0.0..SMALL.1 as f64).contains(&seen.y)
        });
        let count = inside.count();
        assert!(count as f64 > 0.97 * at.places().len() as f64, "{count}");
    }
}

#[test]
fn its_tear_is_a_moment_to_look_at() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = recorded(dir.path());
    recording.events.clear();
    recording.bodies.retain(|body| body.parent.is_none());
    let track = Track::of(&recording);
    let tears = waving::TEARS as f64 * STEP;
    assert_eq!(direct::climax(&track), Some(tears));
    assert_eq!(direct::window(&track), (0.0, track.end));
    let (before, after) = (caption(&track, tears - 0.01), caption(&track, tears + 0.1));
    assert_eq!((&before[..], &after[..]), ("0.490 s", "0.600 s  sheet in 2 pieces"));
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
    let third = 3.2 * waving::EVERY as f64 * STEP;
    let places = |time: f64| track.sheets[0].at(time).expect("is there").places();
    assert_eq!(places(third), places(third - 4.0 * STEP));
    recording.surfaces.clear();
    assert!(Track::of(&recording).sheets.is_empty());
    draw(&recording, dir.path(), SMALL).expect("draws what is left");
}
