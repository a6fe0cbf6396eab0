//! Whole runs: energy over time, and the same bits again.

use crate::common;

use common::*;
use cullet_geometry::Vec3;
use cullet_world::{ContactMaterial, World};

#[test]
fn a_drop_loses_only_what_bouncing_friction_and_cracks_cost() {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let material = ContactMaterial { restitution: 0.7, ..GLASS };
    put(&mut world, body("ball", sphere(0.05, 4), material, Vec3::new(0.0, 0.0, 0.55)));
    let energy = |world: &World| world.totals().kinetic_energy + world.totals().potential_energy;
    let start = energy(&world);
    let hit = until_hit(&mut world, 200).remove(0);
    let lost = start - energy(&world);
    // ½ m* v² (1 − e²), e the mean of 0.7 and 0.3
    let want = hit.impact.energy * (1.0 - 0.5 * 0.5);
    assert!((lost - want).abs() < 0.05 * start, "lost {lost} J, not {want} J, of {start} J");
    let mut last = energy(&world);
    for _ in 0..400 {
        world.step().unwrap();
        let now = energy(&world);
        // A body stopped where it touches keeps the speed of the whole step: m g v dt at most.
        assert!(now < last + 4e-3 * start, "energy grew from {last} to {now} J");
        last = now;
    }
}

#[test]
fn the_same_run_gives_the_same_bits() {
    let run = || {
        let mut world = World::new(settings()).unwrap();
        put(&mut world, floor());
        for k in 0..4 {
            let at = Vec3::new(0.05 * f64::from(k), 0.0, 0.3 + 0.25 * f64::from(k));
            put(&mut world, body("cube", cuboid(CUBE), GLASS, at));
        }
        let mut broken = 0;
        for _ in 0..240 {
            for hit in world.step().unwrap() {
                let whole = world.body(hit.body).is_some_and(|b| b.generation == 0);
                if whole && broken < 2 {
                    let mass = world.body(hit.body).unwrap().mass;
                    let mut pieces = cells(CUBE, 3, 0.4);
                    shove(&mut pieces, 8, &hit.impact.normal, hit.impact.impulse, mass, 0.2);
                    if world.replace(hit.body, &[hit], pieces, 0.5).is_ok() {
                        broken += 1;
                    }
                }
            }
        }
        assert_eq!(broken, 2);
        bits(&world)
    };
    assert_eq!(run(), run());
}
