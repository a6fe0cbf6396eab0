//! Sums over a body, and its stress.

use super::PeridynamicDomain;
use crate::bonds::BondSlot;
use cullet_geometry::{Mat3, Vec3};
use rayon::prelude::*;

/// Sums over a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodySum {
    /// \[J\].
    pub kinetic: f64,
    /// \[J\].
    pub elastic: f64,
    /// What points that touch hold \[J\].
    pub contact: f64,
    /// \[kg m/s\].
    pub momentum: Vec3,
    /// About the origin \[kg m²/s\].
    pub angular: Vec3,
    /// Points that have no bond left.
    pub debris: usize,
    /// Their mass \[kg\].
    pub debris_mass: f64,
    /// Their part of the momentum \[kg m/s\].
    pub debris_momentum: Vec3,
}

impl PeridynamicDomain {
    /// Sums over the body.
    #[must_use]
    pub fn sums(&self) -> BodySum {
        let mut sum = BodySum { contact: self.contact, ..BodySum::default() };
        for (p, state) in self.states[..self.own].iter().enumerate() {
            let (mass, v) = (self.mass(p), self.velocities[p]);
            sum.kinetic += 0.5 * mass * v.norm_squared();
            sum.elastic +=
                self.volumes[p] * self.law.energy(1.0 - state.damage, state.mean, state.deviation);
            sum.momentum += v * mass;
            sum.angular += self.places[p].cross(&v) * mass;
            if self.is_debris(p) {
                sum.debris += 1;
                sum.debris_mass += mass;
                sum.debris_momentum += v * mass;
            }
        }
        sum
    }

    /// Elastic energy of the body at its places as they are now, in f64 \[J\]: bonds have softened
    /// and flowed as in the last step.
    pub(crate) fn elastic_now(&self) -> f64 {
        self.elastic_of(|_| true)
    }

    /// The same of some points.
    pub(crate) fn elastic_of(&self, counts: impl Fn(usize) -> bool + Sync) -> f64 {
        let of = |p: usize| {
            if !counts(p) {
                return 0.0;
            }
            let (mut whole, mut first, mut second) = (0.0, 0.0, 0.0);
            for bond in self.bonds.of(p) {
                let weight = self.weight(p, bond) * self.left(bond);
                let x = self.elastic_extension(p, bond, self.places[bond.end] - self.places[p]);
                whole += weight;
                first += weight * x;
                second += weight * x * x;
            }
            if whole <= 0.0 {
                return 0.0;
            }
            let mean = first / whole;
            self.volumes[p] * self.law.energy(whole, mean, second - first * mean)
        };
        let energies: Vec<f64> = (0..self.own).into_par_iter().map(of).collect();
        energies.iter().sum()
    }

    /// Whether a point has no bond left: it flies on by itself.
    #[must_use]
    pub fn is_debris(&self, point: usize) -> bool {
        self.states[point].damage >= 1.0
    }

    /// Cauchy's stress at a point for small strains, Σw (∂W/∂q/w) n⊗n \[Pa\].
    #[must_use]
    pub fn stress(&self, point: usize) -> Mat3 {
        let state = &self.states[point];
        self.bonds.of(point).fold(Mat3::zeros(), |sum, b| {
            let along = self.places[b.end] - self.places[point];
            let z = self.elastic_extension(point, b, along) - state.mean;
            let n = along / along.norm();
            sum + n
                * n.transpose()
                * (self.weight(point, b) * self.left(b) * self.law.pull(state.mean, z))
        })
    }

    /// w of a bond \[1\].
    pub(crate) fn weight(&self, point: usize, bond: BondSlot) -> f64 {
        f64::from(bond.of(&self.bonds.weights)) / f64::from(self.totals[point])
    }

    /// q − e_p of a bond that is `along` \[m\] now \[1\].
    pub(super) fn elastic_extension(&self, point: usize, bond: BondSlot, along: Vec3) -> f64 {
        let flowed = if self.flowed[0].is_empty() { 0.0 } else { bond.of(&self.flowed[0]) };
        along.norm() / self.rest(point, bond) - 1.0 - f64::from(flowed)
    }
}
