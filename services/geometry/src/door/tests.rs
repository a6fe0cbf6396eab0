//! A corpus of bad meshes: each is refused by its name and, where that is possible, repaired.

use super::*;
use crate::mesh::Solid;
use crate::shapes::{Detail, cuboid, cylinder, sphere, torus};

fn unit_box() -> TriMesh {
    cuboid(Vec3::repeat(1.0), Detail::default()).unwrap()
}

fn ball() -> TriMesh {
    sphere(1.0, Detail { segments: 40, edge: None }).unwrap()
}

fn refused(mesh: &TriMesh) -> DoorError {
    admit(mesh, Repair::Refuse).unwrap_err()
}

/// Repairs, and holds the result to what every admitted mesh must be.
fn repaired(mesh: &TriMesh) -> (TriMesh, RepairReport) {
    let (mended, report) = admit(mesh, Repair::Auto).unwrap();
    assert!(mended.is_closed());
    let exact = Exact::new(&Solid::outer(mended.clone())).unwrap();
    assert!(exact.volume() > 0.0 && !exact.crosses_itself().unwrap());
    let again = admit(&mended, Repair::Refuse).map(|(mesh, _)| mesh);
    assert_eq!(again.as_ref().map(|_| ()), Ok(()), "a repaired mesh is not clean");
    assert!(!report.is_clean() || mended == *mesh);
    (mended, report)
}

fn assert_volume(mesh: &TriMesh, volume: f64, tolerance: f64) {
    let error = mesh.signed_volume() / volume - 1.0;
    assert!(error.abs() <= tolerance, "relative volume error {error:e}");
}

#[test]
fn clean_meshes_pass_untouched_at_every_size() {
    for size in [1e-6, 1e-3, 1.0, 1e4] {
        for mesh in [unit_box().scaled(size), ball().scaled(size)] {
            for repair in [Repair::Auto, Repair::Refuse] {
                let (same, report) = admit(&mesh, repair).unwrap();
                assert_eq!(same, mesh);
                assert!(report.is_clean() && report.to_string().starts_with("nothing to repair"));
            }
        }
    }
    for size in [1e-9, 1e9] {
        assert!(matches!(refused(&unit_box().scaled(size)), DoorError::Size { .. }));
    }
}

