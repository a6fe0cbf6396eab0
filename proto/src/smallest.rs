//! The smallest jobs there are, for tests and measurements of what carries jobs.

use crate::job::FractureJob;
use crate::window::WindowJob;
use cullet_geometry::{Pose, Solid, TriMesh, Vec3};
use cullet_model::{
    ContinuumBody, ContinuumSetup, Impact, Law, Material, MembraneLaw, MembraneMaterial,
    MembranePace, MembraneSheet, Problem, Settings, SheetAir, Window,
};

impl FractureJob {
    /// A glass tetrahedron of 1 m, hit once; `seed` tells it from others.
    #[must_use]
    pub fn smallest(solver: &str, seed: u64) -> Self {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let material = Material {
            density: 2500.0,
            young: 7e10,
            poisson: 0.2,
            failure_stress: 5e7,
            fracture_energy: 8.0,
        };
        let impact = Impact {
            point: Vec3::new(0.1, 0.2, 0.3),
            normal: Vec3::x(),
            impulse: 1.0,
            duration: 1e-4,
            radius: 1e-3,
            energy: 1.0,
            closing_speed: 1.0,
            crushing_pressure: 1e12,
        };
        let settings = Settings {
            max_particles: 1,
            max_steps: 1,
            min_volume_ratio: 0.0,
            max_fragments: 9,
            debris: 0.0,
            ..Settings::default()
        };
        let problem = Problem {
            body: Solid::outer(TriMesh { vertices, triangles }).into(),
            law: Law::even(material),
            impacts: vec![impact],
            supports: Vec::new(),
            spin: Vec3::zeros(),
            settings,
            seed,
        };
        Self { solver: solver.into(), fallback: None, problem, direction: None }
    }
}

impl WindowJob {
    /// The first window of a square of paper of 0.1 m; `seed` tells it from others.
    #[must_use]
    pub fn smallest(family: &str, seed: u64) -> Self {
        let material = MembraneMaterial {
            density: 300.0,
            young: 5e7,
            poisson: 1.0 / 3.0,
            fracture_energy: 500.0,
            strength: 5e5,
            law: MembraneLaw::Brittle,
            scatter: 0.0,
            bending_floor: 0.3,
            damping: 0.1,
        };
        let air = SheetAir {
            density: 0.0,
            drag: 0.0,
            wind: Vec3::zeros(),
            gusts: [0.0; 2],
            pressure: 0.0,
        };
        let sheet = MembraneSheet {
            outline: vec![[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]],
            notches: Vec::new(),
            thickness: 1.5e-4,
            spacing: 0.01,
            horizon: 3.015,
            material,
            pose: Pose::identity(),
            velocity: Vec3::zeros(),
            grips: Vec::new(),
            air,
            diffusion: Default::default(),
            foundation: None,
            pace: MembranePace::Softer(10.0),
        };
        let setup = ContinuumSetup {
            body: ContinuumBody::Membrane(sheet),
            world_step: 1.0 / 240.0,
            gravity: Vec3::new(0.0, -9.81, 0.0),
            seed,
        };
        let window =
            Window { first_step: 0, steps: 4, frame_every: 8, proxies: Vec::new(), retired: None };
        Self { family: family.into(), setup, state: None, window }
    }
}
