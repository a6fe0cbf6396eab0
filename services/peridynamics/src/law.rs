//! What a point bears: Hooke's law and von Mises' yield on its bonds together.

use crate::anisotropy::BondAnisotropy;
use crate::bonds::{BondError, positive};
use cullet_model::{DuctileFailure, Hardening};

/// Steps of Newton's method, and share of the yield stress at which it has ended.
const ROUNDS: usize = 40;
const ENOUGH: f64 = 1e-12;

/// What the mean extension adds to the cost of a plane that is opened, of 9K/μ − 15: measured with
/// ν = 0.1, 0.25, 0.4 and horizons of 2 to 4 spacings, planes of three directions.
const MEAN_SHARE: f64 = 0.0145;

/// An elastoplastic solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeridynamicLaw {
    /// ρ \[kg/m³\].
    pub density: f64,
    /// K \[Pa\].
    pub bulk: f64,
    /// μ \[Pa\].
    pub shear: f64,
    /// How it yields, where it does.
    pub hardening: Option<Hardening>,
    /// How it breaks, where it does.
    pub breaking: Option<BondBreaking>,
    /// How it breaks by flowing, where it does.
    pub ductile: Option<DuctileFailure>,
    /// γ, where there is one: a point flows up to this plastic stretch and is elastic beyond. It
    /// is √(5Σwe_p²), the plastic strain where that is along one axis \[1\]. The paper limits each
    /// bond (its Fig. 5).
    pub max_plastic_stretch: Option<f64>,
    /// In which directions it is stiffer or stronger, where it is.
    pub anisotropy: Option<BondAnisotropy>,
    /// How points that have lost bonds push each other, where they do.
    pub contact: Option<PartedContact>,
    /// What slows it.
    pub damping: PeridynamicDamping,
}

/// What slows a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PeridynamicDamping {
    /// Share of critical damping that dashpots of bonds give the fastest mode: slower ones have
    /// less by their ω. 0.1 takes the noise behind cracks \[1\].
    pub bonds: f64,
    /// λ: what moves loses the share λ dt of its velocity to the air \[1/s\].
    pub air: f64,
}

/// Contact of points that have lost bonds and have none to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartedContact {
    /// Coulomb's coefficient \[1\].
    pub friction: f64,
}

/// How bonds break: a bond whose elastic stretch exceeds half of a critical one s_c softens, and
/// bears nothing any more at s_c. Sudden breaking would trap cracks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondBreaking {
    /// G_f \[J/m²\].
    pub fracture_energy: f64,
    /// α: s_c rises to s_c(1 + αφ) where the share φ of bonds is broken, so that less dust comes
    /// \[1\].
    pub dust: f64,
}

impl BondBreaking {
    /// s_c of bonds whose points have Σw l₀ = `reach` \[m\] on the mean. A plane of any direction
    /// is crossed by ½Σw l₀ of bonds over its area, each of which takes 15/4 μ s_c² where ν = ¼;
    /// elsewhere the mean extension has a part in it that `MEAN_SHARE` stands for.
    #[must_use]
    pub fn critical_stretch(&self, bulk: f64, shear: f64, reach: f64) -> f64 {
        let more = 1.0 + MEAN_SHARE * (9.0 * bulk / shear - 15.0);
        (self.fracture_energy / (1.875 * shear * more * reach)).sqrt()
    }

    /// What is left of a bond at an elastic stretch \[1\].
    #[must_use]
    pub fn left(stretch: f64, critical: f64) -> f64 {
        if stretch <= 0.5 * critical { 1.0 } else { (critical / stretch - 1.0).max(0.0) }
    }
}

/// What a step of yielding did to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yielded {
    /// What is left of its deviatoric extensions, r \[1\].
    pub left: f64,
    /// Equivalent plastic strain that was added \[1\].
    pub strain: f64,
    /// Energy that it took \[J/m³\].
    pub work: f64,
}

/// Sums over a point's bonds, over Σwk, of what has flowed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowedSums {
    /// Σwke_p² \[1\].
    pub square: f64,
    /// Σwke_pz \[1\].
    pub product: f64,
}

impl PeridynamicLaw {
    /// Of Young's modulus \[Pa\] and Poisson's ratio.
    #[must_use]
    pub fn elastic(density: f64, young: f64, poisson: f64) -> Self {
        let bulk = young / (3.0 * (1.0 - 2.0 * poisson));
        Self {
            density,
            bulk,
            shear: young / (2.0 * (1.0 + poisson)),
            hardening: None,
            breaking: None,
            ductile: None,
            anisotropy: None,
            max_plastic_stretch: None,
            contact: None,
            damping: PeridynamicDamping::default(),
        }
    }

    /// That its numbers hold.
    ///
    /// # Errors
    ///
    /// If one does not.
    pub(crate) fn check(&self) -> Result<(), BondError> {
        positive("the density [kg/m^3]", self.density)?;
        positive("the bulk modulus [Pa]", self.bulk)?;
        positive("the shear modulus [Pa]", self.shear)?;
        if let Some(limit) = self.max_plastic_stretch {
            positive("the greatest plastic stretch", limit)?;
        }
        if let Some(anisotropy) = self.anisotropy {
            positive("the ratio of strengths", anisotropy.strength)?;
            positive("the length of the axis of strength", anisotropy.axis.norm())?;
        }
        if let Some(ductile) = self.ductile {
            // Between what shells and what deep notches have.
            positive("the failure strain at a triaxiality of -2/3", ductile.strain(-2.0 / 3.0))?;
            positive("the failure strain at a triaxiality of 3", ductile.strain(3.0))?;
        }
        let PeridynamicDamping { bonds, air } = self.damping;
        let fine = |x: f64| x.is_finite() && x >= 0.0;
        match (fine(bonds), fine(air)) {
            (false, _) => Err(BondError::NoNumber { what: "the damping of bonds", value: bonds }),
            (_, false) => Err(BondError::NoNumber { what: "the damping by air", value: air }),
            _ => Ok(()),
        }
    }

