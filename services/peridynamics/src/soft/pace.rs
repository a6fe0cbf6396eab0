//! How fast the waves of a soft solid are.

use cullet_continuum::WorkingPace;
use cullet_model::{BondedSolid, Hardening, Material, MembranePace, Refusal};

/// What a pace makes of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SolidPace {
    /// What is worked with.
    pub(super) material: Material,
    /// Likewise.
    pub(super) bonds: BondedSolid,
    /// Inertia over mass \[1\].
    pub(super) inertia: f64,
    /// √(E/ρ) that is worked with \[m/s\].
    pub(super) speed: f64,
}

impl SolidPace {
    /// # Errors
    ///
    /// If the speed is no positive number.
    pub(super) fn new(
        material: &Material,
        bonds: &BondedSolid,
        pace: MembranePace,
    ) -> Result<Self, Refusal> {
        let working = WorkingPace::new(material.young, material.density, pace)?;
        let WorkingPace { young, inertia, speed, stretches: more } = working;
        // All stretches at which something happens grow by `more`; G stays by itself.
        let failure_stress = material.failure_stress / more;
        let softer = |h: Hardening| Hardening {
            yield_stress: h.yield_stress / more,
            hardening: h.hardening / libm::pow(more, 1.0 + h.exponent),
            ..h
        };
        Ok(Self {
            material: Material { young, failure_stress, ..*material },
            bonds: BondedSolid { hardening: bonds.hardening.map(softer), ..*bonds },
            inertia,
            speed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::SolidPace;
    use cullet_model::{BondedSolid, Hardening, Material, MembranePace};

    #[test]
    fn a_pace_keeps_weight_and_toughness_and_says_what_it_changes() {
        let material = Material {
            density: 1000.0,
            young: 4e6,
            poisson: 0.3,
            failure_stress: 2e5,
            fracture_energy: 50.0,
        };
        let hardening = Hardening { yield_stress: 1e5, hardening: 8e5, exponent: 1.0 };
        let bonds = BondedSolid { hardening: Some(hardening), ..BondedSolid::default() };
        let of = |pace| SolidPace::new(&material, &bonds, pace);
        let real = of(MembranePace::Real).unwrap();
        assert!((real.speed - 4000.0_f64.sqrt()).abs() < 1e-12);
        let soft = of(MembranePace::Softer(0.5 * real.speed)).unwrap();
        assert!((soft.material.young / 1e6 - 1.0).abs() < 1e-12);
        assert_eq!(soft.material.fracture_energy, 50.0);
        let law = soft.bonds.hardening.unwrap();
        // Twice the strain at yield, and at each stress beyond.
        assert!((law.yield_stress / 5e4 - 1.0).abs() < 1e-12);
        assert!((law.hardening / 2e5 - 1.0).abs() < 1e-12);
        let heavy = of(MembranePace::Heavier(0.5 * real.speed)).unwrap();
        assert!((heavy.inertia - 4.0).abs() < 1e-12);
        assert_eq!(heavy.material, material);
        assert_eq!(of(MembranePace::Softer(1e3)).unwrap(), real);
        assert!(of(MembranePace::Heavier(f64::NAN)).is_err());
    }
}
