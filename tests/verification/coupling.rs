//! The coupling of solver and rigid world, and the rigid world itself: specimens of the whole, as
//! the catalogue has them, R1 to R7, E11 of a hit, H1 (i) and (iii) and H3. What the world can show
//! alone is in `services/world/tests`: R1 on grids and R7's push handed over (`replace.rs`), R4's
//! closing speed (`impacts.rs`); in `stability` R6's bound and R7's first touch (F36, F42). Only
//! cuts along planes that no hit would choose are made here by hand.

use crate::common;

use common::{Cullet, Said, unique};
use cullet_fragment::cut::{CutSettings, Partition, by_sites};
use cullet_geometry::math::unit;
use cullet_geometry::shapes::{self, Detail as Facets};
use cullet_geometry::{Mat3, Solid, TriMesh, Vec3};
use cullet_model::CrackFaceDetail;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/specimens");
    folder.join(format!("{name}.toml"))
}

fn bench(name: &str, more: &[&str]) -> Said {
    Cullet::new(&["bench", "-q"]).path(&file(name)).args(more).output()
}

/// Runs a specimen whose own expectations decide the exit code.
fn hold(name: &str, more: &[&str]) {
    let said = bench(name, more);
    assert_eq!(said.code, 0, "{name}\n{}{}", said.stdout, said.stderr);
    assert!(said.stdout.contains(name), "{}", said.stdout);
}

/// The metrics of each run, by name; all that is expected holds, or is a gap.
fn metrics(name: &str, more: &[&str]) -> Vec<BTreeMap<String, serde_json::Value>> {
    let said = bench(name, &[&["--json", "--workers", "2"], more].concat());
    assert_eq!(said.code, 0, "{name}\n{}{}", said.stdout, said.stderr);
    let rows = said.stdout.lines().map(|line| {
        let told: serde_json::Value = serde_json::from_str(line).expect("JSON");
        let rows = told["metrics"].as_array().cloned().unwrap_or_default();
        rows.into_iter().map(|row| (row["metric"].as_str().unwrap_or("").to_owned(), row)).collect()
    });
    rows.collect()
}

fn value(row: &BTreeMap<String, serde_json::Value>, metric: &str) -> f64 {
    row[metric]["value"].as_f64().unwrap_or(f64::NAN)
}

fn cube(side: f64) -> TriMesh {
    shapes::cuboid(Vec3::repeat(side), Facets::default()).expect("a cube")
}

fn ball(radius: f64, segments: u32) -> TriMesh {
    let detail = Facets { segments, ..Facets::default() };
    shapes::sphere(radius, detail).expect("a sphere")
}

/// Cuts a body along the cells of sites, each a part of its own.
fn cut(mesh: &TriMesh, sites: &[Vec3]) -> Partition {
    let labels: Vec<u32> = (0..sites.len() as u32).collect();
    let settings = CutSettings {
        min_volume_ratio: 0.0,
        max_fragments: 1000,
        seed: 1,
        detail: CrackFaceDetail::NONE,
    };
    let times = vec![1e-5; sites.len()];
    by_sites(&Solid::outer(mesh.clone()), sites, &labels, &times, &settings).expect("a cut")
}

/// Cuts whose parts have moments in closed form.
fn cuts() -> [(&'static str, TriMesh, Vec<Vec3>); 2] {
    let octant = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 0.05 } else { -0.05 };
        // Off the lattice by less than a thousandth: a lattice has corners of eight cells.
        let off = Vec3::from([0, 1, 2].map(|a| 5e-5 * (unit(9, a, i.into()) - 0.5)));
        Vec3::new(side(0), side(1), side(2)) + off
    };
    [
        ("half spheres", ball(0.1, 120), vec![Vec3::z() * -0.04, Vec3::z() * 0.04]),
        ("octants", cube(0.2), (0..8).map(octant).collect()),
    ]
}

/// R1, R2 and R3 of bodies that fly, turn and are hit: mass, both momenta and energy as the world's
/// books and the recording have them, to 1e-12; volume; inertia by the parallel axes.
#[test]
fn r1_to_r3_a_split_keeps_what_there_was() {
    hold("r1-split-ball", &[]);
    hold("r1-split-cube", &["--sweep", "scene.fracture.max_fragments=8,64"]);
}

