//! What the surface of a solid does where it meets another, or its own cracks.

use crate::Material;

/// Hardness over the tensile strength, where none is given: a brittle solid bears ten times its
/// tensile strength in plain compression, and under a ball, held by what is around it, three times
/// that \[Tabor 1951\].
pub const HARDNESS_OVER_STRENGTH: f64 = 30.0;

/// Friction between the sides of a crack, where none is given: that of rock under up to 200 MPa
/// \[Byerlee 1978, from memory\].
pub const CRACK_FRICTION: f64 = 0.85;

/// How surfaces of a solid bear others.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceLaw {
    /// Hardness H: mean pressure at which a contact crushes or yields \[Pa\].
    pub hardness: f64,
    /// Coulomb's coefficient between the sides of a crack μ \[1\].
    pub friction: f64,
}

impl SurfaceLaw {
    /// That of a brittle solid of which nothing else is known: H = 30 σ_f, μ = 0.85.
    #[must_use]
    pub fn of(material: &Material) -> Self {
        Self {
            hardness: HARDNESS_OVER_STRENGTH * material.failure_stress,
            friction: CRACK_FRICTION,
        }
    }
}
