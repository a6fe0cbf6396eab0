mod marks;
mod open;

use super::{CutError, CutSettings, DamageField, Partition, by_sites, extract};
use cullet_geometry::inside::Nearest;
use cullet_geometry::math::unit;
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};
use cullet_model::CrackFaceDetail;

const NO_DETAIL: CrackFaceDetail = CrackFaceDetail::NONE;
const SETTINGS: CutSettings =
    CutSettings { min_volume_ratio: 1e-4, max_fragments: 100, seed: 1, detail: NO_DETAIL };

/// A box from `low` to `high`.
fn block(low: Vec3, high: Vec3) -> TriMesh {
    let corner =
        |i: usize| Vec3::from([0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] }));
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]];
    let triangles = quads.iter().flat_map(halves).collect();
    TriMesh { vertices: (0..8).map(corner).collect(), triangles }
}

fn cube() -> Solid {
    Solid::outer(block(Vec3::zeros(), Vec3::repeat(1.0)))
}

/// A cloud of particles, eight to a cell of `h`, with the damage that `damaged` tells.
struct Cloud {
    h: f64,
    positions: Vec<Vec3>,
    damage: Vec<f64>,
    time: Vec<f64>,
}

impl Cloud {
    fn new(
        h: f64,
        (low, high): (Vec3, Vec3),
        inside: impl Fn(Vec3) -> bool,
        damaged: impl Fn(Vec3) -> bool,
    ) -> Self {
        let step = 0.5 * h;
        let n = (high - low).map(|x| (x / step).round() as u64);
        let mut cloud = Self { h, positions: vec![], damage: vec![], time: vec![] };
        for i in 0..n.x * n.y * n.z {
            let node = [i % n.x, i / n.x % n.y, i / (n.x * n.y)];
            let at = |k: usize| {
                low[k] + step * (node[k] as f64 + 0.5 + 0.5 * (unit(5, k as u64, i) - 0.5))
            };
            let p = Vec3::new(at(0), at(1), at(2));
            if inside(p) {
                cloud.positions.push(p);
                cloud.damage.push(if damaged(p) { 1.0 } else { 0.3 * unit(6, 0, i) });
                cloud.time.push(if damaged(p) { 1e-6 + 1e-5 * p.x.abs() } else { f64::INFINITY });
            }
        }
        cloud
    }

    fn in_cube(h: f64, damaged: impl Fn(Vec3) -> bool) -> Self {
        Self::new(h, (Vec3::zeros(), Vec3::repeat(1.0)), |_| true, damaged)
    }

    fn field(&self) -> DamageField<'_> {
        DamageField {
            spacing: self.h,
            positions: &self.positions,
            damage: &self.damage,
            damage_time: &self.time,
            time_step: 1e-9,
            top_speed: 3000.0,
            scale: Vec3::repeat(1.0),
            normals: None,
            pieces: None,
            scored: &[],
        }
    }
}

/// The laws every partition keeps.
fn assert_lawful(partition: &Partition, whole: f64, particles: usize) {
    let sum: f64 = partition.parts.iter().map(|part| part.volume).sum();
    assert!((sum - whole).abs() <= 1e-9 * whole, "parts sum to {sum}, the body is {whole}");
    for part in &partition.parts {
        assert!(part.volume > 0.0 && part.solid.mesh.is_closed());
        assert_eq!(part.solid.surface.len(), part.solid.mesh.triangles.len());
        assert!(!part.hulls.is_empty() && part.hulls.iter().all(|hull| hull.len() >= 4));
    }
    assert!(partition.parts.windows(2).all(|w| w[0].volume >= w[1].volume));
    assert_eq!(partition.particle_part.len(), particles);
    assert!(partition.particle_part.iter().all(|&p| (p as usize) < partition.parts.len()));
}

