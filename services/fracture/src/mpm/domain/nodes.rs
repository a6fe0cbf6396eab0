//! Points and nodes one by one: their motion, and what pushes them.

use super::{Domain, PointMotion};
use crate::mpm::stencil::{AROUND, Stencil, gather, packed, vector};
use cullet_fragment::pressed_body::{PressClock, PressedBody};
use cullet_geometry::{Mat3, Vec3};
use std::ops::{AddAssign, Mul};
use wide::f64x4;

impl PointMotion {
    /// From the displacements and velocities of the nodes around a point.
    pub(super) fn gather(
        u: &[f64x4; AROUND],
        v: &[f64x4; AROUND],
        stencil: &Stencil,
        gain: &Vec3,
    ) -> Self {
        let (displacement, displacement_gradient) = gather(u, stencil, gain);
        let (velocity, velocity_gradient) = gather(v, stencil, gain);
        Self { displacement, displacement_gradient, velocity, velocity_gradient }
    }
}

impl Domain {
    /// Where the point that was given as number `id` was before the hit \[m\], and its motion.
    #[must_use]
    fn point(&self, id: u32) -> (Vec3, PointMotion) {
        let p = self.slot(id);
        let (nodes, gain) = (&self.grid.nodes, self.grid.spacing.map(|h| 4.0 / h));
        let place = self.particles.reference[p];
        let stencil = Stencil::new(&place, &self.grid.spacing);
        let around = &self.element(p).nodes;
        let u = around.map(|n| nodes.displacement[n as usize]);
        let v = around.map(|n| nodes.velocity[n as usize]);
        (place, PointMotion::gather(&u, &v, &stencil, &gain))
    }

    /// Displacement of each node \[m\].
    #[must_use]
    pub fn node_displacements(&self) -> Vec<Vec3> {
        self.grid.nodes.displacement.iter().map(|u| vector(*u)).collect()
    }

    /// Velocity of each node \[m/s\].
    #[must_use]
    pub fn node_velocities(&self) -> Vec<Vec3> {
        self.grid.nodes.velocity.iter().map(|v| vector(*v)).collect()
    }

    /// Gives each node another velocity \[m/s\].
    pub fn set_node_velocities(&mut self, velocities: &[Vec3]) {
        let pairs = self.grid.nodes.velocity.iter_mut().zip(velocities);
        pairs.for_each(|(v, new)| *v = packed(*new));
        self.contact.restart(&self.grid.nodes);
    }

    /// The nodes that see points with these shares, numbers or vectors, ascending, and what falls
    /// to each \[1\].
    #[must_use]
    pub fn carriers<T>(&self, shares: &[(u32, T)]) -> Vec<(u32, T)>
    where
        T: Copy + Default + PartialEq + Mul<f64, Output = T> + AddAssign,
    {
        let mut all = vec![T::default(); self.grid.nodes.len()];
        for &(id, share) in shares {
            let p = self.slot(id);
            let nodes = &self.element(p).nodes;
            let stencil = Stencil::new(&self.particles.reference[p], &self.grid.spacing);
            stencil.visit(|k, weight, _| all[nodes[k] as usize] += share * weight);
        }
        (0..).zip(all).filter(|one| one.1 != T::default()).collect()
    }

    /// The points that hold together with a whole one, by number.
    pub(crate) fn joined(&self, id: u32) -> impl Iterator<Item = u32> {
        self.cracks.bonds.joined(id)
    }

    /// The neighbours of a point, whatever has become of it, by number.
    pub(crate) fn neighbours(&self, id: u32) -> impl Iterator<Item = u32> {
        self.cracks.bonds.others(id)
    }

    /// The neighbours, by number and ascending, of the points that broke in the last step.
    pub(crate) fn laid_open(&self) -> Vec<u32> {
        let pairs = self.particles.damage_time.iter().zip(&self.particles.id);
        let broken = pairs.filter(|(time, _)| **time == self.time).map(|(_, &id)| id);
        let mut found: Vec<u32> = broken.flat_map(|id| self.cracks.bonds.others(id)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}

impl PressedBody for Domain {
    fn clock(&self) -> PressClock {
        PressClock { time: self.time, step: self.step, steps: self.steps }
    }

    fn point_now(&self, id: u32) -> (Vec3, Mat3) {
        let (place, motion) = self.point(id);
        (place + motion.displacement, motion.displacement_gradient)
    }

    fn speed_now(&self, id: u32) -> Option<Vec3> {
        let bears = !self.particles.eroded[self.slot(id)];
        bears.then(|| self.point(id).1.velocity)
    }

    fn kick(&mut self, id: u32, offset: &Vec3, impulse: &Vec3) {
        let p = self.slot(id);
        let around = self.element(p).nodes;
        let stencil = Stencil::new(&self.particles.reference[p], &self.grid.spacing);
        let least = self.response.least_mass;
        let slope = offset.component_mul(&self.grid.spacing.map(|h| 4.0 / (h * h)));
        let spacing = self.grid.spacing;
        let nodes = &mut self.grid.nodes;
        stencil.visit(|k, weight, away| {
            let n = around[k] as usize;
            let share = weight * (1.0 + slope.dot(&away.component_mul(&spacing)));
            nodes.velocity[n] += packed(impulse * (share / nodes.mass[n].max(least)));
        });
    }
}
