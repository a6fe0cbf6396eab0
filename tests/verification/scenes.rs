//! Every shipped scene runs and shows what it says it shows.

mod directed;
mod drafts;
mod moving;
mod scored;
mod taste;

use crate::common;

use common::{Cullet, corpus, summary, unique};
use cullet_geometry::Solid;
use cullet_record::Recording;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The scenes that are drawn too: solids with debris, bodies of several shapes, joints, a sheet
/// with a quantity in it, cloth, and what is soft. To draw all takes as long as to run many.
const PICTURED: [&str; 6] = ["pot", "tea", "mortar", "towel", "garment", "jelly"];

/// A run of a shipped scene.
struct Shown {
    /// What happened, a line an event.
    told: String,
    folder: PathBuf,
    /// Whether the folder stays, because CULLET_SCENE_RUNS is set.
    left: bool,
}

impl Shown {
    /// Runs a scene; its own expectations decide the exit code, this checks the ledger.
    fn of(name: &str) -> Self {
        let runs = std::env::var_os("CULLET_SCENE_RUNS");
        let folder = runs.as_ref().map_or_else(|| unique(name), |runs| Path::new(runs).join(name));
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name);
        let pictures = if PICTURED.contains(&name) { &[][..] } else { &["--no-pictures"] };
        let run = Cullet::new(&["run", "-q", "--out"]).path(&folder).path(&scene);
        let run = run.args(pictures).output();
        assert_eq!(run.code, 0, "{name}: {}", run.stderr);
        let told = summary(&folder);
        assert_eq!(told["open_fragments"], 0, "{told:#}");
        assert_eq!(told["jobs"]["opened"], told["jobs"]["settled"], "{told:#}");
        assert_eq!(told["jobs"]["failed"], 0, "{told:#}");
        let bounds = [
            ("mass_rel_error", 1e-9),
            ("volume_rel_error", 1e-9),
            ("momentum_rel_error", 1e-9),
            ("angular_momentum_rel_error", 1e-9),
            ("energy_gain_rel", 1e-9),
        ];
        for (key, bound) in bounds {
            let value = told["ledger"][key].as_f64().expect("a number");
            assert!(value <= bound, "{name}: {key} is {value}");
        }
        let inspect = Cullet::new(&["inspect"]).path(&folder.join("run.mcap")).output();
        assert_eq!(inspect.code, 0, "{name}: {}", inspect.stderr);
        Self { told: inspect.stdout.clone(), folder, left: runs.is_some() }
    }

    fn recording(&self) -> Recording {
        Recording::open(&self.folder.join("run.mcap")).expect("a recording")
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        if !self.left {
            std::fs::remove_dir_all(&self.folder).ok();
        }
    }
}

fn holds(name: &str) -> String {
    Shown::of(name).told.clone()
}

#[test]
fn pot() {
    holds("pot");
}

#[test]
fn four_shapes() {
    holds("four-shapes");
}

#[test]
fn bullet() {
    holds("bullet");
}

#[test]
fn pair() {
    holds("pair");
}

#[test]
fn threshold() {
    holds("threshold");
}

#[test]
fn column() {
    holds("column");
}

#[test]
fn bottle() {
    let told = holds("bottle");
    assert!(told.contains("for bottle broken: shell"), "{told}");
}

#[test]
fn bulb() {
    let told = holds("bulb");
    assert!(told.contains("for bulb broken: shell"), "{told}");
}

/// Its shards are solved when the floor meets them again, jagged as their rims are.
#[test]
fn bowl() {
    let told = holds("bowl");
    assert!(told.contains("for bowl broken: shell"), "{told}");
    assert!(told.contains("for bowl.0 broken: shell"), "{told}");
}

#[test]
fn shower() {
    let told = holds("shower");
    assert!(told.contains("diced: the start is solved"), "{told}");
}

#[test]
fn windscreen() {
    let told = holds("windscreen");
    assert!(told.contains("laminated: the interlayer holds"), "{told}");
}

