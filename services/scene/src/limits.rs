//! What must hold between the values of a scene, beyond the range of each.

use super::context::ResolveContext;
use super::format::{Document, World, WorldBounds};
use cullet_document::check::tell;
use cullet_document::tree::Path;
use cullet_geometry::Vec3;

/// Greatest gravity \[m/s²\]: beyond it every contact is a hit.
pub(super) const MAX_GRAVITY: f64 = 1e4;

/// Most steps of a run: more would fill a disk, and take days.
pub(super) const MAX_STEPS: f64 = 1e7;

/// Says what does not fit together; `bodies`: how many there are.
pub(super) fn check(context: &mut ResolveContext<'_>, document: &Document, bodies: usize) {
    world(context, &document.world);
    let most = document.world.max_bodies;
    if bodies > most as usize {
        let message = format!("must be at least {bodies}, the bodies of the scene; it is {most}");
        context.wrong(&path(&["world", "max_bodies"]), message);
    }
    let e = &document.expect;
    let ranges = [
        ("fractures", e.fractures),
        ("fragments", e.fragments),
        ("bodies_final", e.bodies_final),
        ("failed", e.failed),
        ("open_fragments", e.open_fragments),
        ("sheet_pieces", e.sheet_pieces),
        ("joints_broken", e.joints_broken),
    ];
    for (name, range) in ranges {
        if let Some((Some(least), Some(most))) = range.map(|range| (range.min, range.max))
            && least > most
        {
            let message = format!("`min` must be at most `max`; they are {least} and {most}");
            context.wrong(&path(&["expect", name]), message);
        }
    }
    for (name, range) in [("sampled", e.sampled), ("sampled_mass", e.sampled_mass)] {
        if let Some((Some(least), Some(most))) = range.map(|range| (range.min, range.max))
            && least > most
        {
            let message = format!("`min` must be at most `max`; they are {least} and {most}");
            context.wrong(&path(&["expect", name]), message);
        }
    }
    if document.view.as_ref().is_some_and(|view| view.eye == view.target) {
        context.wrong(&path(&["view", "eye"]), "must differ from `target`");
    }
    let window = document.view.as_ref().and_then(|view| view.start.zip(view.end));
    if let Some((start, end)) = window.filter(|(start, end)| end <= start) {
        let message = format!("must be after `start`, {start} s; it is {end} s");
        context.wrong(&path(&["view", "end"]), message);
    }
    let lists = ["body", "grid", "stack", "scatter", "instances", "sheet"];
    if lists.iter().all(|list| context.root.items(list).is_empty()) {
        context.wrong(&[], "the scene has no body and no sheet");
    }
}

fn world(context: &mut ResolveContext<'_>, world: &World) {
    let (tiers, step, duration) = (world.tiers, world.step, world.duration);
    if tiers.tiny > tiers.small {
        let (tiny, small) = (tiers.tiny, tiers.small);
        let message = format!("`tiny` must be at most `small`; they are {tiny} and {small}");
        context.wrong(&path(&["world", "tiers"]), message);
    }
    if duration < step {
        let message = format!("must be at least one step, {step} s; it is {duration} s");
        context.wrong(&path(&["world", "duration"]), message);
    }
    let steps = (duration / step).round();
    if steps > MAX_STEPS {
        let (steps, most) = (tell(steps), tell(MAX_STEPS));
        let message = format!("{duration} s would take {steps} steps; at most {most} are taken");
        context.wrong(&path(&["world", "step"]), message);
    }
    if let Some(WorldBounds { min, max }) = world.bounds
        && let Some(axis) = (0..3).find(|&axis| min[axis] >= max[axis])
    {
        let (axis, low, high) = (["x", "y", "z"][axis], tell(min[axis]), tell(max[axis]));
        let message =
            format!("`min` must be below `max`; along {axis} they are {low} and {high} m");
        context.wrong(&path(&["world", "bounds"]), message);
    }
    let gravity = Vec3::from(world.gravity);
    if gravity.amax() > MAX_GRAVITY || gravity.norm() > MAX_GRAVITY {
        let (most, size) = (tell(MAX_GRAVITY), tell(gravity.amax()));
        let message = format!("its length must be at most {most} m/s2; a component is {size} m/s2");
        context.wrong(&path(&["world", "gravity"]), message);
    }
}

fn path(names: &[&str]) -> Path {
    names.iter().map(|name| (*name).into()).collect()
}
