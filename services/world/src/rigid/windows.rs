//! What windows of deforming bodies ask of the engine.

use super::Rigid;
use super::ccd::set_back;
use super::convert::engine_pose;
use super::hulls::Part;
use cullet_geometry::{Pose, Vec3};
use rapier3d_f64::prelude::{Collider, ContactPair};

impl Rigid {
    /// Corners of a body's convex parts in its own frame \[m\].
    pub(crate) fn corners(&self, id: u32) -> Vec<Vec<Vec3>> {
        self.slots
            .get(&id)
            .map_or(Vec::new(), |slot| slot.parts.iter().map(Part::corners).collect())
    }

    /// Does a body touch another one, as of the last step?
    pub(crate) fn touches(&self, id: u32) -> bool {
        let of = |collider| self.world.colliders.get(collider).and_then(Collider::parent);
        let handle = self.slots.get(&id).map(|slot| slot.handle);
        let other = |pair: &ContactPair| [of(pair.collider1), of(pair.collider2)].contains(&handle);
        let pushed = self.pushes.iter().any(|push| push.ids.0 == id || push.ids.1 == id);
        pushed
            || self.world.contact_pairs().any(|pair| pair.has_any_active_contact() && other(pair))
    }

    /// Puts a body somewhere; its velocity and its angular momentum stay.
    pub(crate) fn place(&mut self, id: u32, pose: &Pose) {
        let handle = self.slots.get(&id).map(|slot| slot.handle);
        if let Some(body) = handle.and_then(|h| self.world.bodies.get_mut(h)) {
            set_back(body, engine_pose(pose));
        }
    }
}
