//! Bodies that an animation of a glTF file drives.

use super::body::{MAX_DISTANCE, MAX_SPEED, TemplatePlacement};
use super::context::ResolveContext;
use super::format::{Axis, Body, BodyAnimation};
use super::geometry::{BodyGeometry, file_beside, upright};
use cullet_assets::{NodeMotion, node_motion};
use cullet_document::check::tell;
use cullet_document::error::nearest;
use cullet_document::files::key;
use cullet_document::tree::{Path, join};
use cullet_geometry::{Mat3, Pose, Quat, Vec3};
use cullet_world::{KeyframedPath, PlacedMotion};
use nalgebra::{Rotation3, Translation3};
use std::sync::Arc;

/// Share by which a node may be scaled that counts as not scaled \[1\]: programs write f32.
const UNSCALED: f64 = 1e-4;

/// Most keys of the animations of all bodies.
const MOST_KEYS: usize = 10_000_000;

/// An animation that was read, and what the scene says of it.
pub(super) struct ReadAnimation {
    written: BodyAnimation,
    /// The key of its file.
    file: String,
    motion: Arc<NodeMotion>,
}

impl ResolveContext<'_> {
    /// The animation of a body, if it has one and its file does; what is wrong is noted.
    pub(super) fn animation(&mut self, body: &Body, path: &Path) -> Option<ReadAnimation> {
        let written = body.animation.as_ref()?;
        let path = join(path, "animation");
        let below = join(&path, "file");
        if self.is_bad(&below) || self.is_bad(&join(&path, "node")) {
            return None;
        }
        let file = key(&self.root.nearest(&below).text.base, &written.file);
        if !cullet_assets::is_gltf(&file) {
            let message =
                format!("\"{}\" is no glTF file: those end in .glb or .gltf", written.file);
            self.wrong(&below, message);
            return None;
        }
        if !self.has_mesh(&file, &below) {
            return None;
        }
        let known = (file.clone(), written.name.clone(), written.node.clone());
        if let Some(motion) = self.motions.motions.get(&known) {
            let motion = Arc::clone(motion);
            return self.bounded(ReadAnimation { written: written.clone(), file, motion }, &path);
        }
        let bytes = self.files.get(&file).ok()?;
        let mut beside = |other: &str| file_beside(self.files, &file, other);
        match node_motion(&bytes, &mut beside, written.name.as_deref(), &written.node) {
            Ok(motion) => {
                let motion = Arc::new(motion);
                self.motions.motions.insert(known, Arc::clone(&motion));
                self.bounded(ReadAnimation { written: written.clone(), file, motion }, &path)
            }
            Err(why) => {
                let near = why
                    .sought()
                    .and_then(|(word, known)| nearest(word, known.iter().map(String::as_str)));
                let help = near.map(|near| format!("did you mean \"{near}\"?"));
                let at = join(&path, why.key());
                let at = if self.root.has(&at) { at } else { path };
                self.wrong_with(&at, why.to_string(), help);
                None
            }
        }
    }

    /// The animation, if the scene may have its keys too.
    fn bounded(&mut self, read: ReadAnimation, path: &Path) -> Option<ReadAnimation> {
        let before = self.motions.keys;
        self.motions.keys = before.saturating_add(read.motion.motion.times().len());
        if self.motions.keys <= MOST_KEYS {
            return Some(read);
        }
        if before <= MOST_KEYS {
            let message = format!("the animations of all bodies have more than {MOST_KEYS} keys");
            self.wrong(path, message);
        }
        None
    }

    /// The path of a body that stands as `at_rest` in the scene where nothing moves it.
    pub(super) fn animated(
        &mut self,
        animation: &ReadAnimation,
        at_rest: TemplatePlacement,
        geometry: &BodyGeometry,
        path: &Path,
    ) -> Option<Arc<KeyframedPath>> {
        let path = join(path, "animation");
        let written = &animation.written;
        let own = geometry.file.as_deref() == Some(&animation.file);
        for (key, _) in [("scale", written.scale.is_some()), ("up", written.up.is_some())]
            .into_iter()
            .filter(|(_, said)| own && *said)
        {
            self.wrong(&join(&path, key), "that of the mesh holds, which is of the same file");
        }
        let scale = animation.motion.scale;
        if !own && scale.iter().any(|s| (s - 1.0).abs() > UNSCALED) {
            let [x, y, z] = scale.map(tell);
            let message = format!(
                "the node is scaled by ({x}, {y}, {z}), and the body is none of its file: it \
                 must be 1"
            );
            self.wrong(&join(&path, "node"), message);
            return None;
        }
        let placed = if own {
            of_own_mesh(animation, at_rest, geometry)
        } else {
            of_other(animation, at_rest)
        };
        let made = match KeyframedPath::of_motion(placed) {
            Ok(made) => made,
            Err(why) => {
                self.wrong(&path, why.to_string());
                return None;
            }
        };
        self.in_range(&made, &path).then(|| Arc::new(made))
    }

    /// Whether a path stays where bodies are, and is not too fast.
    fn in_range(&mut self, made: &KeyframedPath, path: &Path) -> bool {
        let place = |pose: &Pose| pose.translation.vector;
        let far = made.keys().iter().find(|key| place(&key.pose).norm() > MAX_DISTANCE);
        if let Some(far) = far {
            let (at, most) = (tell(far.time), tell(MAX_DISTANCE));
            let far = tell(place(&far.pose).norm());
            let message =
                format!("takes the body {far} m from the origin at {at} s; at most {most} m");
            self.wrong(path, message);
            return false;
        }
        let fast = made.keys().windows(2).find_map(|pair| {
            let way = (place(&pair[1].pose) - place(&pair[0].pose)).norm();
            let speed = way / (pair[1].time - pair[0].time);
            (speed > MAX_SPEED).then_some((pair[0].time, speed))
        });
        if let Some((time, speed)) = fast {
            let (time, speed, most) = (tell(time), tell(speed), tell(MAX_SPEED));
            let message = format!("moves the body at {speed} m/s at {time} s; at most {most} m/s");
            self.wrong(path, message);
            return false;
        }
        true
    }
}

