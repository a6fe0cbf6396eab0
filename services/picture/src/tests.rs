//! Pictures of a run made by hand.

use super::*;
use camera::Camera;
use cullet_geometry::Vec3;
use cullet_proto::recording::{EventKind, NewShape};
use cullet_proto::specimen::Frame;
use cullet_record::{palette, synthetic};

/// Small pictures: the tests ask what is in them, not how they look.
const SMALL: (usize, usize) = (120, 80);

pub(super) fn recorded(dir: &Path) -> Recording {
    let path = dir.join("run.mcap");
    synthetic::run(&path, &synthetic::meta()).expect("records");
    Recording::open(&path).expect("opens")
}

fn pictures(dir: &Path) -> (Vec<u8>, Vec<u8>) {
    let Pictures { sheet, film } =
        draw(&recorded(dir), dir, (&Framing::Whole, SMALL)).expect("draws");
    (std::fs::read(sheet).expect("reads"), std::fs::read(film).expect("reads"))
}

#[test]
fn equal_recordings_give_equal_pictures() {
    let (a, b) = (tempfile::tempdir().expect("folder"), tempfile::tempdir().expect("folder"));
    assert!(pictures(a.path()) == pictures(b.path()));
}

#[test]
fn a_sheet_is_as_wide_as_its_pictures() {
    let sheet = |count| contact_sheet(&vec![Picture::filled(20, 10, [0; 3]); count]);
    let size = |count| (sheet(count).width, sheet(count).height);
    assert_eq!([1, 2, 5].map(size), [(32, 22), (58, 22), (110, 38)]);
}

#[test]
fn recordings_side_by_side_are_shown_soon_after_they_break() {
    let dir = tempfile::tempdir().expect("folder");
    let (recording, file) = (recorded(dir.path()), dir.path().join("sheet.png"));
    let one = (dir.path().join("run.mcap"), "seed=1".to_owned());
    side_by_side(&[one.clone(), one], &SheetView::default(), &file).expect("draws");
    let track = Track::of(&recording);
    let time = moment::shown(&track);
    assert!(time < track.end, "{time}");
    let focus = direct::focus(&track, &recording.meta, SIZE);
    let mut picture = Reel::new(&track, &focus, SIZE).draw(time);
    picture.caption(&format!("seed=1  {}", caption(&track, time)), Typeface::SMALL);
    let due = dir.path().join("due.png");
    contact_sheet(&[picture.clone(), picture]).save(&due).expect("writes");
    assert!(std::fs::read(file).expect("reads") == std::fs::read(due).expect("reads"));
}

#[test]
fn sheet_and_film_are_what_they_claim() {
    let dir = tempfile::tempdir().expect("folder");
    let (sheet, film) = pictures(dir.path());
    let mut reader = png::Decoder::new(std::io::Cursor::new(sheet)).read_info().expect("is PNG");
    let mut rgb = vec![0; reader.output_buffer_size().expect("has a size")];
    let info = reader.next_frame(&mut rgb).expect("is whole");
    assert_eq!((info.width, info.height), (4 * 126 + 6, 2 * 86 + 6));
    let mut decoder = gif::DecodeOptions::new().read_info(&film[..]).expect("is GIF");
    let (mut frames, mut hundredths) = (0, 0);
    while let Some(frame) = decoder.read_next_frame().expect("is whole") {
        frames += 1;
        hundredths += u32::from(frame.delay);
    }
    assert!((20..=65).contains(&frames), "{frames}");
    assert!(hundredths <= 500, "{hundredths}");
}

/// A moment of the run as bytes, without a caption.
fn moment(track: &Track, time: f64) -> Picture {
    let focus = direct::focus(track, &std::collections::BTreeMap::new(), SMALL);
    reel::Reel::new(track, &focus, SMALL).draw(time)
}

/// Share of the pixels near a colour of the screen in hue: red over blue by that much at least.
fn warm(picture: &Picture, red_over_blue: f64) -> f64 {
    let is_warm = |rgb: &&[u8]| f64::from(rgb[0]) > red_over_blue * f64::from(rgb[2]).max(1.0);
    let pixels = picture.rgb.chunks_exact(3);
    let all = pixels.len() as f64;
    pixels.filter(is_warm).count() as f64 / all
}

#[test]
fn the_cube_is_seen_and_casts_a_shadow() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let falling = moment(&track, 0.3);
    assert!(warm(&falling, 1.6) > 0.02, "{}", warm(&falling, 1.6));
    // The cube is in the air: what is dark and not warm is its shadow on the floor.
    let dark = |rgb: &&[u8]| rgb.iter().all(|&c| c < 150) && rgb[0] < rgb[2].saturating_add(20);
    let shadow = falling.rgb.chunks_exact(3).filter(dark).count();
    assert!(shadow > 50, "{shadow}");
}