/// The brick goes through it, and most of what it leaves is solved.
#[test]
fn window() {
    let shown = Shown::of("window");
    let told = &shown.told;
    assert!(told.contains("for pane broken: shell"), "{told}");
    let recording = shown.recording();
    let along = parts_along(&recording, "brick", 1);
    let (first, last) = (along[0][0].1, along.last().expect("a step")[0].1);
    assert!(first < -0.1 && last > 0.5, "the brick went from {first} m to {last} m");
}

/// A shard that the worktop meets again is solved on its midsurface.
#[test]
fn egg() {
    let told = holds("egg");
    assert!(told.contains("for egg broken: shell"), "{told}");
    assert!(told.contains("for egg.0 broken: shell"), "{told}");
}

/// Its dent is deeper than ten times its thickness, and stays.
#[test]
fn lid() {
    let shown = Shown::of("lid");
    let told = &shown.told;
    assert!(told.contains("for lid deformed: shell"), "{told}");
    let recording = shown.recording();
    let lid = recording.bodies.iter().find(|body| body.object == "lid").expect("a lid");
    let height = |geometry: &[u8]| {
        let solid = Solid::try_from(&recording.geometries[geometry]).expect("a solid");
        let (low, high) = solid.mesh.bounds().expect("a mesh");
        high.z - low.z
    };
    let last = recording.poses.last().expect("a step").step;
    let (first, last) = (height(&lid.geometry), recording.geometry_of(lid.id, last));
    let last = height(last.expect("a geometry"));
    assert!(last > 11.0 * first && last < 60.0 * first, "{first} m, {last} m");
}

/// The dent in its side is a third of its radius deep; the wall is 33 mm from its axis before.
#[test]
fn can() {
    let shown = Shown::of("can");
    let told = &shown.told;
    assert!(told.contains("for can deformed: shell"), "{told}");
    let recording = shown.recording();
    let last = recording.poses.last().expect("a step").step;
    let can = recording.bodies.iter().find(|body| body.object == "can").expect("a can");
    let least = |geometry: &[u8]| {
        let mesh = Solid::try_from(&recording.geometries[geometry]).expect("a solid").mesh;
        let side = mesh.vertices.iter().filter(|v| v.z.abs() < 0.03);
        side.map(|v| v.x.hypot(v.y)).fold(f64::INFINITY, f64::min)
    };
    let first = least(&can.geometry);
    let last = least(recording.geometry_of(can.id, last).expect("a geometry"));
    assert!(first > 0.032 && last > 0.018 && last < 0.024, "{first} m, {last} m");
}

/// A tap is too slow for a solve, and the recording says why; the other has a dent in its crown.
#[test]
fn bell() {
    let shown = Shown::of("bell");
    let told = &shown.told;
    assert!(told.contains("rung cannot break: the stress reaches"), "{told}");
    assert!(!told.contains("opened for rung"), "{told}");
    assert!(told.contains("for dented deformed: shell"), "{told}");
    let recording = shown.recording();
    let last = recording.poses.last().expect("a step").step;
    let depth = |name: &str| {
        let bell = recording.bodies.iter().find(|body| body.object == name).expect("a bell");
        let geometry = recording.geometry_of(bell.id, last).expect("a geometry");
        let mesh = Solid::try_from(&recording.geometries[geometry]).expect("a solid").mesh;
        let (_, high) = mesh.bounds().expect("a mesh");
        let crown = mesh.vertices.iter().filter(|v| v.x.hypot(v.y) < 4e-3);
        high.z - crown.map(|v| v.z).fold(f64::NEG_INFINITY, f64::max)
    };
    let (rung, dented) = (depth("rung"), depth("dented"));
    assert!(rung < 1e-6 && dented > 2e-3 && dented < 0.02, "{rung} m, {dented} m");
}

