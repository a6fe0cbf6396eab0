//! The state of the engine between two steps, to be taken up again.

use super::Rigid;
use super::engine_joints::EngineJoints;
use super::rest::Stillness;
use super::suppressed::SuppressedPairs;
use crate::motion::Motion;
use rapier3d_f64::prelude::{
    BroadPhaseBvh, CCDSolver, ColliderSet, ImpulseJointSet, IslandManager, MultibodyJointSet,
    NarrowPhase, PhysicsPipeline, RigidBodySet,
};

/// All that a step changes.
pub(crate) struct SavedRigid {
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    ccd_solver: CCDSolver,
    suppressed: SuppressedPairs,
    joints: EngineJoints,
    before: Vec<(u32, Motion)>,
    prior: Vec<(u32, Motion)>,
    /// Of each body: whether it is damped, and whether it rests.
    calm: Vec<(bool, Stillness)>,
    steps: u64,
}

impl Rigid {
    /// A copy of all that a step changes.
    pub(crate) fn save(&self) -> SavedRigid {
        let world = &self.world;
        SavedRigid {
            islands: world.islands.clone(),
            broad_phase: world.broad_phase.clone(),
            narrow_phase: world.narrow_phase.clone(),
            bodies: world.bodies.clone(),
            colliders: world.colliders.clone(),
            impulse_joints: world.impulse_joints.clone(),
            multibody_joints: world.multibody_joints.clone(),
            ccd_solver: world.ccd_solver.clone(),
            suppressed: self.suppressed.clone(),
            joints: self.joints.clone(),
            before: self.before.clone(),
            prior: self.prior.clone(),
            calm: self.slots.values().map(|slot| (slot.damped, slot.rest.clone())).collect(),
            steps: self.steps,
        }
    }

    /// Takes a state up again: of the same bodies.
    pub(crate) fn restore(&mut self, saved: &SavedRigid) {
        let world = &mut self.world;
        world.islands = saved.islands.clone();
        world.broad_phase = saved.broad_phase.clone();
        world.narrow_phase = saved.narrow_phase.clone();
        world.bodies = saved.bodies.clone();
        world.colliders = saved.colliders.clone();
        world.impulse_joints = saved.impulse_joints.clone();
        world.multibody_joints = saved.multibody_joints.clone();
        world.ccd_solver = saved.ccd_solver.clone();
        // What the pipeline has worked out belongs to the step that does not count.
        world.physics_pipeline = PhysicsPipeline::new();
        self.suppressed = saved.suppressed.clone();
        self.joints = saved.joints.clone();
        self.before.clone_from(&saved.before);
        self.prior.clone_from(&saved.prior);
        self.pushes.clear();
        for (slot, (damped, rest)) in self.slots.values_mut().zip(&saved.calm) {
            (slot.damped, slot.rest) = (*damped, rest.clone());
        }
        self.steps = saved.steps;
    }
}
