//! The decision about all hits that reach one body in one step.

use crate::brittle::{self, AccuracyTarget, SolveLimits};
use crate::ductile;
use crate::family;
use crate::gate::{Gate, GateLimits, gate, stressing_spin};
use crate::reason::RigidReason;
use crate::refinement::{HitClass, Refinement};
use crate::shell;
use cullet_geometry::Vec3;
use cullet_world::{BodyId, BodyMeasure, BodyView, HeldContact, Hit, World};

/// What the scene asks of the solves of a body.
#[derive(Clone, Copy, Debug)]
pub struct Policy<'a> {
    /// How accurate they have to be; `None` where the scene does not say.
    pub target: Option<AccuracyTarget>,
    /// The family that the scene names for the body; `None` leaves it open.
    pub family: Option<&'a str>,
    /// Whether its strength depends on the direction.
    pub weak_plane: bool,
    /// Whether it is glass that was treated.
    pub treated: bool,
    /// The stress at which it yields \[Pa\]; none of what does not.
    pub yield_stress: Option<f64>,
    /// Name of the body's material, for what makes hits alike.
    pub material: &'a str,
    /// What of a solve is already fixed.
    pub limits: SolveLimits,
    /// Most supports that a job takes.
    pub most_supports: usize,
}

/// What to do about the hits.
#[derive(Clone, Debug)]
pub enum Decision {
    /// Nothing can crack: why, for each of the hits.
    Keep(Vec<RigidReason>),
    /// Solve.
    Solve(Box<SolveOrder>),
}

/// A solve, as it is to be ordered.
#[derive(Clone, Debug)]
pub struct SolveOrder {
    /// The family that is asked.
    pub family: String,
    /// Whether that is the scene's choice.
    named: bool,
    /// The family that takes what that one declines.
    pub fallback: Option<&'static str>,
    /// Why this family, where it is not the default; then what the plan says.
    pub reasons: Vec<String>,
    /// The spacings at which the hit is solved; empty where none was planned.
    pub refinement: Refinement,
    /// What the body rests on.
    pub supports: Vec<HeldContact>,
    /// Its spin before the hits, if its stress matters; else zero \[rad/s\].
    pub spin: Vec3,
}

impl SolveOrder {
    /// Why a job asks the family that it asks, where that is the scene's choice.
    #[must_use]
    pub fn choice(&self) -> Option<&'static str> {
        self.named.then_some("the scene's choice")
    }
}

/// Decides about the hits of one body, as one [`World::step`] returned them; `None` when the body
/// is gone.
#[must_use]
pub fn decide(world: &World, body: BodyId, hits: &[Hit], policy: &Policy<'_>) -> Option<Decision> {
    let view = world.body(body)?;
    let measure = world.measure(body)?;
    let measure = &BodyMeasure { generation: world.blows_before(body, hits)?, ..*measure };
    if let Some(yield_stress) = policy.yield_stress {
        return Some(metal(world, (&view, measure), hits, (policy, yield_stress)));
    }
    let mut sampled = match asked(&view, measure, hits, policy) {
        Ok(sampled) => sampled,
        Err(reasons) => return Some(Decision::Keep(reasons)),
    };
    let mut supports = world.supports(body, hits);
    supports.truncate(policy.most_supports);
    let spin = stressing_spin(&view, hits);
    let may_be_shell = policy.family.is_none() && !policy.weak_plane && spin == Vec3::zeros();
    let treated = policy.treated.then(|| shell::treated(&view)).flatten();
    if treated.is_some() {
        // No other family knows what was done to it.
        sampled = None;
    }
    let shell = may_be_shell.then(|| shell::reason(&view, hits)).flatten();
    let shell = treated.clone().or(shell);
    if shell.is_some() && spin == Vec3::zeros() {
        let strength = measure.weakest * view.material.solid.failure_stress;
        let too_soft = |stress, safety| RigidReason::Stress { stress, strength, safety };
        let held = !supports.is_empty();
        if let Some(reasons) = too_slow((&view, measure), hits, held, strength, too_soft) {
            return Some(Decision::Keep(reasons));
        }
    }
    let default = if shell.is_some() { family::SHELL } else { family::DEFAULT };
    let wanted = policy.family.unwrap_or(default);
    let mut refinement = Refinement::default();
    let mut planned = None;
    let known = family::by_name(wanted).is_some_and(|family| family.planned);
    if let Some(target) = policy.target.filter(|_| known && sampled.is_none()) {
        match brittle::finest(hits, &view.material.solid, measure, &target, &policy.limits) {
            Some(Ok(plan)) => {
                let kind = HitClass::of(policy.material, view.volume, hits);
                refinement = Refinement::new(&plan, &target, kind);
                planned = Some(plan.to_string());
            }
            Some(Err(reason)) => sampled = Some(reason),
            None => {}
        }
    }
    let family = if sampled.is_some() { family::SAMPLED } else { wanted };
    // What a striker meets on its way on is not worth sampled pieces.
    let goes_on = measure.generation < view.generation;
    if let Some(reason) = sampled.filter(|_| goes_on) {
        return Some(Decision::Keep(vec![reason; hits.len()]));
    }
    let held = (!supports.is_empty()).then(|| format!("held at {} places", supports.len()));
    let mut order = SolveOrder {
        family: family.to_owned(),
        named: family != family::DEFAULT && policy.family == Some(family),
        fallback: match treated.is_some() || goes_on {
            true => None,
            false => family::by_name(family).map_or(Some(family::SAMPLED), |known| known.fallback),
        },
        reasons: Vec::new(),
        refinement,
        supports,
        spin,
    };
    let why = sampled.map(|reason| reason.to_string());
    let why = why.or_else(|| order.choice().map(str::to_owned)).or(shell);
    order.reasons = why.into_iter().chain(planned).chain(held).collect();
    Some(Decision::Solve(Box::new(order)))
}

