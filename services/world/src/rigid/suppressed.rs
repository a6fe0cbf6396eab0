//! Contacts that are suppressed at birth (F34): siblings whose convex parts overlap when they are
//! born do not push each other apart.
//!
//! A pair stays suppressed until it separates; if it sinks deeper than it was born, contact begins
//! after all.

use super::convert::engine_pose;
use super::hulls::Part;
use super::seams::{HeldBalls, leave_out_edges, leave_out_sides};
use cullet_geometry::Pose;
use rapier3d_f64::parry::query;
use rapier3d_f64::prelude::{
    ContactModificationContext, PairFilterContext, PhysicsHooks, RigidBodyHandle, SolverFlags,
};
use std::collections::BTreeMap;

/// A body's convex parts and where they are.
pub(super) struct Placed<'a> {
    pub(super) parts: &'a [Part],
    pub(super) pose: Pose,
}

/// The suppressed pairs (lower id first) and how deep each may sink before contact begins \[m\].
#[derive(Clone, Default)]
pub(super) struct SuppressedPairs {
    pub(super) pairs: BTreeMap<(u32, u32), f64>,
    /// Pairs that joints hold, and how many do: these do not collide.
    pub(super) joined: BTreeMap<(u32, u32), u32>,
    /// The lowest of those that each body is one with.
    pub(super) fused: BTreeMap<u32, u32>,
}

/// A suppressed pair may sink this share of its smaller part deeper than it was born.
const SINK: f64 = 0.05;

impl SuppressedPairs {
    /// Marks the pair if its stand-ins overlap where they are.
    pub(super) fn admit(&mut self, key: (u32, u32), a: &Placed<'_>, b: &Placed<'_>) {
        let depth = depth(a, b);
        if depth > 0.0 {
            let size = |p: &Placed<'_>| p.parts.iter().map(|part| part.reach).fold(0.0, f64::max);
            self.pairs.insert(key, depth + SINK * size(a).min(size(b)));
        }
    }

    /// Does the pair stay suppressed where it is now?
    pub(super) fn keeps(limit: f64, a: &Placed<'_>, b: &Placed<'_>) -> bool {
        let depth = depth(a, b);
        depth > 0.0 && depth <= limit
    }

    /// Does the pair (lower id first) not collide?
    pub(super) fn holds(&self, pair: (u32, u32)) -> bool {
        let one = |id| self.fused.get(&id);
        self.pairs.contains_key(&pair)
            || self.joined.contains_key(&pair)
            || (one(pair.0).is_some() && one(pair.0) == one(pair.1))
    }

    pub(super) fn forget(&mut self, id: u32) {
        self.pairs.retain(|&(a, b), _| a != id && b != id);
    }
}

/// Greatest overlap of two sets of convex parts \[m\]; zero where they are apart.
pub(super) fn depth(a: &Placed<'_>, b: &Placed<'_>) -> f64 {
    let (pa, pb) = (engine_pose(&a.pose), engine_pose(&b.pose));
    let mut deepest = 0.0f64;
    for x in a.parts {
        let at = pa * x.centre;
        for y in b.parts {
            let gap = (at - pb * y.centre).length();
            if gap > x.reach + y.reach {
                continue;
            }
            let touch = query::contact(&pa, x.shape.as_ref(), &pb, y.shape.as_ref(), 0.0);
            if let Ok(Some(contact)) = touch {
                deepest = deepest.max(-contact.dist);
            }
        }
    }
    deepest
}

/// What the engine asks of a step: which pairs collide, and which of the contacts that it foresees
/// are none.
pub(super) struct StepHooks<'a> {
    pub(super) suppressed: &'a SuppressedPairs,
    pub(super) held: HeldBalls,
    /// \[s\]
    pub(super) step: f64,
    /// Of seams \[m\].
    pub(super) room: f64,
}

impl PhysicsHooks for StepHooks<'_> {
    fn filter_contact_pair(&self, context: &PairFilterContext<'_>) -> Option<SolverFlags> {
        let id = |handle: Option<RigidBodyHandle>| {
            handle.and_then(|h| context.bodies.get(h)).map(|body| body.user_data as u32)
        };
        let suppressed = match (id(context.rigid_body1), id(context.rigid_body2)) {
            (Some(a), Some(b)) => self.suppressed.holds((a.min(b), a.max(b))),
            _ => false,
        };
        (!suppressed).then_some(SolverFlags::COMPUTE_RIGID_IMPULSES)
    }

    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        leave_out_sides(context, self.step, self.room);
        leave_out_edges(context, &self.held, self.room);
    }
}
