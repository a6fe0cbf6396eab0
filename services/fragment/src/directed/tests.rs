use super::{PIECES_TOLERANCE, direct};
use crate::cut::{CutSettings, by_sites};
use cullet_geometry::inside::Inside;
use cullet_geometry::math::unit;
use cullet_geometry::shapes::{self, Detail};
use cullet_geometry::{Sheet, Solid, TriMesh, Vec3};
use cullet_model::outcome::{ADDED_CRACK_AREA, CLOSED_CRACK_AREA, FOUND_FRAGMENTS};
use cullet_model::{
    ArtDirection, BodyRegion, CrackFaceDetail, Fragment, FragmentOrigin, Fragmentation, Impact,
    Law, Material, Problem, Settings,
};

/// A pot without a handle: a wall around a cavity.
fn pot() -> TriMesh {
    let profile =
        [[0.0, 0.0], [0.05, 0.0], [0.06, 0.1], [0.054, 0.1], [0.045, 0.006], [0.0, 0.006]];
    shapes::lathe_solid(&profile, Detail::default()).expect("a pot")
}

fn bodies() -> Vec<(&'static str, TriMesh)> {
    let cuboid = |x, y, z| shapes::cuboid(Vec3::new(x, y, z), Detail::default()).expect("a box");
    vec![("cube", cuboid(0.1, 0.1, 0.1)), ("plate", cuboid(0.3, 0.2, 0.008)), ("pot", pot())]
}

fn problem(mesh: &TriMesh) -> Problem {
    let (_, high) = mesh.bounds().expect("a body");
    let material = Material {
        density: 2500.0,
        young: 7e10,
        poisson: 0.2,
        failure_stress: 5e7,
        fracture_energy: 8.0,
    };
    let impact = Impact {
        point: high,
        normal: -Vec3::z(),
        impulse: 1.0,
        duration: 1e-4,
        radius: 1e-3,
        energy: 1.0,
        closing_speed: 1.0,
        crushing_pressure: 1e12,
    };
    Problem {
        body: Solid::outer(mesh.clone()).into(),
        law: Law::even(material),
        impacts: vec![impact],
        supports: Vec::new(),
        spin: Vec3::zeros(),
        settings: Settings::default(),
        seed: 5,
    }
}

/// A body in so many solved fragments, each with a motion of its own.
fn broken(mesh: &TriMesh, count: u64, detail: CrackFaceDetail) -> Fragmentation {
    let (inside, (low, high)) = (Inside::new(mesh), mesh.bounds().expect("a body"));
    let at = |i: u64| Vec3::from_fn(|k, _| low[k] + (high - low)[k] * unit(3, k as u64, i));
    let sites: Vec<Vec3> =
        (0..).map(at).filter(|p| inside.contains(*p)).take(count as usize).collect();
    let labels: Vec<u32> = (0..count as u32).collect();
    let settings = CutSettings { min_volume_ratio: 0.0, max_fragments: 999, seed: 1, detail };
    let solid = Solid::outer(mesh.clone());
    let cut =
        by_sites(&solid, &sites, &labels, &vec![1e-5; sites.len()], &settings).expect("a cut");
    let fragment = |(i, part): (u64, crate::cut::CutPart)| Fragment {
        solid: part.solid,
        hulls: part.hulls,
        velocity: Vec3::from_fn(|k, _| unit(4, k as u64, i) - 0.5),
        spin: Vec3::from_fn(|k, _| 10.0 * unit(6, k as u64, i)),
        sheet: Sheet::default(),
    };
    let fragments: Vec<Fragment> = (0..).zip(cut.parts).map(fragment).collect();
    let origins = vec![FragmentOrigin::Solved; fragments.len()];
    Fragmentation { fragments, origins, ..Fragmentation::default() }
}

fn directed(mesh: &TriMesh, found: &Fragmentation, direction: &ArtDirection) -> Fragmentation {
    direct(found.clone(), &problem(mesh), direction, &|| false).expect("not cancelled")
}