fn cut_cube(h: f64, damaged: impl Fn(Vec3) -> bool) -> Partition {
    let cloud = Cloud::in_cube(h, damaged);
    let partition = extract(&cube(), &cloud.field(), &SETTINGS).unwrap();
    assert_lawful(&partition, 1.0, cloud.positions.len());
    partition
}

fn volumes(partition: &Partition) -> Vec<f64> {
    partition.parts.iter().map(|part| part.volume).collect()
}

#[test]
fn a_plane_band_halves_a_cube() {
    for (h, place) in [(0.1, 0.5), (0.1, 0.53), (0.07, 0.47), (0.05, 0.31)] {
        let partition = cut_cube(h, |p| (p.x - place).abs() < 0.75 * h);
        let v = volumes(&partition);
        assert_eq!(v.len(), 2, "h {h} place {place}: {v:?}");
        let expected = if place < 0.5 { 1.0 - place } else { place };
        assert!((v[0] - expected).abs() < 0.3 * h, "h {h} place {place}: {v:?}");
        // A flat cut has area 1; roughness may add a little, and cannot take any away.
        let area = partition.crack_area;
        assert!((1.0 - 1e-9..1.1).contains(&area), "h {h} place {place}: area {area}");
    }
}

#[test]
fn an_oblique_band_is_cut_smoothly() {
    let normal = Vec3::new(1.0, 0.7, 0.4).normalize();
    let h = 0.06;
    let partition = cut_cube(h, |p| (p - Vec3::repeat(0.5)).dot(&normal).abs() < 0.8 * h);
    let v = volumes(&partition);
    assert_eq!(v.len(), 2);
    assert!((v[0] - 0.5).abs() < 0.3 * h, "{v:?}");
    // The plane section of a unit cube through its centre: area = 1/|n_x| for this normal where the
    // section reaches no face across x.
    let mean: Vec3 = partition.parts[0]
        .solid
        .surface
        .iter()
        .enumerate()
        .filter(|(_, s)| matches!(s, Surface::Crack { .. }))
        .map(|(t, _)| {
            let [a, b, c] = partition.parts[0].solid.mesh.corners(t);
            0.5 * (b - a).cross(&(c - a))
        })
        .sum();
    assert!(mean.normalize().dot(&normal).abs() > 0.995, "mean normal {mean:?}");
    let roughness = partition.crack_area / mean.norm();
    assert!(roughness < 1.06, "area over projected area {roughness}");
}

#[test]
fn three_bands_make_octants_and_a_junction_three_sectors() {
    let h = 0.08;
    let octants = cut_cube(h, |p| p.iter().any(|x| (x - 0.5).abs() < 0.8 * h));
    let v = volumes(&octants);
    assert_eq!(v.len(), 8);
    assert!(v.iter().all(|v| (v - 0.125).abs() < 0.15 * h), "{v:?}");
    let sectors = cut_cube(h, |p| {
        let q = p - Vec3::repeat(0.5);
        let rays = [0.3f64, 2.4, 4.5].map(|a| (libm::cos(a), libm::sin(a)));
        rays.iter().any(|&(c, s)| c * q.x + s * q.y > 0.0 && (s * q.x - c * q.y).abs() < 0.8 * h)
    });
    assert_eq!(sectors.parts.len(), 3, "{:?}", volumes(&sectors));
}

#[test]
fn damage_that_separates_nothing_leaves_the_body_untouched() {
    type Damaged = fn(Vec3) -> bool;
    let cases: [(&str, Damaged); 4] = [
        ("none", |_| false),
        ("a crack that ends inside", |p| (p.x - 0.5).abs() < 0.08 && p.y < 0.6),
        ("a blob", |p| (p - Vec3::repeat(0.5)).norm() < 0.3),
        ("everything", |_| true),
    ];
    for (name, damaged) in cases {
        let partition = cut_cube(0.1, damaged);
        assert_eq!(partition.parts.len(), 1, "{name}");
        assert_eq!(partition.parts[0].solid, cube(), "{name}");
        assert_eq!(partition.crack_area, 0.0, "{name}");
    }
}

