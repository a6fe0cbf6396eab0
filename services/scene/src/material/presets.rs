//! The materials that scenes can name, with a source for every value.

use crate::sourced::{Kind, Sourced};
use crate::treatment::{HEAT_STRENGTHENED, LAMINATED, PresetTreatment, TOUGHENED};

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
    /// Whether bodies of it break unless they say otherwise: strikers do not.
    pub breakable: bool,
    /// What was done to it, if it is glass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub treatment: Option<PresetTreatment>,
    /// How it yields, if it is a metal that dents.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plasticity: Option<PresetPlasticity>,
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
}

const DOWLING: &str = "Dowling, Mechanical Behavior of Materials, Table 3.10";
const DOWLING_K: &str = "G = K²(1-ν²)/E with K_Ic of Dowling, Table 8.2, and a typical ν";
const MODEL_CODE: &str = "CEB-FIP Model Code 1990 for C30, 16 mm aggregate";
const PETROVIC: &str = "Petrovic 2003, J. Mater. Sci. 38: middle of 0.7 to 3.1 MPa at -10 °C";
const PETROVIC_K: &str = "G = K²(1-ν²)/E with K_Ic 0.1 MPa√m of Petrovic 2003 (0.05 to 0.15)";
const TEXTBOOK: &str = "usual textbook value";
const STRIKER: &str = "usual textbook value; a striker, not meant to break";
const SHEET: &str = "drawing sheet yields at 140 to 240 MPa; no measurement was read";
const SCENES: &str = "chosen for scenes; depends on shape, finish and speed";

const CERAMIC: &str = "ceramics scatter with 5 to 20; no measurement of this one was read";
const GLASS: &str = "annealed glass scatters with 5 to 10, by its surface; no measurement was read";
const ROCK: &str = "rocks scatter with 10 to 20; no measurement of this one was read";
const TOUGH: &str = "tough solids scatter little, above 20; no measurement of this one was read";
const WIDE: &str = "scatters widely with grain and bubbles; no measurement was read";

const fn measured(value: f64, source: &'static str) -> Sourced {
    Sourced { value, kind: Kind::Measured, source }
}

const fn typical(value: f64, source: &'static str) -> Sourced {
    Sourced { value, kind: Kind::Typical, source }
}

/// The glass of windows, bottles and treated plates.
const SODA_LIME: Preset = Preset {
    name: "soda-lime-glass",
    title: "soda-lime glass",
    density: measured(2480.0, DOWLING),
    young: measured(74e9, DOWLING),
    poisson: typical(0.23, TEXTBOOK),
    strength: measured(50e6, DOWLING),
    fracture_energy: measured(7.4, DOWLING_K),
    weibull: typical(7.0, GLASS),
    restitution: typical(0.5, SCENES),
    friction: typical(0.3, SCENES),
    breakable: true,
    treatment: None,
    plasticity: None,
};

