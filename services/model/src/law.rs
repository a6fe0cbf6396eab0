//! How a body's material behaves.

use crate::{Material, StrengthField};

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
    },
}

impl Law {
    /// What it is called in messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Brittle { .. } => "brittle",
        }
    }

    /// Mass density ρ \[kg/m³\].
    #[must_use]
    pub fn density(&self) -> f64 {
        match self {
            Self::Brittle { material, .. } => material.density,
        }
    }
}
