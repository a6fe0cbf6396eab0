//! From a finished contact episode to an impact that a solver understands.

use crate::body::Body;
use crate::curvature::{nearest, radius};
use crate::exchange::Exchange;
use crate::hertz::{Elastic, effective_modulus, hertz};
use crate::id::BodyId;
use crate::motion::Motion;
use cullet_geometry::{Quat, Vec3};
use cullet_model::Impact;

/// A contact episode that reached a body's threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct Hit {
    /// Number of the episode: both bodies of a pair get a hit of the same episode.
    pub episode: u64,
    /// The body that was hit.
    pub body: BodyId,
    /// The body that it met.
    pub other: BodyId,
    /// When the episode began \[s\].
    pub time: f64,
    /// Where they touched, world frame \[m\].
    pub point: Vec3,
    /// The same in the frame of `other`, to be found again later \[m\].
    pub other_point: Vec3,
    /// What a solver needs.
    pub impact: Impact,
    /// Effective mass m* of the pair at the contact, each without what joints hold it to \[kg\].
    pub effective_mass: f64,
    /// Greatest Hertz force \[N\].
    pub peak_force: f64,
    /// What the engine has put into `body` over the episode.
    pub exchanged: Exchange,
    /// What it has put into `other`.
    pub exchanged_other: Exchange,
    /// `other` never moves, or moves by keyframes alone.
    pub fixed_other: bool,
    /// Velocity of `other` where they touched, if it is driven by keyframes \[m/s\].
    pub driven_at: Option<Vec3>,
    /// Orientation of `body` at the first touch.
    pub orientation: Quat,
    /// Angular velocity of `body` then, in its own frame \[rad/s\].
    pub spin: Vec3,
    /// From the centre of `other` to where it was touched, then, world frame \[m\].
    pub lever: Vec3,
    /// Kinetic energy that the contact took out of the pair \[J\].
    pub dissipated: f64,
    /// Steps that the world had taken when the episode ended.
    pub step: u64,
}

/// A body in an episode: what it is, where it was at the first touch, what it received.
pub(crate) struct Party<'a> {
    pub(crate) id: BodyId,
    pub(crate) body: &'a Body,
    pub(crate) motion: &'a Motion,
    pub(crate) exchanged: Exchange,
}

/// What an episode came to.
pub(crate) struct EpisodeOutcome {
    pub(crate) episode: u64,
    pub(crate) time: f64,
    pub(crate) point: Vec3,
    /// Unit, into the first party.
    pub(crate) normal: Vec3,
    pub(crate) impulse: f64,
    pub(crate) closing_speed: f64,
    /// When it ended, in steps of the world.
    pub(crate) step: u64,
    pub(crate) dissipated: f64,
}

/// Contact radius at most this share of the smaller body: beyond, Hertz's half-spaces are none.
const WIDEST_CONTACT: f64 = 0.5;

fn elastic(body: &Body) -> Elastic {
    Elastic { young: body.material.solid.young, poisson: body.material.solid.poisson }
}

fn surface_radius(party: &Party<'_>, point: &Vec3, into: &Vec3) -> (Vec3, f64) {
    let back = party.motion.pose.inverse();
    let mesh = &party.body.solid.mesh;
    let local = nearest(mesh, &(back * nalgebra::Point3::from(*point)).coords);
    (local, radius(mesh, &local, &-(back * into), party.body.reach))
}

/// m* of a pair along `n` at `point` \[kg\]: m*⁻¹ = Σ (1/m + n·[I⁻¹(r×n)]×r)  [Gate 0].
pub(crate) fn effective_mass(
    one: (&Body, &Motion),
    two: (&Body, &Motion),
    point: &Vec3,
    n: &Vec3,
) -> f64 {
    1.0 / (one.0.mobility(one.1, point, n) + two.0.mobility(two.1, point, n))
}

/// The hits on both parties, the first party's first.
pub(crate) fn hits(outcome: &EpisodeOutcome, one: &Party<'_>, two: &Party<'_>) -> [Hit; 2] {
    let (point, into) = (&outcome.point, &outcome.normal);
    let mass = effective_mass((one.body, one.motion), (two.body, two.motion), point, into);
    let (local_one, r1) = surface_radius(one, point, into);
    let (local_two, r2) = surface_radius(two, point, &-into);
    let curvature = 1.0 / r1 + 1.0 / r2;
    let modulus = effective_modulus(elastic(one.body), elastic(two.body));
    let h = hertz(mass, modulus, 1.0 / curvature, outcome.closing_speed);
    let widest = WIDEST_CONTACT * one.body.reach.min(two.body.reach);
    let make = |me: &Party<'_>, you: &Party<'_>, local: Vec3, yours: Vec3, into: Vec3| Hit {
        episode: outcome.episode,
        body: me.id,
        other: you.id,
        time: outcome.time,
        point: *point,
        other_point: yours,
        impact: Impact {
            point: local,
            normal: me.motion.pose.rotation.inverse() * into,
            impulse: outcome.impulse,
            duration: h.duration,
            radius: h.radius.min(widest),
            energy: 0.5 * mass * outcome.closing_speed * outcome.closing_speed,
            closing_speed: outcome.closing_speed,
            crushing_pressure: me.body.material.crushing_pressure(&you.body.material),
        },
        effective_mass: mass,
        peak_force: h.force,
        exchanged: me.exchanged,
        exchanged_other: you.exchanged,
        fixed_other: you.body.immovable(),
        driven_at: you.body.driven.as_ref().map(|_| you.motion.velocity_at(point)),
        orientation: me.motion.pose.rotation,
        spin: me.motion.pose.rotation.inverse() * me.motion.spin,
        lever: you.motion.pose.rotation * yours,
        dissipated: outcome.dissipated,
        step: outcome.step,
    };
    [make(one, two, local_one, local_two, *into), make(two, one, local_two, local_one, -into)]
}
