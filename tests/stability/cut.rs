//! Surfaces and cuts: F25, F26, F29 to F33, F35.

use crate::cloud::{Cloud, SETTINGS, cube, is_lawful};
use crate::kit::{cuboid, is_solid};
use cullet_fracture::brittle::grid_bias_warning;
use cullet_fragment::cut::{CutSettings, Partition, by_sites};
use cullet_fragment::pieces::{Ball, Rubble};
use cullet_geometry::door::{DoorError, Repair, admit};
use cullet_geometry::voronoi::{Cells, VoronoiError};
use cullet_geometry::{Solid, Vec3};
use cullet_model::CrackFaceDetail;

fn halved(solid: &Solid, sites: [Vec3; 2]) -> Partition {
    let settings = CutSettings {
        min_volume_ratio: 1e-4,
        max_fragments: 100,
        seed: 3,
        detail: CrackFaceDetail::default(),
    };
    by_sites(solid, &sites, &[0, 1], &[0.0; 2], &settings).expect("a cut")
}

/// F31: a plane that lies in a face, or a billionth of the body beside it, cuts off nothing and
/// loses nothing; and a face that a cut made is no worse for the next.
#[test]
fn f31_cuts_in_a_face_take_nothing_off() {
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

/// F25: sites on a lattice meet by eight, and their cells are refused; shaken, they are cut into as
/// many closed boxes as there are, without faces of no area, and nothing leaks.
#[test]
fn f25_sites_on_a_lattice_are_shaken() {
    let sites: Vec<Vec3> = (0..64)
        .map(|i| Vec3::new(f64::from(i % 4), f64::from(i / 4 % 4), f64::from(i / 16)))
        .map(|at| (at + Vec3::repeat(0.5)) / 4.0 - Vec3::repeat(0.5))
        .collect();
    let cells = Cells::new(sites.clone(), Vec3::repeat(-0.6), Vec3::repeat(0.6)).expect("a box");
    let refused = |i| matches!(cells.cell(i), Err(VoronoiError::Degenerate { .. }));
    assert!((0..64).any(refused), "eight meet at a corner");
    let labels: Vec<u32> = (0..64).collect();
    let cut = by_sites(&cube(), &sites, &labels, &[0.0; 64], &SETTINGS).expect("a cut");
    is_lawful(&cut, 1.0, 0);
    assert_eq!(cut.parts.len(), 64);
    for part in &cut.parts {
        assert!((part.volume * 64.0 - 1.0).abs() < 0.05, "{}", part.volume);
        let mesh = &part.solid.mesh;
        let areas = (0..mesh.triangles.len()).map(|t| {
            let [a, b, c] = mesh.corners(t);
            0.5 * (b - a).cross(&(c - a)).norm()
        });
        assert!(areas.fold(f64::INFINITY, f64::min) > 0.0, "a face without area");
    }
}

/// F26: a crack across the lattice is a smooth face, not a staircase of its cells, whose faces all
/// lie along the grid, as is told; borders of drawn pieces are bent.
#[test]
fn f26_cracks_are_no_staircases() {
    let normal = Vec3::new(1.0, 0.7, 0.5).normalize();
    let lattice: Vec<Vec3> = (0..216)
        .map(|i| Vec3::new(f64::from(i % 6), f64::from(i / 6 % 6), f64::from(i / 36)))
        .map(|at| (at + Vec3::repeat(0.5)) / 6.0 - Vec3::repeat(0.5))
        .collect();
    let sides: Vec<u32> = lattice.iter().map(|x| u32::from(x.dot(&normal) > 0.0)).collect();
    let stairs = by_sites(&cube(), &lattice, &sides, &[0.0; 216], &SETTINGS).expect("a cut");
    let smooth = Cloud::in_cube(0.08, |p| p.dot(&normal).abs() < 0.064).cut();
    let told = |cut: &Partition| grid_bias_warning(cut.parts.iter().map(|part| &part.solid));
    assert!(told(&stairs).is_some_and(|words| words.contains("as often as chance")));
    assert_eq!(told(&smooth), None);
    let flat: Vec3 = crack_normals(&smooth.parts[0].solid).iter().sum();
    let rough = smooth.crack_area / flat.norm();
    let steps = stairs.crack_area / flat.norm();
    assert!(flat.normalize().dot(&normal).abs() > 0.995 && rough < 1.06, "{rough}");
    assert!(steps > 1.3, "stairs have {steps} of the area");

    let ball = |x: f64| Ball::round(Vec3::new(x, 4.0, 4.0), 2.0);
    let rubble = Rubble::new(vec![ball(3.0), ball(5.0)], 4);
    let border: Vec<f64> = (0..50)
        .map(|k| Vec3::new(0.0, 0.16 * f64::from(k), 0.1 * f64::from(k)))
        .map(|x| rubble.crossing(0, 1, &(x + Vec3::x() * 2.0), &(x + Vec3::x() * 6.0)) * 4.0 + 2.0)
        .collect();
    let (low, high) =
        border.iter().fold((8.0_f64, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    assert!(high - low > 0.05 && high - low < 2.0, "a border between {low} and {high} cells");
}

/// Half the cross product of each crack face's edges.
fn crack_normals(solid: &Solid) -> Vec<Vec3> {
    let faces = solid.surface.iter().enumerate().filter(|(_, surface)| surface.is_crack());
    let areas = faces.map(|(t, _)| {
        let [a, b, c] = solid.mesh.corners(t);
        0.5 * (b - a).cross(&(c - a))
    });
    areas.collect()
}

/// F29: a box without a lid is refused by name, or closed with a report.
#[test]
fn f29_an_open_box_is_closed_or_refused() {
    let mut open = cuboid(Vec3::repeat(1.0));
    open.triangles.drain(0..2);
    let refused = admit(&open, Repair::Refuse).map(|_| ());
    assert!(matches!(refused, Err(DoorError::OpenEdges { count: 4, .. })), "{refused:?}");
    let (closed, report) = admit(&open, Repair::Auto).expect("closed");
    is_solid(&closed);
    assert_eq!((report.holes, report.hole_edges), (1, 4));
    assert!((closed.signed_volume() - 1.0).abs() < 1e-12, "{}", closed.signed_volume());
}

/// F30: two boxes that lie in each other are refused by name, or merged with a report, and what
/// they share counts once.
#[test]
fn f30_shells_that_cross_are_merged_or_refused() {
    let mut two = cuboid(Vec3::repeat(1.0));
    two.append(&cuboid(Vec3::repeat(1.0)).translated(Vec3::new(0.5, 0.25, 0.125)));
    assert!((two.signed_volume() - 2.0).abs() < 1e-12, "counted twice");
    let refused = admit(&two, Repair::Refuse).map(|_| ());
    assert!(matches!(refused, Err(DoorError::SelfIntersecting { .. })), "{refused:?}");
    let (merged, report) = admit(&two, Repair::Auto).expect("merged");
    is_solid(&merged);
    let once = 2.0 - 0.5 * 0.75 * 0.875;
    assert!(report.merged_shells && (merged.signed_volume() - once).abs() < 1e-9);
}

/// F32: a lattice of cracks that asks for pieces of a cell and less gives parts that have an
/// inertia.
#[test]
fn f32_parts_are_large_enough_to_have_an_inertia() {
    let h = 0.08;
    let cloud = Cloud::in_cube(h, |p| p.iter().any(|x| ((x + 0.5) / (2.6 * h)).fract() < 0.3));
    let settings = CutSettings { min_volume_ratio: 0.0, max_fragments: 10_000, ..SETTINGS };
    let cut = cloud.cut_of(&cube(), &settings);
    assert!(cut.parts.len() > 20, "{}", cut.parts.len());
    for part in &cut.parts {
        assert!(part.volume > 0.9 * h * h * h, "{} cells", part.volume / (h * h * h));
        let i = part.solid.mesh.mass_properties().inertia.symmetric_eigenvalues();
        let (least, sum) = (i.min(), i.sum());
        assert!(least > 0.0 && sum - i.max() >= i.max() * (1.0 - 1e-9), "{i:?}");
    }
}

/// F33: a ball inside a shell of damage is a part of its own, in a cavity of the rest, and told;
/// with and without relief.
#[test]
fn f33_an_enclosed_part_is_kept_and_told_of() {
    let h = 0.06;
    let cloud = Cloud::in_cube(h, |p| (p.norm() - 0.28).abs() < 0.8 * h);
    for detail in [
        CrackFaceDetail::NONE,
        CrackFaceDetail { height: 0.3, grain: 0.2, ..CrackFaceDetail::NONE },
    ] {
        let cut = cloud.cut_of(&cube(), &CutSettings { detail, ..SETTINGS });
        assert_eq!(cut.parts.len(), 2);
        let ball = 4.0 / 3.0 * std::f64::consts::PI * 0.021952;
        assert!((cut.parts[1].volume - ball).abs() < 0.02, "{}", cut.parts[1].volume);
        assert_eq!(cut.parts[0].solid.mesh.components().len(), 2, "a cavity");
        assert_eq!(cut.warnings, ["1 of the parts are enclosed by others"]);
        assert!(cut.particle_part.contains(&1));
    }
}

/// Mean steps of height over edges along and across the way that a flat crack ran, where damage
/// times mean something from `time_step` \[s\] on.
fn steps(time_step: f64) -> (f64, f64) {
    let h = 0.08;
    let mut cloud = Cloud::in_cube(h, |p| p.z.abs() < 0.8 * h);
    cloud.time_step = time_step;
    let detail = CrackFaceDetail { height: 0.4, ..CrackFaceDetail::NONE };
    let cut = cloud.cut_of(&cube(), &CutSettings { detail, ..SETTINGS });
    assert_eq!(cut.parts.len(), 2);
    let solid = &cut.parts[0].solid;
    let (mut along, mut across) = ((0.0, 0.0), (0.0, 0.0));
    for (t, _) in solid.surface.iter().enumerate().filter(|(_, surface)| surface.is_crack()) {
        let [a, b, c] = solid.mesh.corners(t);
        for (v, w) in [(a, b), (b, c), (c, a)] {
            let way = w - v;
            let sum = if v.xy().amax() > 0.4 {
                continue;
            } else if way.x.abs() > 3.0 * way.y.abs() {
                &mut along
            } else if way.y.abs() > 3.0 * way.x.abs() {
                &mut across
            } else {
                continue;
            };
            *sum = (sum.0 + way.z.abs() / way.norm(), sum.1 + 1.0);
        }
    }
    (along.0 / along.1, across.0 / across.1)
}

/// F35: the gradient of damage times is 1e-5 s/m: taken as a length it would lead no line anywhere.
/// Ridges run along the way of the crack, also beside the band, where no point has a time; where
/// times differ by less than a step there are none.
#[test]
fn f35_chevrons_run_along_the_way_of_the_crack() {
    let (along, across) = steps(1e-9);
    let (still, flat) = steps(1.1e-5 * 0.08);
    println!("{along} along, {across} across; {still} and {flat} without");
    assert!(across > 0.1 && across > 1.5 * along, "along {along}, across {across}");
    assert!(still < 0.02 && flat < 0.02, "along {still}, across {flat}");
}
