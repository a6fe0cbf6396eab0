//! A written body made ready: checked, given its geometry and its material, not yet placed.

use super::context::ResolveContext;
use super::direction::MIN_LENGTH;
use super::format::{
    Anchor, Body, Fracture, Interior, ObjectsChoice, Resolution, Rotation, SolverChoice,
};
use super::geometry::{BodyGeometry, GeometrySource, MAX_SIZE, ObjectSource, bounds};
use super::material::SceneMaterial;
use super::parts::PlacedShape;
use super::sourced::Fault;
use super::strength::strength;
use super::{bonds, treatment};
use cullet_document::check::tell;
use cullet_document::error::suggest;
use cullet_document::files::key;
use cullet_document::tree::{Path, join};
use cullet_geometry::{Pose, Quat, Vec3};
use cullet_model::{ArtDirection, StrengthField};
use cullet_plan::family;
use cullet_world::KeyframedPath;
use std::sync::Arc;

/// Where a body is to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct TemplatePlacement {
    pub(super) rotation: Quat,
    /// Where the anchor is \[m\].
    pub(super) position: Vec3,
    /// From the centroid to the anchor, in the body's frame \[m\].
    pub(super) anchor: Vec3,
}

impl TemplatePlacement {
    /// Where the body's own frame is.
    pub(super) fn pose(&self) -> Pose {
        Pose::from_parts((self.position - self.rotation * self.anchor).into(), self.rotation)
    }

    /// The same body where its own frame is at a pose.
    pub(super) fn put(&self, pose: &Pose) -> Self {
        let position = pose.translation.vector + pose.rotation * self.anchor;
        Self { rotation: pose.rotation, position, ..*self }
    }
}

/// A body before it has a place.
#[derive(Clone)]
pub(super) struct BodyTemplate {
    /// The object of the mesh file that it is, where each is a body of its own.
    pub(super) object: Option<String>,
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
    /// How it is driven, if it is.
    pub(super) drive: Option<Arc<KeyframedPath>>,
    pub(super) group: Option<String>,
    /// How it is to come apart, if the scene says so.
    pub(super) direction: Option<Arc<ArtDirection>>,
    pub(super) interior: Option<Interior>,
}

/// A shape of a body, and the object of the mesh file that it is made of, where each is a body.
type ObjectGeometry = (Option<String>, Arc<BodyGeometry>);

