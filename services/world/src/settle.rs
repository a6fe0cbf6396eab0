//! The mechanics of a replacement: what the fragments and their strikers move like afterwards, and
//! whether the motion can pay for the crack.
//!
//! All velocities are `base + α·push + β·spread`: `base` is the motion before the hit (the engine's
//! exchange undone); `push` is the rigid part of what the solver gave the pieces, and its exact
//! opposite on the strikers; `spread` is the rest, which carries no momentum. Kinetic energy is
//! quadratic in α and, without a cross term, in β.

use crate::cluster::{Field, Joint, Part, Parts, joint, sum};
use crate::exchange::Exchange;
use crate::ledger::Sink;
use cullet_geometry::Vec3;

/// Change of velocity and spin.
type Change = (Vec3, Vec3);

/// One body (or the fragments of one) that met the broken body.
pub(crate) struct Striker {
    /// Who they are; moving ones only.
    pub(crate) ids: Vec<u32>,
    /// What the broken body received from it.
    pub(crate) mine: Exchange,
    /// What it received.
    pub(crate) theirs: Exchange,
    /// Its share of the whole impulse \[1\].
    pub(crate) weight: f64,
    /// Where it touched, now \[m\].
    pub(crate) point: Vec3,
}

impl Striker {
    fn fixed(&self) -> bool {
        self.ids.is_empty()
    }
}

/// The state before: the broken body, its fragments at rest relative to it, and the strikers.
pub(crate) struct Scene {
    /// The broken body as the engine left it.
    pub(crate) body: Part,
    /// It never moved before it broke.
    pub(crate) fixed: bool,
    /// Where the fragments are and what they weigh; their motion is filled in here.
    pub(crate) fragments: Vec<Part>,
    /// What the solver gave each, world frame: velocity \[m/s\] and spin \[rad/s\].
    pub(crate) given: Vec<Change>,
    pub(crate) strikers: Vec<Striker>,
    /// All moving strikers as the engine left them.
    pub(crate) parts: Parts,
    /// G_f times the crack area \[J\].
    pub(crate) fracture_energy: f64,
}

/// Motion after, and what it cost.
pub(crate) struct Settled {
    pub(crate) fragments: Vec<Part>,
    pub(crate) parts: Parts,
    pub(crate) sink: Sink,
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
    pub(crate) energy_before: f64,
    /// Net exchange of each striker over hit and replacement: what the fragments got, what it got.
    pub(crate) nets: Vec<(Exchange, Exchange)>,
}

/// The motion cannot pay.
pub(crate) struct TooDear {
    pub(crate) available: f64,
    pub(crate) payable: f64,
}

/// Fragments, strikers and sink in one state of motion.
#[derive(Clone)]
struct State {
    fragments: Vec<Part>,
    parts: Parts,
    sink: Sink,
}

/// The push of the solver's impulse at α = 1.
struct Push {
    fragments: Vec<Change>,
    parts: Vec<(u32, Change)>,
    sink: Sink,
    nets: Vec<(Exchange, Exchange)>,
}

/// Rounding that a comparison of energies allows, as a share of the energy.
const ROUNDING: f64 = 1e-12;

pub(crate) fn settle(scene: &Scene) -> Result<Settled, TooDear> {
    let base = undo(scene);
    let (push, spread) = push(scene, &base);
    let compose = |alpha: f64, beta: f64| compose(&base, &push, &spread, alpha, beta);
    let energy = |alpha: f64, beta: f64| {
        let state = compose(alpha, beta);
        sum(state.fragments.iter().chain(state.parts.values())).kinetic
    };
    let strikers = !scene.strikers.is_empty();
    let before = energy(0.0, 0.0);
    let (alpha, beta) = affordable(&energy, before, scene.fracture_energy, strikers)?;
    let state = compose(alpha, beta);
    let scaled = |e: &Exchange| Exchange { linear: e.linear * alpha, torque: e.torque * alpha };
    let nets = push.nets.iter().map(|(mine, theirs)| (scaled(mine), scaled(theirs))).collect();
    Ok(Settled {
        fragments: state.fragments,
        parts: state.parts,
        sink: state.sink,
        alpha,
        beta,
        energy_before: before,
        nets,
    })
}

