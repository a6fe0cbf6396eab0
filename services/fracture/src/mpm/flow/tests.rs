use super::{FlowLaw, FlowResponse, FlowState};
use crate::mpm::elastic::{LameParameters, green_strain, matrix};
use cullet_geometry::{Mat3, Quat, Vec3};
use cullet_model::{DuctileFailure, Hardening, JohnsonCook, Material};

const STEEL: Material = Material {
    density: 7850.0,
    young: 200e9,
    poisson: 0.3,
    failure_stress: 300e6,
    fracture_energy: 1e5,
};

/// Steel that yields at 300 MPa and hardens by `hardening` \[Pa\], in cells of a millimetre.
fn law(hardening: f64, failure: Option<DuctileFailure>) -> FlowLaw {
    let rule = Hardening { yield_stress: 300e6, hardening, exponent: 1.0 };
    FlowLaw {
        elastic: LameParameters::new(&STEEL),
        rule: JohnsonCook { failure, ..JohnsonCook::from(rule) },
        density: STEEL.density,
        tearing_strain: 2.0 * STEEL.fracture_energy / (300e6 * 1e-3),
    }
}

fn at(law: &FlowLaw, f: &Mat3, state: FlowState) -> FlowResponse {
    law.respond(&green_strain(&(f - Mat3::identity())), state, 1e-6)
}

/// Pulls by the stretch `l` along x, with as much across as leaves no stress there; the stretch
/// across, and what the point bears along x \[Pa\], Kirchhoff's.
fn pulled(law: &FlowLaw, l: f64, state: FlowState) -> (FlowResponse, f64, f64) {
    let (mut low, mut high) = (0.2, 4.0);
    loop {
        let w = 0.5 * (low + high);
        let found = at(law, &Mat3::from_diagonal(&Vec3::new(l, w, w)), state);
        if high - low < 1e-14 {
            return (found, w, l * l * found.stress[0]);
        }
        *(if found.stress[1] >= 0.0 { &mut high } else { &mut low }) = w;
    }
}

/// C6: a plateau, the way back along E, the set that is left; pressure moves nothing.
#[test]
fn a_bar_yields_unloads_and_keeps_its_set() {
    let law = law(0.0, None);
    let mut state = FlowState::default();
    let mut plateau = 0.0;
    for k in 1..=200 {
        let l = 1.0 + 1e-4 * f64::from(k);
        let (found, w, kirchhoff) = pulled(&law, l, state);
        state = found.state;
        plateau = kirchhoff / (l * w * w);
    }
    // Kirchhoff's stress flows, J = 1 + (1 − 2ν) σ/E.
    assert!((plateau / 300e6 - 1.0).abs() < 1e-3, "{plateau} Pa");
    let l = 1.02 * (1.0 - 5e-4);
    let (found, w, kirchhoff) = pulled(&law, l, state);
    assert_eq!(found.state, state, "the way back is elastic");
    let slope = (plateau - kirchhoff / (l * w * w)) / (1.02_f64 / l).ln();
    assert!((slope / 200e9 - 1.0).abs() < 5e-3, "{slope} Pa");
    let mut set = (1.0, 1.02);
    while set.1 - set.0 > 1e-12 {
        let l = 0.5 * (set.0 + set.1);
        *(if pulled(&law, l, state).2 > 0.0 { &mut set.1 } else { &mut set.0 }) = l;
    }
    let wanted = 0.02_f64.ln_1p() - 300e6 / 200e9;
    let left = set.0.ln();
    assert!((left / wanted - 1.0).abs() < 1e-3, "{left}, not {wanted}");
    assert!((state.history.strain / wanted - 1.0).abs() < 1e-3);
    let ball = at(&law, &(Mat3::identity() * 0.98), FlowState::default());
    assert_eq!(ball.state, FlowState::default());
    assert!(ball.stress[0] < -3e9, "ten yield stresses: {}", ball.stress[0]);
}

