//! The rigid world and the push that couples it to a solve: F36, F73, F74.

use crate::kit::{STRONG, blow, body, cuboid, energy, rows};
use cullet_fracture::Impact;
use cullet_fracture::mpm::load::Load;
use cullet_geometry::{Pose, Quat, Solid, Vec3};
use cullet_world::{BodyId, BodySpec, Hit, World, WorldSettings};
use std::sync::Arc;

fn stone(density: f64) -> cullet_world::Material {
    cullet_world::Material {
        density,
        young: 30e9,
        poisson: 0.2,
        failure_stress: 10e6,
        fracture_energy: 10.0,
        restitution: 0.3,
        friction: 0.4,
    }
}

fn cube(side: f64, density: f64, at: Vec3, velocity: Vec3) -> BodySpec {
    let mesh = cuboid(Vec3::repeat(side));
    let hulls = vec![mesh.vertices.clone()];
    BodySpec {
        name: "cube".to_owned(),
        solid: Arc::new(Solid::outer(mesh)),
        hulls,
        material: stone(density),
        pose: Pose::translation(at.x, at.y, at.z),
        velocity,
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

/// Two cubes that meet at `at`, and the hits of their meeting.
fn meeting(at: Vec3, density: f64) -> (World, [BodyId; 2], Vec<Hit>) {
    let settings = WorldSettings {
        gravity: Vec3::zeros(),
        impulse_threshold: 1e-9,
        ..WorldSettings::default()
    };
    let mut world = World::new(settings).expect("settings");
    let left = cube(0.2, 2500.0, at - 0.25 * Vec3::x(), 5.0 * Vec3::x());
    let mut right = cube(0.1, density, at + 0.013 * Vec3::y(), Vec3::zeros());
    // A corner first: where faces meet, rounding decides which of their points touch.
    right.pose.rotation = Quat::from_euler_angles(0.6, 0.7, 0.3);
    let ids = [left, right].map(|spec| world.insert(spec).expect("a body"));
    let mut hits = Vec::new();
    for _ in 0..60 {
        hits.extend(world.step().expect("a step"));
    }
    (world, ids, hits)
}

/// F36: bodies a million times as heavy as what they hit throw it off, keep their momentum and
/// make no energy.
#[test]
fn extreme_masses_keep_momentum_and_make_no_energy() {
    for density in [0.02, 1.0, 2500.0, 9e5] {
        let (world, [left, _], hits) = meeting(Vec3::zeros(), density);
        assert!(!hits.is_empty(), "{density} kg/m³: they met");
        let mass = world.body(left).expect("there").mass;
        let after = world.totals();
        let error = (after.momentum - 5.0 * mass * Vec3::x()).norm();
        assert!(error < 1e-9 * mass, "{density} kg/m³: {error}");
        let before = 0.5 * mass * 25.0;
        assert!(after.kinetic_energy <= before * (1.0 + 1e-9), "{density} kg/m³");
        for body in world.bodies() {
            assert!(body.velocity.norm() < 11.0, "{density} kg/m³: {}", body.velocity);
        }
    }
}

/// F74: a hit ten kilometres out is the hit at the origin: all that a solve is told is in the
/// body's own frame, and poses are f64.
#[test]
fn a_hit_far_out_is_the_hit_at_the_origin() {
    let near = meeting(Vec3::zeros(), 2500.0).2;
    let far = meeting(Vec3::new(1e4, -1e4, 1e4), 2500.0).2;
    assert_eq!(near.len(), far.len());
    assert!(!near.is_empty());
    for (a, b) in near.iter().zip(&far) {
        let (a, b) = (a.impact, b.impact);
        assert!((a.point - b.point).norm() < 1e-6, "{} and {}", a.point, b.point);
        let pairs = [
            (a.impulse, b.impulse),
            (a.duration, b.duration),
            (a.radius, b.radius),
            (a.energy, b.energy),
            (a.closing_speed, b.closing_speed),
        ];
        for (a, b) in pairs {
            assert!((a / b - 1.0).abs() < 1e-6, "{a} and {b}");
        }
    }
}

/// F73: a striker so light and stiff that its contact is over within a step gives no more than it
/// has: neither impulse nor energy.
#[test]
fn a_stiff_light_striker_gives_no_more_than_it_has() {
    for share in [0.02, 0.3, 1.0, 4.0, 30.0] {
        let mut domain = body(&rows([8, 8, 8]), &STRONG);
        let mass = STRONG.density * 512.0 * 1e-6;
        let (striker, speed) = (1e-3 * mass, 20.0);
        let reduced = 1.0 / (1.0 / striker + 1.0 / mass);
        let impact = Impact {
            impulse: 2.0 * reduced * speed,
            energy: 0.5 * reduced * speed * speed,
            closing_speed: speed,
            duration: share * domain.step,
            radius: 1e-3,
            ..blow(Vec3::new(-0.04, 0.0, 0.0), Vec3::x(), 1.0)
        };
        let mut load = Load::new(&impact, &domain, impact.duration, 1.0 / mass);
        let mut most: f64 = 0.0;
        while !load.is_over() {
            load.push(&mut domain);
            domain.advance();
            most = most.max(energy(&domain));
        }
        println!("{share} steps: {:.3} of the impulse", load.delivered / impact.impulse);
        assert!(load.delivered <= impact.impulse * (1.0 + 1e-12), "{share}");
        assert!(most <= 1.02 * impact.energy, "{share} steps: {most} of {} J", impact.energy);
    }
}
