//! Hits that are solved with settings of their own: checked against the bodies that they reach.

use super::body::yields;
use super::body_names::BodyNames;
use super::context::ResolveContext;
use super::directions::SceneHit;
use super::format::HitEntry;
use super::scene::SceneBody;
use super::sourced::Fault;
use super::{bonds, treatment};
use cullet_document::tree::{Path, join};

/// The hits of a scene; what is wrong with them is noted.
pub(super) fn hits(
    context: &mut ResolveContext<'_>,
    bodies: &[SceneBody],
    names: &BodyNames<'_>,
    entries: Vec<(Path, HitEntry)>,
) -> Vec<SceneHit> {
    let mut found: Vec<SceneHit> = Vec::with_capacity(entries.len());
    for (path, written) in entries {
        let before = context.errors.len();
        let HitEntry { body, at, seed, solver, spacing, particles } = written;
        let hit = SceneHit { body, at, seed, solver, spacing, particles };
        match object_of(bodies, &hit.body) {
            None => names.unknown(context, &hit.body, &join(&path, "body")),
            Some(body) => check(context, body, &hit, &path),
        }
        let same = bodies.iter().any(|body| body.name == hit.body);
        let origin = origin_of(bodies, &hit.body).filter(|origin| same && origin.breakable);
        if let Some(origin) = origin {
            let (name, origin) = (&hit.body, &origin.name);
            let message = format!(
                "\"{name}\" can be that body or a fragment of \"{origin}\": name one of the two \
                 bodies otherwise"
            );
            context.wrong(&join(&path, "body"), message);
        }
        if found.iter().any(|other| (&other.body, other.at) == (&hit.body, hit.at)) {
            let message =
                format!("a second entry is for the hit of \"{}\" from {at} s on", hit.body);
            context.wrong(&path, message);
        }
        found.extend((context.errors.len() == before).then_some(hit));
    }
    found
}

fn check(context: &mut ResolveContext<'_>, body: &SceneBody, hit: &SceneHit, path: &Path) {
    if !body.breakable {
        context.wrong(&join(path, "body"), format!("\"{}\" does not break", body.name));
    }
    if hit.spacing.is_some() && hit.particles.is_some() {
        context.wrong(path, "takes `spacing` or `particles`, not both");
    }
    let settings = ["seed", "solver", "spacing", "particles"];
    if hit.to_string().is_empty() && context.lacks(path, &settings) {
        let keys = settings.map(|key| format!("`{key}`")).join(", ");
        context.wrong(path, format!("says nothing about the hit: give it one of {keys}"));
    }
    if let Some((key, why)) = hit.solver.as_ref().and_then(|solver| unfit(body, solver)) {
        let key = if key == "solver" { "solver" } else { "body" };
        context.wrong(&join(path, key), why);
    }
}

/// Why a body cannot be solved by that family.
fn unfit(body: &SceneBody, solver: &super::SolverChoice) -> Option<Fault> {
    let (material, strength) = (&body.material, &body.strength);
    let painted = !strength.strokes.is_empty() || strength.vertices.is_some();
    treatment::unfit(material.treatment, &body.solid, solver)
        .or_else(|| yields(material, solver))
        .or_else(|| bonds::unfit(material, painted, solver))
}

/// The body of that name, or of which a fragment has it: `pot.3.0` comes from `pot`, unless there
/// is a `pot.3`.
fn object_of<'a>(bodies: &'a [SceneBody], name: &str) -> Option<&'a SceneBody> {
    let same = bodies.iter().find(|body| body.name == name);
    same.or_else(|| origin_of(bodies, name))
}

/// The body of which a fragment can have that name.
fn origin_of<'a>(bodies: &'a [SceneBody], name: &str) -> Option<&'a SceneBody> {
    let number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let from = |body: &&SceneBody| {
        let rest = name.strip_prefix(body.name.as_str()).and_then(|rest| rest.strip_prefix('.'));
        rest.is_some_and(|rest| rest.split('.').all(number))
    };
    bodies.iter().filter(from).max_by_key(|body| body.name.len())
}