#[test]
fn pictures_change_when_the_cube_breaks_and_not_while_all_rests() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    assert_ne!(moment(&track, 0.39), moment(&track, 0.5));
    assert_eq!(moment(&track, 0.9), moment(&track, 0.95));
}

#[test]
fn grains_are_drawn_and_do_not_move_the_camera() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = recorded(dir.path());
    let track = Track::of(&recording);
    recording.debris.clear();
    let bare = Track::of(&recording);
    assert_eq!((track.specks.len(), bare.specks.len()), (2, 0));
    let none = std::collections::BTreeMap::new();
    let (one, two) = (direct::focus(&track, &none, SMALL), direct::focus(&bare, &none, SMALL));
    assert_eq!(one.camera, two.camera);
    assert_eq!(moment(&track, 0.3), moment(&bare, 0.3));
    assert_ne!(moment(&track, 0.5), moment(&bare, 0.5));
}

#[test]
fn cracks_that_end_inside_are_lines_that_move_with_their_body() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = recorded(dir.path());
    let track = Track::of(&recording);
    recording.cracks.clear();
    let bare = Track::of(&recording);
    assert_eq!((track.lines.len(), bare.lines.len()), (1, 0));
    let body = track.actors.iter().find(|actor| actor.id == 2).expect("a part");
    let line = &track.lines[0];
    assert!(line.at(0.3).is_none(), "not before it broke");
    for time in [0.45, 0.6, 0.9] {
        assert_eq!(line.at(time), body.at(time));
    }
    let none = std::collections::BTreeMap::new();
    let (one, two) = (direct::focus(&track, &none, SMALL), direct::focus(&bare, &none, SMALL));
    assert_eq!(one.camera, two.camera);
    assert_eq!(moment(&track, 0.3), moment(&bare, 0.3));
    assert_ne!(moment(&track, 0.6), moment(&bare, 0.6));
}

#[test]
fn a_still_is_a_picture_of_its_size() {
    let dir = tempfile::tempdir().expect("folder");
    let recording = recorded(dir.path());
    let file = dir.path().join("still.png");
    let wanted = Still { time: StillTime::Telling, size: (192, 108), framing: Framing::Whole };
    let time = still(&recording, &wanted, &file).expect("draws");
    assert!(time > 0.4, "after the break: {time}");
    let bytes = std::fs::read(&file).expect("reads");
    let reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().expect("is PNG");
    assert_eq!((reader.info().width, reader.info().height), (192, 108));
    let of = |time| still(&recording, &Still { time, ..wanted.clone() }, &file);
    let at = |time| of(StillTime::At(time));
    assert_eq!(of(StillTime::Last).expect("draws"), 1.0);
    assert_eq!(of(StillTime::Telling).expect("draws"), time);
    let why = at(9.0).expect_err("it has no such moment").to_string();
    assert!(why.ends_with("has no moment 9 s: it goes from 0 to 1 s"), "{why}");
    assert_eq!(at(1.0).expect("draws"), 1.0);
    assert_ne!(std::fs::read(&file).expect("reads"), bytes);
    let track = Track::of(&recording);
    let focus = direct::focus(&track, &recording.meta, SMALL);
    let near = direct::close(&track, &focus, None, (time, SMALL));
    assert!(near.reach < focus.reach, "{} of {}", near.reach, focus.reach);
    assert!((near.camera.forward - focus.camera.forward).norm() < 1e-12);
}

/// Large enough for parts of it to stay as they were.
const LARGER: (usize, usize) = (240, 160);

#[test]
fn what_is_kept_of_the_last_moment_is_what_would_be_drawn_anew() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let focus = direct::focus(&track, &std::collections::BTreeMap::new(), LARGER);
    let mut reel = reel::Reel::new(&track, &focus, LARGER);
    for time in [0.0, 0.05, 0.3, 0.39, 0.43, 0.5, 0.6, 0.9, 0.95, 0.1] {
        let anew = reel::Reel::new(&track, &focus, LARGER).draw(time);
        assert!(reel.draw(time) == anew, "the moment at {time} s hangs on the one before it");
    }
}

