//! A run made by hand: a cube falls onto a slab and splits in two. Beside it, if wanted, a sheet
//! waves and tears.

mod times;
pub mod waving;

pub use times::{BREAK, STEP, STEPS};

use super::{Event, Finished, PoseRow, RecordError, Recorder, RunMeta, Touch};
use cullet_geometry::{Pose, Quat, Sheet, Solid, Surface, TriMesh, Vec3};
use cullet_proto::recording::{Body, Hit, JobReport, Ledger, PoolReport, Tier, Vector3, Verdict};
use cullet_world::{BodyId, DebrisParticle};
use std::collections::BTreeMap;
use std::path::Path;

/// Half the edge of the cube \[m\].
const HALF: f64 = 0.1;

/// A box about the origin. Its face towards +x (`split > 0`) or −x (`split < 0`) is a crack.
pub fn block(half: Vec3, split: f64) -> Solid {
    let corner = |i: usize| {
        let sign = |bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
        Vec3::new(sign(1) * half.x, sign(2) * half.y, sign(4) * half.z)
    };
    let vertices = (0..8).map(corner).collect();
    let triangles = vec![
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
    ];
    let mut solid = Solid::outer(TriMesh { vertices, triangles });
    let face = if split > 0.0 { 2..4 } else { 0..2 };
    if split != 0.0 {
        solid.surface[face].fill(Surface::crack(2e-5));
    }
    solid
}

/// Half the edges of each part.
pub fn half() -> Vec3 {
    Vec3::new(HALF / 2.0, HALF, HALF)
}

