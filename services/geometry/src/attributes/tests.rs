//! Cuts through surfaces whose attributes are known at every place.

use super::{AttributeError, AttributeTransfer, SkinTriangle, SurfaceAttributes, SurfaceMaterial};
use crate::boolean::Exact;
use crate::door::{Repair, admit};
use crate::math::{Vec3, unit};
use crate::mesh::{Solid, Surface, TriMesh};
use crate::shapes::{Detail, sphere};
use std::collections::BTreeMap;

/// Quads along each edge of the cube.
const QUADS: u32 = 4;

/// The texture coordinates of a point on the face of a cube of edge 1 that looks along `axis`:
/// each face has its place in an atlas, and its own slope.
fn atlas(p: Vec3, axis: usize, side: f64) -> [f64; 2] {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (column, row) = (axis as f64, if side > 0.0 { 1.0 } else { 0.0 });
    [(p[i] + 0.5) / 4.0 + column / 3.0, (p[j] + 0.5) / (3.0 + column) + row / 2.0]
}

/// A cube of edge 1 about the origin: a grid of quads a face, a texture atlas with seams between
/// the faces, and a chess board of two materials over it.
fn cube() -> SurfaceAttributes {
    let mut surface = SurfaceAttributes {
        materials: ["light", "dark"].map(SurfaceMaterial::named).to_vec(),
        ..SurfaceAttributes::default()
    };
    let mut known: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let steps = f64::from(QUADS);
    for (axis, side) in (0..3).flat_map(|axis| [(axis, -0.5), (axis, 0.5)]) {
        for quad in 0..QUADS * QUADS {
            let (a, b) = (quad / QUADS, quad % QUADS);
            let mut corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[da, db]: [u32; 2]| {
                let mut p = Vec3::zeros();
                p[axis] = side;
                p[(axis + 1) % 3] = f64::from(a + da) / steps - 0.5;
                p[(axis + 2) % 3] = f64::from(b + db) / steps - 0.5;
                p
            });
            if side < 0.0 {
                corners.reverse();
            }
            for triangle in [[0, 1, 2], [0, 2, 3]] {
                let places = triangle.map(|k| corners[k]);
                surface.mesh.triangles.push(places.map(|p| {
                    let key = [p.x, p.y, p.z].map(|x| (x * 2.0 * steps).round() as i64);
                    *known.entry(key).or_insert_with(|| {
                        surface.mesh.vertices.push(p);
                        surface.mesh.vertices.len() as u32 - 1
                    })
                }));
                surface.uv.push(places.map(|p| atlas(p, axis, side).map(|x| x as f32)));
                surface.slots.push((a + b) % 2);
            }
        }
    }
    surface.validate().expect("lists of one length");
    surface
}

/// The skin of what a few planes leave of a body on both sides.
fn skins(mesh: &TriMesh, planes: usize) -> Vec<[Vec3; 3]> {
    let mut parts = vec![Exact::new(&Solid::outer(mesh.clone())).expect("a solid")];
    for k in 0..planes as u64 {
        let number = |which: u64| unit(7, which, k) - 0.5;
        let across = Vec3::new(number(0), number(1), number(2));
        let cut = |part: &Exact| {
            let (a, b) = part.split(across, 0.2 * number(3)).expect("a plane");
            [a, b]
        };
        parts = parts.iter().flat_map(cut).filter(|part| !part.is_empty()).collect();
    }
    let mut skin = Vec::new();
    for part in parts {
        let solid = part.to_solid().expect("closed");
        let outer = |t: &usize| solid.surface[*t] == Surface::Outer;
        skin.extend((0..solid.surface.len()).filter(outer).map(|t| solid.mesh.corners(t)));
    }
    skin
}