/// R2: the parts fill the body; R3: their inertia by the parallel axes is the body's.
#[test]
fn r2_r3_parts_have_the_volume_and_the_inertia_of_the_body() {
    for (what, mesh, sites) in cuts() {
        let whole = mesh.mass_properties();
        let (mut volume, mut inertia, mut first) = (0.0, Mat3::zeros(), Vec3::zeros());
        for part in cut(&mesh, &sites).parts {
            let own = part.solid.mesh.mass_properties();
            let arm = own.centroid - whole.centroid;
            let lever = Mat3::identity() * arm.norm_squared() - arm * arm.transpose();
            volume += own.volume;
            first += own.centroid * own.volume;
            inertia += own.inertia + lever * own.volume;
        }
        let lost = (volume / whole.volume - 1.0).abs();
        assert!(lost < 1e-9, "{what}: {lost}");
        let off = (inertia - whole.inertia).norm() / whole.inertia.norm();
        assert!(off < 1e-6, "{what}: {off}");
        assert!((first / volume - whole.centroid).norm() < 1e-9 * 0.1, "{what}");
    }
}

/// R3 in numbers: half a ball's centre and inertia, an octant's inertia.
#[test]
fn r3_halves_and_octants_have_the_moments_of_the_formulas() {
    let all = cuts();
    let radius: f64 = 0.1;
    for part in cut(&all[0].1, &all[0].2).parts {
        let own = part.solid.mesh.mass_properties();
        // A ball of 120 edges a great circle has lost 3e-3 of its volume.
        let scale = own.volume * radius * radius;
        let pairs = [
            (own.volume, 2.0 / 3.0 * std::f64::consts::PI * radius.powi(3)),
            (own.centroid.z.abs(), 3.0 / 8.0 * radius),
            (own.inertia[(2, 2)] / scale, 0.4),
            (own.inertia[(0, 0)] / scale, 0.4 - 9.0 / 64.0),
            (own.inertia[(1, 1)] / scale, 0.2594),
        ];
        for (got, want) in pairs {
            assert!((got / want - 1.0).abs() < 5e-3, "{got} is not {want}");
        }
    }
    for part in cut(&all[1].1, &all[1].2).parts {
        let own = part.solid.mesh.mass_properties();
        assert!((own.volume / 1e-3 - 1.0).abs() < 2e-3, "{}", own.volume);
        for axis in 0..3 {
            let got = own.inertia[(axis, axis)] / (own.volume * 0.01 / 6.0);
            assert!((got - 1.0).abs() < 4e-3, "{got}");
        }
    }
}

/// R4: whether a block breaks does not depend on the world's step. Into how many pieces it does
/// not by more than 10 % up to the default step, in the mean of eight seeds; beyond, the block has
/// turned and sunk by other amounts when it is hit: a gap, which the document gives.
#[test]
#[ignore = "long"]
fn r4_the_step_of_the_world_does_not_decide() {
    let seeds = "scene.world.seed=1,2,3,4,5,6,7,8";
    let steps = "scene.world.step=1/1000 s,1/480 s,1/240 s";
    let told = metrics("r4-step", &["--sweep", seeds, "--sweep", steps]);
    let coarse = metrics("r4-step", &["--sweep", "scene.world.step=1/60 s,1/30 s"]);
    for (k, row) in told.iter().chain(&coarse).enumerate() {
        assert_eq!(row["breaks"]["verdict"], "holds", "{k}: {row:#?}");
    }
    let pieces: Vec<f64> = told.iter().map(|row| value(row, "pieces")).collect();
    assert_eq!(pieces.len(), 24);
    for step in 1..3 {
        let ratios = pieces.chunks(3).map(|seed| seed[step] / seed[0] - 1.0);
        let ratios: Vec<f64> = ratios.collect();
        let mean = |value: fn(f64) -> f64| ratios.iter().map(|&off| value(off)).sum::<f64>() / 8.0;
        assert!(mean(|off| off).abs() < 0.05, "{ratios:?}");
        assert!(mean(f64::abs) < 0.15, "{ratios:?}");
        assert!(ratios.iter().all(|off| off.abs() < 0.3), "{ratios:?}");
    }
    for row in &coarse {
        let off = value(row, "pieces") / pieces[0] - 1.0;
        assert!(off.abs() <= 0.5, "{off}");
    }
}