/// Whether a solver is to be asked, or why the pieces are sampled.
///
/// # Errors
/// Why each of the hits leaves the body as it is.
fn asked(
    view: &BodyView<'_>,
    measure: &BodyMeasure,
    hits: &[Hit],
    policy: &Policy<'_>,
) -> Result<Option<RigidReason>, Vec<RigidReason>> {
    let answer = |hit| gate(hit, &view.material.solid, measure, &limits(hits, hit, policy));
    let answers: Vec<Gate> = hits.iter().map(answer).collect();
    if answers.contains(&Gate::Solve) {
        return Ok(None);
    }
    let sampled = answers.iter().find_map(|gate| match gate {
        Gate::Geometric(reason) => Some(*reason),
        _ => None,
    });
    let rigid = answers.into_iter().filter_map(|gate| match gate {
        Gate::Rigid(reason) => Some(reason),
        _ => None,
    });
    sampled.map_or_else(|| Err(rigid.collect()), |reason| Ok(Some(reason)))
}

/// What to do about hits on a metal that yields: a shell, a solid, or nothing.
fn metal(
    world: &World,
    (view, measure): (&BodyView<'_>, &BodyMeasure),
    hits: &[Hit],
    (policy, yield_stress): (&Policy<'_>, f64),
) -> Decision {
    let mut supports = world.supports(view.id, hits);
    supports.truncate(policy.most_supports);
    let held = !supports.is_empty();
    let bonded = policy.family == Some(family::PERIDYNAMICS);
    let may_be_shell = policy.family != Some(family::DUCTILE) && !bonded;
    let shell = may_be_shell.then(|| shell::reason(view, hits)).flatten();
    let (family, reason) = match shell {
        Some(reason) => {
            let below = |stress, safety| RigidReason::Yield { stress, yield_stress, safety };
            if let Some(reasons) = too_slow((view, measure), hits, held, yield_stress, below) {
                return Decision::Keep(reasons);
            }
            (family::SHELL, reason)
        }
        None => match ductile::reason(view, measure, hits, yield_stress) {
            Ok(reason) if bonded => (family::PERIDYNAMICS, reason),
            Ok(reason) => (family::DUCTILE, reason),
            Err(reasons) => return Decision::Keep(reasons),
        },
    };
    let held = held.then(|| format!("held at {} places", supports.len()));
    let other = policy.family.filter(|wished| *wished != family);
    let other = other.map(|wished| format!("not `{wished}`, which takes no such body"));
    Decision::Solve(Box::new(SolveOrder {
        family: family.to_owned(),
        named: policy.family == Some(family),
        // What bonds do not hold for and what is no wall after all is solid metal.
        fallback: (family != family::DUCTILE).then_some(family::DUCTILE),
        reasons: [Some(reason), other, held].into_iter().flatten().collect(),
        refinement: Refinement::default(),
        supports,
        // What a spin stresses does not yield by it.
        spin: Vec3::zeros(),
    }))
}

/// Why each of the hits on a sheet leaves it as it is, if all do: `limit` is the stress that it
/// bears \[Pa\], `reason` says it of the stress and the share of the limit.
fn too_slow(
    (view, measure): (&BodyView<'_>, &BodyMeasure),
    hits: &[Hit],
    held: bool,
    limit: f64,
    reason: impl Fn(f64, f64) -> RigidReason,
) -> Option<Vec<RigidReason>> {
    let stress = |hit| shell::blow_stress(&view.material.solid, measure, hit, held);
    let stresses: Vec<f64> = hits.iter().map(stress).collect();
    let safety = shell::BLOW_SAFETY;
    let soft = stresses.iter().all(|&stress| stress < safety * limit);
    soft.then(|| stresses.into_iter().map(|stress| reason(stress, safety)).collect())
}

/// Where the gates stand for a hit: by its share of the energy of all of them where the scene asks
/// for an accuracy.
fn limits(hits: &[Hit], hit: &Hit, policy: &Policy<'_>) -> GateLimits {
    if policy.target.is_none() {
        return GateLimits::default();
    }
    let all: f64 = hits.iter().map(|hit| hit.impact.energy).sum();
    GateLimits::fitted(hit.impact.energy / all)
}