/// The largest β at α = 1, else the largest α at β = 0, with K(α, β) + G_f A ≤ K(0, 0)  [F41].
fn affordable(
    energy: &dyn Fn(f64, f64) -> f64,
    before: f64,
    cost: f64,
    pushed: bool,
) -> Result<(f64, f64), TooDear> {
    let full = if pushed { 1.0 } else { 0.0 };
    let (budget, slack) = (before - cost, ROUNDING * before);
    let (all, rigid) = (energy(full, 1.0), energy(full, 0.0));
    // Motion that a solver gave to a body that nothing hit is its own affair: it has no one to
    // answer to.
    if all <= budget + slack {
        return Ok((full, 1.0));
    }
    if rigid <= budget + slack {
        // K(α, β) = K(α, 0) + β² (K(α, 1) − K(α, 0))
        let beta = ((budget - rigid).max(0.0) / (all - rigid)).sqrt();
        return Ok((full, beta.min(1.0)));
    }
    // K(α, 0) = before + c₁ α + c₂ α²
    let half = energy(0.5, 0.0);
    let c2 = 2.0 * (rigid + before - 2.0 * half);
    let c1 = rigid - before - c2;
    let refuse = |payable: f64| TooDear { available: before, payable };
    if !pushed || c2.is_nan() || c2 <= 0.0 || c1 >= 0.0 {
        return Err(refuse(0.0));
    }
    let root = c1 * c1 - 4.0 * c2 * cost;
    if root < 0.0 {
        return Err(refuse(c1 * c1 / (4.0 * c2)));
    }
    let alpha = ((-c1 + root.sqrt()) / (2.0 * c2)).clamp(0.0, 1.0);
    Ok((alpha, 0.0))
}

/// The motion before the hit: each striker's exchange taken back on both sides, equal and opposite.
fn undo(scene: &Scene) -> State {
    let body = &scene.body;
    let mut field = Field { velocity: body.velocity, spin: body.spin, centre: body.centre };
    let own = joint([*body].iter());
    for striker in &scene.strikers {
        if !scene.fixed {
            let back = own.field(&-striker.mine.linear, &-striker.mine.torque);
            field.velocity += back.velocity;
            field.spin += back.spin;
        }
    }
    let mut fragments = scene.fragments.clone();
    for part in &mut fragments {
        (part.velocity, part.spin) = (field.at(&part.centre), field.spin);
    }
    let mut state = State { fragments, parts: scene.parts.clone(), sink: Sink::default() };
    for striker in &scene.strikers {
        let lost = Exchange { linear: -striker.mine.linear, torque: -striker.mine.torque };
        let gained = Exchange { linear: striker.mine.linear, torque: -striker.theirs.torque };
        give_back(scene, striker, &mut state, &lost, &gained);
    }
    state
}

/// Lets a striker have what it had before, and closes the balance of the pair.
fn give_back(
    scene: &Scene,
    striker: &Striker,
    state: &mut State,
    lost: &Exchange,
    gained: &Exchange,
) {
    let mut linear = Vec3::zeros();
    let mut angular = Vec3::zeros();
    if !scene.fixed {
        linear += lost.linear;
        angular += scene.body.centre.cross(&lost.linear) + lost.torque;
    }
    if !striker.fixed() {
        let whole = group(&state.parts, &striker.ids);
        apply(&mut state.parts, &striker.ids, &whole.field(&gained.linear, &gained.torque));
        linear += gained.linear;
        angular += whole.centre.cross(&gained.linear) + gained.torque;
    }
    if scene.fixed || striker.fixed() {
        state.sink.linear -= linear;
        state.sink.angular -= angular;
        return;
    }
    // Both moved on since the hit: the couple that is left goes to both, by their inertia.
    let (mine, theirs) = split(&-angular, &scene.fragments, &state.parts, striker);
    let field = joint(scene.fragments.iter()).field(&Vec3::zeros(), &mine);
    state.fragments.iter_mut().for_each(|part| field.apply(part, 1.0));
    let field = group(&state.parts, &striker.ids).field(&Vec3::zeros(), &theirs);
    apply(&mut state.parts, &striker.ids, &field);
}

