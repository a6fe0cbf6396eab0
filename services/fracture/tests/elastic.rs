//! Elastic verification: patch (E1), objectivity (E2), impact of two bars (E5), conservation (E11).

use cullet_fracture::Material;
use cullet_fracture::damage::Softening;
use cullet_fracture::mpm::Domain;
use cullet_fracture::mpm::elastic::Elastic;
use cullet_fracture::particles::Particles;
use cullet_geometry::{Mat3, Vec3, math::unit};

const STONE: Material = Material {
    density: 2450.0,
    young: 32e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 3.0,
};
const SPACING: f64 = 0.01;

/// Two points a cell and axis, at the quarter points of cells: a body of `cells` spacings.
fn lattice(cells: [usize; 3], low: Vec3) -> Vec<Vec3> {
    let [nx, ny, nz] = cells.map(|n| 2 * n);
    let mut points = Vec::new();
    for i in 0..nx * ny * nz {
        let at = Vec3::new((i / (ny * nz)) as f64, (i / nz % ny) as f64, (i % nz) as f64);
        points.push(low + (at + Vec3::repeat(0.5)) * (0.5 * SPACING));
    }
    points
}

/// A body that cannot break.
fn body(points: &[Vec3], material: &Material) -> Domain {
    let volume = points.len() as f64 * SPACING * SPACING * SPACING / 8.0;
    let particles = Particles::at_rest(points, volume, material.density);
    let strong = Material { failure_stress: 1e20, fracture_energy: 1e40, ..*material };
    Domain::new(particles, material, Softening::new(&strong, SPACING), SPACING)
}

fn cube() -> Domain {
    body(&lattice([8, 8, 8], Vec3::repeat(-4.0 * SPACING)), &STONE)
}

fn drive(domain: &mut Domain, gradient: Mat3, offset: Vec3) {
    for p in 0..domain.particles.len() {
        domain.particles.velocity[p] = gradient * domain.particles.position[p] + offset;
        domain.particles.affine[p] = gradient;
    }
}

fn greatest_stress(domain: &Domain) -> f64 {
    domain.particles.stress.iter().flatten().fold(0.0, |m, s| s.abs().max(m))
}

fn is_interior(x: &Vec3, margin: f64) -> bool {
    x.amax() < (4.0 - margin) * SPACING
}

/// E1: an affine displacement gives every point its exact stress, and no force inside.
#[test]
fn a_patch_is_exact() {
    let m = Mat3::new(0.3, -0.7, 0.2, 1.1, 0.5, -0.4, 0.6, 0.9, -0.8) * 1e-4;
    let mut domain = cube();
    let gradient = m / domain.step;
    drive(&mut domain, gradient, Vec3::zeros());
    domain.advance();
    let wanted = Elastic::new(&STONE).kirchhoff(&m);
    let scale = wanted.iter().fold(0.0_f64, |a, s| a.max(s.abs()));
    for stress in &domain.particles.stress {
        for (s, w) in stress.iter().zip(&wanted) {
            assert!((s - w).abs() < 1e-9 * scale, "{stress:?} is not {wanted:?}");
        }
    }

    let mut still = cube();
    for p in 0..still.particles.len() {
        still.particles.displacement_gradient[p] = m;
        still.particles.stress[p] = wanted;
    }
    still.advance();
    let speed = |inside: bool| {
        let pairs = still.particles.reference.iter().zip(&still.particles.velocity);
        pairs
            .filter(|(x, _)| is_interior(x, 2.5) == inside)
            .fold(0.0_f64, |m, (_, v)| m.max(v.norm()))
    };
    assert!(speed(true) < 1e-12 * speed(false), "{} beside {}", speed(true), speed(false));
}

/// E2: a rigid turn in 100 steps of 0.9 degrees or in one of 37 leaves no stress.
#[test]
fn a_rigid_turn_leaves_no_stress() {
    for (steps, degrees) in [(100, 90.0_f64), (1, 37.0)] {
        let mut domain = cube();
        let angle = degrees.to_radians() / f64::from(steps);
        let axis = Vec3::new(1.0, -2.0, 0.5).normalize();
        let turn = nalgebra::Rotation3::from_scaled_axis(axis * angle).into_inner();
        for _ in 0..steps {
            // The chord of the turn: positions and F both turn exactly.
            let gradient = (turn - Mat3::identity()) / domain.step;
            drive(&mut domain, gradient, Vec3::zeros());
            domain.advance();
        }
        let stress = greatest_stress(&domain) / STONE.young;
        assert!(stress < 1e-9, "{degrees} degrees: {stress}");
    }
}

/// E2: a fast translation leaves no stress.
#[test]
fn a_translation_leaves_no_stress() {
    let mut domain = cube();
    let velocity = Vec3::new(800.0, -600.0, 30.0);
    drive(&mut domain, Mat3::zeros(), velocity);
    for _ in 0..100 {
        domain.advance();
    }
    let stress = greatest_stress(&domain) / STONE.young;
    assert!(stress < 1e-9, "{stress}");
    let moved = domain.particles.position[0] - domain.particles.reference[0];
    assert!((moved - velocity * domain.time).norm() < 1e-9 * moved.norm());
}

