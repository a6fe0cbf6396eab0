//! A body goes, its fragments come: same mass, same momentum, no energy from nowhere (F41, R1–R3).

use crate::body::{Blow, Body, BodySpec, Tier};
use crate::cluster::{Part, Sum, sum};
use crate::error::ReplaceError;
use crate::exchange::{Exchange, PendingExchange};
use crate::id::BodyId;
use crate::impact::Hit;
use crate::impulse_exchange::{
    InsufficientEnergy, ReplacementProblem, ReplacementSolution, Striker, exchange_impulses,
};
use crate::joints::take_out_of;
use crate::motion::Motion;
use crate::rejoin::rejoin;
use crate::removal::forget;
use crate::rigid::{BadPart, Fit, Shape};
use crate::state::WorldState;
use crate::strikers::{find_strikers, moving_parts, remaining_budgets, supporting_strikers};
use crate::support::Reaction;
use crate::{WorldError, ledger::Sink};
use cullet_geometry::{Mat3, Pose, Quat, Vec3};
use cullet_model::{Fragment, Grain};
use std::collections::BTreeSet;
use std::sync::Arc;

/// What a solver made of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Breakage {
    /// Its parts; the cracks inside them are not looked at.
    pub pieces: Vec<Fragment>,
    /// Parts too small to be bodies.
    pub grains: Vec<Grain>,
    /// What held it meanwhile, as [`crate::World::supports`] found it; none where the solver knows
    /// no supports.
    pub reactions: Vec<Reaction>,
    /// G_f times the crack area \[J\].
    pub fracture_energy: f64,
    /// The solver follows a striker only as far as the body breaks: what of it is in the way then
    /// is hit anew, at any age (F43).
    pub meets_again: bool,
}

/// What a replacement came to. Errors are measured on the state that the engine holds afterwards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replacement {
    /// The fragments in the order of the pieces.
    pub fragments: Vec<BodyId>,
    /// The size class of each.
    pub tiers: Vec<Tier>,
    /// The numbers of the grains of debris, in their order.
    pub grains: Vec<u64>,
    /// Their mass \[kg\].
    pub grain_mass: f64,
    /// α: share of the solver's impulse that was handed over \[1\]; one unless energy forbade it.
    /// Of late fragments, and of those of a body that was pressed against others so that its base
    /// could not pay: the share by which it took the place of the engine's.
    pub momentum_scale: f64,
    /// β: share of the speed at which the pieces move apart \[1\]; one unless energy forbade it.
    pub spread_scale: f64,
    /// |Σ m − m| / m \[1\].
    pub mass_rel_error: f64,
    /// |Σ V − V| / V \[1\].
    pub volume_rel_error: f64,
    /// Change of the pair's momentum, fixed bodies included, over the momenta in it \[1\].
    pub momentum_rel_error: f64,
    /// The same for angular momentum about the world's origin \[1\].
    pub angular_momentum_rel_error: f64,
    /// Kinetic energy of the pair before the hit \[J\], as all energies in the frame of the striker
    /// where that is driven by keyframes; and no more than what it is now and what
    /// the contacts took out of it and no other replacement has spent. Of late fragments: the
    /// latter.
    pub energy_before: f64,
    /// Kinetic energy of the pair with the fragments \[J\].
    pub energy_after: f64,
    /// G_f times the crack area, paid from the motion \[J\].
    pub fracture_energy: f64,
    /// max(0, after + paid − before) / before \[1\].
    pub energy_gain_rel: f64,
    /// Joints that hold fragments in place of those that held the body.
    pub joints_kept: usize,
    /// Joints of the body that hold no fragment.
    pub joints_lost: usize,
}

/// The pieces must fill the body to this share.
const VOLUME_TOLERANCE: f64 = 1e-9;

/// Fragments as bodies, before they are put in.
struct Draft {
    bodies: Vec<Body>,
    shapes: Vec<Shape>,
    poses: Vec<Pose>,
}

/// What a body has become, before its motion is settled.
pub(crate) struct ExchangeInput {
    /// The body as it moves now, with the momenta that it has.
    pub(crate) body: Part,
    /// At rest where they are, the grains last.
    pub(crate) fragments: Vec<Part>,
    /// There are grains.
    pub(crate) loose: bool,
    /// Velocity \[m/s\] and spin \[rad/s\] that the solver gave each, world frame.
    pub(crate) given: Vec<(Vec3, Vec3)>,
    /// What the motion pays \[J\].
    pub(crate) cost: f64,
}