/// Both dents are in the upper face, as deep as what made them was fast.
#[test]
fn dent() {
    let shown = Shown::of("dent");
    let told = &shown.told;
    assert!(told.contains("for block deformed: ductile"), "{told}");
    let recording = shown.recording();
    let last = recording.poses.last().expect("a step").step;
    let block = recording.bodies.iter().find(|body| body.object == "block").expect("a block");
    let geometry = recording.geometry_of(block.id, last).expect("a geometry");
    let mesh = Solid::try_from(&recording.geometries[geometry]).expect("a solid").mesh;
    let (_, high) = mesh.bounds().expect("a mesh");
    for (x, least) in [(-0.03, 5e-4), (0.035, 2e-4)] {
        let near = mesh.vertices.iter().filter(|v| v.z > 0.0 && (v.x - x).hypot(v.y) < 4e-3);
        let depth = high.z - near.map(|v| v.z).fold(f64::INFINITY, f64::min);
        assert!(depth > least && depth < 6e-3, "{depth} m deep at x = {x} m");
    }
}

/// Both are solved as points and bonds: one falls apart, the other keeps a dent.
#[test]
fn panels() {
    let told = holds("panels");
    assert!(told.contains("for brittle broken: peridynamics"), "{told}");
    assert!(told.contains("for ductile deformed: peridynamics"), "{told}");
}

/// Four walls of different laws, each solved as points and bonds; the tough one only splits.
#[test]
fn walls() {
    let told = holds("walls");
    for wall in ["brittle", "grained", "tough", "ductile"] {
        assert!(told.contains(&format!("for {wall} broken: peridynamics")), "{told}");
    }
    assert!(told.contains("tough breaks into 2:"), "{told}");
}

#[test]
fn lead_soldier() {
    let told = holds("lead-soldier");
    assert!(told.contains("for soldier deformed: ductile"), "{told}");
}

/// The plate is left with a hole, and the ball has gone through it.
#[test]
fn plate() {
    let shown = Shown::of("plate");
    let told = &shown.told;
    assert!(told.contains("for plate broken: ductile"), "{told}");
    let recording = shown.recording();
    let part = recording.bodies.iter().rfind(|body| body.object == "plate");
    let solid = &recording.geometries[&part.expect("what is left").geometry];
    let mesh = Solid::try_from(solid).expect("a solid").mesh;
    let edges = 3 * mesh.triangles.len() / 2;
    // V − E + F of a ring is 0, and less of one with more holes.
    let euler = (mesh.vertices.len() + mesh.triangles.len()) as i64 - edges as i64;
    assert!((-4..=0).contains(&euler), "{euler}");
    let ball = recording.bodies.iter().find(|body| body.object == "ball").expect("a ball");
    let last = recording.poses.last().expect("a step");
    let at = last.ids.iter().position(|id| *id == ball.id).expect("its pose");
    let place = &last.positions[3 * at..3 * at + 3];
    assert!(place[1] > 0.5, "{place:?}");
}

/// The faster one is flatter.
#[test]
fn clay() {
    let shown = Shown::of("clay");
    let recording = shown.recording();
    let last = recording.poses.last().expect("a step").step;
    let least = |name: &str| {
        let ball = recording.bodies.iter().find(|body| body.object == name).expect("a ball");
        let geometry = recording.geometry_of(ball.id, last).expect("a geometry");
        let mesh = Solid::try_from(&recording.geometries[geometry]).expect("a solid").mesh;
        let (low, high) = mesh.bounds().expect("a mesh");
        high.z - low.z
    };
    let (slow, fast) = (least("slow"), least("fast"));
    assert!(slow < 0.07 && fast < 0.85 * slow, "{slow} m, {fast} m");
}

/// It was as high as wide, and is far wider than high.
#[test]
fn clay_pot() {
    let shown = Shown::of("clay-pot");
    let told = &shown.told;
    assert!(told.contains("for pot deformed: ductile"), "{told}");
    let recording = shown.recording();
    let last = recording.poses.last().expect("a step").step;
    let pot = recording.bodies.iter().find(|body| body.object == "pot").expect("a pot");
    let sizes = |geometry: &[u8]| {
        let solid = Solid::try_from(&recording.geometries[geometry]).expect("a solid");
        let (low, high) = solid.mesh.bounds().expect("a mesh");
        (high.x - low.x, high.y - low.y)
    };
    let (wide, high) = sizes(&pot.geometry);
    assert!((wide - high).abs() < 1e-3, "{wide} m, {high} m");
    let (wide, high) = sizes(recording.geometry_of(pot.id, last).expect("a geometry"));
    assert!(wide > 0.145 && high < 0.7 * wide, "{wide} m, {high} m");
}

