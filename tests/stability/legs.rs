//! Bodies with legs: a crack in one must not reach the other through the gap (F27).

use crate::cloud::{Cloud, SETTINGS, is_lawful, volumes};
use cullet_fragment::cut::{CutSettings, by_sites};
use cullet_geometry::{Solid, TriMesh, Vec3};

/// A horseshoe: two legs along z, `gap` apart, joined at the top.
fn horseshoe(gap: f64) -> (Solid, impl Fn(Vec3) -> bool) {
    let outline = [
        (0.0, 0.0),
        (0.3, 0.0),
        (0.3, 1.0),
        (0.3 + gap, 1.0),
        (0.3 + gap, 0.0),
        (0.6 + gap, 0.0),
        (0.6 + gap, 1.3),
        (0.0, 1.3),
    ];
    let depth = [0.0, 0.3];
    let vertices =
        depth.iter().flat_map(|&y| outline.iter().map(move |&(x, z)| Vec3::new(x, y, z)));
    let caps = [[0, 1, 2], [0, 2, 7], [2, 3, 6], [2, 6, 7], [3, 4, 5], [3, 5, 6]];
    let mut triangles: Vec<[u32; 3]> = caps.to_vec();
    triangles.extend(caps.map(|[a, b, c]| [a + 8, c + 8, b + 8]));
    for k in 0..8 {
        let n = (k + 1) % 8;
        triangles.extend([[k, k + 8, n], [n, k + 8, n + 8]]);
    }
    let solid = Solid::outer(TriMesh { vertices: vertices.collect(), triangles });
    (solid, move |p: Vec3| p.z > 1.0 || p.x < 0.3 || p.x > 0.3 + gap)
}

/// F27: a crack in one leg is cut through that leg alone.
#[test]
fn f27_a_crack_in_one_leg_leaves_the_other_whole() {
    // The gap of 0.025 lies between two lattice planes.
    for (h, gap) in [(0.047, 0.025), (0.05, 0.06), (0.05, 0.12), (0.05, 0.4)] {
        let (solid, inside) = horseshoe(gap);
        let bounds = (Vec3::zeros(), Vec3::new(0.6 + gap, 0.3, 1.3));
        let low = Cloud::new(h, bounds, &inside, |p| p.x < 0.3 && (p.z - 0.5).abs() < 0.8 * h);
        let partition = low.cut_of(&solid, &SETTINGS);
        let v = volumes(&partition);
        assert_eq!(v.len(), 2, "gap {gap}: {v:?}");
        assert!((v[1] - 0.3 * 0.3 * 0.5).abs() < 0.3 * 0.3 * 0.3 * h, "gap {gap}: {v:?}");
        let right = low.positions.iter().zip(&partition.particle_part).filter(|(p, _)| p.x > 0.3);
        assert!(right.into_iter().all(|(_, &part)| part == 0));
    }
}

/// F32: what a cell takes of the other leg, too small to be a part, is its neighbour's.
#[test]
fn f32_a_sliver_of_the_other_leg_goes_to_its_neighbour() {
    let (solid, _) = horseshoe(0.1);
    // Site 0 sits in the left leg, 1 in the right, but so that cell 0 takes a strip of 0.005 of the
    // right leg; site 2 has the bridge.
    let sites =
        [Vec3::new(0.15, 0.15, 0.3), Vec3::new(0.66, 0.15, 0.3), Vec3::new(0.35, 0.15, 1.3)];
    let whole = solid.mesh.signed_volume();
    let cut = |min_volume_ratio| {
        let settings = CutSettings { min_volume_ratio, max_fragments: 100, ..SETTINGS };
        let partition = by_sites(&solid, &sites, &[0, 1, 2], &[0.0; 3], &settings).expect("a cut");
        is_lawful(&partition, whole, 0);
        partition
    };
    let raw = cut(0.0);
    assert_eq!(raw.parts.len(), 4, "{:?}", volumes(&raw));
    assert!(raw.parts[3].volume < 0.005 * whole);
    let tidy = cut(0.01);
    assert_eq!(tidy.parts.len(), 3, "{:?}", volumes(&tidy));
    assert!(tidy.parts[2].volume > 0.2 * whole && tidy.warnings.is_empty());
}

/// F27: where the cut would come out of the leg and go into the next, what has no damage behind it
/// is mended.
#[test]
fn f27_a_crack_without_damage_behind_it_is_mended() {
    // The right leg is a fin that fits between the lattice planes x = 0.40 and 0.45: it holds no
    // node, so the tip of the cracked left leg is the nearest site to the lower half of the fin.
    let h = 0.05;
    let (mut solid, _) = horseshoe(0.12);
    for p in &mut solid.mesh.vertices {
        p.x = if p.x > 0.5 { 0.44 } else { p.x };
    }
    let inside = cullet_geometry::inside::Inside::new(&solid.mesh);
    let bounds = (Vec3::zeros(), Vec3::new(0.45, 0.3, 1.3));
    let band = |p: Vec3| p.x < 0.3 && (p.z - 0.5).abs() < 0.8 * h;
    let cloud = Cloud::new(h, bounds, |p| inside.contains(p), band);
    let partition = cloud.cut_of(&solid, &SETTINGS);
    let v = volumes(&partition);
    assert_eq!(v.len(), 2, "{v:?}");
    assert!((v[1] - 0.3 * 0.3 * 0.5).abs() < 0.3 * 0.3 * 0.3 * h, "{v:?}");
    assert!(partition.crack_area < 1.15 * 0.3 * 0.3, "{}", partition.crack_area);
}