/// E2: the stress of a stretched body that is let go turns and moves nothing as a whole.
#[test]
fn a_stretched_body_has_no_net_torque() {
    let mut domain = cube();
    let stretch = Mat3::new(1e-2, 4e-3, 0.0, 4e-3, -5e-3, 2e-3, 0.0, 2e-3, 3e-3);
    let stress = Elastic::new(&STONE).kirchhoff(&stretch);
    for p in 0..domain.particles.len() {
        domain.particles.displacement_gradient[p] = stretch;
        domain.particles.stress[p] = stress;
        domain.particles.position[p] += stretch * domain.particles.reference[p];
    }
    for _ in 0..50 {
        domain.advance();
    }
    let particles = &domain.particles;
    let speed: f64 = particles.velocity.iter().map(Vec3::norm).sum();
    let scale = particles.mass(0) * speed;
    assert!(scale > 0.0);
    assert!(particles.momentum().norm() < 1e-12 * scale);
    assert!(particles.angular_momentum(SPACING).norm() < 1e-12 * scale * 8.0 * SPACING);
}

/// E11: ten thousand free steps keep momentum and angular momentum; energy only falls.
#[test]
fn a_free_body_keeps_its_momenta() {
    let mut domain = body(&lattice([3, 3, 3], Vec3::new(0.003, -0.011, 0.007)), &STONE);
    let spin = Vec3::new(30.0, -20.0, 40.0);
    for p in 0..domain.particles.len() {
        let noise = |a| 0.3 * (unit(4, a, p as u64) - 0.5);
        let x = domain.particles.position[p];
        domain.particles.velocity[p] =
            spin.cross(&x) + Vec3::new(noise(0), noise(1), noise(2)) + Vec3::new(0.5, 0.2, -0.7);
    }
    let momentum = domain.particles.momentum();
    let angular = domain.particles.angular_momentum(SPACING);
    let energy = |d: &Domain| d.particles.kinetic_energy(SPACING) + d.elastic_energy();
    let (start, mut settled) = (energy(&domain), 0.0);
    let mut most: f64 = 0.0;
    for step in 0..10_000 {
        domain.advance();
        if step % 100 == 99 {
            most = most.max(energy(&domain));
        }
        if step == 5_000 {
            settled = energy(&domain);
        }
    }
    let particles = &domain.particles;
    let drift = (particles.momentum() - momentum).norm() / momentum.norm();
    assert!(drift < 1e-12, "momentum {drift}");
    let drift = (particles.angular_momentum(SPACING) - angular).norm() / angular.norm();
    assert!(drift < 1e-12, "angular momentum {drift}");
    assert!(most <= start * (1.0 + 1e-9), "energy rose from {start} to {most}");
    // APIC has damped the noise; what is left is the rigid motion, which it keeps.
    let loss = 1.0 - energy(&domain) / settled;
    assert!(loss.abs() < 1e-3, "energy loss {loss}");
}

/// E5: a bar that hits an equal one stops, the other leaves with its velocity, after 2L/c.
#[test]
fn two_equal_bars_exchange_velocities() {
    let cells = 80;
    let length = cells as f64 * SPACING;
    let stone = Material { poisson: 0.0, ..STONE };
    let low = Vec3::new(-length, 0.0, 0.0);
    let mut domain = body(&lattice([2 * cells, 2, 2], low), &stone);
    for p in 0..domain.particles.len() {
        let x = domain.particles.position[p].x;
        domain.particles.velocity[p].x = if x < 0.0 { 0.5 } else { -0.5 };
        // The faces touch and do not stick: a layer that bears no tension.
        if x.abs() < 1.5 * SPACING {
            domain.particles.damage[p] = 1.0;
        }
    }
    let mean = |d: &Domain, left: bool| {
        let pairs = d.particles.reference.iter().zip(&d.particles.velocity);
        let side = pairs.filter(|(x, _)| (x.x < 0.0) == left).map(|(_, v)| v.x);
        let side: Vec<f64> = side.collect();
        side.iter().sum::<f64>() / side.len() as f64
    };
    let wave = (stone.young / stone.density).sqrt();
    let contact = 2.0 * length / wave;
    let (mut first, mut last) = (0.0, 0.0);
    while domain.time < 1.05 * contact {
        domain.advance();
        let left = mean(&domain, true);
        if left > 0.25 {
            first = domain.time;
        }
        if left > -0.25 {
            last = domain.time;
        }
    }
    // The mean velocity falls in a straight line; its middle half lasts half the contact.
    let duration = 2.0 * (last - first);
    assert!((duration / contact - 1.0).abs() < 0.05, "contact {duration} of {contact}");
    let (left, right) = (mean(&domain, true), mean(&domain, false));
    assert!((left + right).abs() < 1e-9, "{left} and {right}");
    // 3 % of the change of 1 m/s: the layer and the transfer keep a little.
    assert!((left + 0.5).abs() < 0.02, "left bar leaves with {left}");
}