fn area(&[a, b, c]: &[Vec3; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

fn areas(skin: &[SkinTriangle], slots: usize) -> Vec<f64> {
    let of = |slot: usize| skin.iter().filter(move |t| t.slot as usize == slot);
    (0..slots).map(|slot| of(slot).map(|t| area(&t.corners)).sum()).collect()
}

/// How far the texture coordinates of a cube's skin are from the atlas.
fn farthest(skin: &[SkinTriangle]) -> f64 {
    let mut worst: f64 = 0.0;
    for triangle in skin {
        let [a, b, c] = triangle.corners;
        let across = (b - a).cross(&(c - a));
        let axis = across.iamax();
        for (p, uv) in triangle.corners.iter().zip(triangle.uv) {
            let right = atlas(*p, axis, across[axis]);
            for (x, y) in uv.iter().zip(right) {
                worst = worst.max((f64::from(*x) - y).abs());
            }
        }
    }
    worst
}

#[test]
fn a_cut_cube_keeps_its_atlas_and_its_chess_board() {
    let surface = cube();
    let cut = skins(&surface.mesh, 5);
    let skin = AttributeTransfer::new(&surface).transfer(&cut);
    // The kernel joins triangles of one plane, so some must be divided again.
    assert!(skin.len() > cut.len(), "{} of {}", skin.len(), cut.len());
    assert!(farthest(&skin) < 1e-6, "{:e}", farthest(&skin));
    for (slot, found) in areas(&skin, 2).into_iter().enumerate() {
        assert!((found - 3.0).abs() < 3e-9, "material {slot}: {found} m²");
    }
    let mut whole = vec![0.0; cut.len()];
    skin.iter().for_each(|part| whole[part.of] += area(&part.corners));
    for (triangle, sum) in cut.iter().zip(whole) {
        assert!((area(triangle) - sum).abs() < 1e-9, "parts of {sum} m² of {}", area(triangle));
    }
}

#[test]
fn one_map_over_a_plane_divides_nothing() {
    let mut surface = cube();
    surface.slots.fill(1);
    let cut = skins(&surface.mesh, 4);
    let skin = AttributeTransfer::new(&surface).transfer(&cut);
    assert_eq!(skin.len(), cut.len());
    assert!(skin.iter().zip(&cut).all(|(part, corners)| part.corners == *corners));
    assert!(farthest(&skin) < 1e-6, "{:e}", farthest(&skin));
    assert!(skin.iter().all(|part| part.slot == 1));
}

#[test]
fn smooth_normals_stay_smooth() {
    let mesh = sphere(0.5, Detail { segments: 24, edge: None }).expect("a ball");
    let outward = |p: Vec3| p.normalize();
    let normals = (0..mesh.triangles.len()).map(|t| {
        mesh.corners(t).map(|p| {
            let n = outward(p);
            [n.x as f32, n.y as f32, n.z as f32]
        })
    });
    let surface = SurfaceAttributes { normals: normals.collect(), mesh, ..Default::default() };
    let cut = skins(&surface.mesh, 4);
    let skin = AttributeTransfer::new(&surface).transfer(&cut);
    for part in &skin {
        for (p, n) in part.corners.iter().zip(part.normals) {
            let n = Vec3::from(n.map(f64::from));
            // Within a facet of 7.5° the mix of its corners' normals is this near the ball's own.
            assert!(n.dot(&outward(*p)) > 0.999, "{p:?} {n:?}");
            assert!((n.norm() - 1.0).abs() < 1e-6);
        }
    }
}

/// Inside out in the file, with a face missing: the repair turns and closes it.
#[test]
fn faces_that_a_repair_turned_over_keep_their_attributes() {
    let mut surface = cube();
    for (triangle, uv) in surface.mesh.triangles.iter_mut().zip(&mut surface.uv) {
        triangle.swap(1, 2);
        uv.swap(1, 2);
    }
    surface.normals = surface.uv.iter().map(|_| [[0.0, 0.0, 1.0]; 3]).collect();
    let (mended, report) = admit(&surface.mesh, Repair::Auto).expect("a cube");
    assert!(report.flipped > 0, "{report}");
    let skin = AttributeTransfer::new(&surface).transfer(&skins(&mended, 3));
    for SkinTriangle { corners: [a, b, c], normals, .. } in &skin {
        let across = (b - a).cross(&(c - a)).normalize();
        let inward = normals.iter().any(|n| Vec3::from(n.map(f64::from)).dot(&across) < -1e-6);
        assert!(!inward, "{normals:?} on a face along {across:?}");
    }
    assert!(farthest(&skin) < 1e-6, "{:e}", farthest(&skin));
    for (slot, found) in areas(&skin, 2).into_iter().enumerate() {
        assert!((found - 3.0).abs() < 3e-9, "material {slot}: {found} m²");
    }
}

/// A surface that was made anew lies beside the old one: no texture coordinate jumps over a seam.
#[test]
fn beside_the_surface_the_island_is_kept() {
    let surface = cube();
    let moved: Vec<[Vec3; 3]> = (0..surface.mesh.triangles.len())
        .map(|t| surface.mesh.corners(t).map(|p| 1.003 * p + Vec3::new(0.0, 0.0, 1e-3)))
        .collect();
    let skin = AttributeTransfer::new(&surface).transfer(&moved);
    assert_eq!(skin.len(), moved.len());
    for (part, (slot, uv)) in skin.iter().zip(surface.slots.iter().zip(&surface.uv)) {
        assert_eq!(part.slot, *slot);
        let off = part.uv.iter().flatten().zip(uv.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f32::max) < 2e-3, "{:?} for {uv:?}", part.uv);
    }
}

#[test]
fn an_object_can_be_taken_out() {
    let mut surface = cube();
    surface.object_names = ["odd", "even"].map(str::to_owned).to_vec();
    surface.objects = surface.slots.clone();
    let odd = surface.only(1);
    odd.validate().expect("is sound");
    assert_eq!(odd.mesh.triangles.len(), surface.mesh.triangles.len() / 2);
    assert_eq!(odd.object_names, ["even"]);
    assert!(odd.slots.iter().all(|slot| *slot == 1));
    assert!(odd.uv.len() == odd.mesh.triangles.len() && odd.normals.is_empty());
}

#[test]
fn lists_that_do_not_fit_are_refused_by_name() {
    let mut short = cube();
    short.uv.pop();
    let triangles = short.mesh.triangles.len();
    let error = AttributeError::Length { list: "uv", length: triangles - 1, triangles };
    assert_eq!(short.validate(), Err(error));
    let mut wild = cube();
    wild.slots[5] = 2;
    let error = AttributeError::Index { triangle: 5, list: "material", index: 2, count: 2 };
    assert_eq!(wild.validate(), Err(error));
}

#[test]
fn without_a_mesh_there_is_nothing_to_transfer() {
    let surface = SurfaceAttributes::default();
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y()];
    let skin = AttributeTransfer::new(&surface).transfer(&[corners]);
    assert_eq!((skin[0].corners, skin[0].normals), (corners, [[0.0, 0.0, 1.0]; 3]));
}