/// Pieces, area of cracks \[m²\] and energy out of place \[1\] of the sheets of a run.
fn torn(shown: &Shown) -> (u64, f64, f64) {
    let sheets = &summary(&shown.folder)["sheets"];
    let number = |key: &str| sheets[key].as_f64().expect("a number");
    let pieces = sheets["pieces"].as_u64().expect("a count");
    (pieces, number("torn_area"), number("energy_residual_rel"))
}

/// The ball goes through a hole, and the towel stays one piece.
#[test]
fn drape() {
    let shown = Shown::of("drape");
    let (pieces, area, off) = torn(&shown);
    assert!(pieces == 1 && (1e-5..3e-5).contains(&area) && off < 0.02, "{pieces}, {area}, {off}");
    let along = parts_along(&shown.recording(), "ball", 2);
    let last = along.last().expect("a step")[0].1;
    assert!(last < -0.1, "the ball is at {last} m");
}

/// The tear follows the wet patches: a straight one would have 3.0e-5 m².
#[test]
fn towel() {
    let (pieces, area, off) = torn(&Shown::of("towel"));
    assert!(pieces >= 2 && (3.2e-5..4.5e-5).contains(&area) && off < 0.02, "{area}, {off}");
}

/// A tear of 105 mm, straight down from the slit.
#[test]
fn film() {
    let shown = Shown::of("film");
    let (pieces, area, off) = torn(&shown);
    assert!(pieces <= 3 && (1.5e-5..1.9e-5).contains(&area) && off < 0.02, "{area}, {off}");
    shown.is_predicted_by_a_draft("film");
}

/// A tear of 120 mm, straight down from the slit.
#[test]
fn foil() {
    let (pieces, area, off) = torn(&Shown::of("foil"));
    assert!(pieces == 2 && (1.8e-6..2.2e-6).contains(&area) && off < 0.02, "{area}, {off}");
}

/// Nothing tears.
#[test]
fn curtain() {
    let (pieces, area, off) = torn(&Shown::of("curtain"));
    assert!(pieces == 1 && area == 0.0 && off < 0.01, "{pieces}, {area}, {off}");
}

/// One tear from side to side.
#[test]
fn two_sources() {
    let shown = Shown::of("two-sources");
    let (pieces, area, off) = torn(&shown);
    assert!(pieces >= 2 && (2.4e-5..3.2e-5).contains(&area) && off < 0.05, "{area}, {off}");
    shown.is_predicted_by_a_draft("two-sources");
}

/// It is torn from edge to edge, 175 mm.
#[test]
fn seaweed() {
    let (pieces, area, off) = torn(&Shown::of("seaweed"));
    assert!(pieces >= 2 && (7e-6..2.2e-5).contains(&area) && off < 0.05, "{area}, {off}");
}

#[test]
fn pane() {
    let shown = Shown::of("pane");
    let opened = shown.told.lines().find(|line| line.contains("opened for pane"));
    assert!(opened.is_some_and(|line| line.contains("held at ")), "{opened:?}");
    assert_held_pane_stays_down(&shown.recording());
}

/// Mass \[kg\], place \[m\] and velocity \[m/s\] along an axis of each part of an object after each
/// recorded step.
fn parts_along(recording: &Recording, object: &str, axis: usize) -> Vec<Vec<(f64, f64, f64)>> {
    let bodies = recording.bodies.iter().filter(|body| body.object == object);
    let masses: BTreeMap<u64, f64> = bodies.map(|body| (body.id, body.mass)).collect();
    let mut known: BTreeMap<u64, (f64, f64, f64)> = BTreeMap::new();
    let mut steps = Vec::new();
    for poses in &recording.poses {
        for (k, id) in poses.ids.iter().enumerate() {
            if let Some(&mass) = masses.get(id) {
                let at = 3 * k + axis;
                known.insert(*id, (mass, poses.positions[at], poses.velocities[at]));
            }
        }
        // A body that broke is its parts from then on.
        let parents = recording.bodies.iter().filter(|body| body.birth_step <= poses.step);
        let gone: Vec<u64> = parents.filter_map(|body| body.parent).collect();
        known.retain(|id, _| !gone.contains(id));
        steps.push(known.values().copied().collect());
    }
    steps
}

