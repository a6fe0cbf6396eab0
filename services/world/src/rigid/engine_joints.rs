//! What the engine knows of joints.

use rapier3d_f64::prelude::{ImpulseJointHandle, RigidBodyHandle};
use std::collections::BTreeMap;

/// The joints that the engine holds, by our numbers.
#[derive(Clone, Default)]
pub(super) struct EngineJoints {
    pub(super) handles: BTreeMap<u32, (ImpulseJointHandle, Option<(u32, u32)>)>,
    /// What each but a rope holds.
    pub(super) ends: BTreeMap<u32, (u32, Option<u32>)>,
    /// What each rope holds.
    pub(super) ropes: BTreeMap<u32, (u32, Option<u32>)>,
    /// What each rigid one holds.
    pub(super) welds: BTreeMap<u32, (u32, Option<u32>)>,
    /// How many joints each body has.
    pub(super) counts: BTreeMap<u32, u32>,
    /// What these make of bodies; none where that is to be found anew.
    pub(super) fused: Option<Vec<FusedGroup>>,
    /// A body that never moves and touches nothing: the world.
    pub(super) ground: Option<RigidBodyHandle>,
}

/// What holds a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Holder {
    Nothing,
    /// The world, or a body that never moves.
    Still,
    Driven(u32),
    /// Several that move differently.
    Several,
}

impl Holder {
    pub(super) fn and(self, other: Self) -> Self {
        match (self, other) {
            (one, Self::Nothing) => one,
            (Self::Nothing, two) => two,
            (one, two) if one == two => one,
            _ => Self::Several,
        }
    }
}

/// Bodies that rigid joints hold to each other, in order.
#[derive(Clone, Debug)]
pub(super) struct FusedGroup {
    pub(super) members: Vec<u32>,
    pub(super) holder: Holder,
}