/// A replacement's motion, settled.
pub(crate) struct Exchanged {
    pub(crate) problem: ReplacementProblem,
    pub(crate) solution: ReplacementSolution,
    /// What each hit's contact took out of the motion \[J\].
    pub(crate) energy_budgets: Vec<f64>,
}

/// A body at rest in its place.
pub(crate) fn still((child, pose): (&Body, &Pose)) -> Part {
    let at_rest = Motion { pose: *pose, velocity: Vec3::zeros(), spin: Vec3::zeros() };
    Part::new(child, &at_rest)
}

/// [`crate::World::break_up`].
pub(crate) fn break_up(
    world: &mut WorldState,
    body: BodyId,
    hits: &[Hit],
    breakage: Breakage,
) -> Result<Replacement, ReplaceError> {
    let unknown = ReplaceError::Unknown(body);
    let parent = world.bodies.get(&body.0).cloned().ok_or_else(|| unknown.clone())?;
    let motion = world.rigid.motion(body.0).ok_or(unknown)?;
    if parent.driven.is_some() {
        return Err(ReplaceError::Driven(body));
    }
    check(world, &parent, &breakage)?;
    let Breakage { pieces, grains, reactions, fracture_energy, meets_again } = breakage;
    let own = pieces.iter().map(|p| (p.velocity, p.spin));
    let own = own.chain(grains.iter().map(|g| (g.velocity, Vec3::zeros())));
    let given = own.map(|(v, w)| (motion.to_world(&v), motion.to_world(&w))).collect();
    let strikers = if meets_again { hits.iter().map(|h| h.other.0).collect() } else { Vec::new() };
    let before = parent.blows_before(hits.iter().map(|hit| (hit.other.0, hit.time)));
    let blow = Blow { count: before + 1, strikers };
    let draft = make_bodies(world, (body, &parent, &motion), pieces, &blow)?;
    let specks = grains.iter().map(|grain| grain_part(grain, &parent, &motion));
    let placed = draft.bodies.iter().zip(&draft.poses).map(still);
    let parts = ExchangeInput {
        body: Part::new(&parent, &motion),
        fragments: placed.chain(specks).collect(),
        loose: !grains.is_empty(),
        given,
        cost: fracture_energy,
    };
    let Exchanged { problem, solution, energy_budgets } =
        solve_exchange(world, (body, &parent, &motion), hits, parts, &reactions)?;
    let tiers = draft.bodies.iter().map(|child| child.tier).collect();
    let volumes = draft.bodies.iter().map(|child| child.volume);
    let volume: f64 = volumes.chain(grains.iter().map(|grain| grain.volume)).sum();
    let offsets: Vec<Vec3> =
        draft.poses.iter().map(|pose| motion.pose.inv_mul(pose).translation.vector).collect();
    let held = take_out_of(world, body.0);
    let fragments = put_in(world, body.0, draft, &solution, &problem.strikers);
    let placed: Vec<(u32, Vec3)> = fragments.iter().map(|id| id.0).zip(offsets).collect();
    let rejoined = rejoin(world, held, body.0, &placed);
    book_drivers(world, &problem, &solution);
    record_pending(world, &problem, hits, &energy_budgets, &solution, &fragments);
    let specks = &solution.fragments[fragments.len()..];
    let ids = world.debris.scatter(body.0, &grains, specks);
    let mut report = audit(world, &problem, &solution, &fragments);
    report.grains = ids;
    report.grain_mass = specks.iter().map(|part| part.mass).sum();
    report.tiers = tiers;
    (report.joints_kept, report.joints_lost) = (rejoined.kept, rejoined.lost);
    report.volume_rel_error = (volume / parent.volume - 1.0).abs();
    Ok(report)
}

