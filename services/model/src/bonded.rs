//! What a solid of points and bonds is made of, beside its elasticity.

use crate::{DuctileFailure, Hardening};
use cullet_geometry::Vec3;

/// How a solid bears, yields and breaks whose points are bonded to those around them (Chen and
/// others 2018).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct BondedSolid {
    /// How it yields; `None` where it does not.
    pub hardening: Option<Hardening>,
    /// Whether bonds break, so that a plane costs G_f.
    pub breaks: bool,
    /// α: bonds of points that have lost some break later, so that less dust comes \[1\].
    pub dust: f64,
    /// At which plastic strain bonds break; `None` where flow alone breaks none.
    pub failure: Option<DuctileFailure>,
    /// γ: a point flows up to this plastic stretch and is elastic beyond \[1\].
    pub max_plastic_stretch: Option<f64>,
    /// The axis along which it is stiffer or stronger; `None` where it is alike in all directions.
    pub grain: Option<BondGrain>,
    /// Coulomb's coefficient of parts that touch \[1\].
    pub friction: f64,
    /// Share of critical damping that bonds give the fastest motion \[1\].
    pub bond_damping: f64,
    /// λ: what moves loses the share λ dt of its velocity to the air \[1/s\].
    pub air_damping: f64,
    /// Reach of bonds over the distance of points \[1\].
    pub horizon: f64,
}

/// An axis along which bonds differ, in the body's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct BondGrain {
    /// Its unit direction.
    pub axis: Vec3,
    /// Stretch at which bonds along it break, over that across \[1\].
    pub strength: f64,
    /// What the paper's matrix G stretches along it; across, 1. Bonds along it are as much softer
    /// \[1\].
    pub stretch: f64,
}

impl Default for BondedSolid {
    fn default() -> Self {
        Self {
            hardening: None,
            breaks: true,
            dust: 0.0,
            failure: None,
            max_plastic_stretch: None,
            grain: None,
            friction: 0.3,
            bond_damping: 0.1,
            air_damping: 0.0,
            horizon: 3.015,
        }
    }
}

/// Which property of a [`BondedSolid`] a number of it is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BondProperty {
    /// [`BondedSolid::dust`].
    Dust,
    /// [`BondedSolid::friction`].
    Friction,
    /// [`BondedSolid::bond_damping`].
    BondDamping,
    /// [`BondedSolid::air_damping`].
    AirDamping,
    /// [`BondedSolid::horizon`].
    Horizon,
    /// [`BondedSolid::hardening`].
    Hardening,
    /// [`BondedSolid::max_plastic_stretch`].
    MaxPlasticStretch,
    /// [`BondedSolid::grain`].
    Grain,
    /// [`BondedSolid::failure`].
    Failure,
}

/// A number of a [`BondedSolid`] and its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedNumber {
    /// What it is a number of.
    pub of: BondProperty,
    /// What it is, in words, its value, and the least and the greatest that holds.
    pub bound: (&'static str, f64, f64, f64),
}

impl BondedSolid {
    /// Its numbers: what each is, its value, the least and the greatest that holds.
    #[must_use]
    pub fn bounds(&self) -> Vec<(&'static str, f64, f64, f64)> {
        self.numbers().into_iter().map(|number| number.bound).collect()
    }

    /// Its numbers with their bounds, and what each is of.
    #[must_use]
    pub fn numbers(&self) -> Vec<BoundedNumber> {
        use BondProperty as Of;
        let mut all = vec![
            (Of::Dust, ("dust control [1]", self.dust, 0.0, 10.0)),
            (Of::Friction, ("friction of parted points [1]", self.friction, 0.0, 10.0)),
            (Of::BondDamping, ("damping of bonds [1]", self.bond_damping, 0.0, 1.0)),
            (Of::AirDamping, ("damping by air [1/s]", self.air_damping, 0.0, 1e6)),
            (Of::Horizon, ("horizon over the distance of points [1]", self.horizon, 2.0, 4.1)),
        ];
        let flow = self.hardening.iter().flat_map(Hardening::bounds);
        all.extend(flow.map(|bound| (Of::Hardening, bound)));
        if let Some(limit) = self.max_plastic_stretch {
            all.push((Of::MaxPlasticStretch, ("greatest plastic stretch [1]", limit, 1e-4, 0.3)));
        }
        if let Some(BondGrain { axis, strength, stretch }) = self.grain {
            let bounds = [
                ("length of the grain's axis [1]", axis.norm(), 1.0 - 1e-6, 1.0 + 1e-6),
                ("strength along the grain over that across [1]", strength, 0.1, 10.0),
                ("stretch along the grain [1]", stretch, 0.5, 2.0),
            ];
            all.extend(bounds.map(|bound| (Of::Grain, bound)));
        }
        if let Some(failure) = self.failure {
            let number = |d| (Of::Failure, ("a number of ductile failure [1]", d, -1e3, 1e3));
            all.extend(failure.d.map(number));
            // Between what shells and what deep notches have.
            for triaxiality in [-2.0 / 3.0, 3.0] {
                let strain = failure.strain(triaxiality);
                let bound = ("plastic strain at which bonds break [1]", strain, 1e-4, 1e3);
                all.push((Of::Failure, bound));
            }
        }
        all.into_iter().map(|(of, bound)| BoundedNumber { of, bound }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{BondGrain, BondedSolid};
    use crate::{DuctileFailure, Hardening};
    use cullet_geometry::Vec3;

    #[test]
    fn numbers_that_do_not_hold_are_found_with_their_bound() {
        let fails = |solid: BondedSolid| -> Vec<&'static str> {
            let out = |bound: &(_, f64, f64, f64)| !(bound.2..=bound.3).contains(&bound.1);
            solid.bounds().iter().filter(|bound| out(bound)).map(|bound| bound.0).collect()
        };
        let fine = BondedSolid::default();
        assert_eq!(fails(fine), Vec::<&str>::new());
        let (axis, strength, stretch) = (Vec3::x(), 2.0, 1.0);
        let hardening = Some(Hardening { yield_stress: 1.0, hardening: 0.0, exponent: 1.0 });
        let failure = Some(DuctileFailure { d: [0.0, 0.0, 1.0, 0.0, 0.0] });
        for (solid, what) in [
            (BondedSolid { dust: -1.0, ..fine }, "dust"),
            (BondedSolid { dust: f64::NAN, ..fine }, "dust"),
            (BondedSolid { horizon: 5.0, ..fine }, "horizon"),
            (BondedSolid { hardening, ..fine }, "yield stress"),
            (BondedSolid { failure, ..fine }, "plastic strain"),
            (BondedSolid { max_plastic_stretch: Some(0.4), ..fine }, "greatest plastic stretch"),
            (
                BondedSolid {
                    grain: Some(BondGrain { axis: axis * 2.0, strength, stretch }),
                    ..fine
                },
                "length of the grain's axis",
            ),
            (
                BondedSolid { grain: Some(BondGrain { axis, strength: 99.0, stretch }), ..fine },
                "strength along the grain",
            ),
        ] {
            let found = fails(solid);
            assert!(found.iter().all(|name| name.contains(what)), "{found:?}, not {what}");
            assert!(!found.is_empty(), "{what}");
        }
    }
}
