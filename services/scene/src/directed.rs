//! What directs a shot is checked and made ready: driven bodies, joints, glue and fields.

use super::body::{MAX_DISTANCE, MAX_SPEED, TemplatePlacement};
use super::body_names::BodyNames;
use super::context::ResolveContext;
use super::direction::direction;
use super::directions::{GlueStrength, SceneDirections, SceneGlue, SceneJoint};
use super::format::{Body, GlueEntry, JointEntry, JointForm, KeyframeCurve};
use super::scene::SceneBody;
use cullet_document::check::tell;
use cullet_document::tree::{Node, Path, join};
use cullet_geometry::Vec3;
use cullet_world::{Keyframe, KeyframedPath, PathInterpolation};
use std::sync::Arc;

/// What a joint calls the end that never moves.
const WORLD: &str = "world";

/// Share of its length by which a rope may be too short for the distance of its ends \[1\].
const ROPE_ROUNDING: f64 = 1e-9;

impl ResolveContext<'_> {
    /// Whether a body is driven; notes what a driven body must not say.
    pub(super) fn driven(&mut self, body: &Body, path: &Path) -> bool {
        let curve = body.interpolation != KeyframeCurve::default();
        if body.keyframes.is_empty() {
            if self.root.has(&join(path, "keyframes")) && !self.is_bad(&join(path, "keyframes")) {
                self.wrong(&join(path, "keyframes"), "needs at least one keyframe");
            }
            if curve && self.lacks(path, &["keyframes"]) {
                self.wrong(&join(path, "interpolation"), "is for a body with `keyframes`");
            }
            if body.animation.is_none() {
                return false;
            }
        } else if body.animation.is_some() {
            let message = "a body takes `keyframes` or an `animation`, not both";
            self.wrong(&join(path, "animation"), message);
        }
        let way = if body.animation.is_some() { "animation says" } else { "keyframes say" };
        let moves = format!("its {way} how it moves");
        let still = [0.0; 3];
        let said = [
            ("velocity", body.velocity != still, &moves[..]),
            ("spin", body.spin != still, &moves),
            ("fixed", body.fixed, "a body is fixed or driven, not both"),
            ("breakable", body.breakable == Some(true), "a driven body does not break"),
            ("dynamic", body.dynamic.is_some(), "a driven body is rigid"),
        ];
        for (key, _, why) in said.into_iter().filter(|(_, said, _)| *said) {
            self.wrong(&join(path, key), why);
        }
        true
    }

    /// The keyframes of a body, as placements of its anchor at their times \[s\].
    pub(super) fn keyframes(
        &mut self,
        body: &Body,
        at_rest: TemplatePlacement,
        path: &Path,
    ) -> Vec<(f64, TemplatePlacement)> {
        let mut rows: Vec<(f64, TemplatePlacement)> = Vec::with_capacity(body.keyframes.len());
        for (index, keyframe) in body.keyframes.iter().enumerate() {
            let path = join(&join(path, "keyframes"), index);
            let rotation = match &keyframe.rotation {
                Some(written) => self.rotation(written, &join(&path, "rotation")),
                None => at_rest.rotation,
            };
            let position = keyframe.position.map_or(at_rest.position, Vec3::from);
            let far = if position.norm().is_finite() { position.norm() } else { position.amax() };
            if far > MAX_DISTANCE {
                let (most, far) = (tell(MAX_DISTANCE), tell(far));
                let message = format!("must be at most {most} m long; it is {far} m");
                self.wrong(&join(&path, "position"), message);
            }
            if let Some((before, placed)) = rows.last().copied() {
                let (time, gone) = (keyframe.at - before, (position - placed.position).norm());
                if time <= 0.0 {
                    let (before, at) = (tell(before), tell(keyframe.at));
                    let message = format!(
                        "must be later than the keyframe before, at {before} s; it is {at} s"
                    );
                    self.wrong(&join(&path, "at"), message);
                } else if gone > MAX_SPEED * time {
                    let (most, speed) = (tell(MAX_SPEED), tell(gone / time));
                    let message = format!(
                        "takes the body there at {speed} m/s; at most {most} m/s are taken"
                    );
                    self.wrong(&join(&path, "position"), message);
                }
            }
            rows.push((keyframe.at, TemplatePlacement { rotation, position, ..at_rest }));
        }
        rows
    }

    /// The path of a driven body through its keyframes; nothing of one that is not driven.
    pub(super) fn path_of(
        &mut self,
        body: &Body,
        rows: &[(f64, TemplatePlacement)],
        path: &Path,
    ) -> Option<Arc<KeyframedPath>> {
        let keys = rows.iter().map(|(time, placed)| Keyframe { time: *time, pose: placed.pose() });
        let interpolation = match body.interpolation {
            KeyframeCurve::Linear => PathInterpolation::Linear,
            KeyframeCurve::Smooth => PathInterpolation::Smooth,
        };
        if rows.is_empty() || self.is_bad(&join(path, "keyframes")) {
            return None;
        }
        match KeyframedPath::new(keys.collect(), interpolation) {
            Ok(made) => Some(Arc::new(made)),
            Err(why) => {
                // Its own checks come first, and say where.
                self.wrong(&join(path, "keyframes"), why.to_string());
                None
            }
        }
    }
}