/// E11 of rigid bodies: a hit keeps momentum; angular momentum drifts as the step, a gap, which
/// friction makes: without it nothing is lost.
#[test]
fn e11_a_hit_keeps_momentum_and_the_drift_of_the_angular_one_is_known() {
    let steps = ["--sweep", "scene.world.step=1/240 s,1/1000 s,1/4000 s"];
    let smooth = ["light", "heavy"].map(|name| format!("scene.material.{name}.friction=0"));
    let smooth = ["--set", &smooth[0], "--set", &smooth[1]];
    let drifts = |more: &[&str]| -> Vec<f64> {
        let told = metrics("e11-hit", &[&steps[..], more].concat());
        told.iter().map(|row| value(row, "angular momentum").abs()).collect()
    };
    let rough = drifts(&[]);
    assert!(rough.iter().zip([0.12, 0.025, 0.007]).all(|(drift, most)| drift < &most), "{rough:?}");
    let smooth = drifts(&smooth);
    assert!(smooth.iter().all(|drift| *drift < 1e-12), "{smooth:?}");
}

/// R5: ten blocks on each other for a minute: none drifts by a millimetre, none is hit.
#[test]
fn r5_a_stack_of_ten_stands_for_a_minute() {
    hold("r5-stack", &[]);
}

/// R6: a light slice under a heavy block. Below 1 % of the size to 1:200; at 1:10⁴ it is not: the
/// gap, which the document gives.
#[test]
fn r6_a_light_slice_bears_two_hundred_of_its_weight_and_not_ten_thousand() {
    let told = metrics("r6-slice", &["--sweep", "scene.material.light.density=100,50,1"]);
    let verdicts: Vec<_> =
        told.iter().map(|row| row["sinks by, over its size"]["verdict"].as_str()).collect();
    assert_eq!(verdicts, [Some("holds"), Some("holds"), Some("gap")], "{told:#?}");
}

/// R7: a steel ball of 10 mm through a wall of 10 mm: the wall is hit first at any speed, and what
/// is left of the ball's speed at the catcher behind it grows with what it had, in the mean of four
/// seeds. Below 100 m/s, which is not run, what is left is decided by which pieces it has to push
/// out of its way.
#[test]
#[ignore = "long"]
fn r7_a_ball_goes_through_a_wall_and_never_past_it() {
    let (speeds, seeds) = ([200.0, 300.0, 400.0], 4);
    let sweep = speeds.map(|speed| format!("[{speed},0,0]")).join(",");
    let sweep = format!("scene.body.ball.velocity={sweep}");
    let args = ["--sweep", &sweep, "--sweep", "scene.world.seed=1,2,3,4"];
    let told = metrics("r7-wall", &args);
    assert_eq!(told.len(), speeds.len() * seeds);
    let mut last = 0.0;
    for (rows, speed) in told.chunks(seeds).zip(speeds) {
        let left = |row: &BTreeMap<String, serde_json::Value>| {
            assert_eq!(row["order of the wall"]["verdict"], "holds", "{row:#?}");
            // What stays in the wall is not caught.
            let left = if value(row, "caught") > 0.0 { value(row, "speed left") } else { 0.0 };
            assert!(left < speed, "{speed} m/s: {left}");
            left
        };
        let mean = rows.iter().map(left).sum::<f64>() / seeds as f64;
        assert!(mean > last, "{speed} m/s: {mean}, after {last}");
        last = mean;
    }
}