#[test]
fn samples_shaded_together_look_as_if_each_was_shaded_for_itself() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let focus = direct::focus(&track, &std::collections::BTreeMap::new(), LARGER);
    let mut reel = reel::Reel::new(&track, &focus, LARGER);
    for time in [0.2, 0.39, 0.5, 0.9] {
        let (fast, slow) = (reel.draw(time), reel.slow(time));
        let apart = fast.rgb.iter().zip(&slow.rgb).map(|(a, b)| a.abs_diff(*b));
        let (sum, most) = apart.fold((0, 0), |(sum, most), d| (sum + u64::from(d), d.max(most)));
        let mean = sum as f64 / fast.rgb.len() as f64;
        assert!(mean < 0.2 && most < 40, "{time} s: mean {mean}, most {most}");
    }
}

#[test]
fn what_flies_out_of_a_chosen_view_does_not_coarsen_its_shadows() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let view = |eye: &str| {
        let pairs = [("view.eye", eye), ("view.target", "0 0 0.1"), ("view.fov", "40")];
        let meta = pairs.map(|(key, value)| (key.to_owned(), value.to_owned())).into();
        direct::focus(&track, &meta, LARGER).reach
    };
    let (near, far) = (view("0 -0.2 0.1"), view("0 -50 0.1"));
    assert!((near - 0.2 * 20_f64.to_radians().tan() * 13_f64.sqrt() / 2.0).abs() < 1e-9, "{near}");
    assert!(far < 2.0, "what happens decides in a wide view: {far}");
}

#[test]
fn a_film_plays_back_as_it_was_drawn() {
    let mut frames = vec![Picture::filled(32, 16, [200, 210, 220]); 5];
    for (k, frame) in frames.iter_mut().enumerate() {
        for i in 0..6 {
            frame.set(4 * k + i, 3 + k, [180, 40, 30]);
        }
    }
    frames.push(frames[4].clone());
    let dir = tempfile::tempdir().expect("folder");
    let path = dir.path().join("film.gif");
    film::gif(&frames, 10.0, &path).expect("writes");
    let file = std::fs::File::open(&path).expect("opens");
    let mut decoder = gif::DecodeOptions::new().read_info(file).expect("is GIF");
    let colours = decoder.global_palette().expect("has one").to_vec();
    let mut screen = vec![0_u8; 32 * 16];
    for frame in &frames {
        let drawn = decoder.read_next_frame().expect("is whole").expect("is there");
        for (i, &pixel) in drawn.buffer.iter().enumerate() {
            let (x, y) = (i % usize::from(drawn.width), i / usize::from(drawn.width));
            let at = (y + usize::from(drawn.top)) * 32 + x + usize::from(drawn.left);
            if drawn.transparent != Some(pixel) {
                screen[at] = pixel;
            }
        }
        let shown = screen.iter().flat_map(|&p| &colours[3 * usize::from(p)..][..3]).copied();
        assert_eq!(shown.collect::<Vec<u8>>(), frame.rgb);
    }
    assert!(film::gif(&[], 10.0, &path).is_err());
}

#[test]
fn the_moments_show_the_break_and_the_end() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let moments = direct::moments(&track);
    let counts: Vec<usize> = moments
        .iter()
        .map(|&t| track.present(t).filter(|(_, actor, _)| actor.fragment).count())
        .collect();
    assert_eq!(counts, [0, 0, 2, 2, 2, 2, 2, 2]);
    assert!(moments.windows(2).all(|m| m[0] <= m[1]), "{moments:?}");
    assert!((moments[7] - track.end).abs() < 1e-9);
}

/// A dent is a moment to look at, and the body that has it the one to look at.
#[test]
fn the_moments_show_a_dent() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = recorded(dir.path());
    recording.events.clear();
    recording.bodies.retain(|body| body.parent.is_none());
    let struck = recording.bodies.iter().find(|body| body.id == 1).expect("the cube").clone();
    let step = recording.meta["step"].parse::<f64>().expect("a number");
    recording.shapes.push(NewShape {
        step: (0.6 / step) as u64,
        time: 0.6,
        body: 1,
        geometry: struck.geometry,
        mass: struck.mass,
        volume: struck.volume,
    });
    let track = Track::of(&recording);
    assert_eq!(direct::climax(&track), Some(0.6));
    let moments = direct::moments(&track);
    assert!(moments[1] < 0.6 && moments[2] > 0.6, "{moments:?}");
    let dented = track.actors.iter().filter(|actor| actor.deformed).map(|actor| actor.id);
    assert_eq!(dented.collect::<Vec<_>>(), [1, 1], "before and after");
}