    /// max(9K, 15μ) \[Pa\].
    pub(crate) fn stiffness(&self) -> f64 {
        (9.0 * self.bulk).max(15.0 * self.shear)
    }

    /// σ_eq = μ√(45 Σwz²) \[Pa\].
    #[must_use]
    pub fn equivalent_stress(&self, deviation: f64) -> f64 {
        self.shear * (45.0 * deviation).sqrt()
    }

    /// ½Kθ² + 15/2 μ Σwz² for a mean extension q̄ and a deviation Σwz², of bonds of which the share
    /// `whole` is left \[J/m³\].
    #[must_use]
    pub fn energy(&self, whole: f64, mean: f64, deviation: f64) -> f64 {
        4.5 * self.bulk * whole * mean * mean + 7.5 * self.shear * deviation
    }

    /// ∂W/∂q of a bond over its weight: 3Kθ + 15μz \[Pa\].
    #[must_use]
    pub fn pull(&self, mean: f64, deviatoric: f64) -> f64 {
        9.0 * self.bulk * mean + 15.0 * self.shear * deviatoric
    }

    /// Returns a point that bears more than σ_y(ε_p) to it: σ_eq − 3μΔε = σ_y(ε_p + Δε) (Mitchell
    /// 2011, in this normalisation). All its extensions shrink by one factor, and z has no mean, so
    /// that nothing flows under pressure.
    #[must_use]
    pub fn yields(&self, deviation: f64, plastic: f64) -> Option<Yielded> {
        let hardening = self.hardening?;
        let trial = self.equivalent_stress(deviation);
        if trial <= hardening.yield_stress {
            return None;
        }
        // Without the power, which takes longer than a dozen bonds.
        let stress = |plastic: f64| match hardening.exponent == 1.0 {
            true => (hardening.yield_stress + hardening.hardening * plastic, hardening.hardening),
            false => hardening.stress(plastic),
        };
        if trial <= stress(plastic).0 {
            return None;
        }
        let most = trial / (3.0 * self.shear);
        let (mut low, mut high, mut strain) = (0.0, most, 0.0);
        for _ in 0..ROUNDS {
            let (stress, slope) = stress(plastic + strain);
            let over = trial - 3.0 * self.shear * strain - stress;
            if over.abs() <= ENOUGH * stress {
                break;
            }
            *(if over > 0.0 { &mut low } else { &mut high }) = strain;
            let next = strain + over / (3.0 * self.shear + slope);
            strain = if next > low && next < high { next } else { 0.5 * (low + high) };
        }
        let borne = trial - 3.0 * self.shear * strain;
        let work = 0.5 * (trial + borne) * strain;
        Some(Yielded { left: borne / trial, strain, work })
    }

    /// A return of a point with the deviation Σwz² that goes no further than the limit of plastic
    /// stretch.
    #[must_use]
    pub fn limited(&self, full: Yielded, deviation: f64, flowed: &FlowedSums) -> Yielded {
        let Some(limit) = self.max_plastic_stretch else { return full };
        // Σw(e_p + sz)² is to be γ²/5 at most, s = 1 − r.
        let room = 0.2 * limit * limit - flowed.square;
        let after = |s: f64| s * (2.0 * flowed.product + s * deviation);
        if after(1.0 - full.left) <= room {
            return full;
        }
        let root = (flowed.product * flowed.product + deviation * room).max(0.0).sqrt();
        let share = ((root - flowed.product) / deviation).clamp(0.0, 1.0 - full.left);
        let trial = self.equivalent_stress(deviation);
        let strain = share * trial / (3.0 * self.shear);
        Yielded { left: 1.0 - share, strain, work: trial * (1.0 - 0.5 * share) * strain }
    }
}

#[cfg(test)]
mod tests {
    use super::PeridynamicLaw;
    use cullet_model::Hardening;

    /// What is returned lies on the yield surface, and the work is the energy that went.
    #[test]
    fn what_yields_ends_on_the_surface_and_loses_its_work() {
        for exponent in [0.3, 1.0] {
            let hardening = Hardening { yield_stress: 200e6, hardening: 500e6, exponent };
            let elastic = PeridynamicLaw::elastic(7800.0, 200e9, 0.3);
            let law = PeridynamicLaw { hardening: Some(hardening), ..elastic };
            for (size, plastic) in [(1e-3, 0.0), (1e-2, 0.0), (2e-3, 0.02), (0.1, 1e-3)] {
                let deviation: f64 = size * size;
                let found = law.yields(deviation, plastic).unwrap();
                let after = found.left * found.left * deviation;
                let borne = law.equivalent_stress(after);
                let wanted = hardening.stress(plastic + found.strain).0;
                assert!((borne / wanted - 1.0).abs() < 1e-9, "{size}, {plastic}: {borne}");
                let lost = law.energy(1.0, 0.0, deviation) - law.energy(1.0, 0.0, after);
                assert!((found.work / lost - 1.0).abs() < 1e-9, "{size}, {plastic}: {found:?}");
            }
            assert_eq!(law.yields(1e-10, 0.0), None);
        }
    }
}
