use super::{LatticeChoice, LatticeNodes};
use crate::field::DamageField;
use crate::pieces::{Ball, Pieces, Rubble};
use crate::region::terms::ReliefTerms;
use crate::region::{Mosaic, overlap};
use cullet_geometry::boolean::Exact;
use cullet_geometry::math::unit;
use cullet_geometry::voronoi::WALL;
use cullet_geometry::{Vec3, shapes};
use cullet_model::{CrackFaceDetail, Tolerance};

const H: f64 = 0.05;

/// The mosaic of a unit cube, eight particles to a cell, damaged where `damaged` says.
fn mosaic(damaged: impl Fn(Vec3) -> bool) -> (LatticeNodes, Mosaic) {
    let body = shapes::cuboid(Vec3::repeat(1.0), Default::default()).unwrap();
    let n = (2.0 / H).round() as u64;
    let at = |i: u64, k: u64, node: u64| {
        0.5 * H * (node as f64 + 0.5 + 0.6 * (unit(5, k, i) - 0.5)) - 0.5
    };
    let place = |i: u64| Vec3::new(at(i, 0, i % n), at(i, 1, i / n % n), at(i, 2, i / (n * n)));
    let positions: Vec<Vec3> = (0..n * n * n).map(place).collect();
    let damage: Vec<f64> = positions.iter().map(|&p| f64::from(u8::from(damaged(p)))).collect();
    let damage_time: Vec<f64> = positions.iter().map(|p| 1e-5 * (p.x + 1.0)).collect();
    let field = DamageField {
        spacing: H,
        positions: &positions,
        damage: &damage,
        damage_time: &damage_time,
        time_step: 1e-9,
        top_speed: 3000.0,
        scale: Vec3::repeat(1.0),
        normals: None,
        pieces: None,
        scored: &[],
    };
    let mut nodes = LatticeNodes::new(&body, &field, &LatticeChoice::default()).unwrap();
    nodes.fill();
    let mosaic = nodes.mosaic(None);
    (nodes, mosaic)
}

fn terms(detail: CrackFaceDetail) -> ReliefTerms {
    ReliefTerms { detail, spacing: H, time_step: 1e-9, seed: 7 }
}

/// Unit normals and areas of the faces between labels that lie inside the cube.
fn normals(mosaic: &Mosaic) -> Vec<(Vec3, f64)> {
    let mut normals = Vec::new();
    for facet in mosaic.facets.iter().filter(|facet| facet.cells.1 < WALL) {
        for &t in mosaic.of(facet) {
            let [a, b, c] = t.map(|i| mosaic.places[i as usize]);
            let twice = (b - a).cross(&(c - a));
            let sign = if facet.cells.0 < facet.cells.1 { 1.0 } else { -1.0 };
            if (a + b + c).amax() < 3.0 * 0.45 {
                normals.push((sign * twice.normalize(), 0.5 * twice.norm()));
            }
        }
    }
    normals
}

/// The area-weighted mean angle from `expected`, up to sign \[degrees\].
fn spread(normals: &[(Vec3, f64)], expected: Vec3) -> f64 {
    let whole: f64 = normals.iter().map(|n| n.1).sum();
    let angle = |n: &Vec3| libm::acos(n.dot(&expected).abs().min(1.0)).to_degrees();
    normals.iter().map(|(n, area)| angle(n) * area).sum::<f64>() / whole
}

