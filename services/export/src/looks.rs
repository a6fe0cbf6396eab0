//! What bodies and grains look like.

use cullet_geometry::Vec3;
use cullet_record::InteriorLook;
use cullet_record::palette::{self, Rgb};

/// A colour as light: a factor of glTF is linear, a screen's colour is not (IEC 61966-2-1).
pub(crate) fn linear(rgb: Rgb) -> [f32; 3] {
    let light = |c: f32| if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    rgb.map(light)
}

/// How metallic and how rough a sheet is \[1\].
pub(crate) fn finish(metal: bool) -> [f32; 2] {
    if metal { [1.0, 0.35] } else { [0.0, 0.8] }
}

/// What an object's skin and crack faces look like.
pub(crate) struct ObjectLook {
    pub(crate) skin: Rgb,
    pub(crate) crack: Rgb,
    /// Of crack faces \[1\].
    pub(crate) roughness: f32,
}

/// The roughness of crack faces of which the scene says nothing \[1\].
const ROUGH: f32 = 0.9;

/// What an object's skin and crack faces look like; `inside`: where the scene says so.
pub(crate) fn object_look(
    material: &str,
    object: &str,
    fixed: bool,
    inside: Option<&InteriorLook>,
) -> ObjectLook {
    let (skin, crack) = palette::colours(material, object, 0);
    let crack = inside.map_or(crack, |look| look.colour);
    let roughness = inside.map_or(ROUGH, |look| look.roughness);
    ObjectLook { skin: if fixed { palette::FIXED } else { skin }, crack, roughness }
}

/// Corners of a regular icosahedron on the unit sphere, and its faces, counter-clockwise seen from
/// outside: what a grain looks like.
pub(crate) fn icosahedron() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let corner = |i: usize| {
        let (one, phi) = (if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { 1.0 } else { -1.0 });
        let phi = phi * golden;
        let corner = match i / 4 {
            0 => Vec3::new(0.0, one, phi),
            1 => Vec3::new(one, phi, 0.0),
            _ => Vec3::new(phi, 0.0, one),
        };
        corner.normalize()
    };
    let corners: Vec<Vec3> = (0..12).map(corner).collect();
    // Faces are the triples of neighbours: corners whose distance is an edge.
    let edge = |a: usize, b: usize| corners[a].dot(&corners[b]) > 0.4;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in (a + 1..12).filter(|&b| edge(a, b)) {
            for c in (b + 1..12).filter(|&c| edge(a, c) && edge(b, c)) {
                let [p, q, r] = [a, b, c].map(|i| corners[i]);
                let outside = (q - p).cross(&(r - p)).dot(&p) > 0.0;
                let face = if outside { [a, b, c] } else { [a, c, b] };
                faces.push(face.map(|i| i as u32));
            }
        }
    }
    (corners, faces)
}
