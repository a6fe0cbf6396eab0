//! A scene and its bodies, ready for the world.

use super::directions::SceneDirections;
use super::format::{self, Expect, SolverChoice, View};
use super::material::SceneMaterial;
use super::moving::SceneMovingBody;
use cullet_document::{Bundle, SceneFile};
use cullet_geometry::attributes::SurfaceAttributes;
use cullet_geometry::{Mat3, Pose, Solid, Vec3};
use cullet_model::{ArtDirection, StrengthField};
use cullet_world::KeyframedPath;
use std::sync::Arc;

/// A body of a scene, ready for the world.
#[derive(Clone, Debug)]
pub struct SceneBody {
    /// What the scene calls it.
    pub name: String,
    /// The generator that made it, or the written body of whose mesh file it is one object.
    pub generator: Option<String>,
    /// The object of the mesh file that it is, where each is a body of its own.
    pub mesh_object: Option<String>,
    /// The key of its mesh file.
    pub mesh_file: Option<String>,
    /// What the mesh file has beside the shape, in the body's own frame; nothing where it has no
    /// more. Shared by bodies of equal shape.
    pub surface: Option<Arc<SurfaceAttributes>>,
    /// Its shape; the centroid is the origin \[m\]. Shared by bodies of equal shape.
    pub solid: Arc<Solid>,
    /// Convex parts that stand in for it in collisions, in the same frame \[m\]. Shared likewise.
    pub hulls: Arc<Vec<Vec<Vec3>>>,
    /// Volume \[m³\].
    pub volume: f64,
    /// Inertia about the centroid at unit density, in the body's frame \[m⁵\].
    pub inertia: Mat3,
    /// Body frame to world frame \[m\].
    pub pose: Pose,
    /// Velocity of the centroid \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity in the world frame \[rad/s\].
    pub spin: Vec3,
    /// What it is made of. Shared by bodies of one material.
    pub material: Arc<SceneMaterial>,
    /// How its strength varies; the seed is the run's affair. Shared by bodies of one template.
    pub strength: Arc<StrengthField>,
    /// The least share of its material's strength that the scene gave a part of it \[1\].
    pub weakest: f64,
    /// Whether it never moves.
    pub fixed: bool,
    /// Whether it can break.
    pub breakable: bool,
    /// Grid spacing of its solves \[m\]; the solver chooses without it.
    pub spacing: Option<f64>,
    /// About so many material points in place of the scene's `max_particles`.
    pub particles: Option<u32>,
    /// In place of the world's impulse threshold \[N·s\].
    pub impulse_threshold: Option<f64>,
    /// Which solver: the body's own choice, or the scene's.
    pub solver: SolverChoice,
    /// What was repaired of its mesh, a line each.
    pub repairs: Vec<String>,
    /// How it is driven; nothing where it moves by its forces.
    pub drive: Option<Arc<KeyframedPath>>,
    /// The group that it is in.
    pub group: Option<String>,
    /// How it is to come apart where the scene says so, in its own frame.
    pub direction: Option<Arc<ArtDirection>>,
    /// What it looks like inside, where the scene says so.
    pub interior: Option<format::Interior>,
}

impl SceneBody {
    /// Whether the scene painted its strength, or holds parts of it whole.
    #[must_use]
    pub fn is_painted(&self) -> bool {
        !self.strength.strokes.is_empty() || self.strength.vertices.is_some()
    }
}

/// A scene, checked and complete.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The name of its folder, or of its file.
    pub name: String,
    /// What it shows, in a line.
    pub description: String,
    /// The rigid world and its clock.
    pub world: format::World,
    /// How bodies are broken.
    pub fracture: format::Fracture,
    /// How true and how dear solves should be.
    pub fidelity: format::Fidelity,
    /// The bodies, in the order of the file, then grids, stacks, scatters and instances.
    pub bodies: Vec<SceneBody>,
    /// Bodies that move as they deform: dynamic bodies, then sheets, each in the order of the file.
    pub moving: Vec<SceneMovingBody>,
    /// Joints, glue and fields.
    pub directions: SceneDirections,
    /// What the scene must show.
    pub expect: Expect,
    /// What its recording holds.
    pub recording: format::RecordingSettings,
    /// Where the preview looks from.
    pub view: Option<View>,
    /// What is unusual or was repaired, a line each.
    pub warnings: Vec<String>,
    /// The main file as it is written.
    pub source_text: String,
    /// The `path=value` arguments that were applied.
    pub overrides: Vec<String>,
    /// The key of the main file.
    pub main: String,
    /// Every file that was read, by key.
    pub files: Vec<SceneFile>,
}

impl Scene {
    /// Everything that another machine needs to load the same scene by [`crate::load_bundle`].
    #[must_use]
    pub fn bundle(&self) -> Bundle {
        Bundle {
            name: self.name.clone(),
            main: self.main.clone(),
            overrides: self.overrides.clone(),
            files: self.files.clone(),
        }
    }

    /// Whether anything of it is directed: driven bodies, joints, glue, fields, bounds or pieces.
    #[must_use]
    pub fn is_directed(&self) -> bool {
        self.directions != SceneDirections::default()
            || self.world.bounds.is_some()
            || self.bodies.iter().any(|body| body.drive.is_some() || body.direction.is_some())
    }

    /// How many steps the run takes.
    #[must_use]
    pub fn steps(&self) -> u64 {
        (self.world.duration / self.world.step).round() as u64
    }
}
