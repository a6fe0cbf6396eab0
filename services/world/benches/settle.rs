//! How long a step takes while fragments settle.

#[path = "../tests/fast/common/mod.rs"]
mod common;

use common::*;
use cullet_geometry::Vec3;
use cullet_world::{BodySpec, World, WorldSettings};
use divan::Bencher;

fn main() {
    divan::main();
}

/// A block of n³ jagged fragments, `age` steps after it hit the floor.
fn heap(n: usize, age: u32) -> World {
    let size = Vec3::repeat(0.05 * n as f64);
    let mut world = World::new(WorldSettings::default()).unwrap();
    put(&mut world, floor());
    let block = body("block", cuboid(size), GLASS, Vec3::new(0.0, 0.0, size.z * 0.5 + 0.01));
    let block = put(&mut world, BodySpec { velocity: Vec3::new(0.0, 0.0, -3.0), ..block });
    let hits = until_hit(&mut world, 20);
    let mut pieces = cells(size, n, 0.3);
    for (k, piece) in pieces.iter_mut().enumerate() {
        let u = |s| 2.0 * cullet_geometry::math::unit(1, s, k as u64) - 1.0;
        piece.velocity = Vec3::new(u(0), u(1), u(2) + 2.5);
    }
    world.replace(block, &hits, pieces, 1.0).unwrap();
    steps(&mut world, age);
    world
}

/// 24 steps (0.1 s) of a heap, right after the break and a second later.
#[divan::bench(args = [(5, 0), (5, 240), (10, 0), (10, 240)], sample_count = 3)]
fn steps_24(bencher: Bencher<'_, '_>, (n, age): (usize, u32)) {
    bencher.with_inputs(|| heap(n, age)).bench_local_values(|mut world| steps(&mut world, 24));
}

/// Two blocks of n³ / 2 cubes each that fly through each other, `age` steps after they met.
fn clash(n: usize, age: u32) -> World {
    let free = WorldSettings { max_bodies: n * n * n, ..WorldSettings::default() };
    let mut world = World::new(free).unwrap();
    for k in 0..n * n * n {
        let at = Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64) * 0.1;
        let side = if k % n < n / 2 { 1.0 } else { -1.0 };
        let jitter = |s| 0.02 * cullet_geometry::math::unit(1, s, k as u64);
        let place = at + Vec3::new(jitter(0) - 0.05 * side, jitter(1), jitter(2));
        let cube = body(&format!("cube {k}"), cuboid(Vec3::repeat(0.03)), GLASS, place);
        let velocity = Vec3::new(20.0 * side, 0.0, 0.0);
        put(&mut world, BodySpec { velocity, ..cube });
    }
    steps(&mut world, age);
    world
}

/// A step in which hundreds of bodies go farther than they are large, and meet others (F42).
#[divan::bench(args = [(10, 0), (10, 3), (20, 0), (20, 3)], sample_count = 3)]
fn clash_step(bencher: Bencher<'_, '_>, (n, age): (usize, u32)) {
    bencher.with_inputs(|| clash(n, age)).bench_local_values(|mut world| steps(&mut world, 1));
}

/// A body of 1000 fragments is replaced, contacts and all.
#[divan::bench(sample_count = 3)]
fn replace_1000(bencher: Bencher<'_, '_>) {
    let ready = || {
        let mut world = World::new(WorldSettings::default()).unwrap();
        let size = Vec3::repeat(0.5);
        let block = put(&mut world, body("block", cuboid(size), GLASS, Vec3::zeros()));
        (world, block, cells(size, 10, 0.3))
    };
    bencher.with_inputs(ready).bench_local_values(|(mut world, block, pieces)| {
        world.replace(block, &[], pieces, 0.0).unwrap();
        world
    });
}
