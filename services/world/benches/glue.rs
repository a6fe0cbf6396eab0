//! How long a step takes of a wall of 300 glued bricks.

#[path = "../tests/fast/common/mod.rs"]
mod common;

use common::*;
use cullet_geometry::Vec3;
use cullet_world::{BodyId, BodySpec, GlueBodies, GlueLimit, GlueSpec, World, WorldSettings};
use divan::Bencher;

fn main() {
    divan::main();
}

const BRICK: Vec3 = Vec3::new(0.2, 0.1, 0.08);

/// A wall of 20 × 15 bricks that stands on the floor, `age` steps after it was glued, with a ball
/// that hits it in the next step, if it is to be struck.
fn wall(glued: bool, struck: bool, age: u32) -> World {
    let mut world = World::new(WorldSettings::default()).unwrap();
    put(&mut world, floor());
    let mut bricks: Vec<BodyId> = Vec::new();
    for k in 0..300 {
        let (column, row) = (f64::from(k % 20), f64::from(k / 20));
        let shift = if k / 20 % 2 == 0 { 0.0 } else { BRICK.x / 2.0 };
        let at = Vec3::new(BRICK.x * (column - 9.5) + shift, 0.0, BRICK.z * (row + 0.5));
        let brick = body("brick", cuboid(BRICK), GLASS, at);
        bricks.push(put(&mut world, BodySpec { breakable: false, ..brick }));
    }
    if glued {
        let limit = GlueLimit::Stress { tensile: 2e5, shear: 2e5 };
        let spec = GlueSpec { bodies: GlueBodies::Group(bricks), limit, gap: 1e-4 };
        world.glue(&spec).unwrap();
    }
    steps(&mut world, age);
    if struck {
        let ball = body("ball", sphere(0.08, 6), STEEL, Vec3::new(0.0, -0.2, 0.6));
        let velocity = Vec3::new(0.0, 20.0, 0.0);
        put(&mut world, BodySpec { velocity, breakable: false, ..ball });
    }
    world
}

/// 10 steps at rest, awake: without glue, and with it.
#[divan::bench(args = [false, true], sample_count = 5)]
fn rest_10_steps(bencher: Bencher<'_, '_>, glued: bool) {
    bencher
        .with_inputs(|| wall(glued, false, 10))
        .bench_local_values(|mut world| steps(&mut world, 10));
}

/// 10 steps with a blow in one of the first.
#[divan::bench(args = [false, true], sample_count = 5)]
fn blow_10_steps(bencher: Bencher<'_, '_>, glued: bool) {
    bencher
        .with_inputs(|| wall(glued, true, 10))
        .bench_local_values(|mut world| steps(&mut world, 10));
}