/// What is written of one kind, with its path.
fn entries<T: serde::de::DeserializeOwned>(
    context: &mut ResolveContext<'_>,
    list: &str,
) -> Vec<(Path, T)> {
    let root = context.root;
    // Of a list that is too long no item is looked at.
    let bad = context.lies_in_bad(&[list.into()]);
    let items: &[Node] = if bad { &[] } else { root.items(list) };
    let mut found = Vec::with_capacity(items.len());
    for (index, node) in items.iter().enumerate() {
        let path: Path = vec![list.into(), index.into()];
        if let Some(taken) = context.take::<T>(node, &path).filter(|taken| taken.whole) {
            found.push((path, taken.value));
        }
    }
    found
}

/// Joints, glue and fields of a scene; what is wrong with them is noted.
pub(super) fn directions(
    context: &mut ResolveContext<'_>,
    bodies: &[SceneBody],
    names: &BodyNames<'_>,
    seed: u64,
) -> SceneDirections {
    let mut found = SceneDirections::default();
    for (path, written) in entries::<JointEntry>(context, "joint") {
        found.joints.extend(joint(context, bodies, names, &written, &path));
    }
    for (path, written) in entries::<GlueEntry>(context, "glue") {
        found.glue.extend(glue(context, bodies, names, &written, &path));
    }
    for (path, written) in entries(context, "field") {
        found.fields.extend(super::fields::field(context, bodies, names, (&written, seed), &path));
    }
    let hits = entries(context, "hit");
    found.hits = super::hits::hits(context, bodies, names, hits);
    found
}

fn joint(
    context: &mut ResolveContext<'_>,
    bodies: &[SceneBody],
    names: &BodyNames<'_>,
    written: &JointEntry,
    path: &Path,
) -> Option<SceneJoint> {
    let before = context.errors.len();
    let between = join(path, "between");
    let mut ends = [None; 2];
    for (end, name) in written.between.iter().enumerate().take(2) {
        // A body of that name comes first, so that no scene changes its meaning.
        if name != WORLD || names.knows(WORLD) {
            ends[end] = Some(names.one(context, name, &join(&between, end))?);
        }
    }
    let moves = |end: Option<usize>| {
        end.is_some_and(|body| !bodies[body].fixed && bodies[body].drive.is_none())
    };
    if ends[0] == ends[1] {
        context.wrong(&between, "a joint is between two bodies that differ");
    } else if !ends.iter().any(|end| moves(*end)) {
        let message = "one of the two must be free to move: not fixed, driven, or the world";
        context.wrong(&between, message);
    }
    misplaced_keys(context, written, path);
    let centre = |end: usize| ends[end].map(|body| bodies[body].pose.translation.vector);
    let rope = written.kind == JointForm::Rope;
    let first = match written.kind {
        JointForm::Rope => written.at.map(Vec3::from).or(centre(0)),
        JointForm::Rigid => written.at.map(Vec3::from).or(centre(0)).or(centre(1)),
        JointForm::Hinge | JointForm::Ball => written.at.map(Vec3::from),
    };
    let second = if rope { written.to.map(Vec3::from).or(centre(1)) } else { first };
    for (key, _) in [("at", first), ("to", second)].into_iter().filter(|(_, at)| at.is_none()) {
        if (key == "at" || rope) && context.lacks(path, &[key]) {
            let message = format!("`{key}` is missing: where the joint is, in the world");
            context.wrong(path, message);
        }
    }
    let (first, second) = (first?, second?);
    for (key, at) in [("at", first), ("to", second)] {
        if at.norm() > MAX_DISTANCE || !at.norm().is_finite() {
            let message = format!("must be at most {} m long", tell(MAX_DISTANCE));
            context.wrong(&join(path, key), message);
        }
    }
    let apart = (second - first).norm();
    let length = written.length.unwrap_or(apart);
    if rope && length < apart * (1.0 - ROPE_ROUNDING) {
        let (length, apart) = (tell(length), tell(apart));
        let message =
            format!("must be at least {apart} m, the distance of its ends; it is {length} m");
        context.wrong(&join(path, "length"), message);
    } else if rope && length <= 0.0 {
        context.wrong(path, "`length` is missing: its ends are at one place");
    }
    let axis = axis(context, written, path)?;
    let (force, torque) = (written.force, written.torque);
    let (bodies, anchors) = (ends, [first, second]);
    let (kind, collide) = (written.kind, written.collide.unwrap_or(rope));
    let made = SceneJoint { kind, bodies, anchors, axis, length, force, torque, collide };
    (context.errors.len() == before).then_some(made)
}

