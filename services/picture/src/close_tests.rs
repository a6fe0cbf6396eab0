//! Close views, and sheets of asked moments, of a run made by hand: a cube falls onto a slab and
//! splits in two.

use super::tests::recorded;
use super::track::{Actor, Mesh};
use super::*;
use cullet_geometry::{Pose, Vec3};
use cullet_record::{palette, synthetic};
use std::sync::Arc;

/// Small pictures.
const SMALL: (usize, usize) = (120, 80);

/// Whether all corners of an object's bodies at a time are in the picture.
fn shown(track: &Track, focus: &Focus, object: &str, time: f64) -> bool {
    let own = track.present(time).filter(|(_, a, _)| a.object == object && !a.is_grain());
    let corners: Vec<Vec3> = own.flat_map(|(_, actor, pose)| actor.corners(pose)).collect();
    assert!(!corners.is_empty(), "nothing of {object} is there at {time} s");
    corners.iter().all(|corner| {
        let seen = focus.camera.project(focus.camera.local(*corner));
        (0.0..=SMALL.0 as f64).contains(&seen.x) && (0.0..=SMALL.1 as f64).contains(&seen.y)
    })
}

#[test]
fn a_close_view_has_the_whole_struck_body_until_a_second_later() {
    let dir = tempfile::tempdir().expect("folder");
    let recording = recorded(dir.path());
    let track = Track::of(&recording);
    let of = |framing: Framing| focus(&track, &recording, (&framing, SMALL)).expect("a view");
    let (whole, near) = (of(Framing::Whole), of(Framing::Struck));
    assert!(near.reach < 0.9 * whole.reach, "{} of {}", near.reach, whole.reach);
    assert!((near.camera.forward - whole.camera.forward).norm() < 1e-12, "another direction");
    for time in [0.395, 0.41, 0.5, 0.7, 1.0] {
        assert!(shown(&track, &near, "cube", time), "the cube is cut off at {time} s");
    }
    // The fall is not in it, nor the slab, which was struck and stays whole.
    assert!(!shown(&track, &near, "cube", 0.0) && !shown(&track, &near, "slab", 0.5));
    assert_eq!(of(Framing::Body("cube".into())).camera, near.camera);
    let slab = of(Framing::Body("slab".into()));
    assert!(shown(&track, &slab, "slab", 0.5));
}

#[test]
fn a_body_that_is_not_there_is_reported_with_those_that_are() {
    let dir = tempfile::tempdir().expect("folder");
    let recording = recorded(dir.path());
    let wrong = Framing::Body("vase".to_owned());
    let why = framed(&recording, dir.path(), &wrong).expect_err("no such body").to_string();
    assert!(why.ends_with("no body is called \"vase\"; there are cube, slab"), "{why}");
    assert!(!dir.path().join("preview.png").exists());
    let file = dir.path().join("still.png");
    let still_of = |framing| {
        let wanted = Still { time: StillTime::At(0.5), size: SMALL, framing };
        still(&recording, &wanted, &file).map(|_| std::fs::read(&file).expect("a picture"))
    };
    still_of(wrong).expect_err("no such body");
    let cube = still_of(Framing::Body("cube".to_owned())).expect("a still");
    assert!(cube == still_of(Framing::Struck).expect("a still"), "only the cube breaks");
    assert!(cube != still_of(Framing::Body("slab".to_owned())).expect("a still"));
}

/// A block that breaks at 0.1 s into pieces at these places, each of half edges of so much \[m\].
fn broken(pieces: &[(Vec3, f64)]) -> Track {
    let (outer, inner) = palette::colours("brick", "brick", 0);
    let actor = |id: u64, half: f64, (since, place): (f64, Vec3), end: f64| Actor {
        id,
        object: "vase".to_owned(),
        share: None,
        fragment: id > 0,
        deformed: false,
        fixed: false,
        outer,
        inner,
        mesh: Arc::new(Mesh::of(&synthetic::block(Vec3::repeat(half), 0.0))),
        rows: vec![(since, Pose::translation(place.x, place.y, place.z))],
        velocities: vec![Vec3::zeros()],
        end,
    };
    let mut track = Track { end: 2.0, ..Track::empty(0.01, Vec3::z()) };
    track.actors.push(actor(0, 0.1, (0.0, Vec3::zeros()), 0.1));
    track.breaks.push((0.1, 0));
    for (id, &(place, half)) in (1..).zip(pieces) {
        track.actors.push(actor(id, half, (0.1, place), f64::INFINITY));
    }
    track
}

#[test]
fn pieces_that_are_shot_away_and_chips_do_not_push_the_camera_off() {
    let view = |pieces: &[(Vec3, f64)]| {
        let track = broken(pieces);
        let whole = direct::focus(&track, &std::collections::BTreeMap::new(), SMALL);
        let near = close::focus(&track, &whole, None, SMALL);
        assert!(shown(&track, &near, "vase", 0.05), "the whole body is cut off");
        near.reach
    };
    let heap = [(Vec3::zeros(), 0.05), (Vec3::x() * 0.04, 0.05), (Vec3::y() * -0.04, 0.05)];
    let with = |more: &[(Vec3, f64)]| view(&[&heap[..], more].concat());
    let alone = with(&[]);
    assert_eq!(with(&[(Vec3::new(30.0, 0.0, 9.0), 0.05)]), alone, "one is far away");
    assert_eq!(with(&[(Vec3::new(0.2, 0.1, 0.1), 0.005)]), alone, "a chip");
    let beside = with(&[(Vec3::x() * 0.3, 0.05)]);
    assert!(beside > 1.2 * alone, "a piece beside it is shown: {beside} of {alone}");
}

#[test]
fn a_sheet_of_asked_moments_has_a_row_per_run_and_a_column_per_time() {
    let dir = tempfile::tempdir().expect("folder");
    let (recording, file) = (recorded(dir.path()), dir.path().join("sheet.png"));
    let runs = ["seed=1", "seed=2"].map(|text| (dir.path().join("run.mcap"), text.to_owned()));
    let view = SheetView { times: vec![0.1, 0.45, 7.0], framing: Framing::Struck };
    side_by_side(&runs, &view, &file).expect("draws");
    let track = Track::of(&recording);
    let near = focus(&track, &recording, (&Framing::Struck, SIZE)).expect("a view");
    let mut due = Vec::new();
    for (_, text) in &runs {
        for time in [0.1, 0.45] {
            let mut picture = Reel::new(&track, &near, SIZE).draw(time);
            picture.caption(&format!("{text}  {}", caption(&track, time)), Typeface::SMALL);
            due.push(picture);
        }
        let mut over = Picture::filled(SIZE.0, SIZE.1, BEHIND);
        over.caption(&format!("{text}  ends at 1.000 s"), Typeface::SMALL);
        due.push(over);
    }
    let due = sheet_of(&due, 3);
    assert_eq!((due.width, due.height), (3 * 486 + 6, 2 * 326 + 6));
    let wanted = dir.path().join("due.png");
    due.save(&wanted).expect("writes");
    assert!(std::fs::read(file).expect("reads") == std::fs::read(wanted).expect("reads"));
}
