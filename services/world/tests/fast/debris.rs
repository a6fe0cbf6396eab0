//! Debris: grains keep mass and momentum, fly, and come to rest on what does not move.

use crate::common;

use common::*;
use cullet_geometry::Vec3;
use cullet_model::{Fragment, Grain};
use cullet_world::{Breakage, ReplaceError, World};

/// The cells of the cube, the last of them as grains of these shares.
fn crumbled(shares: &[f64]) -> (Vec<Fragment>, Vec<Grain>) {
    let mut pieces = cells(CUBE, 2, 0.0);
    let last = pieces.pop().unwrap();
    let moments = last.solid.mesh.mass_properties();
    let whole: f64 = shares.iter().sum();
    let grain = |(k, share): (usize, &f64)| Grain {
        position: moments.centroid + any3(5, 10 * k as u64) * 0.03,
        velocity: any3(6, 10 * k as u64) * 2.0,
        volume: moments.volume * share / whole,
        size: 0.01 * share,
    };
    let grains = shares.iter().enumerate().map(grain).collect();
    (pieces, grains)
}

#[test]
fn fragments_and_grains_together_keep_the_books() {
    for case in 0..12 {
        let (mut world, cube, _, hits) = strike(case);
        let (mut pieces, grains) = crumbled(&[1.0, 0.5, 0.2, 0.1]);
        let mass = world.body(cube).unwrap().mass;
        let hit = hits[0].impact;
        shove(&mut pieces, case, &hit.normal, 0.6 * hit.impulse, mass, 0.2);
        for _ in 0..case % 3 {
            world.step().unwrap();
        }
        let before = world.totals();
        let breakage = Breakage { pieces, grains, fracture_energy: 0.01, ..Breakage::default() };
        let r = world.break_up(cube, &hits, breakage).unwrap();
        let after = world.totals();
        assert_eq!((r.fragments.len(), r.grains.len()), (7, 4));
        assert!((r.grain_mass / (mass / 8.0) - 1.0).abs() < 1e-12);
        assert!(r.mass_rel_error < 1e-12 && r.volume_rel_error < 1e-12, "{r:?}");
        assert!(r.momentum_rel_error < 1e-9 && r.angular_momentum_rel_error < 1e-9, "{r:?}");
        assert!(r.energy_gain_rel < 1e-9, "{r:?}");
        assert!((after.mass / before.mass - 1.0).abs() < 1e-12);
        let drift = (after.momentum - before.momentum).norm();
        assert!(drift < 1e-9 * before.mass * 15.0, "{drift}");
        assert_eq!(world.grains().len(), 4);
        assert!(world.grains().iter().all(|g| g.parent == cube && !g.resting));
    }
}

fn falling() -> World {
    let mut world = World::new(settings()).unwrap();
    put(&mut world, floor());
    let cube = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::new(0.0, 0.0, 1.0)));
    let (pieces, grains) = crumbled(&[1.0, 1.0, 1.0, 1.0, 1.0]);
    let breakage = Breakage { pieces, grains, ..Breakage::default() };
    world.break_up(cube, &[], breakage).unwrap();
    world
}

#[test]
fn grains_fly_and_come_to_rest_on_the_floor() {
    let mut world = falling();
    let (mass, start) = (world.totals().mass, world.grains().to_vec());
    for step in 1..=60 {
        world.step().unwrap();
        let time = f64::from(step) / 240.0;
        for (grain, first) in world.grains().iter().zip(&start).filter(|(g, _)| !g.resting) {
            // Semi-implicit Euler falls too far by g t dt / 2.
            let fall = -Vec3::z() * (9.81 * time * (time + 1.0 / 240.0) / 2.0);
            let wanted = first.position + first.velocity * time + fall;
            assert!((grain.position - wanted).norm() < 1e-9, "{}", grain.position - wanted);
        }
    }
    steps(&mut world, 300);
    for grain in world.grains() {
        assert!(grain.resting && grain.velocity == Vec3::zeros());
        assert!(grain.position.z.abs() < 1e-5, "it lies at {}", grain.position.z);
    }
    assert!((world.totals().mass / mass - 1.0).abs() < 1e-12, "no grain is lost");
    let (mut one, mut two) = (falling(), falling());
    steps(&mut one, 100);
    steps(&mut two, 100);
    assert_eq!(bits(&one), bits(&two));
}

#[test]
fn grains_that_are_none_are_refused() {
    let refuse = |change: fn(&mut Vec<Grain>)| {
        let mut world = World::new(settings()).unwrap();
        let cube = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
        let (pieces, mut grains) = crumbled(&[1.0, 1.0]);
        change(&mut grains);
        let error = world.break_up(cube, &[], Breakage { pieces, grains, ..Breakage::default() });
        assert!(world.body(cube).is_some() && world.grains().is_empty());
        error.unwrap_err()
    };
    assert!(matches!(refuse(|g| g[1].volume = -1e-9), ReplaceError::Grain { index: 1, .. }));
    assert!(matches!(refuse(|g| g[0].velocity.y = f64::NAN), ReplaceError::Grain { index: 0, .. }));
    assert!(matches!(refuse(|g| g[0].volume *= 0.9), ReplaceError::Volume { .. }));
}
