//! The coupling of solver and rigid world, and the rigid world itself, as the catalogue has them:
//! R1 to R7 and H3. What the world can show alone is shown in `services/world/tests`: there R1 on
//! grids (`replace.rs`), R4's closing speed, R6 to 1:200 and R7's first touch (`impacts.rs`), R7's
//! push handed over (`replace.rs`). Here pieces are those of real cuts, and runs go through the
//! binary.

mod common;

use common::{Cullet, summary, unique};
use cullet_fracture::cut::{CutSettings, Partition, by_sites};
use cullet_fracture::detail::Detail;
use cullet_geometry::math::unit;
use cullet_geometry::shapes::{self, Detail as Facets};
use cullet_geometry::{Mat3, Pose, Solid, TriMesh, Vec3};
use cullet_world::{BodyId, BodySpec, Material, Piece, World, WorldSettings};
use std::sync::Arc;

const GLASS: Material = Material {
    density: 2500.0,
    young: 70e9,
    poisson: 0.22,
    failure_stress: 50e6,
    fracture_energy: 8.0,
    restitution: 0.3,
    friction: 0.4,
};

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
    let settings =
        CutSettings { min_volume_ratio: 0.0, max_fragments: 1000, seed: 1, detail: Detail::NONE };
    let times = vec![1e-5; sites.len()];
    by_sites(&Solid::outer(mesh.clone()), sites, &labels, &times, &settings).expect("a cut")
}

fn scattered(count: u64, size: f64) -> Vec<Vec3> {
    (0..count).map(|i| Vec3::from([0, 1, 2].map(|a| size * (unit(4, a, i) - 0.5)))).collect()
}

/// The cuts that R1 to R3 ask for.
fn cuts() -> Vec<(&'static str, TriMesh, Vec<Vec3>)> {
    let octant = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 0.05 } else { -0.05 };
        // Off the lattice by less than a thousandth: a lattice has corners of eight cells.
        let off = Vec3::from([0, 1, 2].map(|a| 5e-5 * (unit(9, a, i.into()) - 0.5)));
        Vec3::new(side(0), side(1), side(2)) + off
    };
    vec![
        ("half spheres", ball(0.1, 120), vec![Vec3::z() * -0.04, Vec3::z() * 0.04]),
        ("a sphere's cells", ball(0.1, 60), scattered(20, 0.15)),
        ("octants", cube(0.2), (0..8).map(octant).collect()),
        ("64 cells", cube(0.2), scattered(64, 0.198)),
    ]
}

fn pieces(partition: Partition) -> Vec<Piece> {
    let piece = |part: cullet_fracture::cut::Part| Piece {
        solid: part.solid,
        hulls: part.hulls,
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
    };
    partition.parts.into_iter().map(piece).collect()
}

fn spec(name: &str, mesh: &TriMesh, at: Vec3) -> BodySpec {
    BodySpec {
        name: name.into(),
        solid: Arc::new(Solid::outer(mesh.clone())),
        hulls: vec![mesh.vertices.clone()],
        material: GLASS,
        pose: Pose::translation(at.x, at.y, at.z),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        fixed: false,
        breakable: true,
        weakest: 1.0,
        threshold: None,
        parent: None,
        generation: 0,
        original_volume: None,
    }
}

fn boxed(size: Vec3) -> TriMesh {
    shapes::cuboid(size, Facets::default()).expect("a box")
}

/// A fixed slab whose top is at z = 0.
fn floor(world: &mut World) {
    let slab = spec("floor", &boxed(Vec3::new(4.0, 4.0, 1.0)), Vec3::new(0.0, 0.0, -0.5));
    put(world, BodySpec { fixed: true, breakable: false, ..slab });
}

fn put(world: &mut World, spec: BodySpec) -> BodyId {
    world.insert(spec).expect("the body is sound")
}

fn height(world: &World, id: BodyId) -> f64 {
    world.body(id).expect("it is there").pose.translation.vector.z
}

/// R1: a body that flies and turns goes, the parts of a real cut come: mass, both momenta and
/// energy stay, to 1e-12.
#[test]
fn r1_a_split_keeps_mass_momentum_and_energy() {
    for (what, mesh, sites) in cuts() {
        let settings = WorldSettings { gravity: Vec3::zeros(), ..WorldSettings::default() };
        let mut world = World::new(settings).expect("a world");
        let body = spec(what, &mesh, Vec3::new(1.0, -2.0, 0.5));
        let (velocity, spin) = (Vec3::new(3.0, 1.0, -2.0), Vec3::new(4.0, -9.0, 1.0));
        let id = put(&mut world, BodySpec { velocity, spin, ..body });
        let before = world.totals();
        let parts = pieces(cut(&mesh, &sites));
        assert_eq!(parts.len(), sites.len(), "{what}");
        world.replace(id, &[], parts, 0.0).expect("it is replaced");
        let after = world.totals();
        let mass = after.mass / before.mass - 1.0;
        let energy = after.kinetic_energy / before.kinetic_energy - 1.0;
        let linear = (after.momentum - before.momentum).norm() / before.momentum.norm();
        let turned = after.angular_momentum - before.angular_momentum;
        let angular = turned.norm() / before.angular_momentum.norm();
        for error in [mass, energy, linear, angular] {
            assert!(error.abs() < 1e-12, "{what}: {mass} {energy} {linear} {angular}");
        }
    }
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
    for part in cut(&all[2].1, &all[2].2).parts {
        let own = part.solid.mesh.mass_properties();
        assert!((own.volume / 1e-3 - 1.0).abs() < 2e-3, "{}", own.volume);
        for axis in 0..3 {
            let got = own.inertia[(axis, axis)] / (own.volume * 0.01 / 6.0);
            assert!((got - 1.0).abs() < 4e-3, "{got}");
        }
    }
}