/// R9: what is left of a ball's speed behind a plate of aluminium is Recht and Ipson's without a
/// plug, √(v² − v₅₀²), of one v₅₀ within 12 % from just above the limit to far beyond it.
#[test]
fn r9_a_ball_goes_through_metal_as_recht_and_ipson_say() {
    let speeds = [325.0_f64, 400.0, 800.0];
    let sweep = speeds.map(|speed| format!("[0,{speed},0]")).join(",");
    let sweep = format!("scene.body.ball.velocity={sweep}");
    let told = metrics("r9-plate", &["--sweep", &sweep]);
    assert_eq!(told.len(), speeds.len());
    let mut last = 0.0;
    for (rows, speed) in told.iter().zip(speeds) {
        assert_eq!(rows["energy gained"]["verdict"], "holds", "{rows:#?}");
        let left = value(rows, "speed left");
        assert!(left > last && left < speed, "{speed} m/s: {left}, after {last}");
        let limit = (speed * speed - left * left).sqrt();
        assert!((limit / 225.0 - 1.0).abs() < 0.12, "{speed} m/s: {left}, a limit of {limit}");
        last = left;
    }
}

/// H1: what a dropped ball's hit says, and half of the speed after a bounce of restitution ½,
/// whatever the step.
#[test]
fn h1_hits_are_those_of_hertz() {
    hold("h1-drop", &[]);
    hold("h1-bounce", &["--sweep", "scene.world.step=1/240 s,1/960 s"]);
}

/// H3: a drop loses nothing in flight, and at the break what the books say, cracks paid.
#[test]
fn h3_the_energy_of_a_drop_is_accounted_for() {
    let stuff = ["--sweep", "scene.material.stuff.preset=plaster,concrete"];
    let solvers = ["--sweep", "scene.fracture.solver=geometric,brittle"];
    let told = metrics("h3-drop", &[stuff, solvers].concat());
    let lost = |of: &str| told.iter().map(|row| value(row, of)).collect::<Vec<_>>();
    let [broken, whole] = ["lost in breaks", "lost in hits"].map(lost);
    // Three ways to break and one to bounce; the cracks of concrete are worth more than the bound.
    assert!(broken[..3].iter().all(|share| *share > 0.5) && broken[3] == 0.0, "{broken:?}");
    assert!(whole[..3].iter().all(|share| *share == 0.0) && whole[3] > 0.5, "{whole:?}");
    assert!(value(&told[2], "cracks") > 0.02, "{told:#?}");
    // Pieces of the geometric family keep nothing of the bounce, and a crushed body takes half of
    // its push: gaps, no larger than is known.
    let beyond = lost("beyond bounce and cracks");
    let most = [0.04, 0.1, 0.02, 0.02];
    assert!(beyond.iter().zip(most).all(|(share, most)| share.abs() < most), "{beyond:?}");
}

/// Runs of the whole are lines and files like any other, whatever became of them, and the same for
/// any number at once.
#[test]
fn runs_of_the_whole_are_lines_like_any_other() {
    let out = unique("whole");
    std::fs::create_dir_all(&out).expect("a folder");
    let csv = out.join("all.csv");
    let (table, folder) = (csv.to_string_lossy(), out.to_string_lossy());
    let sweep = ["--sweep", "scene.world.step=1/240 s,1/960 s"];
    let keep = ["--csv", &table, "--out", &folder, "--workers", "2", "--json"];
    let two = bench("h1-bounce", &[&sweep[..], &keep].concat());
    assert_eq!(two.code, 0, "{}", two.stderr);
    let one = bench("h1-bounce", &[&sweep[..], &["--json", "--workers", "1"]].concat());
    let told = |said: &Said| -> Vec<serde_json::Value> {
        let lines = said.stdout.lines();
        let all = lines.map(|line| serde_json::from_str::<serde_json::Value>(line).expect("JSON"));
        all.map(|run| serde_json::json!([run["job"], run["metrics"], run["solver"]])).collect()
    };
    assert_eq!(told(&one), told(&two));
    assert_eq!(told(&one).len(), 2);
    let text = std::fs::read_to_string(&csv).expect("a table");
    assert_eq!(text.lines().count(), 1 + 2 * 5, "{text}");
    // Every second part of a line is in quotes.
    let bare = |line: &str| line.split('"').step_by(2).collect::<String>();
    let columns = |line: &str| bare(line).split(',').count();
    assert!(text.lines().all(|line| columns(line) == 17), "{text}");
    assert!(text.lines().skip(1).all(|line| line.contains(",world,,") && line.ends_with(",ok")));
    for end in ["csv", "mcap", "png"] {
        let file = out.join(format!("h1-bounce.scene.world.step-1_240_s.{end}"));
        assert!(file.metadata().is_ok_and(|data| data.len() > 1000), "{}", file.display());
    }
    std::fs::remove_dir_all(&out).ok();
    let slow = bench("r5-stack", &["--limit", "0.01", "--json"]);
    let told: serde_json::Value = serde_json::from_str(&slow.stdout).expect("JSON");
    assert_eq!((slow.code, told["status"].as_str()), (3, Some("timeout")));
    assert_eq!(told["metrics"].as_array().map(Vec::len), Some(2));
    assert!(told["step"].as_f64().is_some_and(|step| step > 0.0), "{told}");
    let wrong = bench("r5-stack", &["--sweep", "scene.world.step=1/60 s,1 s"]);
    assert_eq!(wrong.code, 64);
    assert!(wrong.stderr.contains("scene.world.step: must be at most 0.05 s"), "{}", wrong.stderr);
}