#[test]
fn crack_faces_do_not_show_the_lattice() {
    // F26: planes at many angles; normals follow the plane, not the axes.
    for k in 0..6 {
        let normal = Vec3::from([0, 1, 2].map(|c| unit(31, c, k) - 0.5)).normalize();
        // A ragged band, as a solve leaves it.
        let ragged = |p: Vec3| 0.6 + 0.4 * unit(32, k, (p.sum() + 2.0).to_bits());
        let (_, mosaic) = mosaic(|p| p.dot(&normal).abs() < ragged(p) * H);
        let normals = normals(&mosaic);
        let off = spread(&normals, normal);
        assert!(off < 6.0, "plane {normal:?}: normals {off:.1}° off in the mean");
        let axial = |n: &Vec3| n.amax() > 0.9962;
        let whole: f64 = normals.iter().map(|n| n.1).sum();
        let share = normals.iter().filter(|(n, _)| axial(n)).map(|n| n.1).sum::<f64>() / whole;
        let steep = normal.amax() > libm::cos(20_f64.to_radians());
        assert!(steep || share < 0.02, "plane {normal:?}: {share:.3} along the axes");
    }
}

#[test]
fn smoothing_keeps_volume() {
    // The ball inside a shell of damage: one Laplace step less would show.
    let (nodes, smooth) = mosaic(|p| (p.norm() - 0.3).abs() < 0.8 * H);
    let (raw, _) = nodes.net();
    let labels: Vec<u32> = (0..nodes.labels()).collect();
    let ball = |mosaic: &Mosaic| {
        let sides = mosaic.sides(&labels, labels.len());
        sides.iter().map(|side| mosaic.region(side).0.signed_volume()).fold(1.0, f64::min)
    };
    let ratio = ball(&smooth) / ball(&raw);
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
}

#[test]
fn regions_fill_the_box_without_overlap() {
    // Crossing bands, a shell, and noise with its isolated nodes and pinched edges.
    type Damaged = fn(Vec3) -> bool;
    let noise = |p: Vec3| {
        let key = p.map(|x| (x / (1.4 * H)).floor());
        unit(8, 3, (key.x + 97.0 * key.y + 9409.0 * key.z + 1e6) as u64) < 0.35
    };
    let cases: [(&str, Damaged); 3] = [
        ("bands", |p| p.iter().any(|x| (x - 0.2 * p.sum()).abs() < 0.8 * H)),
        ("shell", |p| (p.norm() - 0.3).abs() < 0.8 * H),
        ("noise", noise),
    ];
    for (name, damaged) in cases {
        let (nodes, mosaic) = mosaic(damaged);
        assert!(overlap::crossing(&mosaic.places, &mosaic.triangles).is_empty(), "{name}");
        let labels: Vec<u32> = (0..nodes.labels()).collect();
        let (mut sum, mut parts) = (0.0, 0);
        for side in mosaic.sides(&labels, labels.len()) {
            let (mesh, names) = mosaic.region(&side);
            let volume = mesh.signed_volume();
            assert!(volume > 0.0, "{name}");
            let exact = Exact::tagged(&mesh, &names).unwrap();
            assert!((exact.volume() - volume).abs() < 1e-12, "{name}");
            assert!(!exact.crosses_itself().unwrap(), "{name}");
            (sum, parts) = (sum + volume, parts + 1);
        }
        assert!(parts > 1, "{name}");
        let (low, high) = cullet_geometry::mesh::bounds(&mosaic.places).unwrap();
        let whole = (high - low).product();
        assert!((sum - whole).abs() < 1e-12 * whole, "{name}: {sum} of {whole}");
    }
}

#[test]
fn smoothing_moves_corners_by_no_more_than_half_a_spacing() {
    let (nodes, smooth) = mosaic(|p| p.iter().any(|x| (x - 0.2 * p.sum()).abs() < 0.8 * H));
    let (raw, _) = nodes.net();
    let moves = smooth.places.iter().zip(&raw.places).map(|(p, q)| (p - q).norm());
    let most = moves.fold(0.0, f64::max);
    assert!(most > 0.05 * H && most <= 0.5 * H, "{}", most / H);
}

const STRONG: CrackFaceDetail = CrackFaceDetail {
    height: 0.5,
    ribs: 0.3,
    grain: 0.4,
    grain_size: 1.0,
    ..CrackFaceDetail::NONE
};