/// R5: ten blocks on each other for a minute: none drifts by a millimetre, none is hit.
#[test]
fn r5_a_stack_of_ten_stands_for_a_minute() {
    let mut world = World::new(WorldSettings::default()).expect("a world");
    floor(&mut world);
    let place = |k: usize| Vec3::new(0.0, 0.0, 0.05 + 0.1 * k as f64);
    let ids: Vec<BodyId> =
        (0..10).map(|k| put(&mut world, spec("block", &cube(0.1), place(k)))).collect();
    for _ in 0..240 * 60 {
        let hits = world.step().expect("the step is sound");
        assert!(hits.is_empty(), "{hits:?}");
    }
    for (k, id) in ids.iter().enumerate() {
        let at = world.body(*id).expect("it is there").pose.translation.vector;
        let drift = (at - place(k)).norm();
        assert!(drift < 1e-3, "block {k} drifted by {drift} m");
    }
}

/// How far a heavy block sinks on a light slice, over the slice's size, at the worst of 4 s.
fn sink(ratio: f64) -> f64 {
    let mut world = World::new(WorldSettings::default()).expect("a world");
    floor(&mut world);
    let slice = boxed(Vec3::new(0.2, 0.2, 0.05));
    let light = Material { density: 4.0 * GLASS.density / ratio, ..GLASS };
    let thin = spec("slice", &slice, Vec3::new(0.0, 0.0, 0.025));
    put(&mut world, BodySpec { material: light, ..thin });
    let block = put(&mut world, spec("block", &cube(0.2), Vec3::new(0.0, 0.0, 0.15)));
    let mut worst: f64 = 0.0;
    for _ in 0..240 * 4 {
        world.step().expect("the step is sound");
        worst = worst.max(0.15 - height(&world, block));
    }
    worst / 0.2
}

/// R6: a light slice under a heavy block. Below 1 % of the size to 1:200; at 1:10⁴ it is not: the
/// gap, which the document gives.
#[test]
fn r6_a_light_slice_bears_two_hundred_of_its_weight_and_not_ten_thousand() {
    for ratio in [100.0, 200.0] {
        let sunk = sink(ratio);
        assert!(sunk < 0.01, "1:{ratio}: {sunk}");
    }
    let sunk = sink(1e4);
    println!("1:10⁴ sinks by {sunk} of its size");
    assert!(sunk > 0.01, "1:10⁴ holds now ({sunk}): say so in docs/specimens.md");
}

/// H3: a drop loses nothing in flight, in the bounce what the formula says, and at the break what
/// the report says, cracks paid: each to 2 %.
#[test]
fn h3_the_energy_of_a_drop_is_accounted_for() {
    let mut world = World::new(WorldSettings::default()).expect("a world");
    let slab = spec("floor", &boxed(Vec3::new(4.0, 4.0, 1.0)), Vec3::new(0.0, 0.0, -0.5));
    let slick = Material { friction: 0.0, ..GLASS };
    put(&mut world, BodySpec { material: slick, fixed: true, breakable: false, ..slab });
    let mesh = cube(0.1);
    let turn = cullet_geometry::Quat::from_euler_angles(0.5, 0.6, 0.2);
    // No friction: what the bounce takes is then a formula.
    let body = BodySpec { material: slick, ..spec("block", &mesh, Vec3::zeros()) };
    let pose = Pose::from_parts(Vec3::new(0.0, 0.0, 0.6).into(), turn);
    let id = put(&mut world, BodySpec { pose, ..body });
    let energy = |world: &World| world.totals().kinetic_energy + world.totals().potential_energy;
    let start = energy(&world);
    let (last, hits) = loop {
        let before = energy(&world);
        let hits = world.step().expect("the step is sound");
        if !hits.is_empty() {
            break (before, hits);
        }
    };
    assert!((last / start - 1.0).abs() < 0.02, "free fall keeps it: {last} of {start} J");
    let bounced = last - energy(&world);
    // The part of ½ m* v² that a restitution of 0.3 does not give back.
    let formula = hits[0].impact.energy * (1.0 - 0.09);
    assert!((bounced - formula).abs() < 0.02 * start, "{bounced} J, not {formula} J");
    // What a solver hands over: the push of the contact, and pieces that fly apart.
    let partition = cut(&mesh, &scattered(30, 0.099));
    let cost = GLASS.fracture_energy * partition.crack_area;
    let mass = world.body(id).expect("it is there").mass;
    let push = hits[0].impact.normal * (hits[0].impact.impulse / mass);
    let mut parts = pieces(partition);
    for (k, part) in (0..).zip(&mut parts) {
        part.velocity = push + Vec3::from([0, 1, 2].map(|a| 2.0 * unit(5, a, k) - 1.0));
    }
    let report = world.replace(id, &hits, parts, cost).expect("it can pay");
    let lost = report.energy_before - report.energy_after;
    let closure = (last - energy(&world) - lost) / start;
    println!("{start} J: bounce {bounced} J, cracks {cost} J, lost {lost} J, closure {closure}");
    assert!(closure.abs() < 0.02, "{closure}: {report:?}");
    assert!(cost > 0.03 * start && lost >= cost && report.fracture_energy == cost, "{report:?}");
}

