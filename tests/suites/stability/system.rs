//! Units and numbers: F76, F77.

use crate::kit::{STRONG, body, rows};
use cullet_coordinator::scene::{Bundle, SceneFile, load_bundle};
use std::sync::Arc;

/// F76: one number that is none, anywhere in the nodes' motion, is seen.
#[test]
fn one_number_that_is_none_is_seen() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut domain = body(&rows([3, 3, 3]), &STRONG);
        assert!(domain.is_finite());
        let middle = domain.grid.nodes.len() / 2;
        domain.grid.nodes.velocity[middle] = domain.grid.nodes.velocity[middle] * value + value;
        assert!(!domain.is_finite(), "{value}");
        domain.advance();
        assert!(!domain.is_finite(), "{value} after a step");
    }
}

/// What a scene of one body says of a material with that line in it.
fn told(line: &str) -> Result<Vec<String>, String> {
    let text = format!(
        "[[material]]\nname = \"m\"\npreset = \"granite\"\n{line}\n[[body]]\nname = \"b\"\n\
         shape = {{ kind = \"box\", size = [1, 1, 1] }}\nmaterial = \"m\"\n"
    );
    let key = "scene/scene.toml".to_owned();
    let files = vec![SceneFile { key: key.clone(), bytes: Arc::new(text.into_bytes()) }];
    let bundle = Bundle { name: "units".to_owned(), main: key, overrides: Vec::new(), files };
    load_bundle(&bundle).map(|scene| scene.warnings).map_err(|errors| errors.to_string())
}

/// F77: a unit that was mistaken shows in what follows from it: refused where nothing can break
/// so, told where it is only unusual.
#[test]
fn mistaken_units_are_refused_or_told() {
    assert_eq!(told(""), Ok(Vec::new()));
    let kilo = told("strength = \"10 kPa\"").expect_err("too weak");
    assert!(kilo.contains("strength over Young's modulus must lie in [1e-5, 0.1]"), "{kilo}");
    let cases = [
        ("fracture_energy = 0.01", "K_Ic = √(E·G_f) is"),
        ("fracture_energy = 9e6", "K_Ic = √(E·G_f) is"),
        ("density = 2.6", "pressure waves would run at"),
    ];
    for (line, words) in cases {
        let warnings = told(line).unwrap_or_else(|errors| panic!("{line}: {errors}"));
        assert!(warnings.iter().any(|w| w.contains(words)), "{line}: {warnings:?}");
    }
}