#[test]
fn a_thick_band_is_cut_in_its_middle() {
    let partition = cut_cube(0.05, |p| (p.z - 0.4).abs() < 0.15);
    let v = volumes(&partition);
    assert_eq!(v.len(), 2);
    assert!((v[0] - 0.6).abs() < 0.02, "{v:?}");
}

#[test]
fn crack_faces_carry_the_time_of_the_damage() {
    let h = 0.08;
    let partition = cut_cube(h, |p| (p.y - 0.5).abs() < 0.8 * h);
    for part in &partition.parts {
        for (t, surface) in part.solid.surface.iter().enumerate() {
            let corners = part.solid.mesh.corners(t);
            let middle = corners.iter().sum::<Vec3>() / 3.0;
            let on_wall = middle.iter().any(|x| x.abs() < 1e-9 || (x - 1.0).abs() < 1e-9);
            match surface {
                Surface::Outer => assert!(on_wall),
                Surface::Crack { damage_time, front_speed, .. } => {
                    assert!(!on_wall);
                    for (time, corner) in damage_time.iter().zip(corners) {
                        let expected = 1e-6 + 1e-5 * corner.x;
                        let error = (f64::from(*time) - expected).abs();
                        assert!(error < 1.5e-5 * h, "{time} at {corner:?}");
                    }
                    // |∇τ| = 1e-5 s/m would be 1e5 m/s: faster than waves, so held to the top.
                    assert_eq!(*front_speed, [3000.0; 3]);
                }
            }
        }
    }
}

#[test]
fn every_particle_is_inside_its_part() {
    let cloud = Cloud::in_cube(0.08, |p| (p.x - 0.4).abs() < 0.06 || (p.y - 0.6).abs() < 0.06);
    let partition = extract(&cube(), &cloud.field(), &SETTINGS).unwrap();
    assert_eq!(partition.parts.len(), 4);
    for (p, &part) in cloud.positions.iter().zip(&partition.particle_part) {
        let mesh = &partition.parts[part as usize].solid.mesh;
        assert!(cullet_geometry::inside::Inside::new(mesh).contains(*p));
    }
}

#[test]
fn small_and_many_parts_are_merged() {
    let h = 0.08;
    let cloud = Cloud::in_cube(h, |p| p.iter().any(|x| (x - 0.3).abs() < 0.8 * h));
    let cut = |min_volume_ratio, max_fragments| {
        let settings = CutSettings { min_volume_ratio, max_fragments, ..SETTINGS };
        let partition = extract(&cube(), &cloud.field(), &settings).unwrap();
        assert_lawful(&partition, 1.0, cloud.positions.len());
        partition.parts.len()
    };
    // Octants of 0.343, 3 × 0.147, 3 × 0.063 and 0.027.
    assert_eq!(cut(1e-3, 100), 8);
    assert_eq!(cut(0.04, 100), 7);
    assert_eq!(cut(1e-3, 5), 5);
    assert_eq!(cut(0.9, 100), 1);
}