#[test]
fn loose_triangles_are_welded() {
    let whole = ball();
    let soup = TriMesh {
        vertices: whole.triangles.iter().flatten().map(|&i| whole.vertices[i as usize]).collect(),
        triangles: (0..whole.triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
    };
    let (welded, report) = admit(&soup, Repair::Refuse).unwrap();
    assert!(welded.is_closed() && welded.vertices.len() == whole.vertices.len());
    assert_eq!(report.merged_vertices, soup.vertices.len() - whole.vertices.len());
    // Coordinates that differ in the seventh digit, as text files have them, are sewn.
    let mut torn = soup.clone();
    for (i, p) in torn.vertices.iter_mut().enumerate() {
        p.x += 3e-7 * f64::from(i as u32 % 3);
    }
    assert!(matches!(refused(&torn), DoorError::OpenEdges { .. }));
    let (sewn, report) = repaired(&torn);
    assert_volume(&sewn, whole.signed_volume(), 1e-5);
    assert!(report.moved > 0.0 && report.moved < 2e-6 && report.holes == 0);
}

#[test]
fn inside_out_and_mixed_up_meshes_are_turned() {
    let whole = ball();
    assert!(matches!(refused(&whole.flipped()), DoorError::Inverted { shell: 0, shells: 1, .. }));
    let (turned, report) = repaired(&whole.flipped());
    assert_eq!(turned.signed_volume(), whole.signed_volume());
    assert_eq!(report.flipped, whole.triangles.len());
    let mut mixed = whole.clone();
    mixed.triangles.iter_mut().step_by(7).for_each(|t| t.swap(0, 1));
    assert!(matches!(refused(&mixed), DoorError::NotOriented { .. }));
    let (turned, report) = repaired(&mixed);
    assert_volume(&turned, whole.signed_volume(), 1e-12);
    assert_eq!(report.flipped, whole.triangles.len().div_ceil(7));
}

#[test]
fn holes_are_closed() {
    let whole = unit_box();
    let mut open = whole.clone();
    open.triangles.drain(0..2);
    assert!(matches!(refused(&open), DoorError::OpenEdges { count: 4, .. }));
    let (closed, report) = repaired(&open);
    assert_volume(&closed, 1.0, 1e-12);
    assert_eq!((report.holes, report.hole_edges), (1, 4));
    assert!((report.widest_hole - 2.0_f64.sqrt()).abs() < 1e-12);
    // A ball without its cap, and one without two patches that touch in a vertex.
    let mut bowl = ball();
    let middle =
        |t: &[u32; 3], m: &TriMesh| t.iter().map(|&i| m.vertices[i as usize].z).sum::<f64>() / 3.0;
    let copy = bowl.clone();
    bowl.triangles.retain(|t| middle(t, &copy) < 0.8);
    let (closed, report) = repaired(&bowl);
    assert_eq!(report.holes, 1);
    assert_volume(&closed, whole.signed_volume() * copy.signed_volume() * 0.97, 0.03);
    let mut pierced = copy.clone();
    pierced.triangles.drain(10..11);
    pierced.triangles.drain(200..203);
    let (closed, report) = repaired(&pierced);
    assert!(report.holes >= 2);
    assert_volume(&closed, copy.signed_volume(), 1e-2);
}

#[test]
fn degenerate_and_repeated_triangles_are_dropped() {
    let whole = ball();
    let mut doubled = whole.clone();
    doubled.triangles.extend_from_slice(&whole.triangles[3..8]);
    assert!(matches!(refused(&doubled), DoorError::Duplicate { count: 5, .. }));
    let (single, report) = repaired(&doubled);
    assert_eq!(report.duplicates, 5);
    assert_volume(&single, whole.signed_volume(), 1e-12);

    let mut finned = whole.clone();
    let [a, b, c] = whole.triangles[50];
    finned.vertices.push(whole.vertices[a as usize] * 1.5);
    let tip = finned.vertices.len() as u32 - 1;
    finned.triangles.extend([[b, c, tip], [c, b, tip]]);
    assert!(matches!(refused(&finned), DoorError::Duplicate { .. }));
    let (clean, _) = repaired(&finned);
    assert_volume(&clean, whole.signed_volume(), 1e-12);

    let mut flat = whole.clone();
    flat.triangles.push([a, b, b]);
    assert!(matches!(refused(&flat), DoorError::Degenerate { count: 1, .. }));
    let (clean, report) = repaired(&flat);
    assert_eq!(report.degenerate, 1);
    assert_volume(&clean, whole.signed_volume(), 1e-12);
}

#[test]
fn junctions_are_joined() {
    // A box whose top has a vertex in the middle of an edge that the side does not know of.
    let mut mesh = unit_box();
    let top: Vec<usize> = (0..12).filter(|&t| mesh.corners(t).iter().all(|p| p.z > 0.0)).collect();
    let t = top[0];
    let [a, b, c] = mesh.triangles[t];
    let is_side = |i: u32, j: u32| {
        let d = mesh.vertices[i as usize] - mesh.vertices[j as usize];
        d.norm() < 1.1
    };
    let (i, j, k) = if is_side(a, b) { (a, b, c) } else { (b, c, a) };
    mesh.vertices.push(0.5 * (mesh.vertices[i as usize] + mesh.vertices[j as usize]));
    mesh.triangles[t] = [i, 8, k];
    mesh.triangles.push([8, j, k]);
    assert!(matches!(refused(&mesh), DoorError::OpenEdges { count: 3, .. }));
    let (joined, report) = repaired(&mesh);
    assert_eq!((report.junctions, report.holes), (1, 0));
    assert_volume(&joined, 1.0, 1e-12);
}

#[test]
fn shells_that_cross_are_merged() {
    let mut two = unit_box();
    two.append(&unit_box().translated(Vec3::new(0.5, 0.25, 0.125)));
    match refused(&two) {
        DoorError::SelfIntersecting { count, .. } => assert!(count >= 4, "{count}"),
        other => panic!("{other}"),
    }
    let (merged, report) = repaired(&two);
    assert!(report.merged_shells);
    assert_volume(&merged, 2.0 - 0.5 * 0.75 * 0.875, 1e-12);
}

/// Two boxes whose faces lie in each other cross nowhere; the place that was told was the first
/// vertex of the file.
#[test]
fn shells_that_touch_are_told_where_they_touch() {
    let mut two = unit_box();
    two.append(&unit_box().translated(Vec3::new(1.0, 0.3, 0.3)));
    let DoorError::SelfIntersecting { first, .. } = refused(&two) else {
        panic!("{}", refused(&two));
    };
    assert!((first - Vec3::new(0.5, 0.15, 0.15)).amax() < 0.51 && first.x == 0.5, "{first}");
}

#[test]
fn boxes_that_share_an_edge_or_a_face_become_solids() {
    let mut edge = unit_box();
    edge.append(&unit_box().translated(Vec3::new(1.0, 1.0, 0.0)));
    assert!(admit(&edge, Repair::Refuse).is_ok(), "two closed boxes that touch");
    let (edge, _) = topology::weld(&edge);
    assert!(matches!(refused(&edge), DoorError::NonManifold { count: 1, .. }));
    let (apart, report) = repaired(&edge);
    assert_eq!(report.crowded_edges, 1);
    assert_volume(&apart, 2.0, 1e-12);
    let mut face = unit_box();
    face.append(&unit_box().translated(Vec3::new(1.0, 0.0, 0.0)));
    let (one, _) = repaired(&face);
    assert_volume(&one, 2.0, 1e-12);
    assert_eq!(one.components().len(), 1);
}

#[test]
fn nested_shells_are_cavities_or_swallowed() {
    let small = ball().scaled(0.5);
    let mut hollow = ball();
    hollow.append(&small.flipped());
    let (same, report) = repaired(&hollow);
    assert!(report.is_clean());
    assert_volume(&same, ball().signed_volume() * 0.875, 1e-12);
    let mut filled = ball();
    filled.append(&small);
    assert!(matches!(refused(&filled), DoorError::Inverted { shell: 1, shells: 2, .. }));
    let (whole, report) = repaired(&filled);
    assert_eq!(report.dropped_shells, 1);
    assert_volume(&whole, ball().signed_volume(), 1e-12);
    // The whole file inside out: the outer shell is turned, and the inner one is then in material.
    let (turned, _) = repaired(&filled.flipped());
    assert_volume(&turned, ball().signed_volume() * 0.875, 1e-12);
}

/// Two rooms with one wall between them: three triangles at each of its edges.
fn rooms() -> TriMesh {
    let half = unit_box();
    let mut both = half.clone();
    both.append(&half.translated(Vec3::x()));
    let wall = |t: &usize| {
        let [a, b, c] = both.corners(*t);
        !(t / 12 == 1 && [a, b, c].iter().all(|p| (p.x - 0.5).abs() < 1e-12))
    };
    let kept: Vec<usize> = (0..24).filter(wall).collect();
    topology::weld(&both.submesh(&kept)).0
}

#[test]
fn what_cannot_be_mended_is_made_anew() {
    let walled = rooms();
    assert!(matches!(
        refused(&walled),
        DoorError::OpenEdges { .. } | DoorError::NonManifold { .. }
    ));
    let (mended, report) = repaired(&walled);
    assert!(report.remeshed > 0.0 && report.moved < MOST_MOVED * walled.diagonal(), "{report}");
    assert_volume(&mended, 2.0, 0.05);
    let (ring, edge) = {
        let ring = torus(1.0, 0.3, Detail { segments: 60, edge: None }).unwrap();
        let new = remesh::from_distance(&ring, 100.0).unwrap();
        assert_volume(&new.exact.mesh(), ring.signed_volume(), 0.02);
        (new.exact.to_solid().unwrap().mesh, new.edge)
    };
    assert!(ring.is_closed() && edge < 0.05);
}

/// A fin on the rooms is lost when they are made anew: that moves the surface by its length.
#[test]
fn a_surface_moves_far_only_where_that_is_asked_for() {
    let mut finned = rooms();
    let first = finned.vertices.len() as u32;
    let corners = [[0.0, 0.5, 0.0], [0.4, 0.5, 0.0], [0.2, 0.9, 0.0]];
    finned.vertices.extend(corners.map(Vec3::from));
    finned.triangles.push([first, first + 1, first + 2]);
    match admit(&finned, Repair::Auto).unwrap_err() {
        DoorError::Moved { moved, share, at } => {
            assert!((moved - 0.4).abs() < 0.05 && (share - 0.15).abs() < 0.02, "{moved}, {share}");
            assert!((at - Vec3::new(0.2, 0.9, 0.0)).norm() < 1e-12, "{at}");
        }
        other => panic!("{other}"),
    }
    let (mended, report) = admit(&finned, Repair::Remesh).unwrap();
    assert!(mended.is_closed() && report.moved > 0.3 && report.remeshed > 0.0, "{report}");
}

/// A stray triangle on a closed body takes nothing from it.
#[test]
fn what_is_open_is_mended_apart_from_what_is_closed() {
    let mut walled = unit_box();
    walled.triangles.push([0, 1, 7]);
    let (mended, report) = repaired(&walled);
    assert_eq!(report.remeshed, 0.0, "{report}");
    assert_volume(&mended, 1.0, 1e-12);
    // An open box beside a closed one is given its lid, and they are joined.
    let mut open =
        unit_box().translated(Vec3::new(1.0, 0.3, 0.0)).submesh(&(2..12).collect::<Vec<_>>());
    open.append(&unit_box());
    let (mended, report) = repaired(&open);
    assert_eq!((report.holes, report.remeshed), (1, 0.0), "{report}");
    assert_volume(&mended, 2.0, 1e-4);
}

#[test]
fn what_is_no_solid_is_refused_even_when_asked_to_repair() {
    let auto = |mesh: &TriMesh| admit(mesh, Repair::Auto).unwrap_err();
    let whole = unit_box();
    let one = whole.submesh(&[0]);
    assert_eq!(auto(&one), DoorError::NoVolume);
    assert!(matches!(auto(&TriMesh::default()), DoorError::Mesh(MeshError::Empty { .. })));
    let mut broken = whole.clone();
    broken.vertices[3].z = f64::INFINITY;
    assert!(matches!(auto(&broken), DoorError::Mesh(MeshError::NonFinite { vertex: 3, .. })));
    broken = whole.clone();
    broken.triangles[2][0] = 99;
    assert!(matches!(auto(&broken), DoorError::Mesh(MeshError::IndexOutOfRange { index: 99, .. })));
    let point = TriMesh { vertices: vec![Vec3::x(); 4], triangles: vec![[0, 1, 2], [1, 2, 3]] };
    assert!(matches!(auto(&point), DoorError::Size { .. }));
}

/// The four well-known scans, where `CULLET_MESHES` names a folder that has them.
#[test]
fn well_known_meshes_are_admitted_as_they_deserve() {
    let Some(folder) = std::env::var_os("CULLET_MESHES") else {
        return;
    };
    let expected = [
        ("stanford-bunny.obj", false, 223, 7.5486e-4),
        ("spot.obj", true, 0, 7.1826e-1),
        ("rocker-arm.obj", true, 0, 4.2514e-2),
        ("suzanne.obj", false, 42, 2.1680),
    ];
    for (name, clean, hole_edges, volume) in expected {
        let path = std::path::Path::new(&folder).join(name);
        let Ok(text) = std::fs::read_to_string(path) else {
            continue;
        };
        let mesh = read_obj(&text);
        assert_eq!(admit(&mesh, Repair::Refuse).is_ok(), clean, "{name}");
        let (mended, report) = repaired(&mesh);
        assert_eq!((report.is_clean(), report.hole_edges), (clean, hole_edges), "{name}: {report}");
        assert_volume(&mended, volume, 1e-4);
    }
}

/// Vertices and polygons of a Wavefront OBJ text.
fn read_obj(text: &str) -> TriMesh {
    let mut mesh = TriMesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let c: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
                mesh.vertices.push(Vec3::new(c[0], c[1], c[2]));
            }
            Some("f") => {
                let index = |w: &str| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                let f: Vec<u32> = words.map(index).collect();
                mesh.triangles.extend((1..f.len() - 1).map(|i| [f[0], f[i], f[i + 1]]));
            }
            _ => {}
        }
    }
    mesh
}

