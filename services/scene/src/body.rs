//! A written body made ready: checked, given its geometry and its material, not yet placed.

use super::context::ResolveContext;
use super::direction::MIN_LENGTH;
use super::format::{Anchor, Body, Fracture, Rotation, SolverChoice};
use super::geometry::{BodyGeometry, GeometrySource};
use super::material::SceneMaterial;
use super::strength::strength;
use cullet_document::check::tell;
use cullet_document::error::suggest;
use cullet_document::files::key;
use cullet_document::tree::{Path, join};
use cullet_geometry::{Quat, Vec3};
use cullet_model::StrengthField;
use std::sync::Arc;

/// Where a body is to be.
#[derive(Clone, Copy)]
pub(super) struct TemplatePlacement {
    pub(super) rotation: Quat,
    /// Where the anchor is \[m\].
    pub(super) position: Vec3,
    /// From the centroid to the anchor, in the body's frame \[m\].
    pub(super) anchor: Vec3,
}

/// A body before it has a place.
#[derive(Clone)]
pub(super) struct BodyTemplate {
    pub(super) geometry: Arc<BodyGeometry>,
    pub(super) material: Arc<SceneMaterial>,
    pub(super) strength: Arc<StrengthField>,
    pub(super) placement: TemplatePlacement,
    pub(super) velocity: Vec3,
    pub(super) spin: Vec3,
    pub(super) fixed: bool,
    pub(super) breakable: bool,
    pub(super) spacing: Option<f64>,
    pub(super) particles: Option<u32>,
    pub(super) impulse_threshold: Option<f64>,
    pub(super) solver: SolverChoice,
}

