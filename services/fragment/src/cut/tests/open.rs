//! Cracks that end inside a part.

use super::{Cloud, SETTINGS, block, cube, extract};
use crate::cut::{DamageField, OpenCrack, Partition, slit};
use crate::debris::Motes;
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::math::unit;
use cullet_geometry::{Sheet, Solid, Surface, Vec3};
use cullet_model::Fragment;

const H: f64 = 0.06;

fn broken(cloud: &Cloud, normals: Option<&[Vec3]>) -> Partition {
    extract(&cube(), &DamageField { normals, ..cloud.field() }, &SETTINGS).unwrap()
}

/// A cube with a crack from y = 0 to `tip`, tilted about y.
fn notched(tip: f64) -> (Cloud, Vec3) {
    let across = Vec3::new(1.0, 0.0, 0.2).normalize();
    let damaged = move |p: Vec3| (p - Vec3::repeat(0.5)).dot(&across).abs() < 0.8 * H && p.y < tip;
    (Cloud::in_cube(H, damaged), across)
}

fn only(partition: &Partition) -> &OpenCrack {
    assert_eq!(partition.parts.len(), 1);
    let [crack] = &partition.parts[0].cracks[..] else {
        panic!("{} cracks", partition.parts[0].cracks.len());
    };
    crack
}

#[test]
fn a_crack_that_ends_inside_is_a_sheet_that_ends_there() {
    let (cloud, across) = notched(0.6);
    let normals = vec![across; cloud.positions.len()];
    let signs: Vec<Vec3> =
        normals.iter().enumerate().map(|(i, n)| if i % 3 == 0 { -n } else { *n }).collect();
    for normals in [&normals, &signs] {
        let partition = broken(&cloud, Some(normals));
        let sheet = &only(&partition).inside;
        sheet.validate().unwrap();
        // In the middle of the damage, all the way to the tip and to the body's surface.
        let off = sheet.mesh.vertices.iter().map(|p| (p - Vec3::repeat(0.5)).dot(&across).abs());
        let worst = off.fold(0.0, f64::max);
        assert!(worst < 0.35 * H, "{} spacings off", worst / H);
        let tip = sheet.mesh.vertices.iter().map(|p| p.y).fold(0.0, f64::max);
        assert!((tip - 0.6).abs() < 0.8 * H, "{} spacings off the tip", (tip - 0.6) / H);
        let area = 0.6 / across.x;
        assert!((sheet.mesh.area() / area - 1.0).abs() < 0.08, "{}", sheet.mesh.area() / area);
        let surface = Nearest::new(&cube().mesh);
        let (mut outside, mut inside) = (0.0, 0.0);
        for edge in sheet.mesh.open_edges() {
            let [p, q] = edge.map(|v| sheet.mesh.vertices[v as usize]);
            let traced = surface.distance(p).max(surface.distance(q)) < 1e-6;
            *(if traced { &mut outside } else { &mut inside }) += (p - q).norm();
            assert!(traced || p.y > 0.6 - H, "a border inside at {p:?}");
        }
        assert!(outside > 2.1 && outside < 2.4 && inside > 0.9 && inside < 1.3);
        for (p, time) in sheet.mesh.vertices.iter().zip(&sheet.damage_time) {
            let wanted = 1e-6 + 1e-5 * p.x;
            assert!((f64::from(*time) - wanted).abs() < 1.5e-5 * H, "{time} at {p:?}");
        }
    }
}

#[test]
fn a_crack_that_parts_is_no_sheet_and_its_branch_is_one() {
    let through = Cloud::in_cube(H, |p| (p.x - 0.5).abs() < 0.8 * H);
    let normals = vec![Vec3::x(); through.positions.len()];
    let partition = broken(&through, Some(&normals));
    assert_eq!(partition.parts.len(), 2);
    assert!(partition.parts.iter().all(|part| part.cracks.is_empty()));
    let branch = |p: Vec3| (p.y - 0.5).abs() < 0.8 * H && p.x > 0.45 && p.x < 0.8;
    let both = Cloud::in_cube(H, |p| (p.x - 0.45).abs() < 0.8 * H || branch(p));
    let across = |p: &Vec3| if (p.x - 0.45).abs() < 0.8 * H { Vec3::x() } else { Vec3::y() };
    let normals: Vec<Vec3> = both.positions.iter().map(across).collect();
    let partition = broken(&both, Some(&normals));
    assert_eq!(partition.parts.len(), 2);
    let [large, small] = &partition.parts[..] else { panic!() };
    for crack in &small.cracks {
        eprintln!("{} {:?}", crack.inside.mesh.area() / H / H, crack.inside.mesh.bounds());
    }
    assert!(small.cracks.is_empty());
    let [OpenCrack { inside, .. }] = &large.cracks[..] else { panic!("{}", large.cracks.len()) };
    let body = Inside::new(&large.solid.mesh);
    for p in &inside.mesh.vertices {
        assert!((p.y - 0.5).abs() < 0.4 * H, "{p:?}");
        assert!(p.x > 0.45 && p.x < 0.8 + 0.8 * H, "{p:?}");
        assert!(body.contains(*p) || Nearest::new(&large.solid.mesh).distance(*p) < 1e-6);
    }
    let area = inside.mesh.area();
    assert!(area > 0.35 - 2.5 * H && area < 0.35 + H, "{area}");
}

