//! The smallest job there is, for tests and measurements of what carries jobs.

use crate::job::FractureJob;
use cullet_geometry::{Solid, TriMesh, Vec3};
use cullet_model::{Impact, Law, Material, Problem, Settings, StrengthField};

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
            law: Law::Brittle { material, strength: StrengthField::even() },
            impacts: vec![impact],
            supports: Vec::new(),
            spin: Vec3::zeros(),
            settings,
            seed,
        };
        Self { solver: solver.into(), fallback: None, problem }
    }
}
