//! What directs a shot, ready for the run: joints, glue, fields, and hits with settings of their
//! own.

use super::format::{JointForm, SolverChoice};
use cullet_geometry::Vec3;
use std::collections::BTreeSet;
use std::fmt;

/// A joint of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneJoint {
    /// What it leaves free.
    pub kind: JointForm,
    /// The bodies that it joins, as places in [`super::Scene::bodies`]; nothing stands for the
    /// world, and at most once.
    pub bodies: [Option<usize>; 2],
    /// Where it is fastened to each of the two at the start, in the world \[m\]. Both are one point
    /// unless it is a rope.
    pub anchors: [Vec3; 2],
    /// Unit axis of a hinge in the world.
    pub axis: Vec3,
    /// Length of a rope \[m\].
    pub length: f64,
    /// Greatest force \[N\].
    pub force: Option<f64>,
    /// Greatest moment \[N·m\].
    pub torque: Option<f64>,
    /// Whether the two collide with each other.
    pub collide: bool,
}

/// How much glue bears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GlueStrength {
    /// Between each two bodies: force \[N\] and moment \[N·m\].
    Pair {
        /// Greatest force \[N\].
        force: f64,
        /// Greatest moment \[N·m\].
        torque: Option<f64>,
    },
    /// By the area where they touch \[Pa\].
    Area {
        /// Tensile strength \[Pa\].
        tensile: f64,
        /// Shear strength \[Pa\].
        shear: f64,
    },
}

/// Bodies that stick together where they touch.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneGlue {
    /// The bodies, as places in [`super::Scene::bodies`], rising.
    pub bodies: Vec<usize>,
    /// What the glue bears.
    pub strength: GlueStrength,
    /// Greatest distance of two that stick together \[m\].
    pub gap: f64,
}

/// All of a scene that directs it, beside its driven bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDirections {
    /// Joints, in the order of the file.
    pub joints: Vec<SceneJoint>,
    /// Glue, in the order of the file.
    pub glue: Vec<SceneGlue>,
    /// Fields, in the order of the file.
    pub fields: Vec<SceneField>,
    /// Hits with settings of their own, in the order of the file.
    pub hits: Vec<SceneHit>,
}

/// One hit that is solved with settings of its own: the first one of a body from a time on.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneHit {
    /// Name of the body or fragment.
    pub body: String,
    /// Its earliest time \[s\].
    pub at: f64,
    /// In place of the scene's seed.
    pub seed: Option<u64>,
    /// In place of the body's solver.
    pub solver: Option<SolverChoice>,
    /// Grid spacing of the solve \[m\].
    pub spacing: Option<f64>,
    /// Number of material points of the solve.
    pub particles: Option<u32>,
}

impl fmt::Display for SceneHit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let family = |it: &SolverChoice| it.name().unwrap_or("auto").to_owned();
        let settings = [
            self.seed.map(|it| format!("seed {it}")),
            self.solver.as_ref().map(|it| format!("solver {}", family(it))),
            self.spacing.map(|it| format!("spacing {it} m")),
            self.particles.map(|it| format!("{it} particles")),
        ];
        f.write_str(&settings.into_iter().flatten().collect::<Vec<_>>().join(", "))
    }
}

impl SceneDirections {
    /// Whether something of it can break.
    #[must_use]
    pub fn joins(&self) -> bool {
        !self.joints.is_empty() || !self.glue.is_empty()
    }
}

/// What a field does to a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldLaw {
    /// Air that moves.
    Wind {
        /// Velocity of the air \[m/s\].
        velocity: Vec3,
        /// Drag coefficient \[1\].
        drag: f64,
        /// Density of the air \[kg/m³\].
        density: f64,
    },
    /// A pull towards a point.
    Attractor {
        /// The point \[m\].
        point: Vec3,
        /// Acceleration at the distance `size` \[m/s²\].
        strength: f64,
        /// Power of the distance by which it falls beyond `size` \[1\].
        falloff: u32,
        /// Where it is greatest \[m\].
        size: f64,
    },
    /// A stirred acceleration.
    Turbulence {
        /// Root mean square of the acceleration \[m/s²\].
        strength: f64,
        /// Size of eddies \[m\].
        size: f64,
        /// How often they change \[1/s\].
        rate: f64,
        /// Which eddies.
        seed: u64,
    },
    /// Removes bodies behind a plane.
    Kill {
        /// A point of the plane \[m\].
        point: Vec3,
        /// Unit normal; what lies on its other side is removed.
        normal: Vec3,
    },
}

/// A field of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneField {
    /// What it does.
    pub law: FieldLaw,
    /// Names of the bodies of the scene that feel it with their fragments; all without it.
    pub bodies: Option<BTreeSet<String>>,
}