#[test]
fn whole_material_and_crushed_material_have_no_sheets() {
    type Damaged = fn(Vec3) -> bool;
    let cases: [Damaged; 3] = [|_| false, |_| true, |p| (p - Vec3::repeat(0.5)).norm() < 0.3];
    for damaged in cases {
        let cloud = Cloud::in_cube(H, damaged);
        let random = |i: u64| Vec3::new(unit(1, 0, i), unit(1, 1, i), unit(1, 2, i)) * 2.0;
        let random = |i: u64| (random(i) - Vec3::repeat(1.0)).normalize();
        let normals: Vec<Vec3> = (0..cloud.positions.len() as u64).map(random).collect();
        let partition = broken(&cloud, Some(&normals));
        assert!(partition.parts[0].cracks.is_empty());
    }
}

#[test]
fn a_hairline_is_a_slit_and_no_volume_is_lost() {
    let (cloud, across) = notched(0.6);
    let normals = vec![across; cloud.positions.len()];
    let partition = broken(&cloud, Some(&normals));
    let crack = only(&partition);
    let width = 0.05 * H;
    let cut = slit::open(&cube(), &crack.beyond, width, H).unwrap();
    assert!(cut.solid.mesh.is_closed() && cut.kerf.is_closed());
    let (rest, kerf) = (cut.solid.volume(), cut.kerf.signed_volume());
    assert!((rest + kerf - 1.0).abs() < 1e-12, "{rest} + {kerf}");
    let wanted = width * crack.inside.mesh.area();
    assert!((kerf / wanted - 1.0).abs() < 0.08, "{kerf} of {wanted}");
    // Both of its sides are new, and know the same as the sheet.
    let area = cut.solid.crack_area();
    assert!((area / (2.0 * crack.inside.mesh.area()) - 1.0).abs() < 0.08, "{area}");
    for (t, surface) in cut.solid.surface.iter().enumerate() {
        if let Surface::Crack { damage_time, .. } = surface {
            for (time, p) in damage_time.iter().zip(cut.solid.mesh.corners(t)) {
                assert!((f64::from(*time) - 1e-6 - 1e-5 * p.x).abs() < 1.5e-5 * H);
            }
        }
    }
    // The slit is open to three sides of the cube and ends inside.
    let inside = Inside::new(&cut.solid.mesh);
    let at = |y: f64, z: f64| Vec3::new(0.5 - 0.2 * (z - 0.5), y, z);
    let far = Nearest::new(&crack.inside.mesh);
    assert!(inside.contains(at(0.8, 0.5)));
    for (y, z) in [(0.3, 0.5), (0.001, 0.5), (0.3, 0.001), (0.3, 0.999)] {
        let (on, _, _) = far.closest(at(y, z)).unwrap();
        assert!(!inside.contains(on), "closed at {y}, {z}");
    }
}

#[test]
fn a_slit_that_cannot_be_is_refused_with_the_reason() {
    let (cloud, across) = notched(0.6);
    let normals = vec![across; cloud.positions.len()];
    let crack = only(&broken(&cloud, Some(&normals))).clone();
    for width in [0.0, -1.0, f64::NAN, 0.21 * H] {
        let limit = slit::WIDEST * H;
        match slit::open(&cube(), &crack.beyond, width, H) {
            Err(slit::SlitError::Width { limit: told, .. }) => assert_eq!(told, limit),
            other => panic!("{other:?}"),
        }
    }
    // A sheet through the whole body would part it.
    let plane = block(Vec3::new(0.5, -1.0, -1.0), Vec3::new(0.6, 2.0, 2.0));
    let left: Vec<usize> =
        (0..12).filter(|&t| plane.corners(t).iter().all(|p| p.x < 0.55)).collect();
    let mesh = plane.submesh(&left);
    let marks = vec![0.0; mesh.vertices.len()];
    let through = Sheet { mesh, damage_time: marks.clone(), front_speed: marks };
    let parted = slit::open(&cube(), &through, 0.01, 0.1);
    assert!(matches!(parted, Err(slit::SlitError::Parts { count: 2 })), "{parted:?}");
    // One that is folded within its width would cross itself.
    let mut folded = crack.beyond.clone();
    let far = folded.mesh.vertices.iter().map(|p| p.z).fold(0.0, f64::max);
    for p in folded.mesh.vertices.iter_mut().filter(|p| p.z > far - 0.3) {
        p.z = 2.0 * (far - 0.3) - p.z;
    }
    let folded = slit::open(&cube(), &folded, 0.05 * H, H);
    assert!(matches!(folded, Err(slit::SlitError::Crossing { .. })), "{folded:?}");
    let away = slit::open(
        &Solid::outer(cube().mesh.translated(Vec3::repeat(5.0))),
        &crack.beyond,
        0.001,
        H,
    );
    assert_eq!(away, Err(slit::SlitError::Nothing));
}

#[test]
fn a_slit_and_its_dust_move_as_the_fragment_did() {
    let (cloud, across) = notched(0.6);
    let normals = vec![across; cloud.positions.len()];
    let crack = only(&broken(&cloud, Some(&normals))).clone();
    let (velocity, spin) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(30.0, -10.0, 20.0));
    let (solid, hulls, sheet) = (cube(), Vec::new(), crack.inside.clone());
    let mut fragments = [Fragment { solid, hulls, velocity, spin, sheet }];
    let terms = slit::SlitTerms {
        width: 0.1 * H,
        spacing: H,
        grain: 0.5 * H,
        seed: 3,
        motes: &Motes::default(),
    };
    let (dust, warnings) = slit::hairlines(&mut fragments, &[vec![crack]], &terms);
    assert!(warnings.is_empty() && fragments[0].sheet.is_empty() && !dust.is_empty());
    let own = fragments[0].velocity * fragments[0].solid.volume();
    let momentum: Vec3 = dust.iter().map(|grain| grain.velocity * grain.volume).sum();
    assert!((own + momentum - velocity).norm() < 1e-12, "{own} {momentum}");
    assert!((fragments[0].velocity - velocity).norm() > 1e-3, "its centre has moved");
}