/// Volume, momentum and angular momentum about the origin, at unit density; kinetic energy.
fn sums(fracture: &Fragmentation) -> ([Vec3; 3], f64) {
    let (mut sums, mut energy) = ([Vec3::zeros(); 3], 0.0);
    for Fragment { solid, velocity, spin, .. } in &fracture.fragments {
        let p = solid.mesh.mass_properties();
        sums[0].x += p.volume;
        sums[1] += velocity * p.volume;
        sums[2] += p.centroid.cross(velocity) * p.volume + p.inertia * spin;
        energy += 0.5 * (velocity.norm_squared() * p.volume + spin.dot(&(p.inertia * spin)));
    }
    (sums, energy)
}

/// Half of all faces \[m²\]: half of the body's, and the cracks.
fn half_area(of: &Fragmentation) -> f64 {
    of.fragments.iter().map(|f| f.solid.mesh.area()).sum::<f64>() / 2.0
}

fn count(fracture: &Fragmentation, origin: FragmentOrigin) -> usize {
    fracture.origins.iter().filter(|own| **own == origin).count()
}

/// From few fragments to many and from many to few, on bodies that are stout, thin and hollow.
#[test]
fn as_many_pieces_come_as_are_asked_for() {
    for (name, mesh) in bodies() {
        for found in [2, 5, 40] {
            let body = broken(&mesh, found, CrackFaceDetail::default());
            for wanted in [3, 12, 60] {
                let direction = ArtDirection { pieces: Some(wanted), ..ArtDirection::default() };
                let made = directed(&mesh, &body, &direction);
                let (have, wanted) = (made.fragments.len() as f64, f64::from(wanted));
                let line = format!("{name}: {have} of {wanted}, {} found", body.fragments.len());
                println!("{line}; {:?}", made.report.warnings);
                assert!((have - wanted).abs() <= PIECES_TOLERANCE * wanted, "{line}");
                // Cells in the middle of a body are enclosed, and the cut says so.
                let mut others = made.report.warnings.iter().filter(|w| !w.contains("enclosed"));
                assert_eq!(others.next(), None, "{line}");
                let ((before, full), (after, less)) = (sums(&body), sums(&made));
                for (a, b) in before.iter().zip(&after) {
                    assert!((a - b).norm() <= 1e-9 * a.norm(), "{line}: {a} became {b}");
                }
                assert!(less <= full * (1.0 + 1e-9), "{line}: {full} J became {less} J");
                let [added, closed] = [ADDED_CRACK_AREA, CLOSED_CRACK_AREA]
                    .map(|name| made.report.detail(name).expect("a figure"));
                let (grown, all) = (half_area(&made) - half_area(&body), half_area(&body));
                assert!((grown - added + closed).abs() < 1e-9 * all, "{line}: {grown} m²");
                let cracks = half_area(&made) - 0.5 * mesh.area();
                println!("{line}: {added} of {cracks} m² added, {closed} m² closed");
                assert!(added <= cracks * (1.0 + 1e-9), "{line}: {added} of {cracks} m²");
                assert_eq!(made.report.detail(FOUND_FRAGMENTS), Some(body.fragments.len() as f64));
                assert!(made.fragments.iter().all(|f| f.solid.mesh.is_closed()), "{line}");
            }
        }
    }
}

/// What was neither divided nor joined is as the solver left it, to the bit.
#[test]
fn what_is_not_touched_stays_solved() {
    let (_, mesh) = &bodies()[0];
    let body = broken(mesh, 20, CrackFaceDetail::default());
    let ask = |pieces| directed(mesh, &body, &ArtDirection { pieces, ..ArtDirection::default() });
    let same = ask(Some(body.fragments.len() as u32));
    assert_eq!((&same.fragments, &same.origins), (&body.fragments, &body.origins));
    let more = ask(Some(body.fragments.len() as u32 + 3));
    let (solved, made) =
        (count(&more, FragmentOrigin::Solved), count(&more, FragmentOrigin::Directed));
    assert!(solved >= 14 && (4..=6).contains(&made), "{solved} solved, {made} directed");
    let kept = more.fragments.iter().zip(&more.origins);
    let kept = kept.filter(|(_, origin)| **origin == FragmentOrigin::Solved);
    assert!(kept.into_iter().all(|(fragment, _)| body.fragments.contains(fragment)));
    let (added, closed) =
        (more.report.detail(ADDED_CRACK_AREA), more.report.detail(CLOSED_CRACK_AREA));
    assert!(added > Some(0.0) && closed.is_some_and(|area| area < 1e-12), "{added:?} {closed:?}");
    let fewer = ask(Some(6));
    let closed = fewer.report.detail(CLOSED_CRACK_AREA).expect("a figure");
    let less = half_area(&body) - half_area(&fewer);
    assert!((less - closed).abs() < 1e-9 * half_area(&body), "{closed} m²");
    assert_eq!(more, ask(Some(body.fragments.len() as u32 + 3)), "the same each time");
}

