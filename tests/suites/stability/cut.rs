//! The cut: F31.

use crate::kit::{cuboid, is_solid};
use cullet_fracture::cut::{CutSettings, Partition, by_sites};
use cullet_fracture::detail::Detail;
use cullet_geometry::{Solid, Vec3};

fn halved(solid: &Solid, sites: [Vec3; 2]) -> Partition {
    let settings = CutSettings {
        min_volume_ratio: 1e-4,
        max_fragments: 100,
        seed: 3,
        detail: Detail::default(),
    };
    by_sites(solid, &sites, &[0, 1], &[0.0; 2], &settings).expect("a cut")
}

/// F31: a plane that lies in a face, or a billionth of the body beside it, cuts off nothing and
/// loses nothing; and a face that a cut made is no worse for the next.
#[test]
fn cuts_in_a_face_take_nothing_off() {
    let mut solid = Solid::outer(cuboid(Vec3::repeat(1.0)));
    for generation in 0..10 {
        let (low, high) = solid.mesh.bounds().expect("a body");
        let volume = solid.mesh.signed_volume();
        let axis = generation % 3;
        let unit = Vec3::ith(axis, 1.0);
        let middle = 0.5 * (low + high);
        // Sites on both sides of the face that the last cut made, or of one near it.
        for beside in [0.0, 1e-9, -1e-9, 1e-6, -1e-6] {
            let face = middle + unit * (0.5 * (high - low)[axis] * (1.0 + beside));
            let parts = halved(&solid, [face - 0.3 * unit, face + 0.3 * unit]).parts;
            let sum: f64 = parts.iter().map(|part| part.volume).sum();
            assert_eq!(parts.len(), 1, "generation {generation}, {beside}");
            assert!((sum / volume - 1.0).abs() < 1e-9, "{sum} of {volume}");
        }
        // Across the middle: two halves, the larger goes on.
        let parts = halved(&solid, [middle - 0.3 * unit, middle + 0.3 * unit]).parts;
        let sum: f64 = parts.iter().map(|part| part.volume).sum();
        assert_eq!(parts.len(), 2, "generation {generation}");
        assert!((sum / volume - 1.0).abs() < 1e-9, "{sum} of {volume}");
        parts.iter().for_each(|part| is_solid(&part.solid.mesh));
        solid = parts[0].solid.clone();
    }
}