/// A crack across a block, from its upper half to beyond its top, cut off there.
pub fn fin(half: Vec3) -> Sheet {
    let corner = |[y, z]: [f64; 2]| Vec3::new(0.0, 0.8 * y * half.y, z * half.z);
    let mesh = TriMesh {
        vertices: [[-1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 1.0]].map(corner).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    Sheet { mesh, damage_time: vec![1e-5; 4], front_speed: vec![900.0; 4] }
}

/// What the run says of itself.
pub fn meta() -> RunMeta {
    RunMeta {
        scene: "split".to_owned(),
        seed: 7,
        version: "0.1.0".to_owned(),
        scene_text: "[world]\nduration = 1.0\n".to_owned(),
        files: vec![("note.txt".to_owned(), b"by hand".to_vec())],
        step: STEP,
        duration: STEPS as f64 * STEP,
        gravity: Vec3::new(0.0, 0.0, -9.81),
        materials: BTreeMap::from([("brick".to_owned(), "E 15 GPa".to_owned())]),
        view: None,
        interiors: BTreeMap::new(),
        painted: 0,
        drawings: true,
        deterministic: true,
    }
}

fn body(id: u64, parent: Option<u64>, geometry: [u8; 32], half: Vec3) -> Body {
    let volume = 8.0 * half.x * half.y * half.z;
    Body {
        id,
        name: if id == 1 { "cube".to_owned() } else { format!("cube.{id}") },
        object: "cube".to_owned(),
        parent,
        generation: u32::from(parent.is_some()),
        tier: if parent.is_some() { Tier::Large } else { Tier::Whole } as i32,
        material: "brick".to_owned(),
        geometry: geometry.to_vec(),
        mass: 1900.0 * volume,
        volume,
        fixed: false,
        birth_step: if parent.is_some() { BREAK } else { 0 },
    }
}

/// Height of the cube's centre while it falls \[m\].
fn height(time: f64) -> f64 {
    0.9 - 0.5 * 9.81 * time * time
}

/// Where everything is after a step.
fn rows(step: u64) -> Vec<PoseRow> {
    let time = step as f64 * STEP;
    let row = |id, at: Vec3, turn: Vec3, velocity: Vec3| PoseRow {
        id,
        pose: Pose::from_parts(at.into(), Quat::from_scaled_axis(turn)),
        velocity,
        spin: Vec3::zeros(),
    };
    let slab = row(0, Vec3::new(0.0, 0.0, -0.05), Vec3::zeros(), Vec3::zeros());
    if step < BREAK {
        let fall = Vec3::new(0.0, 0.0, -9.81 * time);
        return vec![slab, row(1, Vec3::new(0.0, 0.0, height(time)), Vec3::zeros(), fall)];
    }
    let since = time - BREAK as f64 * STEP;
    let part = |id: u64, side: f64| {
        let away = side * (HALF / 2.0 + 0.8 * since.min(0.3));
        let tilt = Vec3::new(0.0, side * 3.0 * since.min(0.3), 0.0);
        row(id, Vec3::new(away, 0.0, HALF), tilt, Vec3::new(0.8 * side, 0.0, 0.0))
    };
    vec![slab, part(2, -1.0), part(3, 1.0)]
}

/// Two grains that fly apart and lie down at the end.
fn grains(step: u64) -> Vec<DebrisParticle> {
    let since = step.checked_sub(BREAK).map(|steps| steps as f64 * STEP);
    let grain = |since: f64, id: u64, side: f64| {
        let flown = since.min(0.3);
        let resting = since > 0.3;
        DebrisParticle {
            id,
            parent: BodyId(1),
            mass: 0.015,
            size: 0.02,
            position: Vec3::new(side * (HALF + flown), 0.1, HALF * (1.0 - flown / 0.3)),
            velocity: if resting { Vec3::zeros() } else { Vec3::x() * side },
            resting,
        }
    };
    since.into_iter().flat_map(|since| [grain(since, 0, 1.0), grain(since, 1, -1.0)]).collect()
}

/// Starts the recording: slab and cube.
pub fn begin(path: &Path, meta: &RunMeta) -> Result<Recorder, RecordError> {
    born(Recorder::create(path, meta)?)
}

/// Slab and cube are born.
pub(super) fn born(mut recorder: Recorder) -> Result<Recorder, RecordError> {
    let floor = Vec3::new(1.5, 1.5, 0.05);
    let slab = recorder.geometry(&block(floor, 0.0))?;
    let mut ground = body(0, None, slab, floor);
    (ground.name, ground.object, ground.fixed) = ("slab".to_owned(), "slab".to_owned(), true);
    ground.material = "concrete".to_owned();
    recorder.body(&ground)?;
    let half = Vec3::repeat(HALF);
    let cube = recorder.geometry(&block(half, 0.0))?;
    recorder.body(&body(1, None, cube, half))?;
    Ok(recorder)
}

/// What happens at one step, poses included.
pub fn step(recorder: &mut Recorder, step: u64) -> Result<(), RecordError> {
    let time = step as f64 * STEP;
    if step == BREAK {
        break_cube(recorder, time)?;
    }
    recorder.grains(step, time, &grains(step))?;
    recorder.poses(step, time, &rows(step))
}

fn break_cube(recorder: &mut Recorder, time: f64) -> Result<(), RecordError> {
    let job = *blake3::hash(b"the cube").as_bytes();
    let point = Vec3::new(0.0, 0.0, 0.0);
    let (impulse, closing_speed, energy) = (59.6, 3.92, 116.8);
    let solver = "geometric".to_owned();
    let contact =
        Touch { duration: 1e-4, radius: 0.003, peak_force: 1e6, dissipated: 0.91 * energy };
    let impact =
        Event::Impact { body: 1, striker: 0, point, impulse, closing_speed, energy, contact };
    recorder.event(BREAK, time, &impact)?;
    let (asked, reason) = (solver.clone(), "generation 2 is beyond 1".to_owned());
    let directed = false;
    let opened = Event::JobOpened { body: 1, job, solver: asked, reason, directed };
    recorder.event(BREAK, time, &opened)?;
    let hit = Hit {
        point: Some(Vector3 { x: 0.0, y: 0.0, z: -HALF }),
        normal: Some(Vector3 { x: 0.0, y: 0.0, z: 1.0 }),
        impulse,
        duration: 1e-4,
        radius: 0.003,
        energy,
        closing_speed,
    };
    recorder.report(&JobReport {
        job: job.to_vec(),
        body: 1,
        hits: vec![hit],
        asked: "brittle".to_owned(),
        solver,
        verdict: Verdict::Broken as i32,
        refusal: "too thin: 2.0 cells".to_owned(),
        fragments: 2,
        crack_area: 4.0 * HALF * HALF,
        fracture_energy: 80.0 * 4.0 * HALF * HALF,
        strength_ratio: 1.0,
        ..Default::default()
    })?;
    recorder.pool(&PoolReport {
        job: job.to_vec(),
        worker: "w-1".to_owned(),
        wall_seconds: 0.25,
        resent: 1,
        cached: false,
    })?;
    let (verdict, reason) = (Verdict::Broken, String::new());
    recorder.event(BREAK, time, &Event::JobSettled { body: 1, job, verdict, reason })?;
    let half = half();
    for (id, side) in [(2, 1.0), (3, -1.0)] {
        let solid = block(half, side);
        let geometry = recorder.geometry(&solid)?;
        recorder.body(&body(id, Some(1), geometry, half))?;
        if id == 2 {
            recorder.cracks((BREAK, time), id, &solid, &fin(half))?;
        }
    }
    let ledger = Ledger {
        mass_rel_error: 1e-16,
        energy_before: 116.8,
        energy_after: 9.7,
        fracture_energy: 3.2,
        ..Default::default()
    };
    let (grains, grain_mass) = (2, 0.03);
    let fragments = vec![2, 3];
    let fractured =
        Event::Fractured { parent: 1, job, fragments, alpha: 1.0, grains, grain_mass, ledger };
    recorder.event(BREAK, time, &fractured)
}

/// Records the whole run.
pub fn run(path: &Path, meta: &RunMeta) -> Result<Finished, RecordError> {
    let mut recorder = begin(path, meta)?;
    for k in 0..=STEPS {
        step(&mut recorder, k)?;
    }
    let held = Event::Expectation { text: "fragments >= 2".to_owned(), held: true };
    let time = STEPS as f64 * STEP;
    recorder.event(STEPS, time, &held)?;
    recorder.finish(STEPS, time)
}

/// Records the whole run, with the sheet of [`waving`].
///
/// # Errors
/// The file cannot be written.
pub fn run_with_sheet(path: &Path, meta: &RunMeta) -> Result<Finished, RecordError> {
    let mut recorder = begin(path, meta)?;
    waving::begin(&mut recorder);
    for k in 0..=STEPS {
        waving::step(&mut recorder, k)?;
        step(&mut recorder, k)?;
    }
    recorder.finish(STEPS, STEPS as f64 * STEP)
}
