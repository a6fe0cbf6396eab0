//! A body gets a new shape and stays the body that it is: a dent. Its mass is kept, the momentum of
//! the pair too, and what the deformation cost is paid from the motion.

use crate::body::{Body, BodySpec, Tier, invert};
use crate::cluster::{Part, sum};
use crate::error::{ReplaceError, WorldError};
use crate::id::BodyId;
use crate::impact::Hit;
use crate::motion::Motion;
use crate::replace::{
    ExchangeInput, Exchanged, Replacement, audit, book_drivers, record_pending, solve_exchange,
    still,
};
use crate::rigid::{BadPart, Fit, Shape};
use crate::state::WorldState;
use crate::strikers::remaining_budgets;
use crate::support::Reaction;
use cullet_geometry::{Mat3, Pose, Solid, Vec3};
use nalgebra::Translation3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// What a solver made of a body that did not break, in the body's frame before the hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Reshape {
    /// The new shape \[m\].
    pub solid: Solid,
    /// Convex parts that stand in for it in collisions: corner sets \[m\].
    pub hulls: Vec<Vec<Vec3>>,
    /// Velocity of its centroid that the hit gave it, beside the body's motion before the hit
    /// \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity that the hit gave it, likewise \[rad/s\].
    pub spin: Vec3,
    /// What held it meanwhile, as [`crate::World::supports`] found it; none where the solver knows
    /// no supports.
    pub reactions: Vec<Reaction>,
    /// What the deformation cost \[J\].
    pub work: f64,
}

/// [`crate::World::reshape`].
pub(crate) fn reshape(
    world: &mut WorldState,
    id: BodyId,
    hits: &[Hit],
    new: Reshape,
) -> Result<Replacement, ReplaceError> {
    let unknown = ReplaceError::Unknown(id);
    let old = world.bodies.get(&id.0).cloned().ok_or_else(|| unknown.clone())?;
    let motion = world.rigid.motion(id.0).ok_or(unknown)?;
    if old.driven.is_some() {
        return Err(ReplaceError::Driven(id));
    }
    check(&new)?;
    let made = make_body(world, &old, &motion, &new)?;
    if old.fixed {
        return reshape_fixed(world, id, &old, hits, made, new.work);
    }
    let now = Part::new(&old, &motion);
    let body = as_reshaped(&now, &made.body.world_inertia(&made.pose));
    // A body that draws in spins faster; what that takes is paid, too.
    let turning = (sum([body].iter()).kinetic - sum([now].iter()).kinetic).max(0.0);
    let parted = ExchangeInput {
        body,
        fragments: vec![still((&made.body, &made.pose))],
        loose: false,
        given: vec![(motion.to_world(&new.velocity), motion.to_world(&new.spin))],
        cost: new.work + turning,
    };
    let exchanged = solve_exchange(world, (id, &old, &motion), hits, parted, &new.reactions)?;
    let Exchanged { problem, solution, energy_budgets } = exchanged;
    let (part, volume) = (&solution.fragments[0], made.body.volume);
    put_shape(world, id, made, (part.velocity, part.spin));
    for (&other, part) in &solution.parts {
        world.rigid.set_velocity(other, &part.velocity, &part.spin);
    }
    // A bulge may overlap what made it.
    let strikers = problem.strikers.iter().flat_map(|striker| striker.ids.iter().copied());
    let strikers: BTreeSet<u32> = strikers.collect();
    for other in strikers {
        world.rigid.suppress_contacts(&[id.0.max(other)], &[id.0.min(other)]);
    }
    world.replaced.add_to_sink(&solution.sink);
    book_drivers(world, &problem, &solution);
    record_pending(world, &problem, hits, &energy_budgets, &solution, &[id]);
    let mut report = audit(world, &problem, &solution, &[id]);
    report.volume_rel_error = (volume / old.volume - 1.0).abs();
    report.tiers = vec![old.tier];
    report.fracture_energy = new.work;
    report.energy_before -= turning;
    Ok(report)
}