/// Direction does not decide whether a body breaks.
#[test]
fn what_did_not_break_stays_whole() {
    let (_, mesh) = &bodies()[0];
    let mut body = broken(mesh, 2, CrackFaceDetail::default());
    body.fragments.truncate(1);
    body.origins.truncate(1);
    let direction = ArtDirection { pieces: Some(12), ..ArtDirection::default() };
    assert_eq!(directed(mesh, &body, &direction), body);
    let none =
        direct(broken(mesh, 9, CrackFaceDetail::default()), &problem(mesh), &direction, &|| true);
    assert!(none.is_none(), "it was cancelled");
}

fn holder(fracture: &Fragmentation, place: Vec3) -> Vec<usize> {
    let meshes = fracture.fragments.iter().map(|fragment| &fragment.solid.mesh).enumerate();
    meshes.filter(|(_, mesh)| Inside::new(mesh).contains(place)).map(|(k, _)| k).collect()
}

/// Each guide point has a fragment of its own, whether pieces are divided, joined, or left.
#[test]
fn each_guide_point_gets_a_fragment_of_its_own() {
    let mesh = pot();
    // Round the wall, and two in the floor.
    let around = |k: u32| {
        let angle = f64::from(k) * std::f64::consts::TAU / 6.0;
        Vec3::new(0.0535 * libm::cos(angle), 0.0535 * libm::sin(angle), 0.06)
    };
    let mut guides: Vec<Vec3> = (0..6).map(around).collect();
    guides.extend([Vec3::new(0.01, 0.0, 0.003), Vec3::new(-0.01, 0.0, 0.003)]);
    for (found, pieces) in [(3, None), (3, Some(20)), (30, Some(9))] {
        let body = broken(&mesh, found, CrackFaceDetail::default());
        let whole = Vec::new();
        let direction = ArtDirection { pieces, guides: guides.clone(), whole };
        let made = directed(&mesh, &body, &direction);
        let mut holders: Vec<usize> = Vec::new();
        for guide in &guides {
            let own = holder(&made, *guide);
            assert_eq!(own.len(), 1, "{guide} of {found} lies in {own:?}");
            holders.extend(own);
        }
        holders.sort_unstable();
        holders.dedup();
        assert_eq!(
            holders.len(),
            guides.len(),
            "{found} to {pieces:?}: {:?}",
            made.report.warnings
        );
    }
}

/// A region that cracks go through is in one fragment in the end, and that is directed.
#[test]
fn a_part_that_stays_whole_is_in_one_fragment() {
    let mesh = pot();
    let regions = [
        BodyRegion::Ball { centre: Vec3::new(0.055, 0.0, 0.06), radius: 0.015 },
        BodyRegion::Box { low: Vec3::new(-0.04, -0.04, 0.0), high: Vec3::new(0.04, 0.04, 0.004) },
    ];
    let body = broken(&mesh, 40, CrackFaceDetail::default());
    let all = |fracture: &Fragmentation, region: &BodyRegion| {
        let (middle, inside) = (region.middle(), Inside::new(&mesh));
        let at = |i: u64| middle + Vec3::from_fn(|k, _| 0.08 * (unit(9, k as u64, i) - 0.5));
        let within = (0..2000).map(at).filter(|p| region.has(p) && inside.contains(*p));
        let mut own: Vec<usize> = within.flat_map(|p| holder(fracture, p)).collect();
        own.sort_unstable();
        own.dedup();
        own
    };
    for region in regions {
        assert!(all(&body, &region).len() > 1, "cracks go through {region:?}");
        for pieces in [None, Some(12), Some(60)] {
            let direction = ArtDirection { pieces, guides: Vec::new(), whole: vec![region] };
            let made = directed(&mesh, &body, &direction);
            let own = all(&made, &region);
            assert_eq!(own.len(), 1, "{region:?} is in {own:?} of {pieces:?}");
            assert_eq!(made.origins[own[0]], FragmentOrigin::Directed);
            let have = made.fragments.len() as f64;
            let near = pieces.map(f64::from).is_none_or(|n| (have - n).abs() <= 0.2 * n);
            assert!(near, "{have} of {pieces:?}: {:?}", made.report.warnings);
        }
    }
}

