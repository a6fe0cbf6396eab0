//! Bodies taken together, so that impulses can be given to several as if they were one.

use crate::body::{Body, invert, shifted};
use crate::motion::Motion;
use cullet_geometry::{Mat3, Vec3};
use std::collections::BTreeMap;

/// One moving body: what its momentum is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// \[kg\]
    pub(crate) mass: f64,
    /// About its centre, world frame \[kg·m²\].
    pub(crate) inertia: Mat3,
    /// \[m\]
    pub(crate) centre: Vec3,
    /// \[m/s\]
    pub(crate) velocity: Vec3,
    /// \[rad/s\]
    pub(crate) spin: Vec3,
}

impl Part {
    pub(crate) fn new(body: &Body, motion: &Motion) -> Self {
        Self {
            mass: body.mass,
            inertia: body.world_inertia(&motion.pose),
            centre: motion.centre(),
            velocity: motion.velocity,
            spin: motion.spin,
        }
    }

    pub(crate) fn momentum(&self) -> Vec3 {
        self.velocity * self.mass
    }

    /// About the world's origin \[N·m·s\].
    pub(crate) fn angular(&self) -> Vec3 {
        self.centre.cross(&self.momentum()) + self.inertia * self.spin
    }

    pub(crate) fn kinetic(&self) -> f64 {
        0.5 * (self.mass * self.velocity.norm_squared()
            + self.spin.dot(&(self.inertia * self.spin)))
    }
}

/// Moving bodies by id.
pub(crate) type Parts = BTreeMap<u32, Part>;

/// Mass, centre and inertia of some of them, as one rigid body.
pub(crate) struct Joint {
    pub(crate) mass: f64,
    pub(crate) centre: Vec3,
    pub(crate) inertia: Mat3,
}

pub(crate) fn joint<'a>(parts: impl Iterator<Item = &'a Part> + Clone) -> Joint {
    let mass: f64 = parts.clone().map(|p| p.mass).sum();
    let centre = parts.clone().map(|p| p.centre * p.mass).sum::<Vec3>() / mass;
    let inertia = parts.map(|p| shifted(&p.inertia, p.mass, &(p.centre - centre))).sum();
    Joint { mass, centre, inertia }
}

/// A rigid change of motion: what an impulse and a torque impulse about the joint centre do.
pub(crate) struct Field {
    pub(crate) velocity: Vec3,
    pub(crate) spin: Vec3,
    pub(crate) centre: Vec3,
}

impl Joint {
    pub(crate) fn field(&self, linear: &Vec3, torque: &Vec3) -> Field {
        Field {
            velocity: linear / self.mass,
            spin: invert(&self.inertia) * torque,
            centre: self.centre,
        }
    }
}

impl Field {
    pub(crate) fn at(&self, point: &Vec3) -> Vec3 {
        self.velocity + self.spin.cross(&(point - self.centre))
    }

    pub(crate) fn apply(&self, part: &mut Part, scale: f64) {
        part.velocity += self.at(&part.centre) * scale;
        part.spin += self.spin * scale;
    }
}

/// Momentum \[N·s\], angular momentum about the world's origin \[N·m·s\] and kinetic energy \[J\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sum {
    pub(crate) linear: Vec3,
    pub(crate) angular: Vec3,
    pub(crate) kinetic: f64,
}

pub(crate) fn sum<'a>(parts: impl Iterator<Item = &'a Part>) -> Sum {
    let zero = Sum { linear: Vec3::zeros(), angular: Vec3::zeros(), kinetic: 0.0 };
    parts.fold(zero, |s, p| Sum {
        linear: s.linear + p.momentum(),
        angular: s.angular + p.angular(),
        kinetic: s.kinetic + p.kinetic(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_gives_exactly_its_impulse_and_torque() {
        let part = |mass: f64, x: f64| Part {
            mass,
            inertia: Mat3::from_diagonal(&Vec3::new(1.0, 2.0, 2.5)) * mass,
            centre: Vec3::new(x, 0.3 * x * x, -x),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
        };
        let mut parts = [part(1.0, 0.0), part(2.5, 1.0), part(0.1, -4.0)];
        let joint = joint(parts.iter());
        let (linear, torque) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.2, 0.1, 3.0));
        let field = joint.field(&linear, &torque);
        parts.iter_mut().for_each(|p| field.apply(p, 1.0));
        let got = sum(parts.iter());
        assert!((got.linear - linear).norm() < 1e-12);
        assert!((got.angular - joint.centre.cross(&linear) - torque).norm() < 1e-12);
    }
}
