//! The mechanics of a replacement: what the fragments and their strikers move like afterwards, and
//! whether the motion can pay for the crack.
//!
//! All velocities are `base + α·push + β·spread`: `base` is the motion before the hit (the engine's
//! exchange undone); `push` is the rigid part of what the solver gave the pieces, and its exact
//! opposite on the strikers; `spread` is the rest, which carries no momentum. Kinetic energy is
//! quadratic in α and, without a cross term, in β.
//!
//! The momentum of the push keeps the direction that it had in the world at the hit, though the
//! body has turned since; the spread turns with it.
//!
//! Late fragments find the exchange in motions that have gone on since. Theirs are
//! `now + α·(base + push − now) + β·spread`: by the share α the engine's exchange gives way to the
//! solver's, so that the striker gets back what the solver did not deliver. What all of it may cost
//! is what the contact took out of the motion: at α = β = 0 that pays for the crack.
//!
//! A body may be pressed against others while it is hit. Their part in its motion is undone only as
//! far as they are supports that the solver knows; without it the base may be faster than the body
//! ever was. So no replacement leaves more energy than the motion has now and its contacts took out
//! of it. Where the base allows none within that, the fragments come as late ones do.

use crate::cluster::{Field, Joint, Part, Parts, joint, sum};
use crate::exchange::Exchange;
use crate::ledger::Sink;
use cullet_geometry::{Quat, Vec3};

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
    /// Late fragments: from its centre to that point when they met \[m\].
    pub(crate) lever: Vec3,
    /// Of a support: the impulse that the solver had it give the pieces at `point`, as the body
    /// lies now \[N·s\].
    pub(crate) reaction: Option<Vec3>,
    /// Of a driven one: its id, and its velocity there \[m/s\].
    pub(crate) driven: Option<(u32, Vec3)>,
}

impl Striker {
    fn fixed(&self) -> bool {
        self.ids.is_empty()
    }
}

/// The state before: the broken body, its fragments at rest relative to it, and the strikers.
pub(crate) struct ReplacementProblem {
    /// What all velocities are measured against: that of a driven striker \[m/s\].
    pub(crate) frame: Vec3,
    /// The broken body as the engine left it.
    pub(crate) body: Part,
    /// It never moved before it broke.
    pub(crate) fixed: bool,
    /// Where the fragments are and what they weigh, then the grains of debris; their motion is
    /// filled in here.
    pub(crate) fragments: Vec<Part>,
    /// There are grains: points do not turn as the body did.
    pub(crate) loose: bool,
    /// What the solver gave each, world frame: velocity \[m/s\] and spin \[rad/s\].
    pub(crate) given: Vec<Change>,
    pub(crate) strikers: Vec<Striker>,
    /// All moving strikers as the engine left them.
    pub(crate) parts: Parts,
    /// G_f times the crack area \[J\].
    pub(crate) fracture_energy: f64,
    /// What the contacts took out of the motion and nobody has spent yet \[J\].
    pub(crate) energy_budget: f64,
    /// The turn that leads back to how the body lay when it was hit: the engine lets it spin on
    /// within the step of the hit, and beyond.
    pub(crate) back: Quat,
    /// The fragments come in a later step than the hit's.
    pub(crate) late: bool,
}

/// Motion after, and what it cost.
pub(crate) struct ReplacementSolution {
    pub(crate) fragments: Vec<Part>,
    pub(crate) parts: Parts,
    pub(crate) sink: Sink,
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
    pub(crate) energy_before: f64,
    /// Net exchange of each striker over hit and replacement: what the fragments got, what it got.
    pub(crate) nets: Vec<(Exchange, Exchange)>,
    /// What is left of the energy budget \[J\].
    pub(crate) energy_budget: f64,
}

