//! What holds bodies together, what drives them, and what takes them out.

use super::World;
use crate::glue::{GlueReport, GlueSpec, glue};
use crate::id::BodyId;
use crate::joint::{JointBreak, JointCounts, JointError, JointId, JointSpec, JointView};
use crate::joint_store::MOST_RETAKES;
use crate::joints::{join, take_out, view};
use crate::removal::{accelerate, remove};
use cullet_geometry::Vec3;

impl World {
    /// Joins two bodies, or a body and the world, where they are.
    ///
    /// Bodies that rigid joints hold move as one, and those that hold on to what never moves stay
    /// where they are; hinges, ball joints and ropes give a little.
    ///
    /// The limits hold for the mean of the load over one step: a blow that is shorter than a step
    /// counts as its impulse over the step. The load is worked out from the balance of momentum and
    /// angular momentum of all bodies that are joined to each other; where that does not determine
    /// it, as of joints side by side, it is that of rigid bodies on elastic joints, each as stiff
    /// as its area makes it. A rope only pulls.
    ///
    /// Bodies that a rigid joint or a hinge joins no longer collide with each other. Windows of
    /// bodies that deform ([`World::body_for_window`]) know no joints: there a body that is held is
    /// free, and the joint takes hold of it again in the steps of the world. The same holds for
    /// [`World::supports`]: what holds a body by a joint is no support of a solver's problem. What
    /// a joint gave a body while it was hit stays in its motion when it breaks
    /// ([`World::break_up`]).
    ///
    /// # Errors
    /// A body that is gone, the same one twice, two that nothing moves, or a number out of range.
    pub fn join(&mut self, spec: &JointSpec) -> Result<JointId, JointError> {
        join(&mut self.state, spec)
    }

    /// Takes a joint out: whether it was there. This is no break.
    pub fn unjoin(&mut self, id: JointId) -> bool {
        take_out(&mut self.state, id.0).is_some()
    }

    /// Glues bodies where they share a face: one rigid joint a pair, over all coplanar faces that
    /// are no farther apart than [`GlueSpec::gap`]. Its area and its middle are those of the
    /// overlap of the two bodies' meshes.
    ///
    /// Glue of stresses breaks where N/A and the bending over the face come to more than the
    /// tensile strength at a corner of the face, or V/A and the torsion to more than that of shear.
    ///
    /// # Errors
    /// A body that is gone, the same one twice, two that nothing moves, or a number out of range.
    /// Then nothing was glued.
    pub fn glue(&mut self, spec: &GlueSpec) -> Result<GlueReport, JointError> {
        glue(&mut self.state, spec)
    }

    /// A joint, if it is (still) there.
    #[must_use]
    pub fn joint(&self, id: JointId) -> Option<JointView> {
        view(&self.state, id.0)
    }

    /// All joints, in order.
    pub fn joints(&self) -> impl Iterator<Item = JointView> + '_ {
        self.state.joints.all.keys().filter_map(|&id| view(&self.state, id))
    }

    /// The joints that broke in the last step, in the order in which they did. A step in which
    /// joints break is taken again without them: without the one that carried most for what it
    /// bears and all within 5 % of it, and, if others are over their limits then, again; of these
    /// at least 1, 1, 2, 2, 4, 4, 8 and so on break at a time. After 16 times all that are still
    /// over break.
    #[must_use]
    pub fn broken_joints(&self) -> &[JointBreak] {
        &self.state.joints.broken
    }

    /// Sets how often a step in which joints break is taken again at most: 16, and no more, unless
    /// this is called. With 0 all that are over their limits break at once, which is quicker, and
    /// lets a blow shatter all that it is handed through to.
    pub fn set_joint_retakes(&mut self, most: u32) {
        self.state.joints.fewer_retakes = MOST_RETAKES.saturating_sub(most);
    }

    /// How the loads of joints were found so far.
    #[must_use]
    pub fn joint_counts(&self) -> JointCounts {
        self.state.joints.counts
    }

    /// Work that driven bodies did on the others so far, by contacts and by joints \[J\]: impulse
    /// times velocity of the driven body where it acts.
    #[must_use]
    pub fn driven_work(&self) -> f64 {
        self.state.flows.driven_work
    }

    /// The same of one driven body \[J\]; `None` where it is none, or gone.
    #[must_use]
    pub fn driven_work_of(&self, id: BodyId) -> Option<f64> {
        let driven = self.state.bodies.get(&id.0)?.driven.is_some();
        driven.then(|| self.state.driven_work.get(&id.0).copied().unwrap_or(0.0))
    }

    /// Gives a body an acceleration \[m/s²\] over the next step, on top of gravity, through its
    /// centre; several add up. Whether the body is there and can move. A body that sleeps goes on
    /// to sleep while it is given the same as in the step before.
    pub fn accelerate(&mut self, id: BodyId, acceleration: Vec3) -> bool {
        accelerate(&mut self.state, id, acceleration)
    }

    /// Takes a body out of the world, with its joints. Whether it was there. [`crate::Totals`] goes
    /// on to count what it took with it.
    pub fn remove(&mut self, id: BodyId) -> bool {
        remove(&mut self.state, id)
    }
}