/// A body that has its anchor at the node.
fn of_other(animation: &ReadAnimation, at_rest: TemplatePlacement) -> PlacedMotion {
    let ReadAnimation { written, motion, .. } = animation;
    let up = upward(written.up.unwrap_or(Axis::Y));
    PlacedMotion {
        motion: motion.motion.clone(),
        start: written.start,
        scale: written.scale.unwrap_or(1.0),
        to_world: Pose::from_parts(at_rest.position.into(), at_rest.rotation * up),
        from_body: Pose::from_parts((up.inverse() * -at_rest.anchor).into(), up.inverse()),
    }
}

/// A body whose mesh is that of the file, in its place there.
fn of_own_mesh(
    animation: &ReadAnimation,
    at_rest: TemplatePlacement,
    geometry: &BodyGeometry,
) -> PlacedMotion {
    let ReadAnimation { written, motion, .. } = animation;
    let (axis, scale) = geometry.placement;
    let up = upward(axis);
    let mut rest = motion.motion.rest;
    rest.translation.vector *= scale;
    // The mesh is centred on its centroid; the file's origin lies elsewhere in its frame.
    let origin = Pose::from_parts(Translation3::from(-geometry.origin), Quat::identity());
    let turned = Pose::from_parts(Translation3::identity(), up);
    PlacedMotion {
        motion: motion.motion.clone(),
        start: written.start,
        scale,
        to_world: at_rest.pose() * origin.inverse() * turned,
        from_body: rest.inverse() * turned.inverse() * origin,
    }
}

/// The turn that makes an axis of a file z.
fn upward(up: Axis) -> Quat {
    let columns = [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| upright(&axis, up));
    Quat::from_rotation_matrix(&Rotation3::from_matrix_unchecked(Mat3::from_columns(&columns)))
}