impl ResolveContext<'_> {
    /// Makes a body ready; errors are noted, and `None` means that there were some.
    pub(super) fn body_template(
        &mut self,
        body: &Body,
        path: &Path,
        defaults: &Fracture,
    ) -> Option<BodyTemplate> {
        let before = self.errors.len();
        let material = self.material(body, path);
        let rotation = self.rotation(&body.rotation, &join(path, "rotation"));
        let geometry = self.geometry(body, path);
        self.motion(body, path);
        let resolution = body.resolution.unwrap_or_default();
        if body.resolution.is_some()
            && resolution.spacing.is_some() == resolution.particles.is_some()
        {
            self.wrong(&join(path, "resolution"), "takes `spacing` or `particles`, one of them");
        }
        let (Some(material), Some(geometry)) = (material, geometry) else {
            return None;
        };
        let wanted = body.breakable.unwrap_or(!body.fixed && material.breakable);
        if wanted {
            for (_, fault) in material.faults() {
                let message = format!("{} cannot break: {fault}", material.name);
                self.wrong(&join(path, "material"), message);
            }
        }
        let strength = Arc::new(strength(self, body, path, &material, &geometry));
        if self.errors.len() > before {
            return None;
        }
        let (low, high) = geometry.bounds;
        let anchor = match body.anchor {
            Anchor::Origin => geometry.origin,
            Anchor::Centre => (low + high) / 2.0,
            Anchor::Base => Vec3::new((low.x + high.x) / 2.0, (low.y + high.y) / 2.0, low.z),
        };
        Some(BodyTemplate {
            geometry,
            material,
            strength,
            placement: TemplatePlacement { rotation, position: Vec3::from(body.position), anchor },
            velocity: Vec3::from(body.velocity),
            spin: Vec3::from(body.spin),
            fixed: body.fixed,
            breakable: wanted,
            spacing: resolution.spacing,
            particles: resolution.particles,
            impulse_threshold: body.impulse_threshold,
            solver: body.solver.clone().unwrap_or_else(|| defaults.solver.clone()),
        })
    }

    fn material(&mut self, body: &Body, path: &Path) -> Option<Arc<SceneMaterial>> {
        let Some(name) = &body.material else {
            if self.lacks(path, &["material"]) {
                self.wrong(path, "`material` is missing: a preset or a [[material]]");
            }
            return None;
        };
        if let Some(material) = self.materials.get(name) {
            return Some(Arc::clone(material));
        }
        if !self.spoiled_materials.contains(name) {
            let known: Vec<&str> = self.materials.keys().map(String::as_str).collect();
            let help = suggest(name, &known);
            let message = format!("there is no material \"{name}\"");
            self.wrong_with(&join(path, "material"), message, help);
        }
        None
    }

    fn motion(&mut self, body: &Body, path: &Path) {
        if body.fixed {
            let moves = [("velocity", body.velocity), ("spin", body.spin)];
            for (key, value) in moves {
                if value != [0.0; 3] {
                    self.wrong(&join(path, key), "a fixed body does not move");
                }
            }
            if body.breakable == Some(true) {
                self.wrong(&join(path, "breakable"), "a fixed body does not break");
            }
        }
        let limits = [
            ("position", body.position, MAX_DISTANCE, "m"),
            ("velocity", body.velocity, MAX_SPEED, "m/s"),
            ("spin", body.spin, MAX_SPIN, "rad/s"),
        ];
        for (key, value, limit, unit) in limits {
            let value = Vec3::from(value);
            // What is too large to be squared is told by its greatest component.
            let size = if value.norm().is_finite() { value.norm() } else { value.amax() };
            if size > limit {
                let message = format!(
                    "must be at most {} {unit} long; it is {} {unit}",
                    tell(limit),
                    tell(size)
                );
                self.wrong(&join(path, key), message);
            }
        }
    }

    fn geometry(&mut self, body: &Body, path: &Path) -> Option<Arc<BodyGeometry>> {
        let source = match (&body.shape, &body.mesh) {
            (Some(_), Some(_)) => {
                self.wrong(&join(path, "mesh"), "a body has a `shape` or a `mesh`, not both");
                return None;
            }
            (None, None) => {
                if self.lacks(path, &["shape", "mesh"]) {
                    self.wrong(path, "a body needs a `shape` or a `mesh`");
                }
                return None;
            }
            (Some(shape), None) => {
                let sizes = [("fit", body.fit), ("scale", body.scale)];
                for (key, _) in sizes.into_iter().filter(|(_, value)| value.is_some()) {
                    self.wrong(&join(path, key), "is for a `mesh`; a `shape` has its measures");
                }
                GeometrySource::Shape(shape.clone())
            }
            (None, Some(mesh)) => {
                if body.fit.is_some() && body.scale.is_some() {
                    self.wrong(&join(path, "scale"), "a mesh takes `fit` or `scale`, not both");
                }
                let written = join(path, "mesh");
                let key = key(&self.root.nearest(&written).text.base, mesh);
                if !self.has_mesh(&key, &written) {
                    return None;
                }
                GeometrySource::Mesh {
                    key,
                    fit: body.fit,
                    scale: body.scale,
                    up: body.up,
                    repair: body.repair,
                }
            }
        };
        match self.geometries.get(&source, self.files) {
            Ok(geometry) => Some(geometry),
            Err(why) => {
                let key = if body.mesh.is_some() { "mesh" } else { "shape" };
                self.unmade(&join(path, key), why, None);
                None
            }
        }
    }

    /// The rotation that is written in one of the three ways; two at once are an error.
    pub fn rotation(&mut self, rotation: &Rotation, path: &Path) -> Quat {
        let ways = [
            rotation.axis.is_some() || rotation.degrees.is_some(),
            rotation.euler_degrees.is_some(),
            rotation.quaternion.is_some(),
        ];
        if ways.iter().filter(|used| **used).count() > 1 {
            let message = "takes `axis` and `degrees`, or `euler_degrees`, or `quaternion`";
            self.wrong(path, message);
            return Quat::identity();
        }
        let radians = f64::to_radians;
        if let Some([w, x, y, z]) = rotation.quaternion {
            let quaternion = nalgebra::Quaternion::new(w, x, y, z);
            return Quat::try_new(quaternion, MIN_LENGTH).unwrap_or_else(|| {
                self.wrong(&join(path, "quaternion"), "must have a length above 1e-6");
                Quat::identity()
            });
        }
        if let Some([x, y, z]) = rotation.euler_degrees {
            return Quat::from_euler_angles(radians(x), radians(y), radians(z));
        }
        match (rotation.axis, rotation.degrees) {
            (None, None) => Quat::identity(),
            (Some(axis), Some(degrees)) => {
                match nalgebra::Unit::try_new(Vec3::from(axis), MIN_LENGTH) {
                    Some(axis) => Quat::from_axis_angle(&axis, radians(degrees)),
                    None => {
                        self.wrong(&join(path, "axis"), "must have a length above 1e-6");
                        Quat::identity()
                    }
                }
            }
            (Some(_), None) => {
                self.wrong(path, "`degrees` is missing beside `axis`");
                Quat::identity()
            }
            (None, Some(_)) => {
                self.wrong(path, "`axis` is missing beside `degrees`");
                Quat::identity()
            }
        }
    }
}

/// Farthest place from the world's origin \[m\]: farther, contacts lose their digits.
pub(super) const MAX_DISTANCE: f64 = 1e5;

/// Fastest body \[m/s\]: faster than that nothing here is brittle fracture any more.
pub(super) const MAX_SPEED: f64 = 1e4;

/// Fastest spin \[rad/s\]: a turn must span some steps.
pub(super) const MAX_SPIN: f64 = 1e4;