/// Runs a scene and tells its summary and its events.
fn run(name: &str, scene: &str, more: &[&str]) -> (serde_json::Value, String) {
    let folder = unique(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let (file, out) = (folder.join("scene.toml"), folder.join("out"));
    std::fs::write(&file, scene).expect("a file");
    let run = Cullet::new(&["run", "-q", "--out"]).path(&out).path(&file).args(more).output();
    assert_eq!(run.code, 0, "{name}: {}", run.stderr);
    let told = summary(&out);
    let events = Cullet::new(&["inspect"]).path(&out.join("run.mcap")).output().stdout;
    std::fs::remove_dir_all(&folder).ok();
    (told, events)
}

const DROP: &str = r#"
[world]
duration = 0.05
max_generation = 1
[fracture]
max_particles = 6000
[[body]]
name = "floor"
shape = { kind = "box", size = [4, 4, "20 cm"] }
position = [0, 0, "-10 cm"]
material = "granite"
fixed = true
[[body]]
name = "block"
shape = { kind = "box", size = ["14 cm", "14 cm", "14 cm"] }
position = [0, 0, 0.15]
rotation = { euler_degrees = [20, 10, 15] }
velocity = [0, 0, -6]
material = "plaster"
"#;

/// R4: whether a block breaks does not depend on the world's step. Into how many pieces it does
/// not by more than 10 % up to the default step; beyond, the block has turned and sunk by other
/// amounts when it is hit: a gap, which the document gives.
#[test]
fn r4_the_step_of_the_world_does_not_decide() {
    let pieces = |step: &str| {
        let set = format!("world.step=\"{step}\"");
        let (told, _) = run("r4", DROP, &["--set", &set]);
        assert_eq!(told["fractures"], 1, "{step}: {told:#}");
        told["fragments"].as_f64().expect("a number")
    };
    let first = pieces("1/1000 s");
    for (step, most) in [("1/480 s", 0.1), ("1/240 s", 0.1), ("1/60 s", 0.5), ("1/30 s", 0.5)] {
        let now = pieces(step);
        println!("{step}: {now} of {first}");
        assert!((now / first - 1.0).abs() <= most, "{step}: {now} pieces, not {first}");
    }
}

const WALL: &str = r#"
[world]
duration = 0.06
step = "1/960 s"
max_generation = 1
gravity = [0, 0, 0]
[fracture]
max_particles = 16000
[[body]]
name = "wall"
shape = { kind = "box", size = ["1 cm", "10 cm", "10 cm"] }
material = "plaster"
[[body]]
name = "catcher"
shape = { kind = "box", size = ["20 cm", 2, 2] }
position = [0.45, 0, 0]
material = "plaster"
solver = "geometric"
[[body]]
name = "ball"
shape = { kind = "sphere", radius = "5 mm" }
position = [-0.05, 0.003, 0.002]
material = "steel"
"#;

/// R7: a steel ball of 10 mm through a wall of 10 mm: the wall is hit first at any speed, and what
/// is left of the ball's speed at the catcher behind it grows with what it had. Below 100 m/s what
/// is left is decided by which pieces it has to push out of its way: 32 m/s of 70.
#[test]
fn r7_a_ball_goes_through_a_wall_and_never_past_it() {
    let mut last = 0.0;
    for speed in [50.0, 100.0, 200.0, 300.0] {
        let set = format!("body.ball.velocity=[{speed}, 0, 0]");
        let (_, events) = run("r7", WALL, &["--set", &set]);
        let hit = events.lines().find(|line| line.contains(" hits ")).expect("a hit");
        assert!(hit.contains("ball hits wall"), "{events}");
        // What stays in the wall is not caught.
        let caught = events.lines().find(|line| line.contains("ball hits catcher"));
        let left = caught.map_or(0.0, |line| {
            let words = line.split(" at ").nth(1).expect("a speed");
            words.split(' ').next().and_then(|v| v.parse().ok()).expect("a number")
        });
        println!("{speed} m/s: {left} m/s left");
        assert!(left < speed, "{speed} m/s: {left}");
        // At 50 m/s it stays there.
        assert!(left > last || speed < 100.0, "{speed} m/s: {left}, after {last}");
        last = left;
    }
}