/// The motion cannot pay.
pub(crate) struct InsufficientEnergy {
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
/// A base that has by this share more energy than there was is that of a body that others pushed,
/// too \[1\].
const SQUEEZED: f64 = 1e-9;

pub(crate) fn exchange_impulses(
    problem: &ReplacementProblem,
) -> Result<ReplacementSolution, InsufficientEnergy> {
    let (base, surplus) = undo(problem);
    let (push, spread) = push(problem, &base);
    let (now, present) = present(problem);
    let changes = Changes { base: &base, push: &push, spread: &spread, now: &now };
    // What there was before the contacts took their share of it.
    let held = kinetic(&now) - present + problem.energy_budget;
    let start = kinetic(&base) - surplus;
    // Others that pushed the body meanwhile, and that are not undone, make the base faster than it
    // ever was.
    let squeezed = held < start * (1.0 - SQUEEZED);
    let excess = if squeezed { start - held } else { 0.0 };
    let strikers = !problem.strikers.is_empty();
    let find = |late: bool| {
        // What the grains have more than the body had is paid like the crack.
        let surplus = if late { present } else { surplus };
        let cost = (problem.fracture_energy + surplus).max(0.0);
        let energy_budget = if late { problem.energy_budget } else { -excess };
        let energy = |alpha: f64, beta: f64| kinetic(&changes.state(late, alpha, beta));
        let (alpha, beta) = affordable(&energy, energy_budget, cost, strikers)?;
        let energy_before = if late { held } else { start - excess };
        Ok((late, alpha, beta, energy_before))
    };
    // Where such a base can pay for nothing, the motion now can.
    let found = match find(problem.late) {
        Err(InsufficientEnergy { .. }) if !problem.late && squeezed => find(true),
        found => found,
    };
    let (late, alpha, beta, energy_before) = found?;
    let state = changes.state(late, alpha, beta);
    let left = held - problem.fracture_energy - kinetic(&state);
    let net = |held: &Exchange, pushed: &Exchange| {
        let mut net = held.scaled(if late { 1.0 - alpha } else { 0.0 });
        net.add(&pushed.scaled(alpha));
        net
    };
    let each = problem.strikers.iter().zip(&push.nets);
    Ok(ReplacementSolution {
        nets: each.map(|(s, p)| (net(&s.mine, &p.0), net(&s.theirs, &p.1))).collect(),
        fragments: state.fragments,
        parts: state.parts,
        sink: state.sink,
        alpha,
        beta,
        energy_before,
        energy_budget: left.max(0.0),
    })
}

/// What the motions may become.
struct Changes<'a> {
    base: &'a State,
    push: &'a Push,
    spread: &'a [Change],
    now: &'a State,
}

impl Changes<'_> {
    /// At these α and β, from the base or, late, from the motion now.
    fn state(&self, late: bool, alpha: f64, beta: f64) -> State {
        if late {
            let full = compose(self.base, self.push, self.spread, 1.0, 0.0);
            return between(self.now, &full, self.spread, alpha, beta);
        }
        compose(self.base, self.push, self.spread, alpha, beta)
    }
}

/// The largest β at α = 1, else the largest α at β = 0, with K(α, β) + G_f A ≤ K(0, 0) + E, E the
/// energy budget [F41]. Where the budget more than pays for the crack, the largest α = β: the
/// pieces part as far as the exchange gives way.
fn affordable(
    energy: &dyn Fn(f64, f64) -> f64,
    energy_budget: f64,
    cost: f64,
    pushed: bool,
) -> Result<(f64, f64), InsufficientEnergy> {
    let full = if pushed { 1.0 } else { 0.0 };
    let start = energy(0.0, 0.0);
    let before = start + energy_budget;
    let (budget, slack) = (before - cost, ROUNDING * before);
    let (all, rigid) = (energy(full, 1.0), energy(full, 0.0));
    // Motion that a solver gave to a body that nothing hit is its own affair: it has no one to
    // answer to.
    if all <= budget + slack {
        return Ok((full, 1.0));
    }
    let room = energy_budget - cost;
    let together = room > 0.0;
    if rigid <= budget + slack && !together {
        // K(α, β) = K(α, 0) + β² (K(α, 1) − K(α, 0))
        let beta = ((budget - rigid).max(0.0) / (all - rigid)).sqrt();
        return Ok((full, beta.min(1.0)));
    }
    // K(α, β) = start + c₁ α + c₂ α²
    let (half, whole) = if together { (energy(0.5, 0.5), all) } else { (energy(0.5, 0.0), rigid) };
    let c2 = 2.0 * (whole + start - 2.0 * half);
    let c1 = whole - start - c2;
    let refuse = |payable: f64| InsufficientEnergy { available: before, payable };
    if !pushed || c2.is_nan() || c2 <= 0.0 || (c1 >= 0.0 && room < 0.0) {
        return Err(refuse(energy_budget));
    }
    let root = c1 * c1 + 4.0 * c2 * room;
    if root < 0.0 {
        return Err(refuse(energy_budget + c1 * c1 / (4.0 * c2)));
    }
    if room < 0.0 && -c1 - root.sqrt() > 2.0 * c2 {
        // More than the whole push would have to be handed over.
        return Err(refuse(energy_budget - c1 - c2));
    }
    let alpha = ((-c1 + root.sqrt()) / (2.0 * c2)).clamp(0.0, 1.0);
    Ok((alpha, if together { alpha } else { 0.0 }))
}