#[test]
fn five_generations_stay_closed_and_add_up() {
    let mut parts = vec![cube()];
    for generation in 0..5u64 {
        let mut next = Vec::new();
        for (k, solid) in parts.iter().enumerate() {
            let (low, high) = solid.mesh.bounds().unwrap();
            let at = |i, axis: usize| {
                let u = unit(generation * 1000 + k as u64, axis as u64, i);
                low[axis] + u * (high[axis] - low[axis])
            };
            let sites: Vec<Vec3> =
                (0..4).map(|i| Vec3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
            let settings = CutSettings { min_volume_ratio: 0.0, seed: 3, ..SETTINGS };
            let cut = by_sites(solid, &sites, &[0, 1, 2, 3], &[1e-6; 4], &settings).unwrap();
            assert_lawful(&cut, solid.mesh.signed_volume(), 0);
            next.extend(cut.parts.into_iter().map(|part| part.solid));
        }
        next.truncate(40);
        parts = next;
    }
}

#[test]
fn mass_properties_of_the_parts_add_up_to_the_body() {
    let at = |i, axis| unit(8, axis, i);
    let sites: Vec<Vec3> = (0..64).map(|i| Vec3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
    let labels: Vec<u32> = (0..64).collect();
    let settings = CutSettings { min_volume_ratio: 0.0, ..SETTINGS };
    let cut = by_sites(&cube(), &sites, &labels, &[0.0; 64], &settings).unwrap();
    assert_eq!(cut.parts.len(), 64);
    let (mut first, mut inertia) = (Vec3::zeros(), cullet_geometry::Mat3::zeros());
    for part in &cut.parts {
        let p = part.solid.mesh.mass_properties();
        let arm = p.centroid - Vec3::repeat(0.5);
        first += p.volume * arm;
        // Parallel axes: I = I_c + V (|r|² 1 − r rᵀ).
        let square = cullet_geometry::Mat3::identity() * arm.norm_squared();
        inertia += p.inertia + (square - arm * arm.transpose()) * p.volume;
    }
    // A unit cube of unit density has I = 1/6 about every axis through its centre.
    let error = (inertia - cullet_geometry::Mat3::identity() / 6.0).norm();
    assert!(first.norm() < 1e-12 && error < 1e-12, "{first:?} {error}");
}

#[test]
fn a_hollow_body_is_cut_and_keeps_its_cavity() {
    let (outer, inner) =
        (block(Vec3::zeros(), Vec3::repeat(1.0)), block(Vec3::repeat(0.25), Vec3::repeat(0.75)));
    let mut mesh = outer;
    mesh.vertices.extend(inner.vertices);
    mesh.triangles.extend(inner.triangles.iter().map(|&[a, b, c]| [a + 8, c + 8, b + 8]));
    let solid = Solid::outer(mesh);
    let h = 0.06;
    let inside = |p: Vec3| p.iter().any(|x| (x - 0.5).abs() > 0.25);
    let bounds = (Vec3::zeros(), Vec3::repeat(1.0));
    let cloud = Cloud::new(h, bounds, inside, |p| (p.x - 0.4).abs() < 0.8 * h);
    let partition = extract(&solid, &cloud.field(), &SETTINGS).unwrap();
    assert_lawful(&partition, 0.875, cloud.positions.len());
    assert_eq!(partition.parts.len(), 2);
    // A corner cut off far from the cavity leaves the cavity in the rest.
    let corner = Cloud::new(h, bounds, inside, |p| (p.sum() - 0.5).abs() < 1.2 * h);
    let partition = extract(&solid, &corner.field(), &SETTINGS).unwrap();
    assert_lawful(&partition, 0.875, corner.positions.len());
    assert_eq!(partition.parts.len(), 2);
}

#[test]
fn parts_of_a_cut_body_can_be_cut_again_by_damage() {
    let h = 0.06;
    let first = cut_cube(h, |p| (p.x - 0.4).abs() < 0.8 * h);
    let solid = &first.parts[0].solid;
    let inside = cullet_geometry::inside::Inside::new(&solid.mesh);
    let bounds = solid.mesh.bounds().unwrap();
    let cloud = Cloud::new(h, bounds, |p| inside.contains(p), |p| (p.y - 0.5).abs() < 0.8 * h);
    let again = extract(solid, &cloud.field(), &SETTINGS).unwrap();
    assert_lawful(&again, first.parts[0].volume, cloud.positions.len());
    assert_eq!(again.parts.len(), 2);
    assert!((again.crack_area - 0.6).abs() < 0.08, "new crack {}", again.crack_area);
}

#[test]
fn the_bits_do_not_depend_on_the_number_of_threads() {
    let h = 0.08;
    let cloud = Cloud::in_cube(h, |p| p.iter().any(|x| (x - 0.45 - 0.1 * p.z).abs() < 0.8 * h));
    let cut = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| extract(&cube(), &cloud.field(), &SETTINGS).unwrap())
    };
    let one = cut(1);
    assert!(one.parts.len() >= 6);
    assert_eq!(one, cut(2));
    assert_eq!(one, cut(3));
}

