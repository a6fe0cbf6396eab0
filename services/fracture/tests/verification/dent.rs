//! Dents of a ball, by spacing and by step.

use cullet_fracture::Ductile;
use cullet_geometry::{Solid, Vec3, shapes};
use cullet_model::{
    BodyShape, Deformation, Hardening, Impact, Law, Material, Problem, Progress, Settings,
    SolveOutcome, Solver, Support,
};
use std::sync::Arc;

const LEAD: Material = Material {
    density: 11340.0,
    young: 16e9,
    poisson: 0.44,
    failure_stress: 20e6,
    fracture_energy: 2e4,
};
const SOFT: Hardening = Hardening { yield_stress: 20e6, hardening: 0.0, exponent: 1.0 };

/// A ball of 2 cm radius and 97 g at 20 m/s on a block of 8 × 8 × 4 cm that lies on a plane.
fn dent(spacing: f64) -> Deformation {
    let size = Vec3::new(0.08, 0.08, 0.04);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a block");
    let top = Vec3::new(0.0, 0.0, 0.02);
    let (mass, speed, radius) = (0.0966, 20.0, 0.02_f64);
    let energy = 0.5 * mass * speed * speed;
    let stiffness = 4.0 / 3.0 * LEAD.young / (1.0 - LEAD.poisson * LEAD.poisson) * radius.sqrt();
    let deepest = libm::pow(2.5 * energy / stiffness, 0.4);
    let impact = Impact {
        point: top,
        normal: -Vec3::z(),
        impulse: 2.0 * mass * speed,
        duration: 2.943 * deepest / speed,
        radius: (radius * deepest).sqrt(),
        energy,
        closing_speed: speed,
        crushing_pressure: 1e12,
    };
    let problem = Problem {
        body: BodyShape::Solid(Arc::new(Solid::outer(mesh))),
        law: Law::Yielding { material: LEAD, hardening: SOFT },
        impacts: vec![impact],
        supports: vec![Support { point: -top, normal: Vec3::z(), radius: 0.1, mobility: 0.0 }],
        spin: Vec3::zeros(),
        settings: Settings {
            spacing: Some(spacing),
            max_particles: 200_000,
            ..Settings::default()
        },
        seed: 1,
    };
    let mut solve = Ductile::begin(problem).expect("accepted");
    loop {
        match solve.advance() {
            Progress::Running(_) => {}
            Progress::Done(SolveOutcome::Deformed(found)) => return *found,
            other => panic!("{other:?}"),
        }
    }
}

/// How deep the upper face lies at its middle \[m\].
fn measure(found: &Deformation) -> f64 {
    let mesh = &found.body.solid().expect("a solid").mesh;
    let near = mesh.vertices.iter().filter(|x| x.xy().norm() < 0.004 && x.z > 0.0);
    0.02 - near.map(|x| x.z).fold(f64::INFINITY, f64::min)
}

/// The depth does not depend on the cells; it is less than Tabor's, which takes the contact to be
/// as wide as the ball is at the depth: what piles up at the rim makes it wider.
#[test]
fn dents_converge_with_the_cells() {
    let pressed = 3.0 * std::f64::consts::PI * SOFT.yield_stress * 0.02;
    let mut depths = Vec::new();
    for spacing in [0.006, 0.0045, 0.003] {
        let found = dent(spacing);
        let energy = 0.5 * 0.0966 * 400.0;
        let deepest = measure(&found);
        let detail = |name| found.report.detail(name).expect("told");
        let (balance, volume) = (detail("energy_balance"), detail("volume_change"));
        let tabor = (energy / pressed).sqrt();
        println!(
            "h {spacing}: {:.3} of Tabor's depth; work {:.3}, balance {balance:.3}, volume \
             {volume:+.1e}",
            deepest / tabor,
            found.work / energy
        );
        assert!((balance - 1.0).abs() < 0.02, "{spacing}: {balance}");
        assert!(volume.abs() < 1e-3, "{spacing}: {volume}");
        depths.push(deepest / tabor);
    }
    assert!(depths.iter().all(|d| (d / depths[2] - 1.0).abs() < 0.05), "{depths:?}");
    assert!((0.78..0.95).contains(&depths[2]), "{depths:?}");
}