fn played(scene: &Path, name: &str) -> Recording {
    let out = unique(name);
    let run = Cullet::new(&["run", "-q", "--no-pictures", "--out"]).path(&out).path(scene).output();
    assert_eq!(run.code, 0, "{name}: {}", run.stderr);
    let told = summary(&out);
    assert!(told["ledger"]["momentum_rel_error"].as_f64().is_some_and(|e| e < 1e-9), "{told:#}");
    assert!(told["ledger"]["energy_gain_rel"].as_f64().is_some_and(|e| e < 1e-9), "{told:#}");
    let recording = Recording::open(&out.join("run.mcap")).expect("a recording");
    std::fs::remove_dir_all(&out).ok();
    recording
}

/// A pane that lies on ledges and is hit from above: what broke it threw nothing back up. From
/// 0.05 s on its pieces rock and bounce on the ledges.
fn assert_held_pane_stays_down(recording: &Recording) {
    let steps = parts_along(recording, "pane", 2);
    assert!(steps.last().is_some_and(|parts| parts.len() > 8), "it broke");
    let height = |parts: &Vec<(f64, f64, f64)>| {
        let mass: f64 = parts.iter().map(|part| part.0).sum();
        parts.iter().map(|part| part.0 * part.1).sum::<f64>() / mass
    };
    let early = recording.poses.iter().take_while(|poses| poses.time < 0.05).count();
    let highest = steps[..early].iter().map(height).fold(f64::NEG_INFINITY, f64::max);
    let rise = highest - height(&steps[0]);
    assert!(rise < 2e-3, "its centre of mass rose by {rise} m");
}

/// A window in a frame that holds its edges on both sides: what the frame does not hold leaves the
/// way the ball flies.
#[test]
fn a_window_leaves_the_way_that_it_is_struck() {
    let recording = played(Path::new(&corpus("window.toml")), "window");
    let steps = parts_along(&recording, "pane", 1);
    let last = steps.last().expect("a step");
    let free: Vec<f64> = last.iter().map(|part| part.2).filter(|v| v.abs() > 0.1).collect();
    assert!(free.len() > 30, "{} of {} parts are free", free.len(), last.len());
    let along = free.iter().filter(|&&v| v > 0.0).count() as f64 / free.len() as f64;
    assert!(along >= 0.9, "{along} of {} free parts leave along the strike", free.len());
}

#[test]
fn wall() {
    let told = holds("wall");
    let mut asked = told.lines().filter_map(|line| line.split_once(", asks geometric"));
    let why = asked.next().map(|(_, why)| why);
    assert!(why.is_some_and(|why| why.starts_with(": ")), "why no solver was asked: {why:?}");
}

/// F42: bodies go where their velocities take them, whatever the step: a run in which one does not
/// for five steps on end fails.
#[test]
fn places_follow_velocities_at_any_step() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let (wall, facade) = ("scenes/wall", "tests/corpus/facade.toml");
    let (drop, finer) = ("tests/corpus/drop.toml", "fracture.max_particles=12000");
    for (scene, step, other) in [
        (wall, "world.step=\"1/120 s\"", "world.duration=1.2"),
        (wall, "world.step=\"1/960 s\"", "world.duration=0.4"),
        (facade, "world.step=\"1/240 s\"", "world.duration=0.3"),
        (facade, "world.step=\"1/120 s\"", "world.duration=0.3"),
        (drop, "world.step=\"1/240 s\"", finer),
        (drop, "world.step=\"1/120 s\"", finer),
    ] {
        let out = unique("follow");
        let args = ["run", "--no-pictures", "--set", step, "--set", other, "--out"];
        let run = Cullet::new(&args).path(&out).path(&root.join(scene)).output();
        assert_eq!(run.code, 0, "{scene}, {step}: {}", run.stderr);
        std::fs::remove_dir_all(&out).ok();
    }
}