impl ResolveContext<'_> {
    /// Makes a body ready, or the bodies of a mesh file of several objects; errors are noted, and
    /// `None` means that there were some.
    pub(super) fn body_templates(
        &mut self,
        body: &Body,
        path: &Path,
        defaults: &Fracture,
    ) -> Option<Vec<BodyTemplate>> {
        let before = self.errors.len();
        let material = self.material(body, path);
        let rotation = self.rotation(&body.rotation, &join(path, "rotation"));
        let shapes = self.shapes(body, path);
        self.motion(body, path);
        let driven = self.driven(body, path);
        let animation = self.animation(body, path);
        let resolution = self.resolution(body, path);
        let (Some(material), Some(shapes)) = (material, shapes) else {
            return None;
        };
        let wanted = body.breakable.unwrap_or(!body.fixed && !driven && material.breakable);
        let solver = body.solver.clone().unwrap_or_else(|| defaults.solver.clone());
        if wanted {
            self.check_strength(body, &material, path);
            self.unfit(body, (&material, &solver), &shapes, path);
        }
        if driven && shapes.len() > 1 {
            self.refuse_driven_objects(body, shapes.len(), path);
        }
        let direction = self.direction_of((body, wanted), &shapes, defaults, path);
        let held = direction.as_deref();
        let anchors = anchors(body.anchor, &shapes);
        let mut templates = Vec::with_capacity(shapes.len());
        for ((object, geometry), anchor) in shapes.into_iter().zip(anchors) {
            let strength = Arc::new(strength(self, body, path, &material, &geometry, held));
            let at_rest = TemplatePlacement { rotation, position: body.position.into(), anchor };
            let keyframes = self.keyframes(body, at_rest, path);
            let told = self.errors.len() > before;
            let drive = match &animation {
                _ if told => None,
                Some(animation) => self.animated(animation, at_rest, &geometry, path),
                None => self.path_of(body, &keyframes, path),
            };
            let placement = match (&drive, &animation) {
                (Some(drive), Some(_)) => at_rest.put(&drive.at(0.0)),
                _ => keyframes.first().map_or(at_rest, |(_, placed)| *placed),
            };
            templates.push(BodyTemplate {
                object,
                geometry,
                material: Arc::clone(&material),
                strength,
                placement,
                velocity: Vec3::from(body.velocity),
                spin: Vec3::from(body.spin),
                fixed: body.fixed,
                breakable: wanted,
                spacing: resolution.spacing,
                particles: resolution.particles,
                impulse_threshold: body.impulse_threshold,
                solver: solver.clone(),
                drive,
                group: body.group.clone(),
                direction: direction.clone(),
                interior: body.interior,
            });
        }
        (self.errors.len() == before).then_some(templates)
    }

    /// How finely a body is resolved, as written; that it says so twice or not at all is noted.
    fn resolution(&mut self, body: &Body, path: &Path) -> Resolution {
        let resolution = body.resolution.unwrap_or_default();
        if body.resolution.is_some()
            && resolution.spacing.is_some() == resolution.particles.is_some()
        {
            self.wrong(&join(path, "resolution"), "takes `spacing` or `particles`, one of them");
        }
        resolution
    }

    /// Notes why the material of a body cannot break.
    fn check_strength(&mut self, body: &Body, material: &SceneMaterial, path: &Path) {
        let faults = match body.dynamic {
            Some(_) => material.faults(),
            None => material.rigid_faults(),
        };
        for (_, fault) in faults {
            let message = format!("{} cannot break: {fault}", material.name);
            self.wrong(&join(path, "material"), message);
        }
    }

    /// Notes that each of several objects of one mesh file cannot be driven.
    fn refuse_driven_objects(&mut self, body: &Body, count: usize, path: &Path) {
        let message = format!("only a body of one object is driven; its mesh file has {count}");
        let key = if body.animation.is_some() { "animation" } else { "keyframes" };
        self.wrong(&join(path, key), message);
    }

    /// Notes why the family that is asked for cannot break the shapes of a body.
    fn unfit(
        &mut self,
        body: &Body,
        (material, solver): (&SceneMaterial, &SolverChoice),
        shapes: &[ObjectGeometry],
        path: &Path,
    ) {
        for (_, geometry) in shapes {
            let unfit = treatment::unfit(material.treatment, &geometry.solid, solver)
                .or_else(|| yields(material, solver))
                .or_else(|| bonds::unfit(material, !body.paint.is_empty(), solver));
            if let Some((key, why)) = unfit {
                self.wrong(&join(path, key), why);
            }
        }
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
            let help = self.advice(|| {
                let known: Vec<&str> = self.materials.keys().map(String::as_str).collect();
                suggest(name, &known)
            });
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

    fn shapes(&mut self, body: &Body, path: &Path) -> Option<Vec<ObjectGeometry>> {
        let ways = [
            ("shape", body.shape.is_some()),
            ("parts", !body.parts.is_empty()),
            ("mesh", body.mesh.is_some()),
        ];
        let mut written = ways.into_iter().filter(|(_, written)| *written).map(|(key, _)| key);
        let Some(way) = written.next() else {
            if self.lacks(path, &["shape", "parts", "mesh"]) {
                self.wrong(path, "a body needs a `shape`, `parts` or a `mesh`");
            }
            return None;
        };
        if let Some(second) = written.next() {
            let message = format!("a body has a `{way}` or a `{second}`, not both");
            self.wrong(&join(path, second), message);
            return None;
        }
        let sources = match (&body.shape, &body.mesh) {
            (_, None) => {
                let several = body.objects != ObjectsChoice::default();
                let keys = [
                    ("fit", body.fit.is_some()),
                    ("scale", body.scale.is_some()),
                    ("thickness", body.thickness.is_some()),
                    ("object", body.object.is_some()),
                    ("objects", several),
                ];
                for (key, _) in keys.into_iter().filter(|(_, written)| *written) {
                    self.wrong(&join(path, key), "is for a `mesh`; a `shape` has its measures");
                }
                vec![(None, self.shape_source(body, path))]
            }
            (_, Some(mesh)) => self.mesh_sources(body, mesh, path)?,
        };
        let mut shapes = Vec::with_capacity(sources.len());
        for (object, source) in sources {
            match self.geometries.get(&source, self.files) {
                Ok(geometry) => shapes.push((object, geometry)),
                Err(why) => {
                    let key = if body.object.is_some() { "object" } else { way };
                    let which = object.map(|name| format!("object \"{name}\": "));
                    let message = which.unwrap_or_default() + &why;
                    self.unmade(&join(path, key), message, None);
                    return None;
                }
            }
        }
        Some(shapes)
    }

    /// What a body of one or several shapes is made from.
    fn shape_source(&mut self, body: &Body, path: &Path) -> GeometrySource {
        if let Some(shape) = &body.shape {
            return GeometrySource::Shape(shape.clone());
        }
        let mut parts = Vec::with_capacity(body.parts.len());
        for (index, part) in body.parts.iter().enumerate() {
            let path = join(&join(path, "parts"), index);
            let rotation = self.rotation(&part.rotation, &join(&path, "rotation"));
            let position = Vec3::from(part.position);
            if position.amax() > MAX_SIZE {
                let (most, far) = (tell(MAX_SIZE), tell(position.amax()));
                let message = format!("each must be at most {most} m; one is {far} m");
                self.wrong(&join(&path, "position"), message);
            }
            let pose = Pose::from_parts(position.into(), rotation);
            parts.push(PlacedShape { shape: part.shape.clone(), pose });
        }
        GeometrySource::Parts(parts)
    }

    /// What the body or bodies of a mesh file are made from.
    fn mesh_sources(
        &mut self,
        body: &Body,
        mesh: &str,
        path: &Path,
    ) -> Option<Vec<(Option<String>, GeometrySource)>> {
        if body.fit.is_some() && body.scale.is_some() {
            self.wrong(&join(path, "scale"), "a mesh takes `fit` or `scale`, not both");
        }
        let apart = body.objects == ObjectsChoice::Bodies;
        if apart && body.object.is_some() {
            let message = "picks one object; `objects = \"bodies\"` makes a body of each";
            self.wrong(&join(path, "object"), message);
            return None;
        }
        let written = join(path, "mesh");
        let key = key(&self.root.nearest(&written).text.base, mesh);
        if !self.has_mesh(&key, &written) {
            return None;
        }
        let source = |object| GeometrySource::Mesh {
            key: key.clone(),
            fit: body.fit,
            scale: body.scale,
            thickness: body.thickness,
            up: body.up,
            repair: body.repair,
            object,
        };
        if !apart {
            let object = body.object.clone();
            let object = object.map(|name| ObjectSource { name, in_scale: false });
            return Some(vec![(None, source(object))]);
        }
        let names = match self.geometries.objects(&key, self.files) {
            Ok(names) if names.is_empty() => {
                let message = "this file has no objects with names; it is one body";
                self.wrong(&join(path, "objects"), message);
                return None;
            }
            Ok(names) => names,
            Err(why) => {
                self.unmade(&written, why, None);
                return None;
            }
        };
        let each = names.into_iter().map(|name| {
            let object = ObjectSource { name: name.clone(), in_scale: true };
            (Some(name), source(Some(object)))
        });
        Some(each.collect())
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

/// The anchor of each shape, in its own frame \[m\]: one point of all of them together.
fn anchors(anchor: Anchor, shapes: &[ObjectGeometry]) -> Vec<Vec3> {
    let at = |(low, high): (Vec3, Vec3)| match anchor {
        Anchor::Origin => Vec3::zeros(),
        Anchor::Centre => (low + high) / 2.0,
        Anchor::Base => Vec3::new((low.x + high.x) / 2.0, (low.y + high.y) / 2.0, low.z),
    };
    match shapes {
        [(_, one)] if anchor != Anchor::Origin => vec![at(one.bounds)],
        _ => {
            // In the frame of the file, which they share.
            let boxes =
                shapes.iter().map(|(_, it)| [it.bounds.0, it.bounds.1].map(|p| p - it.origin));
            let corners: Vec<Vec3> = boxes.flatten().collect();
            let point = at(bounds(&corners));
            shapes.iter().map(|(_, it)| it.origin + point).collect()
        }
    }
}

/// Farthest place from the world's origin \[m\]: farther, contacts lose their digits.
pub(super) const MAX_DISTANCE: f64 = 1e5;

/// Fastest body \[m/s\]: faster than that nothing here is brittle fracture any more.
pub(super) const MAX_SPEED: f64 = 1e4;

/// Fastest spin \[rad/s\]: a turn must span some steps.
pub(super) const MAX_SPIN: f64 = 1e4;

/// Why a body cannot be solved as the scene wishes that yields, or that does not, by the key at
/// fault.
pub(super) fn yields(material: &SceneMaterial, solver: &SolverChoice) -> Option<Fault> {
    let name = solver.name()?;
    let (shell, ductile) = (family::SHELL, family::DUCTILE);
    let why = match material.plasticity {
        Some(_) if [shell, ductile, family::PERIDYNAMICS].contains(&name) => return None,
        Some(_) => format!("`{name}` takes nothing that yields: `{shell}` and `{ductile}` do"),
        None if name == ductile => format!("`{name}` takes only what yields: give `plasticity`"),
        None => return None,
    };
    Some(("solver", why))
}
