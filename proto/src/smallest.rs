//! The smallest job there is, for tests and measurements of what carries jobs.

use crate::job::{Detail, FractureJob, Impact, Material, Precision, Settings};
use crate::strength::Strength;
use cullet_geometry::{Solid, TriMesh, Vec3};

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
            spacing: None,
            max_particles: 1,
            max_steps: 1,
            min_volume_ratio: 0.0,
            max_fragments: 9,
            detail: Detail::default(),
            debris: 0.0,
            grain: None,
            hairline: None,
            precision: Precision::Double,
            error: None,
        };
        Self {
            solver: solver.into(),
            fallback: None,
            solid: Solid::outer(TriMesh { vertices, triangles }),
            material,
            strength: Strength::default(),
            impacts: vec![impact],
            supports: Vec::new(),
            spin: Vec3::zeros(),
            settings,
            seed,
        }
    }
}
