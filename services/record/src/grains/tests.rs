use super::super::DEBRIS;
use super::super::found::Found;
use super::super::read::{load, walk};
use super::super::synthetic::{self, STEP};
use super::super::{Finished, Recording, RunDigest, inspect};
use super::*;
use cullet_proto::recording::Recorded;
use cullet_world::BodyId;
use std::path::Path;

/// Steps of the flight.
const FLIGHT: u64 = 60;
const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -9.81);
/// The grain that comes to rest while older ones fly, and the step.
const RESTS: (usize, u64) = (1, 20);
/// The grain that something pushes, and the step.
const PUSHED: (usize, u64) = (2, 30);

/// All grains after each step, moved as the world moves them: 40 are born at once, 10 later.
fn flight() -> Vec<Vec<DebrisParticle>> {
    let born = |id: u64| {
        let k = id as f64;
        let velocity = Vec3::new(libm::cos(k), libm::sin(k), 1.0 + 0.1 * k);
        DebrisParticle {
            id,
            parent: BodyId(1),
            mass: 1e-3,
            size: 1e-3,
            position: Vec3::new(0.1, 1.0 / (k + 3.0), 0.7),
            velocity,
            resting: false,
        }
    };
    let mut now: Vec<DebrisParticle> = Vec::new();
    let mut steps = Vec::new();
    for step in 0..FLIGHT {
        for (k, grain) in now.iter_mut().enumerate().filter(|(_, grain)| !grain.resting) {
            grain.velocity += GRAVITY * STEP;
            grain.position += grain.velocity * STEP;
            if (k, step) == RESTS || step + 1 == FLIGHT {
                (grain.velocity, grain.resting) = (Vec3::zeros(), true);
            }
            if (k, step) == PUSHED {
                grain.velocity.x += 0.25;
            }
        }
        match step {
            0 => now.extend((0..40).map(born)),
            10 => now.extend((40..50).map(born)),
            _ => {}
        }
        steps.push(now.clone());
    }
    steps
}

fn recorded(folder: &Path, steps: &[Vec<DebrisParticle>]) -> Finished {
    let path = folder.join("run.mcap");
    let mut recorder = synthetic::begin(&path, &synthetic::meta()).expect("begins");
    for (step, grains) in (0..).zip(steps) {
        recorder.grains(step, step as f64 * STEP, grains).expect("records");
    }
    recorder.finish(FLIGHT, FLIGHT as f64 * STEP).expect("finishes")
}

/// The messages of a file: topic and payload.
fn messages(path: &Path) -> Vec<(String, Vec<u8>)> {
    let (path, bytes) = load(path).expect("reads");
    let (mut topics, mut all) = (BTreeMap::new(), Vec::new());
    let mut take = |found: Found| {
        match found {
            Found::Channel(channel) => drop(topics.insert(channel.id, channel.topic)),
            Found::Message(header, data, _) => {
                all.push((topics[&header.channel_id].clone(), data));
            }
            _ => {}
        }
        Ok(())
    };
    walk(&path, &bytes, &mut take).expect("walks");
    all
}

fn on_debris(path: &Path) -> Vec<Grains> {
    let of_grains = messages(path).into_iter().filter(|(topic, _)| topic == DEBRIS);
    of_grains.map(|(_, data)| Grains::from_bytes(&data).expect("decodes")).collect()
}

/// The rows of a step as recordings had them before there was a short form.
fn long_rows(step: u64, grains: &[DebrisParticle]) -> Grains {
    let mut rows = Grains { step, time: step as f64 * STEP, ..Default::default() };
    grains.iter().for_each(|grain| put_grain(&mut rows, grain));
    rows
}

#[test]
fn reading_gives_every_row_to_the_last_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let steps = flight();
    let recording = Recording::open(&recorded(folder.path(), &steps).path).expect("reads");
    let mut last: BTreeMap<u64, Speck> = BTreeMap::new();
    let mut messages = recording.debris.iter().peekable();
    for (step, grains) in (0..).zip(&steps) {
        while let Some(rows) = messages.next_if(|rows| rows.step == step) {
            last.extend(exact(rows));
        }
        for grain in grains {
            let told = long_rows(step, std::slice::from_ref(grain));
            let (_, told) = exact(&told).next().expect("a row");
            assert_eq!(last[&grain.id].bits(), told.bits(), "grain {} at {step}", grain.id);
        }
    }
    assert!(messages.next().is_none());
}