/// What hits and supports gave a body and its strikers, settled anew with what the solver says.
pub(crate) fn solve_exchange(
    world: &WorldState,
    (body, parent, motion): (BodyId, &Body, &Motion),
    hits: &[Hit],
    parted: ExchangeInput,
    reactions: &[Reaction],
) -> Result<Exchanged, ReplaceError> {
    let ExchangeInput { body: whole, fragments, loose, given, cost } = parted;
    let mut strikers = find_strikers(world, body.0, hits);
    strikers
        .extend(reactions.iter().flat_map(|reaction| supporting_strikers(world, reaction, motion)));
    let parts = moving_parts(world, &strikers);
    let energy_budgets = remaining_budgets(world, body.0, hits);
    let supported: f64 = reactions.iter().map(|reaction| reaction.support.dissipated).sum();
    let first = hits.first();
    let turned = |hit: &Hit| hit.orientation * motion.pose.rotation.inverse();
    let frame = driver_frame(hits);
    let mut whole = whole;
    whole.velocity -= frame;
    let mut parts = parts;
    parts.values_mut().for_each(|part| part.velocity -= frame);
    let problem = ReplacementProblem {
        frame,
        body: whole,
        fixed: parent.immovable(),
        fragments,
        loose,
        given,
        strikers,
        parts,
        fracture_energy: cost,
        energy_budget: (energy_budgets.iter().sum::<f64>() + supported).max(0.0),
        back: first.map_or_else(Quat::identity, turned),
        late: first.is_some_and(|hit| hit.step < world.steps),
    };
    let mut solution =
        exchange_impulses(&problem).map_err(|InsufficientEnergy { available, payable }| {
            ReplaceError::Unaffordable { fracture_energy: cost, available, payable }
        })?;
    solution.fragments.iter_mut().for_each(|part| part.velocity += frame);
    solution.parts.values_mut().for_each(|part| part.velocity += frame);
    Ok(Exchanged { problem, solution, energy_budgets })
}

/// Velocity of the driven striker that hit hardest \[m/s\]: what it does to the body it could do in
/// its own frame, in which it has no energy to give.
fn driver_frame(hits: &[Hit]) -> Vec3 {
    let driven = hits.iter().filter_map(|hit| Some((hit.impact.impulse, hit.driven_at?)));
    let hardest = driven.max_by(|one, other| one.0.total_cmp(&other.0));
    hardest.map_or_else(Vec3::zeros, |(_, velocity)| velocity)
}

/// Books what driven strikers did more, or less, than the engine had them do.
pub(crate) fn book_drivers(
    world: &mut WorldState,
    problem: &ReplacementProblem,
    solution: &ReplacementSolution,
) {
    for (striker, (net, _)) in problem.strikers.iter().zip(&solution.nets) {
        if let Some((id, velocity)) = striker.driven {
            let more = (net.linear - striker.mine.linear).dot(&velocity);
            world.flows.driven_work += more;
            *world.driven_work.entry(id).or_insert(0.0) += more;
        }
    }
}

fn check(world: &WorldState, parent: &Body, breakage: &Breakage) -> Result<(), ReplaceError> {
    let Breakage { pieces, grains, reactions, fracture_energy: cost, .. } = breakage;
    if pieces.len() + grains.len() < 2 {
        return Err(ReplaceError::TooFew(pieces.len() + grains.len()));
    }
    let (count, limit) = (world.bodies.len() - 1 + pieces.len(), world.settings.max_bodies);
    if count > limit {
        return Err(ReplaceError::Budget { pieces: pieces.len(), count, limit });
    }
    let mut volume = 0.0;
    for (index, piece) in pieces.iter().enumerate() {
        let corners = piece.solid.mesh.vertices.len() as u32;
        let highest = piece.solid.mesh.triangles.iter().flatten().copied().max();
        let bad = |what, value| Err(ReplaceError::Piece { index, what, value });
        if highest.is_none_or(|i| i >= corners) {
            return bad("the highest corner index", f64::from(highest.unwrap_or(0)));
        }
        let own = piece.solid.mesh.mass_properties().volume;
        if !(own.is_finite() && own > 0.0) {
            return bad("the volume [m³]", own);
        }
        let speed = piece.velocity.norm() + piece.spin.norm();
        if !speed.is_finite() {
            return bad("the speed [m/s]", speed);
        }
        volume += own;
    }
    for (index, grain) in grains.iter().enumerate() {
        let motion = grain.velocity.norm() + grain.position.norm();
        let sound = grain.volume > 0.0 && grain.size > 0.0 && motion.is_finite();
        if !(sound && grain.volume.is_finite() && grain.size.is_finite()) {
            let value = grain.volume;
            return Err(ReplaceError::Grain { index, value });
        }
        volume += grain.volume;
    }
    for (index, reaction) in reactions.iter().enumerate() {
        let value = reaction.impulse;
        if !(value.is_finite() && value >= 0.0) {
            return Err(ReplaceError::Reaction { index, value });
        }
    }
    let ratio = volume / parent.volume;
    if (ratio - 1.0).abs() > VOLUME_TOLERANCE {
        return Err(ReplaceError::Volume { ratio, bound: VOLUME_TOLERANCE });
    }
    if !(cost.is_finite() && *cost >= 0.0) {
        return Err(ReplaceError::Piece {
            index: 0,
            what: "the fracture energy [J]",
            value: *cost,
        });
    }
    Ok(())
}