#[test]
fn an_assembly_of_parts_that_touch_is_joined_exactly() {
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, 1.1, -0.7);
    let mut all = TriMesh::default();
    let mut sum = 0.0;
    for k in 0..119 {
        let (x, y, z) = (k % 7, (k / 7) % 5, k / 35);
        let mut part = if k % 3 == 0 {
            cylinder(0.5, 1.0, Detail { segments: 40, edge: None }).unwrap()
        } else {
            unit_box()
        };
        sum += part.signed_volume();
        part = part.translated(Vec3::new(x as f64, y as f64 + 0.37 * x as f64, z as f64));
        part.vertices.iter_mut().for_each(|p| *p = turn * *p);
        all.append(&part);
    }
    let (one, report) = repaired(&all);
    assert_eq!(report.remeshed, 0.0, "{report}");
    assert_volume(&one, sum, 1e-4);
    assert!(report.moved < 1e-5 * all.diagonal(), "{report}");
}

/// Four corners, two of them raised: along either diagonal two triangles span them, and along the
/// other one those that close them.
#[test]
fn a_hole_is_never_closed_with_the_triangles_that_it_is_in() {
    let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]];
    let vertices: Vec<Vec3> = vertices.map(Vec3::from).to_vec();
    for triangles in [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]] {
        let sheet = TriMesh { vertices: vertices.clone(), triangles: triangles.to_vec() };
        let (mended, report) = repaired(&sheet);
        assert_eq!((report.holes, report.hole_edges), (1, 4));
        // The tetrahedron of the corners, or the half of it below or above the middle of the rim.
        let whole = 1.0 / 6.0;
        let volume = mended.signed_volume();
        let right = [whole, whole / 2.0].iter().any(|v| (volume / v - 1.0).abs() < 1e-12);
        assert!(right, "{volume}");
    }
}