/// A mesh without a volume, then bodies that stand in one another: a line each, and what comes
/// after them is run. Where there is no mesh at all nothing is.
#[test]
fn a_scene_that_cannot_be_made_is_a_status_and_the_next_one_runs() {
    let out = unique("scene-geometry");
    std::fs::create_dir_all(&out).expect("a folder");
    let (csv, file) = (out.join("all.csv"), out.join("thing.toml"));
    let meshes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/corpus/meshes");
    for name in ["one.obj", "clean.obj"] {
        std::fs::copy(meshes.join(name), out.join(name)).expect("a mesh");
    }
    let text = "[scene.world]\nduration = 0.01\n\
        [[scene.body]]\nname = \"thing\"\nmesh = \"clean.obj\"\nfit = \"10 cm\"\n\
        position = [0, 0, 1]\nmaterial = \"plaster\"\n\
        [[scene.body]]\nname = \"ball\"\nshape = { kind = \"sphere\", radius = \"5 cm\" }\n\
        position = [0, 0, 2]\nmaterial = \"steel\"\n\
        [[probe]]\nname = \"z\"\nkind = \"position\"\nbody = \"thing\"\ncomponent = \"z\"\n\
        [[metric]]\nname = \"end\"\nprobe = \"z\"\nreduce = \"final\"\n";
    std::fs::write(&file, text).expect("a file");
    let mesh = |name: &str| format!("{:?}", out.join(name));
    let sweep = format!("scene.body.thing.mesh={},{}", mesh("one.obj"), mesh("clean.obj"));
    let (table, place) = (csv.to_string_lossy(), "scene.body.ball.position=[0,0,1],[0,0,2]");
    let more = ["--sweep", &sweep, "--sweep", place, "--csv", &table, "--workers", "2"];
    let said = Cullet::new(&["bench", "-q"]).path(&file).args(&more).output();
    assert_eq!(said.code, 3, "{}{}", said.stdout, said.stderr);
    for why in ["scene.body.thing.mesh: the mesh", "scene.body.ball.position: \"ball\" overlaps"] {
        assert!(said.stdout.contains(&format!("geometry: {why}")), "{}", said.stdout);
    }
    let text = std::fs::read_to_string(&csv).expect("a table");
    let words: Vec<&str> = text.lines().filter_map(|line| line.rsplit(',').next()).collect();
    assert_eq!(words, ["status", "geometry", "geometry", "geometry", "ok"], "{text}");
    let set = format!("scene.body.thing.mesh={}", mesh("none.obj"));
    let said = Cullet::new(&["bench", "-q", "--set", &set]).path(&file).output();
    assert_eq!(said.code, 64, "{}", said.stdout);
    assert!(said.stderr.contains("scene.body.thing.mesh: cannot read"), "{}", said.stderr);
    std::fs::remove_dir_all(&out).ok();
}