#[test]
fn relief_is_the_same_on_both_sides_and_nothing_overlaps() {
    // F34: one surface, moved once. Bands that meet, with as much relief as a look may ask for.
    let (nodes, flat) = mosaic(|p| p.iter().any(|x| (x - 0.2 * p.sum()).abs() < 0.8 * H));
    let relief = nodes.mosaic(Some(&terms(STRONG)));
    let moved = |places: &[Vec3]| places.iter().filter(|p| !flat.places.contains(p)).count();
    assert!(moved(&relief.places[..flat.places.len()]) > 100);
    assert!(overlap::crossing(&relief.places, &relief.triangles).is_empty());
    let labels: Vec<u32> = (0..nodes.labels()).collect();
    let mut sum = 0.0;
    for side in relief.sides(&labels, labels.len()) {
        let (mesh, names) = relief.region(&side);
        assert!(mesh.signed_volume() > 0.0);
        assert!(!Exact::tagged(&mesh, &names).unwrap().crosses_itself().unwrap());
        sum += mesh.signed_volume();
    }
    let (low, high) = cullet_geometry::mesh::bounds(&flat.places).unwrap();
    let whole = (high - low).product();
    assert!((sum - whole).abs() < 1e-12 * whole, "{sum} of {whole}");
}

#[test]
fn the_front_is_known_beside_the_band_too() {
    // F35: τ = (x + 1) · 1e-5 on a band about z = 0 only; unmasked means pull it to zero off it.
    let (nodes, _) = mosaic(|p| p.z.abs() < 0.8 * H);
    for (x, z) in [(0.0, 0.0), (0.2, 0.3 * H), (-0.3, H)] {
        let front = nodes.front(Vec3::new(x, 0.1, z), 1.0).unwrap();
        let expected = 1e-5 * (x + 1.0);
        assert!((front.time - expected).abs() < 0.01 * H * 1e-5, "{} for {expected}", front.time);
        assert!((front.slope - Vec3::x() * 1e-5).norm() < 0.01e-5, "{:?}", front.slope);
    }
    assert_eq!(nodes.front(Vec3::new(0.0, 0.0, 0.4), 1.0), None);
}

/// Drawn pieces get the finest lattice, unless an error is good enough; others do not.
#[test]
fn the_lattice_is_as_fine_as_the_error_asks() {
    let size = Vec3::repeat(4.0 * H);
    let body = shapes::cuboid(size, shapes::Detail::default()).unwrap();
    let positions: Vec<Vec3> = (0..8)
        .map(|k| H * Vec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
        .collect();
    let fine = |drawn: bool, error: Option<f64>| {
        let ball = |k: f64| Ball::round(Vec3::new(k, 0.5, 0.5), 1.0);
        let balls = if drawn { vec![ball(0.0), ball(1.0)] } else { Vec::new() };
        let of = (0..8).map(|k| Some(k & 1)).collect();
        let (found, rubble) = (if drawn { 0 } else { 2 }, Rubble::new(balls, 1));
        let pieces = Pieces { of, found, rubble, crushed: 0.0, tolerance: Tolerance(error) };
        let field = DamageField {
            spacing: H,
            positions: &positions,
            damage: &[1.0; 8],
            damage_time: &[1e-5; 8],
            time_step: 1e-9,
            top_speed: 3000.0,
            scale: Vec3::repeat(1.0),
            normals: None,
            pieces: Some(&pieces),
            scored: &[],
        };
        (LatticeNodes::new(&body, &field, &LatticeChoice::default()).unwrap().lattice.spacing / H
            * 1e6)
            .round()
            / 1e6
    };
    let asked = [None, Some(0.1), Some(0.5), Some(1.0)];
    assert_eq!(asked.map(|error| fine(true, error)), [0.5, 0.59, 0.8, 0.8]);
    assert_eq!(asked.map(|error| fine(false, error)), [0.7; 4]);
}
