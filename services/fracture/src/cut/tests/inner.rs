//! Parts inside others, and parts that are hardly there.

use super::{Cloud, SETTINGS, assert_lawful, cube};
use crate::cut::{CutSettings, extract};
use crate::detail::Detail;
use cullet_geometry::Vec3;

#[test]
fn an_enclosed_part_is_kept_and_told_of() {
    // F33: a ball of whole material inside a shell of damage, with and without relief.
    let h = 0.06;
    let cloud = Cloud::in_cube(h, |p| ((p - Vec3::repeat(0.5)).norm() - 0.28).abs() < 0.8 * h);
    for detail in [Detail::NONE, Detail { height: 0.3, grain: 0.2, ..Detail::NONE }] {
        let settings = CutSettings { detail, ..SETTINGS };
        let partition = extract(&cube(), &cloud.field(), &settings).unwrap();
        assert_lawful(&partition, 1.0, cloud.positions.len());
        let volumes: Vec<f64> = partition.parts.iter().map(|part| part.volume).collect();
        assert_eq!(volumes.len(), 2);
        assert!((volumes[1] - 4.0 / 3.0 * std::f64::consts::PI * 0.021952).abs() < 0.02);
        assert_eq!(partition.parts[0].solid.mesh.components().len(), 2, "a cavity");
        assert_eq!(partition.warnings, ["1 of the parts are enclosed by others"]);
        let inner = partition.particle_part.iter().filter(|&&part| part == 1).count();
        assert!(inner > 0);
    }
}

#[test]
fn parts_are_large_enough_to_have_an_inertia() {
    // F32: a lattice of bands that asks for pieces of a cell and less.
    let h = 0.08;
    let cloud = Cloud::in_cube(h, |p| p.iter().any(|x| (x / (2.6 * h)).fract() < 0.3));
    let settings = CutSettings { min_volume_ratio: 0.0, max_fragments: 10_000, ..SETTINGS };
    let partition = extract(&cube(), &cloud.field(), &settings).unwrap();
    assert_lawful(&partition, 1.0, cloud.positions.len());
    assert!(partition.parts.len() > 20, "{}", partition.parts.len());
    for part in &partition.parts {
        assert!(part.volume > 0.9 * h * h * h, "{} cells", part.volume / (h * h * h));
        let i = part.solid.mesh.mass_properties().inertia.symmetric_eigenvalues();
        let (least, sum) = (i.min(), i.sum());
        assert!(least > 0.0 && sum - i.max() >= i.max() * (1.0 - 1e-9), "{i:?}");
    }
}