/// A ball that reaches nearly to all faces of a cube, and cracks that all go through it: the body
/// stays broken, and the ball in one piece.
#[test]
fn a_region_never_swallows_the_body() {
    let (_, mesh) = &bodies()[0];
    let centre = mesh.mass_properties().centroid;
    let ball = BodyRegion::Ball { centre, radius: 0.045 };
    for (found, pieces) in [(2, None), (3, None), (3, Some(4)), (2, Some(12))] {
        let body = broken(mesh, found, CrackFaceDetail::default());
        let direction = ArtDirection { pieces, guides: Vec::new(), whole: vec![ball] };
        let made = directed(mesh, &body, &direction);
        let have = made.fragments.len();
        assert!(have >= 2, "{found} to {pieces:?}: {have}");
        let near = pieces.is_none_or(|n| (have as f64 - f64::from(n)).abs() <= 0.2 * f64::from(n));
        assert!(near, "{have} of {pieces:?}: {:?}", made.report.warnings);
        let at = |i: u64| centre + Vec3::from_fn(|k, _| 0.09 * (unit(9, k as u64, i) - 0.5));
        let within = (0..500).map(at).filter(|p| ball.has(p));
        let mut own: Vec<usize> = within.flat_map(|p| holder(&made, p)).collect();
        own.sort_unstable();
        own.dedup();
        assert_eq!(own.len(), 1, "the ball is in {own:?} of {have}");
    }
    // Nothing is left beside this one: the pieces are as they were found, and it is said.
    let all = BodyRegion::Ball { centre, radius: 1.0 };
    let body = broken(mesh, 3, CrackFaceDetail::default());
    let direction = ArtDirection { pieces: None, guides: Vec::new(), whole: vec![all] };
    let made = directed(mesh, &body, &direction);
    assert_eq!((&made.fragments, &made.origins), (&body.fragments, &body.origins));
    let said = &made.report.warnings;
    assert!(said.iter().any(|line| line.contains("as found")), "{said:?}");
}

/// Guide points on a square, one in a region and one beside it: each has a fragment of its own.
#[test]
fn guide_points_may_be_symmetric_and_beside_a_region() {
    let (_, mesh) = &bodies()[0];
    let centre = mesh.mass_properties().centroid;
    let at = |x: f64, y: f64| centre + Vec3::new(x, y, 0.0);
    let square = vec![at(0.03, 0.03), at(-0.03, 0.03), at(0.03, -0.03), at(-0.03, -0.03)];
    let ball = BodyRegion::Ball { centre: at(0.02, 0.0), radius: 0.02 };
    let beside = vec![at(0.015, 0.0), at(-0.004, 0.001)];
    for (guides, whole) in [(square, Vec::new()), (beside, vec![ball])] {
        for pieces in [None, Some(8)] {
            let body = broken(mesh, 2, CrackFaceDetail::default());
            let direction = ArtDirection { pieces, guides: guides.clone(), whole: whole.clone() };
            let made = directed(mesh, &body, &direction);
            let mut own: Vec<usize> = guides.iter().flat_map(|p| holder(&made, *p)).collect();
            own.sort_unstable();
            own.dedup();
            assert_eq!(own.len(), guides.len(), "{pieces:?}: {:?}", made.report.warnings);
        }
    }
}
