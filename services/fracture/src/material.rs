//! What a solver needs to know of a material.

/// A brittle, isotropic solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Mass density ρ \[kg/m³\].
    pub density: f64,
    /// Young's modulus E \[Pa\].
    pub young: f64,
    /// Poisson's ratio ν \[1\].
    pub poisson: f64,
    /// Rankine threshold σ_f \[Pa\].
    pub failure_stress: f64,
    /// Mode I fracture energy G_f \[J/m²\].
    pub fracture_energy: f64,
}
