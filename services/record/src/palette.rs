//! Colours: a body looks like its material, its crack faces look like the inside of it, and
//! neighbours of one material still differ a little.

use cullet_geometry::math::scramble;

/// Red, green, blue in \[0, 1\], as a screen shows them.
pub type Rgb = [f32; 3];

/// What a part of a material's name says about its looks: the surface, then the inside.
const LOOKS: &[(&str, Rgb, Rgb)] = &[
    ("glass", [0.46, 0.71, 0.74], [0.83, 0.95, 0.93]),
    ("ice", [0.62, 0.80, 0.90], [0.93, 0.98, 1.00]),
    ("porcelain", [0.91, 0.90, 0.87], [0.80, 0.69, 0.55]),
    ("stoneware", [0.45, 0.53, 0.60], [0.86, 0.72, 0.55]),
    ("plaster", [0.90, 0.87, 0.81], [0.75, 0.66, 0.55]),
    ("brick", [0.60, 0.32, 0.25], [0.86, 0.63, 0.48]),
    ("concrete", [0.60, 0.60, 0.58], [0.83, 0.79, 0.71]),
    ("granite", [0.53, 0.49, 0.50], [0.84, 0.75, 0.72]),
    ("limestone", [0.80, 0.74, 0.61], [0.96, 0.92, 0.83]),
    ("marble", [0.87, 0.87, 0.88], [0.72, 0.73, 0.79]),
    ("pmma", [0.60, 0.76, 0.86], [0.88, 0.96, 1.00]),
    ("alumina", [0.90, 0.88, 0.82], [0.77, 0.69, 0.61]),
    ("steel", [0.36, 0.39, 0.44], [0.66, 0.69, 0.74]),
    ("rubber", [0.20, 0.21, 0.23], [0.42, 0.42, 0.44]),
    ("aluminium", [0.77, 0.78, 0.80], [0.88, 0.89, 0.90]),
    ("aluminum", [0.77, 0.78, 0.80], [0.88, 0.89, 0.90]),
    ("foil", [0.77, 0.78, 0.80], [0.88, 0.89, 0.90]),
    ("paper", [0.82, 0.80, 0.75], [0.90, 0.89, 0.86]),
    ("towel", [0.82, 0.80, 0.75], [0.90, 0.89, 0.86]),
    ("tissue", [0.84, 0.83, 0.80], [0.90, 0.89, 0.86]),
    ("cotton", [0.78, 0.75, 0.69], [0.88, 0.86, 0.82]),
    ("linen", [0.83, 0.78, 0.67], [0.92, 0.88, 0.80]),
    ("cloth", [0.72, 0.33, 0.30], [0.88, 0.70, 0.66]),
    ("latex", [0.80, 0.69, 0.49], [0.90, 0.83, 0.70]),
    ("nori", [0.17, 0.26, 0.16], [0.30, 0.40, 0.26]),
    ("seaweed", [0.17, 0.26, 0.16], [0.30, 0.40, 0.26]),
    ("leaf", [0.33, 0.52, 0.21], [0.60, 0.74, 0.42]),
    ("cork", [0.70, 0.53, 0.36], [0.84, 0.70, 0.52]),
];

/// Parts of the names of metals.
const METALS: &[&str] = &[
    "steel",
    "aluminium",
    "aluminum",
    "foil",
    "copper",
    "brass",
    "bronze",
    "iron",
    "silver",
    "gold",
];

/// For materials of no known look.
const OTHERS: &[(Rgb, Rgb)] = &[
    ([0.80, 0.47, 0.36], [0.96, 0.80, 0.68]),
    ([0.35, 0.56, 0.66], [0.80, 0.90, 0.92]),
    ([0.51, 0.62, 0.41], [0.86, 0.91, 0.76]),
    ([0.79, 0.64, 0.34], [0.97, 0.90, 0.72]),
    ([0.57, 0.46, 0.62], [0.87, 0.80, 0.90]),
];

/// How far two objects of one material may differ in lightness \[1\].
const OBJECT_SPREAD: f32 = 0.09;
/// How far two fragments of one object may differ in lightness \[1\].
const FRAGMENT_SPREAD: f32 = 0.05;

/// The colours of a body: its surface, and its crack faces.
pub fn colours(material: &str, object: &str, id: u64) -> (Rgb, Rgb) {
    let name = material.to_lowercase();
    let known = LOOKS.iter().find(|(part, ..)| name.contains(part));
    let (outer, inner) = known.map_or_else(
        || OTHERS[(text_key(&name) % OTHERS.len() as u64) as usize],
        |&(_, outer, inner)| (outer, inner),
    );
    let shade =
        1.0 + OBJECT_SPREAD * centred(text_key(object)) + FRAGMENT_SPREAD * centred(scramble(id));
    (scale(outer, shade), scale(inner, shade))
}

/// Whether a material of that name shines as metals do.
#[must_use]
pub fn is_metal(material: &str) -> bool {
    let name = material.to_lowercase();
    METALS.iter().any(|part| name.contains(part))
}

/// The colour of a thin crack in a surface of that colour.
pub fn dark(outer: Rgb) -> Rgb {
    scale(outer, 0.22)
}

/// The colour of what nothing moves.
pub const FIXED: Rgb = [0.74, 0.73, 0.70];

fn text_key(text: &str) -> u64 {
    text.bytes().fold(0, |key, byte| scramble(key ^ u64::from(byte)))
}

/// A number in \[-1, 1\] that belongs to `key`.
fn centred(key: u64) -> f32 {
    (key >> 40) as f32 / (1u64 << 23) as f32 - 1.0
}

fn scale(rgb: Rgb, by: f32) -> Rgb {
    rgb.map(|c| (c * by).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_of_sheets_look_like_themselves() {
        let of = |material: &str| colours(material, "sheet", 0).0;
        let spread = |rgb: Rgb| {
            rgb.iter().copied().fold(0.0, f32::max) - rgb.iter().copied().fold(1.0, f32::min)
        };
        let foil = of("aluminium-foil");
        assert!(foil[0] > 0.65 && spread(foil) < 0.06, "{foil:?} is light grey");
        let paper = of("towel");
        assert!(paper[2] > 0.6 && paper[0] > paper[2], "{paper:?} is off-white");
        let rubber = of("rubber");
        assert!(rubber[0] < 0.3 && spread(rubber) < 0.06, "{rubber:?} is dark grey");
        let leaf = of("leaf");
        assert!(leaf[1] > 1.3 * leaf[0] && leaf[1] > 1.3 * leaf[2], "{leaf:?} is green");
        assert!(is_metal("Aluminium-Foil") && !is_metal("alumina") && !is_metal("towel"));
    }
}
