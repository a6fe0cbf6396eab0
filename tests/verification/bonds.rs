//! Specimens of the catalogue as points with bonds.

use super::specimens::{bench, metrics, value};

/// What makes a specimen one of bonds.
const BONDS: [&str; 4] = ["--set", "family=peridynamics", "--set", "precision=single"];

/// Runs specimens as bonds, with those overrides, whose expectations decide the exit code.
fn hold(names: &[&str], more: &[&str]) {
    for name in names {
        let said = bench(name, &[&BONDS[..], more].concat());
        assert_eq!(said.code, 0, "{name}\n{}{}", said.stdout, said.stderr);
        assert!(said.stdout.contains(name), "{}", said.stdout);
    }
}

#[test]
fn bonds_turn_without_stress_and_pass_waves_on() {
    hold(&["e2-turn", "e3-fixed-end", "e4-pochhammer"], &["--set", "frames=1"]);
    let told = metrics("e11-conservation", &BONDS);
    assert!(value(&told[0], "momentum drift").abs() < 1e-12);
    assert!(value(&told[0], "energy drift").abs() < 1e-3);
}

/// Bonds stretch a bar of eight rows as they must; bent and twisted its edges are soft.
#[test]
fn bonds_stretch_bend_and_twist_a_bar() {
    hold(&["c9-stretch"], &["--set", "frames=1"]);
    for (name, metric, due, slack) in
        [("c10-bend", "sag", -2.025e-5, 0.1), ("c12-twist", "twist", 2.3119e-3, 0.06)]
    {
        let told = metrics(name, &BONDS);
        let over = value(&told[0], metric) / due;
        assert!((0.97..1.0 + slack).contains(&over), "{name}: {over}");
    }
}

/// Prandtl's pressure under a strip, whatever the horizon; a wide one needs more rows.
#[test]
fn bonds_dent_as_prandtl_says() {
    hold(&["t2-punch"], &["--set", "spacing=0.00166666666666667"]);
}

/// Taylor's bar is not for bonds, and the run says so with the strain and the time.
#[test]
fn bonds_refuse_a_bar_that_is_crushed() {
    let said = bench("t1-taylor", &[&BONDS[..], &["--set", "ends=refused"]].concat());
    assert_eq!(said.code, 0, "{}{}", said.stdout, said.stderr);
    for word in ["at 1.4", "e-6 s, step", "has a plastic strain of 0.30", "take a ductile law"] {
        assert!(said.stdout.contains(word), "{word}: {}", said.stdout);
    }
}

/// Rice's strip: its crack starts from G_f to 1.25 G_f and runs to the end.
#[test]
fn a_strip_between_clamps_tears_when_it_must() {
    hold(&["k6-rice"], &["--set", "frames=1"]);
}

/// K1 within its tolerance, with the horizon of the family.
#[test]
fn an_edge_crack_runs_through_bonds_when_it_must() {
    hold(&["k1-edge-crack"], &["--set", "frames=1", "--set", "spacing=3.5mm"]);
}
