//! Recordings that were cut off or damaged: recovery, reading, and solids out of their columns.

use super::bytes::{INPUT, damaged};
use super::timed;
use cullet_geometry::{Pose, Solid, Surface, Vec3, shapes};
use cullet_proto::recording::{Body, Geometry, Tier};
use cullet_record::{Event, PoseRow, Recorder, RunMeta, Touch, inspect, recover};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn place(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{name}"))
}

fn cube() -> Solid {
    let mesh = shapes::cuboid(Vec3::repeat(0.1), shapes::Detail::default()).expect("a box");
    let mut solid = Solid::outer(mesh);
    solid.surface[0] = Surface::crack(2e-5);
    solid.surface[1] = Surface::crack(3e-5);
    solid
}

/// A cube that falls for a second, recorded.
fn recorded() -> Vec<u8> {
    let path = place("seed.mcap");
    let meta = RunMeta {
        scene: "fall".to_owned(),
        seed: 7,
        version: "0".to_owned(),
        scene_text: "[world]\nduration = 1.0\n".to_owned(),
        files: vec![("note.txt".to_owned(), b"by hand".to_vec())],
        step: 0.01,
        duration: 1.0,
        gravity: Vec3::new(0.0, 0.0, -9.81),
        materials: BTreeMap::from([("brick".to_owned(), "E 15 GPa".to_owned())]),
        view: None,
        interiors: BTreeMap::new(),
        painted: 0,
        drawings: true,
        deterministic: true,
    };
    let mut recorder = Recorder::create(&path, &meta).expect("a recording");
    let geometry = recorder.geometry(&cube()).expect("a solid").to_vec();
    let body = Body {
        id: 1,
        name: "cube".to_owned(),
        object: "cube".to_owned(),
        tier: Tier::Whole as i32,
        material: "brick".to_owned(),
        geometry,
        mass: 2.0,
        volume: 0.001,
        ..Body::default()
    };
    recorder.body(&body).expect("a body");
    let (point, job) = (Vec3::zeros(), [3; 32]);
    for step in 0..=100 {
        let time = step as f64 * 0.01;
        let row = PoseRow {
            id: 1,
            pose: Pose::translation(0.0, 0.0, -5.0 * time * time),
            velocity: Vec3::new(0.0, 0.0, -9.81 * time),
            spin: Vec3::zeros(),
        };
        recorder.poses(step, time, &[row]).expect("a pose");
        if step == 50 {
            let (impulse, closing_speed, energy) = (1.0, 2.0, 3.0);
            let (body, striker, contact) = (1, 0, Touch::default());
            let hit =
                Event::Impact { body, striker, point, impulse, closing_speed, energy, contact };
            recorder.event(step, time, &hit).expect("an event");
            let (solver, reason) = ("brittle".to_owned(), String::new());
            let opened = Event::JobOpened { body: 1, job, solver, reason, directed: false };
            recorder.event(step, time, &opened).expect("an event");
        }
    }
    recorder.finish(100, 1.0).expect("an end");
    std::fs::read(&path).expect("a recording")
}

/// The same with every chunk's check sum taken out: what is damaged inside is believed.
fn unchecked(mut bytes: Vec<u8>) -> Vec<u8> {
    let (mut at, mut chunks) = (8, 0);
    while at + 9 <= bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight bytes"));
        if bytes[at] == 0x06 {
            // start, end and size before it, 8 bytes each
            bytes[at + 9 + 24..at + 9 + 28].fill(0);
            chunks += 1;
        }
        at += 9 + length as usize;
    }
    assert!(chunks > 0, "the recording has chunks");
    bytes
}

#[test]
fn recovery() {
    let whole = recorded();
    let seeds = [whole.clone(), unchecked(whole)];
    let (from, to) = (place("damaged.mcap"), place("recovered.mcap"));
    bolero::check!().with_iterations(600).with_max_len(INPUT).for_each(|input: &[u8]| {
        let (_, bytes) = damaged(input, &seeds);
        std::fs::write(&from, &bytes).expect("a file");
        match timed("a recovery", || recover(&from, &to)) {
            Ok(saved) => {
                assert!(saved.lost_bytes <= bytes.len() as u64);
                let again = recover(&to, &place("again.mcap"));
                // Of one that is cut off at its very beginning nothing is left.
                if saved.messages + saved.attachments > 0 || again.is_ok() {
                    let again = again.expect("what was saved is whole");
                    assert!(again.damaged == 0, "{again}");
                    assert_eq!(again.complete, saved.holes.is_empty(), "{again}");
                    assert_eq!(again.messages, saved.messages);
                }
            }
            Err(error) => assert!(error.to_string().contains("fuzz-damaged.mcap"), "{error}"),
        }
        if let Err(error) = timed("a reading", || inspect(&from)) {
            assert!(!error.to_string().is_empty());
        }
    });
}

/// Columns of a recorded solid with numbers changed, doubled or gone: never a panic, and what
/// passes is the solid that was recorded.
#[test]
fn solids() {
    let good = Geometry::from(&cube());
    assert_eq!(Solid::try_from(&good), Ok(cube()));
    let check = bolero::check!().with_iterations(20_000).with_max_len(32);
    check.for_each(|input: &[u8]| {
        let mut bad = good.clone();
        for edit in input.chunks_exact(3) {
            let (at, value) = (usize::from(edit[1]), u32::from(edit[2]));
            let columns = [
                &mut bad.triangles,
                &mut bad.corner,
                &mut bad.interior_vertex,
                &mut bad.parent,
                &mut bad.material,
            ];
            let which = usize::from(edit[0]) % 10;
            match columns.into_iter().nth(which) {
                Some(column) if value % 3 == 0 => column.truncate(at % (column.len() + 1)),
                Some(column) if value % 3 == 1 => column.push(value),
                Some(column) if !column.is_empty() => {
                    let at = at % column.len();
                    column[at] = value.wrapping_mul(0x0101_0101);
                }
                Some(_) => {}
                None if which == 5 => bad.vertices.truncate(at % 25),
                None if which == 6 => bad.crack.iter_mut().for_each(|c| *c ^= edit[2]),
                None if which == 7 => bad.uv.truncate(at % 9),
                None if which == 8 => bad.damage_time.truncate(at % 7),
                None => bad.front_speed.truncate(at % 7),
            }
        }
        match Solid::try_from(&bad) {
            Ok(solid) => assert_eq!(solid, cube()),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    });
}