/// Makes bodies of the pieces: each re-centred on its own centre of mass.
fn make_bodies(
    world: &WorldState,
    (id, parent, motion): (BodyId, &Body, &Motion),
    pieces: Vec<Fragment>,
    blow: &Blow,
) -> Result<Draft, ReplaceError> {
    let settings = &world.settings;
    let birth = world.time();
    let mut draft = Draft { bodies: Vec::new(), shapes: Vec::new(), poses: Vec::new() };
    for (k, mut piece) in pieces.into_iter().enumerate() {
        let centre = piece.solid.mesh.mass_properties().centroid;
        piece.solid.mesh.vertices.iter_mut().for_each(|p| *p -= centre);
        piece.hulls.iter_mut().flatten().for_each(|p| *p -= centre);
        if piece.hulls.is_empty() {
            piece.hulls.push(piece.solid.mesh.vertices.clone());
        }
        let spec = BodySpec {
            name: format!("{}.{k}", parent.name),
            solid: Arc::new(piece.solid),
            hulls: piece.hulls,
            material: parent.material,
            density: Some(parent.density),
            pose: motion.pose * nalgebra::Translation3::from(centre),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            fixed: false,
            driven: None,
            breakable: parent.breakable,
            weakest: parent.weakest,
            threshold: parent.threshold,
            parent: Some(id),
            generation: parent.generation + 1,
            original_volume: Some(parent.original_volume),
        };
        let mut body = Body::new(&spec, &settings.tiers, settings.max_generation, birth)?;
        body.blow.clone_from(blow);
        let fit = if body.tier == Tier::Tiny { Fit::Tiny } else { Fit::Fragment };
        let shape = Shape::new(&body, &spec.hulls, fit).map_err(|BadPart { index, why }| {
            WorldError::Hull { name: spec.name.clone(), index, count: spec.hulls.len(), why }
        })?;
        draft.bodies.push(body);
        draft.shapes.push(shape);
        draft.poses.push(spec.pose);
    }
    Ok(draft)
}

fn put_in(
    world: &mut WorldState,
    body: u32,
    draft: Draft,
    solution: &ReplacementSolution,
    strikers: &[Striker],
) -> Vec<BodyId> {
    forget(world, body);
    let mut ids = Vec::with_capacity(draft.bodies.len());
    let placed = draft.bodies.into_iter().zip(draft.shapes).zip(draft.poses);
    for (((child, shape), pose), part) in placed.zip(&solution.fragments) {
        let id = world.take_id();
        let motion = Motion { pose, velocity: part.velocity, spin: part.spin };
        let damping = if child.tier == Tier::Whole { 0.0 } else { world.settings.debris_damping };
        world.rigid.insert(id, &child, shape, &motion, damping);
        world.bodies.insert(id, child);
        ids.push(id);
    }
    for (&id, part) in &solution.parts {
        world.rigid.set_velocity(id, &part.velocity, &part.spin);
    }
    // A support goes on to hold the fragments.
    let others = strikers.iter().filter(|striker| striker.reaction.is_none());
    let others: BTreeSet<u32> = others.flat_map(|striker| striker.ids.clone()).collect();
    let others: Vec<u32> = others.into_iter().collect();
    world.rigid.suppress_contacts(&ids, &others);
    world.replaced.add_to_sink(&solution.sink);
    world.replaced.children.insert(body, ids.clone());
    ids.into_iter().map(BodyId).collect()
}