fn make_body(
    world: &WorldState,
    old: &Body,
    motion: &Motion,
    new: &Reshape,
) -> Result<Remade, ReplaceError> {
    let mass = new.solid.mesh.mass_properties();
    let centre = mass.centroid;
    let mut solid = new.solid.clone();
    solid.mesh.vertices.iter_mut().for_each(|p| *p -= centre);
    let mut hulls = new.hulls.clone();
    hulls.iter_mut().flatten().for_each(|p| *p -= centre);
    if hulls.is_empty() {
        hulls.push(solid.mesh.vertices.clone());
    }
    let spec = BodySpec {
        name: old.name.clone(),
        solid: Arc::new(solid),
        hulls,
        material: old.material,
        density: Some(old.mass / mass.volume),
        pose: if old.fixed { motion.pose * Translation3::from(centre) } else { motion.pose },
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
        fixed: old.fixed,
        driven: None,
        breakable: old.breakable,
        weakest: old.weakest,
        threshold: old.threshold,
        parent: old.parent,
        generation: old.generation,
        original_volume: Some(old.original_volume),
    };
    let settings = &world.settings;
    let mut body = Body::new(&spec, &settings.tiers, settings.max_generation, old.birth)?;
    // It is as much of the original as it was, whatever its volume.
    (body.mass, body.tier, body.breakable) = (old.mass, old.tier, old.breakable);
    body.blow.clone_from(&old.blow);
    let fit = if body.tier == Tier::Tiny { Fit::Tiny } else { Fit::Fragment };
    let shape = Shape::new(&body, &spec.hulls, fit).map_err(|BadPart { index, why }| {
        WorldError::Hull { name: spec.name.clone(), index, count: spec.hulls.len(), why }
    })?;
    Ok(Remade { body, shape, pose: spec.pose })
}

/// Puts a body's new shape in the place of the old one, with that velocity \[m/s\] and spin
/// \[rad/s\].
fn put_shape(world: &mut WorldState, id: BodyId, made: Remade, (velocity, spin): (Vec3, Vec3)) {
    let Remade { body, shape, pose } = made;
    let held = world.joints.of_body(id.0);
    held.iter().for_each(|&joint| world.rigid.unjoin(joint));
    world.rigid.remove(id.0);
    world.episodes.forget(id.0);
    world.settling.end(id.0);
    world.replaced.drop_pending(id.0);
    let damping = if body.tier == Tier::Whole { 0.0 } else { world.settings.debris_damping };
    world.rigid.insert(id.0, &body, shape, &Motion { pose, velocity, spin }, damping);
    world.bodies.insert(id.0, body);
    for joint in held {
        if let Some(own) = world.joints.all.get(&joint) {
            world.rigid.join(joint, own);
        }
    }
}

/// A body that never moves keeps its place, and what its contacts took out of the motion pays.
fn reshape_fixed(
    world: &mut WorldState,
    id: BodyId,
    old: &Body,
    hits: &[Hit],
    made: Remade,
    work: f64,
) -> Result<Replacement, ReplaceError> {
    let available = remaining_budgets(world, id.0, hits).iter().sum::<f64>().max(0.0);
    if work > available {
        let payable = available;
        return Err(ReplaceError::Unaffordable { fracture_energy: work, available, payable });
    }
    let volume_rel_error = (made.body.volume / old.volume - 1.0).abs();
    put_shape(world, id, made, (Vec3::zeros(), Vec3::zeros()));
    Ok(Replacement {
        fragments: vec![id],
        tiers: vec![old.tier],
        volume_rel_error,
        energy_before: available,
        fracture_energy: work,
        ..Replacement::default()
    })
}

/// A body as it moves when it takes another inertia (about its centre, world frame \[kg·m²\]): its
/// centre, momentum and angular momentum are kept.
fn as_reshaped(now: &Part, inertia: &Mat3) -> Part {
    let spin = invert(inertia) * (now.inertia * now.spin);
    Part { inertia: *inertia, spin, ..*now }
}

/// A body in its new shape, and where it is.
struct Remade {
    body: Body,
    shape: Shape,
    pose: Pose,
}

/// Refuses what is no shape or no motion.
fn check(new: &Reshape) -> Result<(), ReplaceError> {
    let mesh = &new.solid.mesh;
    let bad = |what, value| Err(ReplaceError::Piece { index: 0, what, value });
    let corners = mesh.vertices.len() as u32;
    let highest = mesh.triangles.iter().flatten().copied().max();
    if highest.is_none_or(|i| i >= corners) {
        return bad("the highest corner index", f64::from(highest.unwrap_or(0)));
    }
    let volume = mesh.mass_properties().volume;
    if !(volume.is_finite() && volume > 0.0) {
        return bad("the volume [m³]", volume);
    }
    let speed = new.velocity.norm() + new.spin.norm();
    if !speed.is_finite() {
        return bad("the speed [m/s]", speed);
    }
    if !(new.work.is_finite() && new.work >= 0.0) {
        return bad("the work of the deformation [J]", new.work);
    }
    for (index, reaction) in new.reactions.iter().enumerate() {
        let value = reaction.impulse;
        if !(value.is_finite() && value >= 0.0) {
            return Err(ReplaceError::Reaction { index, value });
        }
    }
    Ok(())
}