/// The axis of a hinge, upward for all else; nothing of one without a direction.
fn axis(context: &mut ResolveContext<'_>, written: &JointEntry, path: &Path) -> Option<Vec3> {
    match written.axis.map(direction) {
        Some(Ok(axis)) => Some(axis.into()),
        Some(Err(why)) => {
            context.wrong(&join(path, "axis"), why);
            None
        }
        None => Some(Vec3::z()),
    }
}

/// Notes keys that a joint of that kind does not have, and those that it lacks.
fn misplaced_keys(context: &mut ResolveContext<'_>, written: &JointEntry, path: &Path) {
    let kind = written.kind;
    let keys = [
        ("to", written.to.is_some(), kind == JointForm::Rope, "is for a rope"),
        ("length", written.length.is_some(), kind == JointForm::Rope, "is for a rope"),
        ("axis", written.axis.is_some(), kind == JointForm::Hinge, "is for a hinge"),
        (
            "torque",
            written.torque.is_some(),
            matches!(kind, JointForm::Rigid | JointForm::Hinge),
            "a ball joint and a rope bear no moment",
        ),
        (
            "collide",
            written.collide.is_some(),
            matches!(kind, JointForm::Ball | JointForm::Rope),
            "bodies that a rigid joint or a hinge joins never collide with each other",
        ),
    ];
    for (key, _, _, why) in keys.into_iter().filter(|(_, said, fits, _)| *said && !fits) {
        context.wrong(&join(path, key), why);
    }
    if kind == JointForm::Hinge && written.axis.is_none() && context.lacks(path, &["axis"]) {
        context.wrong(path, "`axis` is missing: what the hinge turns about");
    }
}

fn glue(
    context: &mut ResolveContext<'_>,
    bodies: &[SceneBody],
    names: &BodyNames<'_>,
    written: &GlueEntry,
    path: &Path,
) -> Option<SceneGlue> {
    let before = context.errors.len();
    let named = names.all(context, &written.bodies, &join(path, "bodies"));
    let free = |body: &usize| !bodies[*body].fixed && bodies[*body].drive.is_none();
    if context.errors.len() == before && (named.len() < 2 || !named.iter().any(free)) {
        let count = named.len();
        let message =
            format!("glue needs two bodies or more, one of them free to move; these are {count}");
        context.wrong(&join(path, "bodies"), message);
    }
    let strength = match (written.force, written.tensile, written.shear) {
        (Some(force), None, None) => GlueStrength::Pair { force, torque: written.torque },
        (None, Some(tensile), Some(shear)) => GlueStrength::Area { tensile, shear },
        _ => {
            if context.lacks(path, &["force", "tensile", "shear"]) {
                context.wrong(path, "glue takes `force`, or `tensile` and `shear`");
            }
            return None;
        }
    };
    if written.torque.is_some() && written.force.is_none() {
        context.wrong(&join(path, "torque"), "is for glue with `force`");
    }
    let bodies = named.into_iter().collect();
    let made = SceneGlue { bodies, strength, gap: written.gap };
    (context.errors.len() == before).then_some(made)
}