#[test]
fn bad_fields_are_refused() {
    let cloud = Cloud::in_cube(0.2, |_| false);
    let good = cloud.field();
    let refused = |field: DamageField<'_>| extract(&cube(), &field, &SETTINGS).unwrap_err();
    let none = refused(DamageField { positions: &[], ..good });
    assert!(matches!(none, CutError::Lengths { .. }));
    let flat = refused(DamageField { spacing: 0.0, ..good });
    assert!(matches!(flat, CutError::NotFinite { what: "spacing", .. }));
    let fine = refused(DamageField { spacing: 1e-4, ..good });
    assert!(matches!(fine, CutError::TooLarge { .. }));
    let mut damage = cloud.damage.clone();
    damage[7] = f64::NAN;
    let nan = refused(DamageField { damage: &damage, ..good });
    assert_eq!(nan, CutError::NotFinite { what: "damage in [0, 1]", index: 7 });
    let mut open = cube();
    open.mesh.triangles.pop();
    open.surface.pop();
    assert!(matches!(extract(&open, &good, &SETTINGS), Err(CutError::Boolean(_))));
    let greedy = CutSettings { min_volume_ratio: f64::NAN, ..SETTINGS };
    assert!(matches!(extract(&cube(), &good, &greedy), Err(CutError::NotFinite { .. })));
    let uneven = by_sites(&cube(), &[Vec3::repeat(0.5)], &[0, 1], &[0.0], &SETTINGS);
    assert!(matches!(uneven, Err(CutError::Lengths { counts: [1, 2, 1] })));
}

#[test]
fn a_band_on_the_lattice_leaves_no_degenerate_faces() {
    // F25: particles and damage exactly on lattice planes, nothing jittered.
    let h = 0.125;
    let step = 0.5 * h;
    let at = |i: usize| step * (i as f64 + 0.5);
    let grid = (0..16 * 16 * 16).map(|i| Vec3::new(at(i % 16), at(i / 16 % 16), at(i / 256)));
    let positions: Vec<Vec3> = grid.collect();
    let damage: Vec<f64> =
        positions.iter().map(|p| f64::from(u8::from((p.x - 0.5).abs() < h))).collect();
    let time = vec![1e-5; positions.len()];
    let field = DamageField {
        spacing: h,
        positions: &positions,
        damage: &damage,
        damage_time: &time,
        time_step: 1e-9,
        top_speed: 3000.0,
        scale: Vec3::repeat(1.0),
        normals: None,
        pieces: None,
        scored: &[],
    };
    let partition = extract(&cube(), &field, &SETTINGS).unwrap();
    assert_lawful(&partition, 1.0, positions.len());
    assert_eq!(partition.parts.len(), 2);
    assert!((partition.crack_area - 1.0).abs() < 2e-3, "area {}", partition.crack_area);
    assert!((partition.parts[0].volume - 0.5).abs() < 0.1 * h, "{}", partition.parts[0].volume);
    for part in &partition.parts {
        for t in 0..part.solid.mesh.triangles.len() {
            let [a, b, c] = part.solid.mesh.corners(t);
            assert!((b - a).cross(&(c - a)).norm() > 1e-10 * h * h, "a face without area");
        }
    }
}

