//! How far the family holds.

use super::PeridynamicDomain;
use cullet_geometry::{Mat3, Vec3};
use rayon::prelude::*;
use thiserror::Error;

/// Most change of volume that no pressure explains, most equivalent plastic strain, and least J of
/// a point: beyond these, bonds have lost modes of shear.
pub(crate) const MOST_DRIFT: f64 = 0.02;
const MOST_PLASTIC: f64 = 0.3;
const LEAST_JACOBIAN: f64 = 0.2;

/// Points that have lost more of their bonds have no deformation gradient.
const MOST_DAMAGE: f64 = 0.5;

/// Why a body has to be handed over to another family.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum StrainLimit {
    /// The volume has drifted.
    #[error(
        "flow has changed the body's volume by {drift:.3}; bonds hold up to {MOST_DRIFT}: take a \
         ductile law in the MPM"
    )]
    Volume {
        /// Σ(J/J_e)V/ΣV − 1 of points whose bonds are whole \[1\].
        drift: f64,
    },
    /// A point has flowed too far.
    #[error(
        "point {point} has a plastic strain of {strain:.3}; bonds hold up to {MOST_PLASTIC}: take \
         a ductile law in the MPM"
    )]
    Plastic {
        /// Which, from 0.
        point: usize,
        /// ε_p \[1\].
        strain: f64,
    },
    /// A point is crushed.
    #[error(
        "point {point} has {jacobian:.3} of its volume; bonds hold down to {LEAST_JACOBIAN}: take \
         a ductile law in the MPM"
    )]
    Crushed {
        /// Which, from 0.
        point: usize,
        /// J \[1\].
        jacobian: f64,
    },
    /// A place or a velocity is no number any more.
    #[error("point {point} is nowhere any more: the step was too long, or a law has failed")]
    NoNumber {
        /// Which, from 0.
        point: usize,
    },
}

impl PeridynamicDomain {
    /// F = Σwk (y/l₀)⊗n (Σwk n⊗n)⁻¹ of a point, exact where it is the same all around; none where
    /// half of its bonds are gone.
    #[must_use]
    pub fn gradient(&self, point: usize) -> Option<Mat3> {
        self.slope(point, &self.places)
    }

    /// Likewise the gradient of the velocity by places at rest \[1/s\].
    #[must_use]
    pub fn velocity_gradient(&self, point: usize) -> Option<Mat3> {
        self.slope(point, &self.velocities)
    }

    /// The gradient at a point of what goes by point.
    fn slope(&self, point: usize, of: &[Vec3]) -> Option<Mat3> {
        let (mut moved, mut shape) = (Mat3::zeros(), Mat3::zeros());
        if self.states[point].damage > MOST_DAMAGE {
            return None;
        }
        for bond in self.bonds.of(point) {
            let rest = self.reference[bond.end] - self.reference[point];
            let weight = self.weight(point, bond) * self.left(bond) / rest.norm_squared();
            moved += (of[bond.end] - of[point]) * rest.transpose() * weight;
            shape += rest * rest.transpose() * weight;
        }
        Some(moved * shape.try_inverse()?)
    }

    /// That no point has flowed too far: quick enough for each step.
    ///
    /// # Errors
    ///
    /// With the point that has flowed farthest.
    pub fn check_flow(&self) -> Result<(), StrainLimit> {
        let most =
            |best: (usize, f64), (p, x): (usize, f64)| if x > best.1 { (p, x) } else { best };
        let plastic = self.states.iter().map(|state| state.plastic).enumerate();
        let (point, strain) = plastic.fold((0, 0.0), most);
        let over = strain > MOST_PLASTIC;
        if over { Err(StrainLimit::Plastic { point, strain }) } else { Ok(()) }
    }

    /// That the body is still one that bonds hold for. It takes about as long as a step: every few
    /// dozen are enough.
    ///
    /// # Errors
    ///
    /// With the first limit that is passed.
    pub fn check(&self) -> Result<(), StrainLimit> {
        let whole = |p: &usize| {
            self.places[*p].iter().chain(self.velocities[*p].iter()).all(|c| c.is_finite())
        };
        if let Some(point) = (0..self.places.len()).find(|p| !whole(p)) {
            return Err(StrainLimit::NoNumber { point });
        }
        self.check_flow()?;
        let found = self.volume_change();
        if let Some((point, jacobian)) = found.first_crushed {
            return Err(StrainLimit::Crushed { point, jacobian });
        }
        match found.drift.abs() > MOST_DRIFT {
            true => Err(StrainLimit::Volume { drift: found.drift }),
            false => Ok(()),
        }
    }

    /// How its volume has changed. It takes about as long as a step.
    pub(crate) fn volume_change(&self) -> VolumeChange {
        let of = |p: usize| self.gradient(p).map(|f| f.determinant());
        let found: Vec<Option<f64>> = (0..self.places.len()).into_par_iter().map(of).collect();
        let (mut drift, mut volume, mut crushed) = (0.0, 0.0, 0.0);
        let mut first_crushed = None;
        for (point, jacobian) in found.into_iter().enumerate() {
            let Some(jacobian) = jacobian else { continue };
            if jacobian < LEAST_JACOBIAN {
                crushed += self.volumes[point];
                first_crushed = first_crushed.or(Some((point, jacobian)));
            }
            // What has lost bonds has opened, and not flowed.
            if self.states[point].damage > 0.0 {
                continue;
            }
            // Of uniform pressure J is (1 + q̄)³.
            let elastic = (1.0 + self.states[point].mean).powi(3);
            drift += self.volumes[point] * (jacobian / elastic - 1.0);
            volume += self.volumes[point];
        }
        let crushed = crushed / self.volumes.iter().sum::<f64>();
        VolumeChange {
            drift: if volume > 0.0 { drift / volume } else { 0.0 },
            crushed,
            first_crushed,
        }
    }
}

/// How the volume of a body has changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VolumeChange {
    /// Σ(J/J_e)V/ΣV − 1 of points whose bonds are whole \[1\].
    pub(crate) drift: f64,
    /// Share of the body that has less than a fifth of its volume \[1\].
    pub(crate) crushed: f64,
    /// The first point of that, and its J.
    pub(crate) first_crushed: Option<(usize, f64)>,
}
