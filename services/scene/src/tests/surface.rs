//! Hardness of materials and friction of their cracks: what is written, what a preset has, and what
//! follows from the rest.

use super::from_text;
use crate::rigid::contact_material;

/// Hardness \[Pa\] and friction \[1\] of a material as the world takes it.
fn surface(material: &str) -> Result<[f64; 2], String> {
    let text = format!(
        "[[material]]\nname = \"own\"\n{material}\n\
         [[body]]\nname = \"cube\"\nmaterial = \"own\"\nposition = [0, 0, 1]\n\
         shape = {{ kind = \"box\", size = [0.1, 0.1, 0.1] }}\n\
         [[body]]\nname = \"floor\"\nshape = {{ kind = \"box\", size = [2, 2, 0.2] }}\n\
         material = \"granite\"\nfixed = true\n"
    );
    let scene = from_text(&text, &[]).map_err(|why| why.to_string())?;
    let cube = scene.bodies.iter().find(|body| body.name == "cube").expect("a cube");
    let surface = contact_material(&cube.material).surface;
    Ok([surface.hardness, surface.friction])
}

#[test]
fn hardness_is_given_or_follows() {
    let own = "density = 1200\nyoung = \"4 GPa\"\npoisson = 0.2\nstrength = \"2 MPa\"\n\
               fracture_energy = 5\n";
    let metal = "density = 8000\nyoung = \"100 GPa\"\npoisson = 0.3\nstrength = \"200 MPa\"\n\
                 fracture_energy = 1e5\nplasticity = { yield_stress = \"100 MPa\", hardening = \
                 \"500 MPa\", exponent = 1 }\n";
    for (material, wanted) in [
        ("preset = \"plaster\"\n".to_owned(), [33e6, 0.85]),
        // A preset keeps what it was measured at, whatever else is written.
        ("preset = \"plaster\"\nstrength = \"1 MPa\"\n".to_owned(), [33e6, 0.85]),
        ("preset = \"plaster\"\nhardness = \"50 MPa\"\n".to_owned(), [50e6, 0.85]),
        ("preset = \"plaster\"\ncrack_friction = 0\n".to_owned(), [33e6, 0.0]),
        (own.to_owned(), [60e6, 0.85]),
        (format!("{own}hardness = 1e8\ncrack_friction = 0.4\n"), [1e8, 0.4]),
        // 3 (100 + 0.08 · 500) MPa.
        (metal.to_owned(), [420e6, 0.85]),
    ] {
        let found = surface(&material).unwrap_or_else(|why| panic!("{material}: {why}"));
        assert!((found[0] / wanted[0] - 1.0).abs() < 1e-12, "{material}: {found:?}");
        assert_eq!(found[1], wanted[1], "{material}");
    }
    for (key, words) in [
        ("hardness = 0", "material.own.hardness: must be above 0"),
        ("hardness = -1e6", "material.own.hardness: must be above 0"),
        ("crack_friction = 11", "material.own.crack_friction: must be at most 10"),
    ] {
        let why = surface(&format!("preset = \"plaster\"\n{key}\n")).expect_err(key);
        assert!(why.contains(words), "{key}: {why}");
    }
}