#[test]
fn parts_with_relief_fit_and_add_up() {
    // F34: every corner of a crack face lies on a face of another part, to rounding.
    let h = 0.08;
    let detail =
        CrackFaceDetail { height: 0.4, ribs: 0.1, grain: 0.3, grain_size: 1.5, ..NO_DETAIL };
    let cloud = Cloud::in_cube(h, |p| p.iter().any(|x| (x - 0.45 - 0.1 * p.z).abs() < 0.8 * h));
    let settings = CutSettings { detail, ..SETTINGS };
    let partition = extract(&cube(), &cloud.field(), &settings).unwrap();
    assert_lawful(&partition, 1.0, cloud.positions.len());
    assert!(partition.parts.len() >= 6);
    let faces: Vec<Nearest> =
        partition.parts.iter().map(|part| Nearest::new(&part.solid.mesh)).collect();
    for (p, part) in partition.parts.iter().enumerate() {
        for (t, _) in part.solid.surface.iter().enumerate().filter(|(_, s)| s.is_crack()) {
            for corner in part.solid.mesh.corners(t) {
                let others = (0..faces.len()).filter(|&q| q != p);
                let gap = others.map(|q| faces[q].distance(corner)).fold(1.0, f64::min);
                assert!(gap < 1e-9, "a gap of {gap} at {corner:?}");
            }
        }
    }
}

#[test]
fn noisy_faces_of_cells_add_up() {
    let at = |i, axis| unit(8, axis, i);
    let sites: Vec<Vec3> = (0..27).map(|i| Vec3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
    let labels: Vec<u32> = (0..27).collect();
    let detail = CrackFaceDetail { edge: 0.6, grain: 0.5, grain_size: 2.0, ..NO_DETAIL };
    let settings = CutSettings { min_volume_ratio: 0.0, detail, ..SETTINGS };
    let cut = by_sites(&cube(), &sites, &labels, &[0.0; 27], &settings).unwrap();
    assert_lawful(&cut, 1.0, 0);
    assert_eq!(cut.parts.len(), 27);
    let flat = by_sites(&cube(), &sites, &labels, &[0.0; 27], &SETTINGS).unwrap();
    assert!(cut.crack_area > 1.03 * flat.crack_area, "{} {}", cut.crack_area, flat.crack_area);
}

#[test]
fn crack_faces_know_how_fast_the_front_was_and_whose_they_are() {
    let h = 0.08;
    let mut cloud = Cloud::in_cube(h, |p| (p.y - 0.5).abs() < 0.8 * h);
    for (time, p) in cloud.time.iter_mut().zip(&cloud.positions) {
        *time = p.x / 800.0;
    }
    let speeds = |scale: Vec3| {
        let partition =
            extract(&cube(), &DamageField { scale, ..cloud.field() }, &SETTINGS).unwrap();
        let cracks = partition.parts.iter().flat_map(|part| part.solid.surface.clone());
        cracks
            .filter_map(|s| match s {
                Surface::Crack { front_speed, parent: 0, .. } => Some(front_speed.map(f64::from)),
                _ => None,
            })
            .flatten()
            .collect::<Vec<f64>>()
    };
    assert!(speeds(Vec3::repeat(1.0)).iter().all(|v| (v / 800.0 - 1.0).abs() < 0.04));
    // A frame squeezed along x: the front ran twice as far in the same time.
    assert!(speeds(Vec3::new(2.0, 1.0, 1.0)).iter().all(|v| (v / 1600.0 - 1.0).abs() < 0.04));
    let mut half = extract(&cube(), &cloud.field(), &SETTINGS).unwrap().parts.swap_remove(0).solid;
    half.name_parent(4);
    let sites = [Vec3::new(0.3, 0.2, 0.5), Vec3::new(0.7, 0.2, 0.5)];
    let again = by_sites(&half, &sites, &[0, 1], &[0.0; 2], &SETTINGS).unwrap();
    for part in &again.parts {
        let area = |wanted: u32| -> f64 {
            let own = |&(_, s): &(usize, &Surface)| match *s {
                Surface::Outer => false,
                Surface::Crack { parent, .. } => parent == wanted,
            };
            let corners = |(t, _)| part.solid.mesh.corners(t);
            let faces = part.solid.surface.iter().enumerate().filter(own).map(corners);
            faces.map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum()
        };
        assert!((area(5) - 0.5).abs() < 0.05 && (area(0) - 0.5).abs() < 0.05);
    }
}

mod grid;
