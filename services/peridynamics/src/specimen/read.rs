//! What is read off points and bonds.

use crate::bonds::BondSlot;
use crate::domain::PeridynamicDomain;
use cullet_geometry::{Mat3, Vec3};
use cullet_specimen::{FieldValues, LocalVector, PointField, PointFields};
use std::collections::BTreeMap;

/// Share of the bonds that a plane crack in the middle between two rows takes, in a continuum, at
/// which a point is broken: rows are not one.
const BROKEN: f64 = 0.8;

/// Bonds of pieces reach no farther than this \[spacings\]: the diagonal of a cell.
const NEAR: f64 = 1.75;

/// What is read off the points, and what of it was there before anything moved.
#[derive(Clone, Debug)]
pub(super) struct ReadBonds {
    /// Where each was, in the grid's frame \[m\].
    rest: Vec<Vec3>,
    /// Share of the bonds of each that notches took \[1\].
    notched: Vec<f64>,
    /// Share of bonds that is gone of a point that is broken \[1\].
    broken: f64,
    spacing: f64,
}

/// Σwk beyond a plane at the share `off` of the horizon from a point, in a continuum whose weights
/// go with the length: ½∫4r³(1 − a/r)dr from a to 1 \[1\].
pub(super) fn beyond(off: f64) -> f64 {
    0.5 * ((1.0 - off.powi(4)) - 4.0 / 3.0 * off * (1.0 - off.powi(3)))
}

impl ReadBonds {
    /// Of a domain at rest that has been strained once, and its `horizon` \[spacings\].
    pub(super) fn new(domain: &PeridynamicDomain, horizon: f64, spacing: f64) -> Self {
        Self {
            rest: domain.places[..domain.own].to_vec(),
            notched: domain.states.iter().map(|state| state.damage).collect(),
            broken: BROKEN * beyond(0.5 / horizon),
            spacing,
        }
    }

    /// Where each point was, in the grid's frame \[m\].
    pub(super) fn rest(&self) -> &[Vec3] {
        &self.rest
    }

    /// Share of a point's bonds that is gone since, over that of a broken one \[1\].
    fn damage(&self, domain: &PeridynamicDomain, p: usize) -> f64 {
        let (now, first) = (domain.states[p].damage, self.notched[p]);
        let share = if first < 1.0 { (now - first) / (1.0 - first) } else { 0.0 };
        (share / self.broken).clamp(0.0, 1.0)
    }

    /// What the points carry. Where half of a point's bonds are gone it has no gradient: it moves
    /// as a whole, and has no strain.
    pub(super) fn fields(&self, domain: &PeridynamicDomain, fields: &[PointField]) -> PointFields {
        let count = domain.own;
        let strained = |field: &PointField| {
            use PointField::{Displacement, Strain, Stress, VolumeRatio};
            matches!(field, Displacement | Strain | Stress | VolumeRatio)
        };
        let gradients: Vec<Mat3> = match fields.iter().any(strained) {
            true => (0..count).map(|p| domain.gradient(p).unwrap_or(Mat3::identity())).collect(),
            false => Vec::new(),
        };
        let vectors = |of: &dyn Fn(usize) -> (Vec3, Mat3)| {
            let local = |(value, gradient)| LocalVector { value, gradient };
            FieldValues::Vectors((0..count).map(|p| local(of(p))).collect())
        };
        let numbers =
            |of: &dyn Fn(usize) -> f64| FieldValues::Numbers((0..count).map(of).collect());
        let tensors = |of: &dyn Fn(usize) -> Mat3| {
            let pairs =
                |m: Mat3| [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(1, 2)], m[(2, 0)]];
            FieldValues::Tensors((0..count).map(|p| pairs(of(p))).collect())
        };
        let value = |field| match field {
            PointField::Displacement => {
                vectors(&|p| (domain.places[p] - self.rest[p], gradients[p] - Mat3::identity()))
            }
            PointField::Velocity => vectors(&|p| {
                (domain.velocities[p], domain.velocity_gradient(p).unwrap_or_default())
            }),
            PointField::Stress => tensors(&|p| pulled_back(&domain.stress(p), &gradients[p])),
            PointField::Strain => {
                tensors(&|p| (gradients[p].transpose() * gradients[p] - Mat3::identity()) * 0.5)
            }
            PointField::Damage => numbers(&|p| self.damage(domain, p)),
            PointField::PlasticStrain => numbers(&|p| domain.states[p].plastic),
            PointField::VolumeRatio => numbers(&|p| gradients[p].determinant()),
        };
        PointFields {
            places: self.rest.clone(),
            numbers: (0..count as u32).collect(),
            volumes: domain.volumes[..count].to_vec(),
            fields: fields.iter().map(|&field| (field, value(field))).collect(),
        }
    }

    /// Shares of the body's mass that its pieces have, the largest first.
    pub(super) fn shares(&self, domain: &PeridynamicDomain) -> Vec<f64> {
        let mut roots: Vec<u32> = (0..domain.own as u32).collect();
        for p in 0..domain.own {
            let is_near = |b: &BondSlot| {
                let near = domain.rest(p, *b) <= NEAR * self.spacing;
                near && domain.left(*b) > 0.0 && b.end < domain.own
            };
            for bond in domain.bonds.of(p).filter(is_near) {
                let (a, b) = (root(&mut roots, p), root(&mut roots, bond.end));
                roots[a.max(b)] = a.min(b) as u32;
            }
        }
        let mut sizes: BTreeMap<usize, f64> = BTreeMap::new();
        for p in 0..domain.own {
            *sizes.entry(root(&mut roots, p)).or_default() += domain.volumes[p];
        }
        let all: f64 = domain.volumes[..domain.own].iter().sum();
        let mut shares: Vec<f64> = sizes.into_values().map(|size| size / all).collect();
        shares.sort_unstable_by(|a, b| b.total_cmp(a));
        shares
    }
}

fn root(roots: &mut [u32], point: usize) -> usize {
    let mut at = point;
    while roots[at] as usize != at {
        roots[at] = roots[roots[at] as usize];
        at = roots[at] as usize;
    }
    at
}

/// The second Piola-Kirchhoff stress of Cauchy's, J F⁻¹ σ F⁻ᵀ \[Pa\].
fn pulled_back(stress: &Mat3, gradient: &Mat3) -> Mat3 {
    match gradient.try_inverse() {
        Some(back) => back * stress * back.transpose() * gradient.determinant(),
        None => *stress,
    }
}