pub(super) const PRESETS: &[Preset] = &[
    Preset {
        name: "alumina",
        title: "alumina, 99.5 %",
        density: measured(3890.0, DOWLING),
        young: measured(372e9, DOWLING),
        poisson: typical(0.22, TEXTBOOK),
        strength: measured(262e6, DOWLING),
        fracture_energy: measured(40.9, DOWLING_K),
        weibull: typical(10.0, CERAMIC),
        restitution: typical(0.5, SCENES),
        friction: typical(0.4, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "brick",
        title: "fired clay brick",
        density: typical(1900.0, TEXTBOOK),
        young: typical(15e9, TEXTBOOK),
        poisson: typical(0.15, TEXTBOOK),
        strength: typical(2.4e6, TEXTBOOK),
        fracture_energy: typical(80.0, "van der Pluijm: 60 to 130 J/m²; not read here"),
        weibull: typical(8.0, CERAMIC),
        restitution: typical(0.2, SCENES),
        friction: typical(0.65, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "concrete",
        title: "concrete, C30",
        density: typical(2400.0, TEXTBOOK),
        young: typical(33.6e9, MODEL_CODE),
        poisson: typical(0.2, TEXTBOOK),
        strength: typical(2.9e6, MODEL_CODE),
        fracture_energy: typical(76.0, MODEL_CODE),
        weibull: typical(12.0, ROCK),
        restitution: typical(0.2, SCENES),
        friction: typical(0.65, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "granite",
        title: "granite, Westerly",
        density: measured(2640.0, DOWLING),
        young: measured(49.6e9, DOWLING),
        poisson: typical(0.23, TEXTBOOK),
        strength: measured(9.6e6, DOWLING),
        fracture_energy: measured(15.1, DOWLING_K),
        weibull: typical(18.0, ROCK),
        restitution: typical(0.3, SCENES),
        friction: typical(0.6, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "heat-strengthened-glass",
        title: "heat-strengthened soda-lime glass",
        treatment: Some(HEAT_STRENGTHENED),
        ..SODA_LIME
    },
    Preset {
        name: "ice",
        title: "fresh-water ice, -10 °C",
        density: typical(917.0, TEXTBOOK),
        young: typical(9.3e9, TEXTBOOK),
        poisson: typical(0.33, TEXTBOOK),
        strength: measured(1.0e6, PETROVIC),
        fracture_energy: measured(0.96, PETROVIC_K),
        weibull: typical(5.0, WIDE),
        restitution: typical(0.3, SCENES),
        friction: typical(0.05, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "laminated-glass",
        title: "laminated soda-lime glass",
        treatment: Some(LAMINATED),
        ..SODA_LIME
    },
    Preset {
        name: "limestone",
        title: "limestone, dolomitic",
        density: measured(2790.0, DOWLING),
        young: measured(69e9, DOWLING),
        poisson: typical(0.29, TEXTBOOK),
        strength: measured(19.2e6, DOWLING),
        fracture_energy: measured(22.4, DOWLING_K),
        weibull: typical(16.0, ROCK),
        restitution: typical(0.3, SCENES),
        friction: typical(0.6, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "plaster",
        title: "plaster of Paris",
        density: typical(1150.0, TEXTBOOK),
        young: typical(
            4.5e9,
            "depends on porosity: Vekinis, Ashby and Beaumont 1993, not read here",
        ),
        poisson: typical(0.22, TEXTBOOK),
        strength: typical(
            2.5e6,
            "depends on porosity: Vekinis, Ashby and Beaumont 1993, not read here",
        ),
        fracture_energy: typical(
            4.1,
            "depends on porosity: Vekinis, Ashby and Beaumont 1993, not read here",
        ),
        weibull: typical(8.0, CERAMIC),
        restitution: typical(0.2, SCENES),
        friction: typical(0.6, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "mild-steel",
        title: "low-carbon sheet steel, annealed",
        density: typical(7850.0, TEXTBOOK),
        young: typical(205e9, TEXTBOOK),
        poisson: typical(0.29, TEXTBOOK),
        strength: typical(350e6, TEXTBOOK),
        fracture_energy: typical(1.5e5, TEXTBOOK),
        weibull: typical(40.0, TOUGH),
        restitution: typical(0.4, SCENES),
        friction: typical(0.4, SCENES),
        breakable: true,
        treatment: None,
        plasticity: Some(PresetPlasticity {
            yield_stress: typical(200e6, SHEET),
            hardening: typical(400e6, SHEET),
            exponent: typical(0.45, SHEET),
        }),
    },
    Preset {
        name: "pmma",
        title: "PMMA (acrylic glass)",
        density: typical(1190.0, TEXTBOOK),
        young: typical(3.0e9, TEXTBOOK),
        poisson: typical(0.37, TEXTBOOK),
        strength: typical(70e6, TEXTBOOK),
        fracture_energy: measured(932.0, DOWLING_K),
        weibull: typical(20.0, TOUGH),
        restitution: typical(0.5, SCENES),
        friction: typical(0.4, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "porcelain",
        title: "porcelain, zircon",
        density: measured(3600.0, DOWLING),
        young: measured(147e9, DOWLING),
        poisson: typical(0.2, TEXTBOOK),
        strength: measured(56e6, DOWLING),
        fracture_energy: typical(11.0, "G = K²(1-ν²)/E with a typical K_Ic of 1.3 MPa√m"),
        weibull: typical(12.0, CERAMIC),
        restitution: typical(0.4, SCENES),
        friction: typical(0.4, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "rubber",
        title: "natural rubber, filled",
        density: typical(1100.0, STRIKER),
        young: typical(5e6, STRIKER),
        poisson: typical(0.49, STRIKER),
        strength: typical(15e6, STRIKER),
        fracture_energy: typical(1e4, STRIKER),
        weibull: typical(20.0, TOUGH),
        restitution: typical(0.8, SCENES),
        friction: typical(0.9, SCENES),
        breakable: false,
        treatment: None,
        plasticity: None,
    },
    SODA_LIME,
    Preset {
        name: "steel",
        title: "structural steel",
        density: typical(7850.0, STRIKER),
        young: typical(205e9, STRIKER),
        poisson: typical(0.29, STRIKER),
        strength: typical(450e6, STRIKER),
        fracture_energy: typical(2e4, STRIKER),
        weibull: typical(40.0, TOUGH),
        restitution: typical(0.4, SCENES),
        friction: typical(0.4, SCENES),
        breakable: false,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "stoneware",
        title: "stoneware",
        density: typical(2350.0, TEXTBOOK),
        young: typical(65e9, TEXTBOOK),
        poisson: typical(0.2, TEXTBOOK),
        strength: typical(45e6, TEXTBOOK),
        fracture_energy: typical(17.9, "G = K²(1-ν²)/E with a typical K_Ic of 1.1 MPa√m"),
        weibull: typical(9.0, CERAMIC),
        restitution: typical(0.3, SCENES),
        friction: typical(0.5, SCENES),
        breakable: true,
        treatment: None,
        plasticity: None,
    },
    Preset {
        name: "toughened-glass",
        title: "toughened soda-lime glass",
        treatment: Some(TOUGHENED),
        ..SODA_LIME
    },
];
