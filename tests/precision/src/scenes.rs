//! The scenes, for whichever engine the parent module names `rapier`.

use super::rapier::math::{Real, Vector};
use super::rapier::prelude::{
    ColliderBuilder, IntegrationParameters, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
    SpringCoefficients,
};
use std::time::Instant;

/// Step of the world \[s\] and its substeps, as in the rigid world.
const STEP: f64 = 1.0 / 240.0;
const SUBSTEPS: usize = 8;
/// Side of a box \[m\] and density \[kg/m³\] where nothing else is said.
const SIDE: f64 = 0.1;
const DENSITY: f64 = 2500.0;

/// All rows, in the order of the table.
pub(crate) fn rows() -> Vec<(String, f64)> {
    let mut rows = pile();
    rows.extend(stack());
    rows.extend(stored());
    [0.0, 1e3, 1e4].iter().for_each(|at| rows.extend(collision(*at)));
    rows.extend(sandwich());
    rows
}

fn row(what: &str, value: f64) -> (String, f64) {
    (what.to_owned(), value)
}

fn real(value: f64) -> Real {
    value as Real
}

fn vector(x: f64, y: f64, z: f64) -> Vector {
    Vector::new(real(x), real(y), real(z))
}

fn wide(v: Vector) -> [f64; 3] {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A number in (−1, 1) that belongs to `k`.
fn any(k: u64) -> f64 {
    let mut x = k.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    2.0 * ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
}

/// A world with the settings of the rigid world.
fn world(gravity: f64) -> PhysicsWorld {
    let stiff = |hz: f64| SpringCoefficients::new(real(hz), real(10.0));
    let unit = 0.1;
    PhysicsWorld {
        gravity: vector(0.0, 0.0, -gravity),
        integration_parameters: IntegrationParameters {
            dt: real(STEP),
            length_unit: real(unit),
            num_solver_iterations: SUBSTEPS,
            contact_softness: stiff(240.0),
            static_contact_softness: stiff(480.0),
            normalized_max_corrective_velocity: real(0.2 / unit),
            normalized_max_linear_velocity: real(2e6 / unit),
            // The rigid world's hooks keep the engine from it.
            contact_recycling: false,
            ..IntegrationParameters::default()
        },
        ..PhysicsWorld::default()
    }
}

/// Puts in a box of that size \[m\] and density \[kg/m³\].
fn put(world: &mut PhysicsWorld, size: [f64; 3], density: f64, at: Vector) -> RigidBodyHandle {
    let body = RigidBodyBuilder::dynamic().translation(at).can_sleep(false);
    let [x, y, z] = size.map(|side| real(side / 2.0));
    let shape = ColliderBuilder::cuboid(x, y, z).density(real(density)).friction(real(0.4));
    world.insert(body, shape).0
}

/// A slab whose top is at z = 0.
fn floor(world: &mut PhysicsWorld) {
    let body = RigidBodyBuilder::fixed().translation(vector(0.0, 0.0, -1.0));
    let shape = ColliderBuilder::cuboid(real(10.0), real(10.0), real(1.0)).friction(real(0.4));
    world.insert(body, shape);
}

/// Deepest overlap of any pair now \[m\].
fn deepest(world: &PhysicsWorld) -> f64 {
    let manifolds = world.contact_pairs().flat_map(|pair| pair.manifolds());
    let depths = manifolds.flat_map(|m| &m.points).map(|point| -f64::from(point.dist));
    depths.fold(0.0, f64::max)
}

fn at(world: &PhysicsWorld, id: RigidBodyHandle) -> [f64; 3] {
    wide(world.bodies[id].translation())
}

/// 1000 boxes fall onto a floor and come to rest: 4 s.
fn pile() -> Vec<(String, f64)> {
    let mut world = world(9.81);
    floor(&mut world);
    for k in 0..1000u32 {
        // Every other layer is half a box aside, so that no stacks stand.
        let (x, y, z) = (f64::from(k % 10), f64::from(k / 10 % 10), f64::from(k / 100));
        let aside = 0.13 * (0.5 * (z % 2.0) - 5.0);
        let shake = |axis: u64| 0.02 * any(3 * u64::from(k) + axis);
        let (x, y) = (0.13 * x + aside + shake(0), 0.13 * y + aside + shake(1));
        put(&mut world, [SIDE; 3], DENSITY, vector(x, y, 0.1 + 0.15 * z + shake(2)));
    }
    let mut times = Vec::new();
    for _ in 0..(4.0 / STEP) as u32 {
        let start = Instant::now();
        world.step();
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    vec![
        row("pile of 1000: median time a step [ms]", 1e3 * times[times.len() / 2]),
        row("pile of 1000: deepest overlap after 4 s [mm]", 1e3 * deepest(&world)),
    ]
}

/// Ten boxes stand on each other for 60 s.
fn stack() -> Vec<(String, f64)> {
    let mut world = world(9.81);
    floor(&mut world);
    let height = |k: u32| SIDE * (f64::from(k) + 0.5);
    let ids: Vec<_> =
        (0..10).map(|k| put(&mut world, [SIDE; 3], DENSITY, vector(0.0, 0.0, height(k)))).collect();
    (0..(60.0 / STEP) as u32).for_each(|_| world.step());
    let (mut aside, mut sunk) = (0.0f64, 0.0f64);
    for (k, id) in (0..10).zip(&ids) {
        let [x, y, z] = at(&world, *id);
        aside = aside.max(x.hypot(y));
        sunk = sunk.max(height(k) - z);
    }
    vec![
        row("stack of 10 after 60 s: sideways [mm]", 1e3 * aside),
        row("stack of 10 after 60 s: sunk [mm]", 1e3 * sunk),
    ]
}

/// What is left of zero when 1000 velocities whose momenta cancel are stored and read back.
fn stored() -> Vec<(String, f64)> {
    let mut world = world(0.0);
    let (mut sum, mut size) = ([0.0; 3], 0.0);
    for k in 0..1000u64 {
        // Of two with opposite momenta the second has 1.7 times the mass.
        let (density, speed) = if k % 2 == 0 { (1000.0, 17.0) } else { (1700.0, -10.0) };
        let id = put(&mut world, [SIDE; 3], density, vector(k as f64, 0.0, 0.0));
        let v = [0, 1, 2].map(|axis| speed * any(5000 + 3 * (k / 2) + axis));
        world.bodies[id].set_linvel(vector(v[0], v[1], v[2]), true);
        let mass = density * SIDE * SIDE * SIDE;
        let kept = wide(world.bodies[id].linvel());
        sum.iter_mut().zip(kept).for_each(|(s, v)| *s += mass * v);
        size += mass * length(kept);
    }
    vec![row("1000 momenta stored: error over their sum", length(sum) / size)]
}

/// Two boxes meet off-centre, far from the origin.
fn collision(distance: f64) -> Vec<(String, f64)> {
    let mut world = world(0.0);
    let one = put(&mut world, [SIDE; 3], DENSITY, vector(distance - 0.2, 0.0, 0.0));
    let two = put(&mut world, [SIDE; 3], 2.0 * DENSITY, vector(distance + 0.2, 0.03, 0.02));
    world.bodies[one].set_linvel(vector(5.0, 0.0, 0.0), true);
    world.bodies[two].set_linvel(vector(-3.0, 0.1, 0.0), true);
    let mass = [1.0, 2.0].map(|m| m * DENSITY * SIDE * SIDE * SIDE);
    let start = at(&world, one);
    let momenta = |world: &PhysicsWorld| {
        let v = [one, two].map(|id| wide(world.bodies[id].linvel()));
        [0, 1, 2].map(|k| mass[0] * v[0][k] + mass[1] * v[1][k])
    };
    let size = 5.0 * mass[0] + 3.0 * mass[1];
    let before = momenta(&world);
    (0..4).for_each(|_| world.step());
    let path = at(&world, one)[0] - start[0] - 5.0 * 4.0 * STEP;
    (0..116).for_each(|_| world.step());
    let after = momenta(&world);
    let off = length([0, 1, 2].map(|k| after[k] - before[k])) / size;
    let name = format!("collision {distance} m out");
    vec![
        row(&format!("{name}: momentum error"), off),
        row(&format!("{name}: path error of a flight of 83 mm [mm]"), 1e3 * path.abs()),
    ]
}

/// A light slice on the floor under 10⁴ times its mass, 4 s.
fn sandwich() -> Vec<(String, f64)> {
    let mut world = world(9.81);
    floor(&mut world);
    put(&mut world, [0.2, 0.2, 0.05], 1.0, vector(0.0, 0.0, 0.025));
    let top = put(&mut world, [0.2; 3], 2500.0, vector(0.0, 0.0, 0.15));
    (0..(4.0 / STEP) as u32).for_each(|_| world.step());
    vec![row("slice under 10⁴ its mass: sunk [mm]", 1e3 * (0.15 - at(&world, top)[2]))]
}
