//! What a preset has, and where its values come from.

use crate::sourced::{Kind, Sourced};
use crate::treatment::PresetTreatment;

/// A material that scenes can name without describing it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Preset {
    /// What scenes call it.
    pub name: &'static str,
    /// What exactly it is.
    pub title: &'static str,
    /// Mass density ρ \[kg/m³\].
    pub density: Sourced,
    /// Young's modulus E \[Pa\].
    pub young: Sourced,
    /// Poisson's ratio ν \[1\].
    pub poisson: Sourced,
    /// Tensile strength σ_f \[Pa\].
    pub strength: Sourced,
    /// Mode I fracture energy G_f \[J/m²\].
    pub fracture_energy: Sourced,
    /// Weibull modulus m of the flaws \[1\].
    pub weibull: Sourced,
    /// Speed after over speed before a bounce \[1\].
    pub restitution: Sourced,
    /// Coulomb friction \[1\].
    pub friction: Sourced,
    /// Hardness H: mean pressure at which a contact crushes or yields \[Pa\].
    pub hardness: Sourced,
    /// Whether bodies of it break unless they say otherwise: strikers do not.
    pub breakable: bool,
    /// What was done to it, if it is glass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub treatment: Option<PresetTreatment>,
    /// How it yields, if it is a metal that dents.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plasticity: Option<PresetPlasticity>,
}

/// What a preset has of Johnson and Cook's law beside σ_y = A + Bαⁿ.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PresetFlow {
    /// C \[1\]; ε̇₀ is 1/s.
    pub rate: Sourced,
    /// T_m − T₀ \[K\].
    pub melting: Sourced,
    /// m \[1\].
    pub softening: Sourced,
    /// Heat capacity \[J/(kg K)\].
    pub heat_capacity: Sourced,
    /// D₁ to D₅ \[1\].
    pub failure: [Sourced; 5],
}

/// σ_y = A + Bαⁿ of a preset.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PresetPlasticity {
    /// A \[Pa\].
    pub yield_stress: Sourced,
    /// B \[Pa\].
    pub hardening: Sourced,
    /// n \[1\].
    pub exponent: Sourced,
    /// How it goes by rate and warmth, and tears, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flow: Option<PresetFlow>,
}

pub(super) const DOWLING: &str = "Dowling, Mechanical Behavior of Materials, Table 3.10";
pub(super) const DOWLING_K: &str =
    "G = K²(1-ν²)/E with K_Ic of Dowling, Table 8.2, and a typical ν";
pub(super) const MODEL_CODE: &str = "CEB-FIP Model Code 1990 for C30, 16 mm aggregate";
pub(super) const PETROVIC: &str =
    "Petrovic 2003, J. Mater. Sci. 38: middle of 0.7 to 3.1 MPa at -10 °C";
pub(super) const PETROVIC_K: &str =
    "G = K²(1-ν²)/E with K_Ic 0.1 MPa√m of Petrovic 2003 (0.05 to 0.15)";
pub(super) const TEXTBOOK: &str = "usual textbook value";
pub(super) const STRIKER: &str = "usual textbook value; a striker, not meant to break";
pub(super) const SHEET: &str = "drawing sheet yields at 140 to 240 MPa; no measurement was read";
pub(super) const SCENES: &str = "chosen for scenes; depends on shape, finish and speed";

pub(super) const INDENTED: &str = "hardness by an indenter, as usually quoted; not read here";
pub(super) const STAMPED: &str =
    "by a stamp of millimetres; its minerals have 6 to 8 GPa; no measurement was read";
pub(super) const CUBES: &str =
    "three times the strength of a cube in compression, for what is around holds it";
pub(super) const FLOWS: &str = "three times the flow stress at a strain of 0.08 (Tabor)";

pub(super) const CERAMIC: &str =
    "ceramics scatter with 5 to 20; no measurement of this one was read";
pub(super) const GLASS: &str =
    "annealed glass scatters with 5 to 10, by its surface; no measurement was read";
pub(super) const ROCK: &str = "rocks scatter with 10 to 20; no measurement of this one was read";
pub(super) const TOUGH: &str =
    "tough solids scatter little, above 20; no measurement of this one was read";
pub(super) const WIDE: &str = "scatters widely with grain and bubbles; no measurement was read";

pub(super) const fn measured(value: f64, source: &'static str) -> Sourced {
    Sourced { value, kind: Kind::Measured, source }
}

pub(super) const fn typical(value: f64, source: &'static str) -> Sourced {
    Sourced { value, kind: Kind::Typical, source }
}