/// The motion as the engine left it: the fragments move as the body does; and their surplus.
fn present(problem: &ReplacementProblem) -> (State, f64) {
    let body = &problem.body;
    let (fragments, surplus) = carried(problem, &body.velocity, &body.spin);
    (State { fragments, parts: problem.parts.clone(), sink: Sink::default() }, surplus)
}

/// The fragments with the momentum and the angular momentum that the body has at a velocity and
/// spin, and how much more energy they have than it \[J\].
fn carried(problem: &ReplacementProblem, velocity: &Vec3, spin: &Vec3) -> (Vec<Part>, f64) {
    let body = Part { velocity: *velocity, spin: *spin, ..problem.body };
    if !problem.loose {
        let field = Field { velocity: *velocity, spin: *spin, centre: body.centre };
        return (moved(&problem.fragments, &field), 0.0);
    }
    let whole = joint(problem.fragments.iter());
    let linear = body.momentum();
    let torque = body.angular() - whole.centre.cross(&linear);
    let parts = moved(&problem.fragments, &whole.field(&linear, &torque));
    let surplus = sum(parts.iter()).kinetic - body.kinetic();
    (parts, surplus)
}

/// The parts, moving as one.
fn moved(parts: &[Part], field: &Field) -> Vec<Part> {
    let moved = |part: &Part| Part { velocity: field.at(&part.centre), spin: field.spin, ..*part };
    parts.iter().map(moved).collect()
}

fn kinetic(state: &State) -> f64 {
    sum(state.fragments.iter().chain(state.parts.values())).kinetic
}

/// The motion before the hit: each striker's exchange taken back on both sides, equal and opposite.
fn undo(problem: &ReplacementProblem) -> (State, f64) {
    let body = &problem.body;
    let mut field = Field { velocity: body.velocity, spin: body.spin, centre: body.centre };
    let own = joint([*body].iter());
    for striker in &problem.strikers {
        if !problem.fixed {
            let back = own.field(&-striker.mine.linear, &-striker.mine.torque);
            field.velocity += back.velocity;
            field.spin += back.spin;
        }
    }
    let (fragments, surplus) = carried(problem, &field.velocity, &field.spin);
    let mut state = State { fragments, parts: problem.parts.clone(), sink: Sink::default() };
    for striker in &problem.strikers {
        let lost = Exchange { linear: -striker.mine.linear, torque: -striker.mine.torque };
        let gained = Exchange { linear: striker.mine.linear, torque: -striker.theirs.torque };
        give_back(problem, striker, &mut state, &lost, &gained);
    }
    (state, surplus)
}

/// Lets a striker have what it had before, and closes the balance of the pair.
fn give_back(
    problem: &ReplacementProblem,
    striker: &Striker,
    state: &mut State,
    lost: &Exchange,
    gained: &Exchange,
) {
    let mut linear = Vec3::zeros();
    let mut angular = Vec3::zeros();
    if !problem.fixed {
        linear += lost.linear;
        angular += problem.body.centre.cross(&lost.linear) + lost.torque;
    }
    if !striker.fixed() {
        let whole = group(&state.parts, &striker.ids);
        apply(&mut state.parts, &striker.ids, &whole.field(&gained.linear, &gained.torque));
        linear += gained.linear;
        angular += whole.centre.cross(&gained.linear) + gained.torque;
    }
    if problem.fixed || striker.fixed() {
        state.sink.linear -= linear;
        state.sink.angular -= angular;
        return;
    }
    // Both moved on since the hit: the couple that is left goes to both.
    let [mine, theirs] = close(problem, striker, &state.parts, &-angular);
    state.fragments.iter_mut().for_each(|part| mine.field.apply(part, 1.0));
    apply(&mut state.parts, &striker.ids, &theirs.field);
}

/// What the solver gave, in its rigid and its spreading part, and the strikers' answer to the rigid
/// part.
fn push(problem: &ReplacementProblem, base: &State) -> (Push, Vec<Change>) {
    let whole = joint(problem.fragments.iter());
    let moved: Vec<Part> = problem
        .fragments
        .iter()
        .zip(&problem.given)
        .map(|(part, &(velocity, spin))| Part { velocity, spin, ..*part })
        .collect();
    let total = sum(moved.iter());
    let torque = total.angular - whole.centre.cross(&total.linear);
    let rigid = whole.field(&total.linear, &torque);
    let spread =
        moved.iter().map(|p| (p.velocity - rigid.at(&p.centre), p.spin - rigid.spin)).collect();
    let then = |v: Vec3| problem.back * v;
    let (linear, torque) = (then(total.linear), then(torque));
    let rigid = whole.field(&linear, &torque);
    let mut push = Push {
        fragments: problem.fragments.iter().map(|p| (rigid.at(&p.centre), rigid.spin)).collect(),
        parts: Vec::new(),
        sink: Sink::default(),
        nets: Vec::new(),
    };
    // What supports gave is theirs to answer; the strikers share the rest.
    let held = |striker: &Striker| {
        let linear = striker.reaction.unwrap_or_else(Vec3::zeros);
        (then(linear), then((striker.point - whole.centre).cross(&linear)))
    };
    let (mut left, mut couple) = (linear, torque);
    for (linear, torque) in problem.strikers.iter().map(held) {
        left -= linear;
        couple -= torque;
    }
    for striker in &problem.strikers {
        let (linear, torque) = match striker.reaction {
            Some(_) => held(striker),
            None => (left * striker.weight, couple * striker.weight),
        };
        answer(problem, striker, base, &mut push, &linear, &torque, &whole);
    }
    (push, spread)
}

