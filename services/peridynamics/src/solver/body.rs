//! A body of points and bonds that something presses on.

use crate::domain::{BondTally, PeridynamicDomain};
use cullet_fragment::pressed_body::{PressClock, PressedBody};
use cullet_geometry::{Mat3, Vec3};

/// The body, its clock, and what only its outcome needs.
#[derive(Debug)]
pub(super) struct PressedDomain {
    pub(super) domain: PeridynamicDomain,
    pub(super) clock: PressClock,
    /// Where points were before the hit \[m\].
    pub(super) first: Vec<Vec3>,
    /// When each point lost its first bonds \[s\]; infinite where it has lost none.
    pub(super) broke: Vec<f64>,
    /// Angular momentum that what presses gave at the surface and points have not, for they lie
    /// under it \[N·m·s\].
    pub(super) beside: Vec3,
}

impl PressedBody for PressedDomain {
    fn clock(&self) -> PressClock {
        self.clock
    }

    /// The surface goes along with its point, so that what presses does the work that the point
    /// takes up.
    fn point_now(&self, id: u32) -> (Vec3, Mat3) {
        (self.domain.places[id as usize], Mat3::zeros())
    }

    /// Points without bonds are pushed on too.
    fn speed_now(&self, id: u32) -> Option<Vec3> {
        self.domain.velocities.get(id as usize).copied()
    }

    fn kick(&mut self, id: u32, offset: &Vec3, impulse: &Vec3) {
        let mass = self.domain.mass(id as usize);
        self.domain.velocities[id as usize] += impulse / mass;
        self.beside += offset.cross(impulse);
    }
}

impl PressedDomain {
    /// At rest, with steps of `step` \[s\].
    pub(super) fn new(mut domain: PeridynamicDomain, step: f64) -> Self {
        domain.strain();
        let first = domain.places.clone();
        let broke = vec![f64::INFINITY; first.len()];
        let clock = PressClock { time: 0.0, step, steps: 0 };
        Self { domain, clock, first, broke, beside: Vec3::zeros() }
    }

    /// A step.
    pub(super) fn advance(&mut self) -> BondTally {
        let tally = self.domain.advance(self.clock.step, |_, v| v);
        self.clock.time += self.clock.step;
        self.clock.steps += 1;
        for (broke, state) in self.broke.iter_mut().zip(&self.domain.states) {
            if state.damage > 0.0 && broke.is_infinite() {
                *broke = self.clock.time;
            }
        }
        tally
    }

    /// Speed of the fastest point \[m/s\].
    pub(super) fn fastest(&self) -> f64 {
        self.domain.velocities.iter().map(Vec3::norm_squared).fold(0.0, f64::max).sqrt()
    }

    pub(super) fn masses(&self) -> Vec<f64> {
        (0..self.first.len()).map(|p| self.domain.mass(p)).collect()
    }

    /// Of the whole \[m/s\].
    pub(super) fn velocity(&self) -> Vec3 {
        let sums = self.domain.sums();
        sums.momentum / self.masses().iter().sum::<f64>()
    }

    /// Kinetic, elastic and of contact \[J\].
    pub(super) fn energy(&self) -> f64 {
        let sums = self.domain.sums();
        // Velocities are half a step behind.
        let pairs = self.domain.velocities.iter().zip(&self.domain.forces);
        let ahead: f64 = pairs.map(|(v, f)| v.dot(f)).sum();
        sums.kinetic + 0.5 * self.clock.step * ahead + sums.elastic + sums.contact
    }
}