/// What the solver gave, in its rigid and its spreading part, and the strikers' answer to the rigid
/// part.
fn push(scene: &Scene, base: &State) -> (Push, Vec<Change>) {
    let whole = joint(scene.fragments.iter());
    let moved: Vec<Part> = scene
        .fragments
        .iter()
        .zip(&scene.given)
        .map(|(part, &(velocity, spin))| Part { velocity, spin, ..*part })
        .collect();
    let total = sum(moved.iter());
    let torque = total.angular - whole.centre.cross(&total.linear);
    let rigid = whole.field(&total.linear, &torque);
    let spread =
        moved.iter().map(|p| (p.velocity - rigid.at(&p.centre), p.spin - rigid.spin)).collect();
    let mut push = Push {
        fragments: scene.fragments.iter().map(|p| (rigid.at(&p.centre), rigid.spin)).collect(),
        parts: Vec::new(),
        sink: Sink::default(),
        nets: Vec::new(),
    };
    for striker in &scene.strikers {
        answer(scene, striker, base, &mut push, &total.linear, &torque, &whole);
    }
    (push, spread)
}

fn answer(
    scene: &Scene,
    striker: &Striker,
    base: &State,
    push: &mut Push,
    linear: &Vec3,
    torque: &Vec3,
    whole: &Joint,
) {
    let (linear, torque) = (linear * striker.weight, torque * striker.weight);
    let gained = whole.centre.cross(&linear) + torque;
    if striker.fixed() {
        push.sink.linear -= linear;
        push.sink.angular -= gained;
        push.nets.push((Exchange { linear, torque }, Exchange::zero()));
        return;
    }
    let group = group(&base.parts, &striker.ids);
    let own = (striker.point - group.centre).cross(&-linear);
    let angular = gained + group.centre.cross(&-linear) + own;
    let (mine, theirs) = split(&-angular, &scene.fragments, &base.parts, striker);
    let field = whole.field(&Vec3::zeros(), &mine);
    for (part, change) in scene.fragments.iter().zip(&mut push.fragments) {
        change.0 += field.at(&part.centre);
        change.1 += field.spin;
    }
    let field = group.field(&-linear, &(own + theirs));
    for id in &striker.ids {
        if let Some(part) = base.parts.get(id) {
            push.parts.push((*id, (field.at(&part.centre), field.spin)));
        }
    }
    let (mine, theirs) = (torque + mine, own + theirs);
    push.nets
        .push((Exchange { linear, torque: mine }, Exchange { linear: -linear, torque: theirs }));
}

/// A couple shared between the fragments and a striker by their inertia: the lighter would spin up
/// for nothing.
fn split(couple: &Vec3, fragments: &[Part], parts: &Parts, striker: &Striker) -> (Vec3, Vec3) {
    let mine = joint(fragments.iter()).inertia.trace();
    let theirs = group(parts, &striker.ids).inertia.trace();
    let share = mine / (mine + theirs);
    (couple * share, couple * (1.0 - share))
}

fn group(parts: &Parts, ids: &[u32]) -> Joint {
    let members: Vec<Part> = ids.iter().filter_map(|id| parts.get(id)).copied().collect();
    joint(members.iter())
}

fn apply(parts: &mut Parts, ids: &[u32], field: &Field) {
    for id in ids {
        if let Some(part) = parts.get_mut(id) {
            field.apply(part, 1.0);
        }
    }
}

fn compose(base: &State, push: &Push, spread: &[Change], alpha: f64, beta: f64) -> State {
    let mut state = base.clone();
    for ((part, p), s) in state.fragments.iter_mut().zip(&push.fragments).zip(spread) {
        part.velocity += p.0 * alpha + s.0 * beta;
        part.spin += p.1 * alpha + s.1 * beta;
    }
    for (id, change) in &push.parts {
        if let Some(part) = state.parts.get_mut(id) {
            part.velocity += change.0 * alpha;
            part.spin += change.1 * alpha;
        }
    }
    state.sink.linear += push.sink.linear * alpha;
    state.sink.angular += push.sink.angular * alpha;
    state
}