/// Where joints break and no body does, the first of them is the first blow.
#[test]
fn the_moments_show_the_break_of_a_joint() {
    let dir = tempfile::tempdir().expect("folder");
    let mut recording = recorded(dir.path());
    recording.bodies.retain(|body| body.parent.is_none());
    let mut broken = recording.events[0].clone();
    recording.events.clear();
    (broken.kind, broken.body, broken.time) = (EventKind::JointBroken as i32, None, 0.2);
    recording.events.push(broken);
    let track = Track::of(&recording);
    assert_eq!(direct::climax(&track), Some(0.2));
    let moments = direct::moments(&track);
    assert!(moments[1] > 0.2 - track.step && moments[1] < 0.2, "{moments:?}");
    assert!(moments[2] > 0.2 && moments[2] < 0.25, "{moments:?}");
}

/// The cube falls out of a close view: the sheet and the film show it while it is there.
#[test]
fn no_moment_is_empty_where_bodies_leave_the_view() {
    let dir = tempfile::tempdir().expect("folder");
    let track = Track::of(&recorded(dir.path()));
    let cube = track.actors.iter().find(|actor| actor.id == 1).expect("the cube");
    let place = cube.at(0.0).expect("it is there").translation.vector;
    let camera = Camera::look((place + Vec3::y() * 2.0, place), track.up, 20.0, SMALL);
    let view = (&camera, SMALL);
    let shown = |time: f64| glimpse::take_glimpse(&track, view, time).in_view;
    assert!(shown(0.0) > 0.01 && shown(track.end) == 0.0, "it falls out of the view");
    let outline = direct::outline_run(&track, view);
    let moments = outline.choose_moments(direct::MOMENTS);
    assert_eq!(moments.len(), 8);
    assert!(moments.is_sorted() && moments.iter().all(|&time| shown(time) > 0.0), "{moments:?}");
    let (start, end) = outline.find_shown_span();
    assert!(shown(start) > 0.0 && shown(end) > 0.0 && end < 0.9, "{start} to {end}");
}

#[test]
fn the_scene_says_what_time_the_pictures_show() {
    let dir = tempfile::tempdir().expect("folder");
    let mut track = Track::of(&recorded(dir.path()));
    let first = direct::climax(&track).expect("something breaks");
    let (start, end) = (first - 2.0 * track.step, first + 10.0 * track.step);
    track.wanted = [Some(start), Some(end)];
    let moments = direct::moments(&track);
    assert!(moments[0] >= start && moments[1] < first, "{moments:?} from {start}");
    assert!((moments[7] - end).abs() < 1e-9, "{moments:?} to {end}");
    assert_eq!(direct::window(&track), (start, end));
    track.wanted = [Some(first + track.step), None];
    assert!(direct::moments(&track).iter().all(|&t| t > first), "after the break");
}

#[test]
fn crack_faces_and_surfaces_are_seen_in_their_own_colours() {
    let (outer, inner) = palette::colours("clay_brick", "cube", 1);
    let apart = (0..3).map(|i| (outer[i] - inner[i]).abs()).sum::<f32>();
    assert!(apart > 0.4, "{outer:?} {inner:?}");
}

#[test]
fn a_recording_without_anything_still_gives_pictures() {
    let dir = tempfile::tempdir().expect("folder");
    let path = dir.path().join("run.mcap");
    let recorder = cullet_record::Recorder::create(&path, &synthetic::meta()).expect("begins");
    recorder.finish(0, 0.0).expect("finishes");
    draw(&Recording::open(&path).expect("opens"), dir.path(), (&Framing::Whole, SMALL))
        .expect("draws");
}

#[test]
fn the_scale_of_points_has_the_colours_of_its_ends() {
    let point = |value: f32| [value, 2.0 * value, 0.5, value];
    let frame = |time, least: f32| Frame { time, points: [least, 3.0].map(point).to_vec() };
    let sheet = points::sheet(&[frame(0.0, 1.0), frame(1.0, 2.0)], "speed [m/s]");
    let row = |y: usize| -> Vec<[u8; 3]> {
        let pixels = sheet.rgb[3 * y * sheet.width..3 * (y + 1) * sheet.width].chunks_exact(3);
        pixels.map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect()
    };
    // Somewhere along the upper edge all colours stand side by side, from the least of all moments.
    let due = |share: f32| points::colour(1.0 + 2.0 * share, (1.0, 3.0));
    let all: Vec<[u8; 3]> = (0..120).map(|x| due(x as f32 / 119.0)).collect();
    let found = (0..24).any(|y| row(y).windows(all.len()).any(|part| part == all));
    assert!(found, "no scale");
    let none = points::sheet(&[Frame { time: 0.0, points: Vec::new() }], "speed [m/s]");
    assert!(!none.rgb.chunks_exact(3).any(|rgb| rgb == due(1.0)), "a scale of nothing");
}