fn answer(
    problem: &ReplacementProblem,
    striker: &Striker,
    base: &State,
    push: &mut Push,
    linear: &Vec3,
    torque: &Vec3,
    whole: &Joint,
) {
    let gained = whole.centre.cross(linear) + torque;
    if striker.fixed() {
        push.sink.linear -= linear;
        push.sink.angular -= gained;
        let net = Exchange { linear: *linear, torque: *torque };
        push.nets.push((net, Exchange::zero()));
        return;
    }
    let group = group(&base.parts, &striker.ids);
    let lever = if problem.late { striker.lever } else { striker.point - group.centre };
    let own = lever.cross(&-linear);
    let angular = gained + group.centre.cross(&-linear) + own;
    let [mine, theirs] = close(problem, striker, &base.parts, &-angular);
    for (part, change) in problem.fragments.iter().zip(&mut push.fragments) {
        change.0 += mine.field.at(&part.centre);
        change.1 += mine.field.spin;
    }
    let linear = linear + mine.gained.linear;
    let (mine, theirs) = (torque + mine.gained.torque, own + theirs.gained.torque);
    let field = group.field(&-linear, &theirs);
    for id in &striker.ids {
        if let Some(part) = base.parts.get(id) {
            push.parts.push((*id, (field.at(&part.centre), field.spin)));
        }
    }
    push.nets
        .push((Exchange { linear, torque: mine }, Exchange { linear: -linear, torque: theirs }));
}

/// What one side of a pair gets to close the balance.
struct Share {
    field: Field,
    gained: Exchange,
}

/// A couple shared between the fragments and a striker. At once by their inertia: the lighter would
/// spin up for nothing. Late they may be far apart: then as if they were one body, which takes the
/// least energy.
fn close(
    problem: &ReplacementProblem,
    striker: &Striker,
    parts: &Parts,
    couple: &Vec3,
) -> [Share; 2] {
    let (mine, theirs) = (joint(problem.fragments.iter()), group(parts, &striker.ids));
    if problem.late {
        let all = joint(problem.fragments.iter().chain(&members(parts, &striker.ids)));
        let side = |part: &Joint| {
            let field = all.field(&Vec3::zeros(), couple);
            let linear = field.at(&part.centre) * part.mass;
            let torque = part.inertia * field.spin;
            Share { field, gained: Exchange { linear, torque } }
        };
        return [side(&mine), side(&theirs)];
    }
    let (one, two) = (mine.inertia.trace(), theirs.inertia.trace());
    let share = one / (one + two);
    let side = |part: &Joint, torque: Vec3| {
        let linear = Vec3::zeros();
        Share { field: part.field(&linear, &torque), gained: Exchange { linear, torque } }
    };
    [side(&mine, couple * share), side(&theirs, couple * (1.0 - share))]
}

fn members(parts: &Parts, ids: &[u32]) -> Vec<Part> {
    ids.iter().filter_map(|id| parts.get(id)).copied().collect()
}

fn group(parts: &Parts, ids: &[u32]) -> Joint {
    joint(members(parts, ids).iter())
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

/// From the motion now by α towards the whole change, and β of the spread.
fn between(now: &State, full: &State, spread: &[Change], alpha: f64, beta: f64) -> State {
    let step = |from: Vec3, to: Vec3| from + (to - from) * alpha;
    let mut state = now.clone();
    for ((part, to), s) in state.fragments.iter_mut().zip(&full.fragments).zip(spread) {
        part.velocity = step(part.velocity, to.velocity) + s.0 * beta;
        part.spin = step(part.spin, to.spin) + s.1 * beta;
    }
    for (part, to) in state.parts.values_mut().zip(full.parts.values()) {
        part.velocity = step(part.velocity, to.velocity);
        part.spin = step(part.spin, to.spin);
    }
    state.sink.linear = full.sink.linear * alpha;
    state.sink.angular = full.sink.angular * alpha;
    state
}