/// Notes for each striker that may itself be waiting to break what it holds from the episode by
/// now.
pub(crate) fn record_pending(
    world: &mut WorldState,
    problem: &ReplacementProblem,
    hits: &[Hit],
    energy_budgets: &[f64],
    solution: &ReplacementSolution,
    fragments: &[BodyId],
) {
    let others: Vec<u32> = fragments.iter().map(|id| id.0).collect();
    let left = if problem.energy_budget > 0.0 {
        solution.energy_budget / problem.energy_budget
    } else {
        0.0
    };
    for (striker, (mine, theirs)) in problem.strikers.iter().zip(&solution.nets) {
        let &[id] = striker.ids.as_slice() else {
            continue;
        };
        if !world.bodies.get(&id).is_some_and(|body| body.breakable) {
            continue;
        }
        let own = hits.iter().zip(energy_budgets).filter(|(hit, _)| hit.other.0 == id);
        for (k, (hit, energy_budget)) in own.enumerate() {
            // The first episode of a pair carries the whole exchange; none is settled twice.
            let (held, given) =
                if k == 0 { (*theirs, *mine) } else { (Exchange::zero(), Exchange::zero()) };
            let others = others.clone();
            let pending = PendingExchange {
                mine: held,
                theirs: given,
                others,
                energy_budget: energy_budget * left,
            };
            world.replaced.pending.insert((hit.episode, id), pending);
        }
    }
}

/// Compares what the engine holds now with what it held before.
pub(crate) fn audit(
    world: &WorldState,
    problem: &ReplacementProblem,
    solution: &ReplacementSolution,
    fragments: &[BodyId],
) -> Replacement {
    let now = |id: u32| {
        let (body, mut motion) = (world.bodies.get(&id)?, world.rigid.motion(id)?);
        motion.velocity -= problem.frame;
        Some(Part::new(body, &motion))
    };
    let pieces: Vec<Part> = fragments.iter().filter_map(|id| now(id.0)).collect();
    let others: Vec<Part> = solution.parts.keys().filter_map(|&id| now(id)).collect();
    let old: Vec<Part> = problem.parts.values().copied().collect();
    let own = if problem.fixed { &[][..] } else { std::slice::from_ref(&problem.body) };
    let before = sum(old.iter().chain(own));
    let specks = solution.fragments[fragments.len()..].iter();
    let specks = specks.map(|part| Part { velocity: part.velocity - problem.frame, ..*part });
    let pieces: Vec<Part> = pieces.into_iter().chain(specks).collect();
    let after = sum(pieces.iter().chain(&others));
    let all: Vec<Part> = old.iter().chain(own).chain(&pieces).chain(&others).copied().collect();
    let (linear, angular) = drift(&before, &after, &solution.sink, &all);
    let (paid, start) = (problem.fracture_energy, solution.energy_before);
    let gain = (after.kinetic + paid - start).max(0.0);
    let mass: f64 = pieces.iter().map(|p| p.mass).sum();
    Replacement {
        fragments: fragments.to_vec(),
        tiers: Vec::new(),
        grains: Vec::new(),
        grain_mass: 0.0,
        momentum_scale: solution.alpha,
        spread_scale: solution.beta,
        mass_rel_error: (mass / problem.body.mass - 1.0).abs(),
        volume_rel_error: 0.0,
        momentum_rel_error: linear,
        angular_momentum_rel_error: angular,
        energy_before: start,
        energy_after: after.kinetic,
        fracture_energy: paid,
        energy_gain_rel: ratio(gain, start),
        joints_kept: 0,
        joints_lost: 0,
    }
}

/// How far momentum and angular momentum moved, over the sizes of the momenta involved.
fn drift(before: &Sum, after: &Sum, sink: &Sink, parts: &[Part]) -> (f64, f64) {
    let linear: f64 = parts.iter().map(|p| p.momentum().norm()).sum();
    let angular: f64 = parts.iter().map(|p| p.angular().norm()).sum();
    (
        ratio((after.linear + sink.linear - before.linear).norm(), linear),
        ratio((after.angular + sink.angular - before.angular).norm(), angular),
    )
}

fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

/// A grain, at rest beside the others.
fn grain_part(grain: &Grain, parent: &Body, motion: &Motion) -> Part {
    Part {
        mass: grain.volume * parent.density,
        inertia: Mat3::zeros(),
        centre: (motion.pose * nalgebra::Point3::from(grain.position)).coords,
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
    }
}