#[test]
fn the_digest_is_that_of_the_long_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let steps = flight();
    let finished = recorded(folder.path(), &steps);
    let mut digest = RunDigest::default();
    let mut lying = 0;
    for (topic, data) in messages(&finished.path) {
        if topic != DEBRIS {
            digest.update(&topic, &data);
            continue;
        }
        let told = Grains::from_bytes(&data).expect("decodes");
        if !told.masses.is_empty() {
            digest.update(&topic, &data);
            continue;
        }
        let (now, before) = (&steps[told.step as usize], &steps[told.step as usize - 1]);
        while lying < before.len() && before[lying].resting {
            lying += 1;
        }
        let rows = long_rows(told.step, &now[lying..before.len()]);
        digest.update(&topic, &rows.to_bytes());
    }
    assert_eq!(digest.hex(), finished.summary.digest);
    assert_eq!(inspect(&finished.path).expect("reads").summary, finished.summary);
}

#[test]
fn a_grain_in_flight_takes_half_the_bytes_and_one_that_lies_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let steps = flight();
    let told = on_debris(&recorded(folder.path(), &steps).path);
    let (mut short, mut long) = (0, 0);
    for rows in told.iter().filter(|rows| rows.masses.is_empty()) {
        let now = &steps[rows.step as usize];
        short += rows.to_bytes().len();
        long += long_rows(rows.step, now).to_bytes().len();
        let tells = |grain: usize| {
            let id = grain as u64;
            (rows.ids.contains(&id), rows.flying.contains(&id))
        };
        let of_resting = match rows.step {
            step if step < RESTS.1 || step + 1 == FLIGHT => continue,
            step => (step == RESTS.1, false),
        };
        assert_eq!(tells(RESTS.0), of_resting, "step {}", rows.step);
        assert_eq!(tells(PUSHED.0), (rows.step == PUSHED.1, rows.step != PUSHED.1));
        for (id, at) in rows.flying.iter().zip(rows.flown_positions.as_chunks::<3>().0) {
            let exact = now[*id as usize].position;
            let off = Vec3::from(at.map(f64::from)) - exact;
            assert!(off.amax() <= 2f64.powi(-24) * exact.amax(), "{off}");
        }
    }
    assert!(short * 100 < long * 55, "{short} of {long} bytes");
}

#[test]
fn rows_of_before_read_as_they_are() {
    let mut rows = GrainRows::default();
    let old = long_rows(3, &flight()[3]);
    assert!(rows.long(&old).is_none());
    rows.take(&old);
    assert_eq!(rows.known.len(), 40);
}

#[test]
fn after_a_lost_part_rows_stay_rounded_and_odd_ones_do_no_harm() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = on_debris(&recorded(folder.path(), &flight()).path);
    let short = told.iter().find(|rows| rows.step == 5).expect("a step in flight");
    let meta = BTreeMap::from([
        ("step".to_owned(), STEP.to_string()),
        ("gravity".to_owned(), "0 0 -9.81".to_owned()),
    ]);
    // Nothing of before is known; or what is known is too old.
    let mut late = GrainRows::of(&meta);
    late.take(&long_rows(2, &flight()[2]));
    for rows in [GrainRows::of(&meta), GrainRows::default(), late] {
        let LongForm { moved, all } = rows.long(short).expect("the short form");
        assert_eq!((&moved.ids, &all), (&short.flying, &moved));
        let rounded: Vec<f64> = short.flown_positions.iter().copied().map(f64::from).collect();
        assert_eq!(moved.positions, rounded);
    }
    let odd = Grains {
        first: Some(u64::MAX),
        last: Some(0),
        ids: vec![9, 3, 3],
        positions: vec![0.0; 7],
        velocities: vec![f64::NAN; 6],
        flying: vec![u64::MAX, 3],
        flown_positions: vec![f32::INFINITY; 4],
        ..Default::default()
    };
    let LongForm { moved, .. } = GrainRows::of(&meta).long(&odd).expect("the short form");
    assert_eq!(moved.ids, [3, 9]);
}
