//! Bonds of materials that `peridynamics` solves, and bodies that it cannot.

use super::from_text;
use cullet_geometry::Vec3;
use cullet_model::{BondGrain, BondedSolid, DuctileFailure};

/// A plate of a material, above a floor.
fn scene(material: &str, more: &str) -> String {
    format!(
        "[[material]]\nname = \"own\"\n{material}\n\
         [[body]]\nname = \"plate\"\nmaterial = \"own\"\nposition = [0, 0, 1]\n\
         solver = \"peridynamics\"\n\
         shape = {{ kind = \"box\", size = [0.4, 0.3, 0.02] }}\n{more}\n\
         [[body]]\nname = \"floor\"\nshape = {{ kind = \"box\", size = [2, 2, 0.2] }}\n\
         material = \"granite\"\nfixed = true\n"
    )
}

fn bonds(keys: &str) -> BondedSolid {
    let written = format!("preset = \"granite\"\nperidynamics = {{ {keys} }}");
    let scene = from_text(&scene(&written, ""), &[]).unwrap_or_else(|why| panic!("{why}"));
    let plate = scene.bodies.iter().find(|body| body.name == "plate").expect("a plate");
    assert_eq!(plate.solver.name(), Some("peridynamics"));
    plate.material.bonds
}

#[test]
fn bonds_are_as_they_are_written() {
    assert_eq!(bonds(""), BondedSolid::default());
    let all = "breaks = false, dust = 0.5, failure = [0.1, 0.5, -1.5], air = \"5 1/s\", \
               max_plastic_stretch = \"15 %\", friction = 0.2, damping = 0.05, horizon = 2.04, \
               grain = { axis = [0, 3, 4], strength = 2, softness = 0.8 }";
    let axis = Vec3::new(0.0, 0.6, 0.8);
    let wanted = BondedSolid {
        hardening: None,
        breaks: false,
        dust: 0.5,
        failure: Some(DuctileFailure { d: [0.1, 0.5, -1.5, 0.0, 0.0] }),
        max_plastic_stretch: Some(0.15),
        grain: Some(BondGrain { axis, strength: 2.0, stretch: 0.8 }),
        friction: 0.2,
        bond_damping: 0.05,
        air_damping: 5.0,
        horizon: 2.04,
    };
    assert_eq!(bonds(all), wanted);
}

#[test]
fn what_bonds_cannot_do_is_told_with_its_place_and_bound() {
    let granite = |keys: &str| format!("preset = \"granite\"\n{keys}");
    for (material, more, words) in [
        (
            granite("peridynamics = { dust = -1 }"),
            "",
            "material.own.peridynamics.dust: must be at least 0",
        ),
        (
            granite("peridynamics = { horizon = 5 }"),
            "",
            "material.own.peridynamics.horizon: must be at most 4.1",
        ),
        (granite("peridynamics = { dist = 1 }"), "", "dust"),
        (
            granite("peridynamics = { grain = { axis = [0, 0, 0], strength = 2 } }"),
            "",
            "material.own.peridynamics.grain: `axis` must have a length above 1e-6",
        ),
        (
            granite("peridynamics = { failure = [0.1, -0.5, 1.0] }"),
            "",
            "material.own.peridynamics.failure: plastic strain at which bonds break [1] is",
        ),
        (
            granite("weak_plane = { normal = [0, 0, 1], ratio = 0.5 }"),
            "",
            "body.plate.material: `peridynamics` knows no weak plane, but the `grain`",
        ),
        (
            granite("layers = { normal = [0, 0, 1], thickness = 0.01, ratio = 0.5 }"),
            "",
            "body.plate.material: `peridynamics` knows no layers",
        ),
        (
            granite(""),
            "paint = [{ kind = \"sphere\", centre = [0, 0, 0], radius = 0.1, factor = 0.5 }]",
            "body.plate.paint: `peridynamics` knows no painted strength",
        ),
        (
            "preset = \"toughened-glass\"".to_owned(),
            "",
            "body.plate.solver: `peridynamics` takes no toughened glass",
        ),
    ] {
        let told = from_text(&scene(&material, more), &[]).expect_err("refused").to_string();
        assert!(told.contains(words), "{words:?} is not in:\n{told}");
    }
}
