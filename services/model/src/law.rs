//! How a body's material behaves.

use crate::{BondedSolid, Hardening, JohnsonCook, Material, StrengthField, SurfaceLaw, Treatment};

/// A constitutive law with its numbers. Further laws will follow: a family refuses those that it
/// does not know.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Law {
    /// Linear elastic until the greatest principal stress reaches σ_f; a crack then takes G_f.
    Brittle {
        /// Elasticity, σ_f and G_f.
        material: Material,
        /// How σ_f varies from place to place.
        strength: StrengthField,
        /// How its surface bears others, and its cracks their sides.
        surface: SurfaceLaw,
    },
    /// The same of a plate of glass that was treated.
    Treated {
        /// Elasticity, σ_f and G_f of the glass itself.
        material: Material,
        /// How σ_f varies from place to place.
        strength: StrengthField,
        /// What was done to it.
        treatment: Treatment,
    },
    /// Linear elastic until it yields: J2 plasticity with isotropic hardening. Nothing cracks.
    Yielding {
        /// Elasticity; σ_f and G_f are not used.
        material: Material,
        /// How it yields.
        hardening: Hardening,
    },
    /// Likewise, by a law that also goes by rate and warmth, and tears.
    JohnsonCook {
        /// Elasticity and G_f; σ_f is not used.
        material: Material,
        /// How it flows and tears.
        flow: JohnsonCook,
    },
    /// Points that are bonded to those around them: elastic, and yielding or breaking as they say.
    Bonded {
        /// Elasticity and G_f; σ_f is not used.
        material: Material,
        /// How bonds yield and break.
        bonds: BondedSolid,
    },
}

impl Law {
    /// That of a brittle solid of which nothing else is known, as strong everywhere.
    #[must_use]
    pub fn even(material: Material) -> Self {
        let (strength, surface) = (StrengthField::even(), SurfaceLaw::of(&material));
        Self::Brittle { material, strength, surface }
    }

    /// What it is called in messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Brittle { .. } => "brittle",
            Self::Treated { treatment, .. } => treatment.kind(),
            Self::Yielding { .. } => "yielding",
            Self::JohnsonCook { .. } => "Johnson-Cook",
            Self::Bonded { .. } => "bonded",
        }
    }

    /// Mass density ρ \[kg/m³\].
    #[must_use]
    pub fn density(&self) -> f64 {
        match self {
            Self::Brittle { material, .. }
            | Self::Treated { material, .. }
            | Self::Yielding { material, .. }
            | Self::JohnsonCook { material, .. }
            | Self::Bonded { material, .. } => material.density,
        }
    }
}