/// Bars drawn to three times and to a tenth of their length bear the flow stress of their strain,
/// and what flows keeps its volume.
#[test]
fn flow_goes_on_at_any_strain() {
    let law = law(500e6, None);
    for (end, steps) in [(3.0_f64, 600), (0.1, 1200)] {
        let mut state = FlowState::default();
        let mut last = (0.0, 0.0);
        for k in 1..=steps {
            let l = (end.ln() * f64::from(k) / f64::from(steps)).exp();
            let (found, _, kirchhoff) = pulled(&law, l, state);
            state = found.state;
            last = (kirchhoff.abs(), (l.ln().abs() - kirchhoff.abs() / 200e9).abs());
        }
        let (stress, strain) = last;
        assert!((state.history.strain / strain - 1.0).abs() < 2e-3, "{state:?}, {strain}");
        let wanted = 300e6 + 500e6 * strain;
        assert!((stress / wanted - 1.0).abs() < 2e-3, "{stress} Pa, not {wanted}");
        let left = (matrix(&state.flowed) + Mat3::identity()).determinant();
        assert!((left - 1.0).abs() < 1e-9, "{left}");
    }
}

/// What the stress does along any path is what is held and what flow and tearing took.
#[test]
fn the_work_of_a_path_is_held_or_spent() {
    let failure = Some(DuctileFailure { d: [0.1, 0.0, 0.0, 0.0, 0.0] });
    for failure in [None, failure] {
        let law = law(500e6, failure);
        let turn = Quat::from_scaled_axis(Vec3::new(0.9, -0.4, 0.5)).to_rotation_matrix();
        let path = |s: f64| {
            let wave = (9.0 * s).sin();
            let shear = Mat3::new(
                0.25 * s,
                0.5 * wave,
                0.0,
                0.0,
                -0.15 * s,
                0.3 * s,
                0.1 * wave,
                0.0,
                0.02 * s,
            );
            turn.into_inner() * (Mat3::identity() + shear)
        };
        let (mut state, mut work, mut spent, mut torn) = (FlowState::default(), 0.0, 0.0, 0.0);
        let steps = 100_000;
        let mut before = at(&law, &path(0.0), state);
        for k in 1..=steps {
            let [f0, f1] = [k - 1, k].map(|k| path(f64::from(k) / f64::from(steps)));
            let after = at(&law, &f1, state);
            let first = |f: &Mat3, found: &FlowResponse| f * matrix(&found.stress);
            let mean = (first(&f0, &before) + first(&f1, &after)) * 0.5;
            work += mean.component_mul(&(f1 - f0)).sum();
            spent += after.work;
            torn += after.torn;
            state = after.state;
            before = after;
        }
        let held = law.energy(&green_strain(&(path(1.0) - Mat3::identity())), &state);
        let all = held + spent + torn;
        assert!(state.history.strain > 0.5, "{state:?}");
        assert_eq!(state.spent >= 1.0, failure.is_some());
        assert!((work / all - 1.0).abs() < 1e-4, "{work}: held {held}, spent {spent}, torn {torn}");
    }
}

/// A point that has torn bears no tension and all of the pressure.
#[test]
fn what_has_torn_bears_pressure_alone() {
    let law = law(0.0, Some(DuctileFailure { d: [0.01, 0.0, 0.0, 0.0, 0.0] }));
    let mut state = FlowState::default();
    let mut spent = 0.0;
    for k in 1..=20_000 {
        let (found, ..) = pulled(&law, 1.0 + 5e-5 * f64::from(k), state);
        state = found.state;
        spent += found.work;
    }
    assert_eq!(law.damage(&state), 1.0);
    // Up to ε_f, then G_f over the cell: σ_y falls along a straight line.
    let wanted = 300e6 * 0.01 + 1e5 / 1e-3;
    assert!((spent / wanted - 1.0).abs() < 0.02, "{spent} J/m³, not {wanted}");
    let apart = at(&law, &(Mat3::identity() * 1.001), state);
    assert!(apart.stress.iter().all(|s| s.abs() < 1.0), "{:?}", apart.stress);
    let pressed = at(&law, &(Mat3::identity() * 0.999), state);
    assert!(pressed.stress[0] < -4e8, "{:?}", pressed.stress);
}
