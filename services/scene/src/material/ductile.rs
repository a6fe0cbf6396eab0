//! Presets of what yields: metals, a plastic, wet clay.

use super::preset::{
    FLOWS, Preset, PresetFlow, PresetPlasticity, SCENES, TEXTBOOK, TOUGH, typical,
};
use crate::sourced::Sourced;

const COOK: &str = "as usually quoted of Johnson and Cook's law of 1983; not read here";
const TEAR: &str = "as usually quoted of Johnson and Cook's failure law of 1985; not read here";
const SOFT: &str = "soft metals yield at 5 to 12 MPa; no measurement was read";
const PLASTIC: &str = "yields at 35 to 50 MPa at room temperature; no measurement was read";
const WET: &str = "modelling clay yields at 20 to 100 kPa, by its water; no measurement was read";

const fn hardening(stress: [f64; 3], source: &'static str) -> Option<PresetPlasticity> {
    Some(PresetPlasticity {
        yield_stress: typical(stress[0], source),
        hardening: typical(stress[1], source),
        exponent: typical(stress[2], source),
        flow: None,
    })
}

/// A, B, n; C, T_m − T₀, m, heat capacity; D₁ to D₅.
const fn johnson_cook(
    [yield_stress, modulus, exponent]: [f64; 3],
    [rate, melting, softening, heat_capacity]: [f64; 4],
    [first, second, slope, haste, heat]: [f64; 5],
) -> Option<PresetPlasticity> {
    let failure = [
        typical(first, TEAR),
        typical(second, TEAR),
        typical(slope, TEAR),
        typical(haste, TEAR),
        typical(heat, TEAR),
    ];
    let flow = PresetFlow {
        rate: typical(rate, COOK),
        melting: typical(melting, COOK),
        softening: typical(softening, COOK),
        heat_capacity: typical(heat_capacity, TEXTBOOK),
        failure,
    };
    Some(PresetPlasticity {
        yield_stress: typical(yield_stress, COOK),
        hardening: typical(modulus, COOK),
        exponent: typical(exponent, COOK),
        flow: Some(flow),
    })
}

/// What scatters little and breaks, if at all, long after it has yielded.
const fn ductile(
    (name, title): (&'static str, &'static str),
    [density, young, poisson, strength, fracture_energy]: [Sourced; 5],
    [restitution, friction, hardness]: [f64; 3],
    plasticity: Option<PresetPlasticity>,
) -> Preset {
    Preset {
        name,
        title,
        density,
        young,
        poisson,
        strength,
        fracture_energy,
        weibull: typical(40.0, TOUGH),
        restitution: typical(restitution, SCENES),
        friction: typical(friction, SCENES),
        hardness: typical(hardness, FLOWS),
        breakable: true,
        treatment: None,
        plasticity,
    }
}

pub(super) const ABS: Preset = ductile(
    ("abs", "ABS plastic"),
    [
        typical(1050.0, TEXTBOOK),
        typical(2.2e9, TEXTBOOK),
        typical(0.37, TEXTBOOK),
        typical(4e7, TEXTBOOK),
        typical(3000.0, TEXTBOOK),
    ],
    [0.4, 0.4, 1.22e8],
    hardening([4e7, 1e7, 1.0], PLASTIC),
);

pub(super) const ALUMINIUM_6061: Preset = ductile(
    ("aluminium-6061", "aluminium 6061-T6"),
    [
        typical(2700.0, TEXTBOOK),
        typical(6.9e10, TEXTBOOK),
        typical(0.33, TEXTBOOK),
        typical(3.1e8, TEXTBOOK),
        typical(10000.0, TEXTBOOK),
    ],
    [0.3, 0.4, 1.09e9],
    johnson_cook(
        [3.24e8, 1.14e8, 0.42],
        [0.002, 632.0, 1.34, 896.0],
        [-0.77, 1.45, -0.47, 0.0, 1.6],
    ),
);

pub(super) const ARMOUR_STEEL: Preset = ductile(
    ("armour-steel", "quenched and tempered steel, 4340"),
    [
        typical(7830.0, TEXTBOOK),
        typical(2.05e11, TEXTBOOK),
        typical(0.29, TEXTBOOK),
        typical(1.1e9, TEXTBOOK),
        typical(50000.0, TEXTBOOK),
    ],
    [0.4, 0.4, 3.17e9],
    johnson_cook(
        [7.92e8, 5.1e8, 0.26],
        [0.014, 1500.0, 1.03, 477.0],
        [0.05, 3.44, -2.12, 0.002, 0.61],
    ),
);

pub(super) const CLAY: Preset = ductile(
    ("clay", "wet modelling clay"),
    [
        typical(1800.0, TEXTBOOK),
        typical(6e6, WET),
        typical(0.45, WET),
        typical(40000.0, WET),
        typical(50.0, WET),
    ],
    [0.05, 0.7, 1.04e5],
    hardening([30000.0, 10000.0, 0.3], WET),
);

pub(super) const COPPER: Preset = ductile(
    ("copper", "copper, annealed, oxygen-free"),
    [
        typical(8960.0, TEXTBOOK),
        typical(1.24e11, TEXTBOOK),
        typical(0.34, TEXTBOOK),
        typical(2.2e8, TEXTBOOK),
        typical(1.5e5, TEXTBOOK),
    ],
    [0.3, 0.4, 6.7e8],
    johnson_cook(
        [9e7, 2.92e8, 0.31],
        [0.025, 1063.0, 1.09, 383.0],
        [0.54, 4.89, -3.03, 0.014, 1.12],
    ),
);

pub(super) const LEAD: Preset = ductile(
    ("lead", "lead, soft"),
    [
        typical(11340.0, TEXTBOOK),
        typical(1.6e10, TEXTBOOK),
        typical(0.44, TEXTBOOK),
        typical(1.7e7, TEXTBOOK),
        typical(20000.0, TEXTBOOK),
    ],
    [0.1, 0.5, 5.21e7],
    hardening([8e6, 2e7, 0.3], SOFT),
);
