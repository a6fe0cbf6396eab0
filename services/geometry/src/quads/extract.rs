//! From the field of lattices to quads: triangles whose corners share a lattice point vanish, the
//! diagonals of the lattice's squares too, and each face left is divided into quads.

use super::net::QuadNet;
use crate::divide::key;
use crate::math::Vec3;
use crate::remesh::editable::{EdgeSide, EditableMesh, VertexRole};

/// Vertices nearer to each other than this, over the side of the lattice, share a lattice point.
const SHARED: f64 = 0.7;
/// Passes in which such vertices are merged; one nearly does.
const PASSES: usize = 8;

/// Merges vertices until each lattice point of this `side` \[m\] has one.
pub(super) fn merge_lattice_points(mesh: &mut EditableMesh, side: f64) {
    let mut weights = vec![1.0; mesh.points.len()];
    for _ in 0..PASSES {
        let mut merged = 0;
        for (_, edge) in edges_by_length(mesh, SHARED * side) {
            // Earlier merges may have moved it.
            let is_there = mesh.is_edge(edge[0], edge[1]);
            if is_there && mesh.length(edge) < SHARED * side {
                merged += usize::from(merge(mesh, edge, &mut weights));
            }
        }
        merged += remove_thin(mesh, &mut weights);
        if merged == 0 {
            break;
        }
    }
}

/// Merges the ends of an edge in their weighted mean, or in the one that may not move.
fn merge(mesh: &mut EditableMesh, [a, b]: [u32; 2], weights: &mut [f64]) -> bool {
    for (gone, keep) in [(a, b), (b, a)] {
        if !mesh.can_collapse(gone, keep) {
            continue;
        }
        let (w, x) = (weights[gone as usize], weights[keep as usize]);
        let is_same = mesh.role[gone as usize] == mesh.role[keep as usize]
            && mesh.role[keep as usize] != VertexRole::Corner;
        let p =
            if is_same { (mesh.at(gone) * w + mesh.at(keep) * x) / (w + x) } else { mesh.at(keep) };
        mesh.collapse(gone, keep, p);
        weights[keep as usize] += w;
        return true;
    }
    false
}

/// Removes interior vertices of three triangles, which stand in the middle of a larger one, and
/// gives rim vertices of a single triangle an edge across.
fn remove_thin(mesh: &mut EditableMesh, weights: &mut [f64]) -> usize {
    let mut changes = 0;
    for v in 0..mesh.points.len() as u32 {
        match (mesh.role[v as usize], mesh.valence(v)) {
            (VertexRole::Interior, 3) => {
                let keep = mesh.neighbours(v).into_iter().find(|&w| mesh.can_collapse(v, w));
                if let Some(keep) = keep {
                    let p = mesh.at(keep);
                    mesh.collapse(v, keep, p);
                    weights[keep as usize] += weights[v as usize];
                    changes += 1;
                }
            }
            (VertexRole::Border, 2) => {
                if let [a, b] = mesh.neighbours(v)[..] {
                    mesh.flip([a, b]);
                    changes += usize::from(mesh.valence(v) > 2);
                }
            }
            _ => {}
        }
    }
    changes
}

/// Edges shorter than `limit` \[m\], shortest first.
fn edges_by_length(mesh: &EditableMesh, limit: f64) -> Vec<(f64, [u32; 2])> {
    let all = mesh.edges().into_iter().map(|edge| (mesh.length(edge), edge));
    let mut edges: Vec<(f64, [u32; 2])> = all.filter(|(length, _)| *length < limit).collect();
    edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    edges
}

/// The faces that are left when diagonals between two triangles are taken out, the best first.
/// An interior vertex keeps three edges, one of a rim a third beside those of the rim.
pub(super) fn faces(mesh: &EditableMesh) -> Vec<Vec<u32>> {
    let count = mesh.triangles.len() as u32;
    let mut is_free: Vec<bool> = (0..count).map(|t| mesh.is_alive(t)).collect();
    let mut valence: Vec<usize> = (0..mesh.points.len() as u32).map(|v| mesh.valence(v)).collect();
    let least = |v: u32| if mesh.role[v as usize] == VertexRole::Corner { 2 } else { 3 };
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for (_, [a, b], [left, right]) in diagonals(mesh) {
        let sides = [left.triangle as usize, right.triangle as usize];
        let spare = [a, b].iter().all(|&v| valence[v as usize] > least(v));
        if spare && sides.iter().all(|&t| is_free[t]) {
            sides.iter().for_each(|&t| is_free[t] = false);
            [a, b].iter().for_each(|&v| valence[v as usize] -= 1);
            faces.push(vec![a, right.across, b, left.across]);
        }
    }
    let rest = (0..mesh.triangles.len()).filter(|&t| is_free[t]);
    faces.extend(rest.map(|t| mesh.triangles[t].to_vec()));
    faces
}

/// Edges between two triangles with the least sine of an angle of the quad around them, those of
/// the best quad first.
fn diagonals(mesh: &EditableMesh) -> Vec<(f64, [u32; 2], [EdgeSide; 2])> {
    let of = |edge: [u32; 2]| match mesh.sides(edge) {
        [Some(left), Some(right)] => {
            let corners = [edge[0], right.across, edge[1], left.across];
            Some((least_sine(corners.map(|v| mesh.at(v))), edge, [left, right]))
        }
        _ => None,
    };
    let mut scored: Vec<_> = mesh.edges().into_iter().filter_map(of).collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    scored
}

/// The least sine of the angles of a quad; negative where one is more than straight.
fn least_sine(corners: [Vec3; 4]) -> f64 {
    let normal = (corners[2] - corners[0]).cross(&(corners[3] - corners[1]));
    let mut least = 1.0_f64;
    for k in 0..4 {
        let (e, f) = (corners[(k + 1) % 4] - corners[k], corners[(k + 3) % 4] - corners[k]);
        let scale = e.norm() * f.norm() * normal.norm();
        least = least.min(if scale > 0.0 { e.cross(&f).dot(&normal) / scale } else { -1.0 });
    }
    least
}

/// Divides each face into one quad a corner, through its centre and the middles of its edges.
pub(super) fn divided(mesh: &EditableMesh, faces: &[Vec<u32>]) -> QuadNet {
    let mut net = QuadNet::default();
    let mut index = vec![u32::MAX; mesh.points.len()];
    for &v in faces.iter().flatten() {
        if index[v as usize] == u32::MAX {
            index[v as usize] = net.add(mesh.at(v), mesh.role[v as usize]);
        }
    }
    let ends = |face: &Vec<u32>, k: usize| key(face[k], face[(k + 1) % face.len()]);
    let mut edges: Vec<[u32; 2]> =
        faces.iter().flat_map(|face| (0..face.len()).map(|k| ends(face, k))).collect();
    edges.sort_unstable();
    let mut middles: Vec<([u32; 2], u32)> = Vec::new();
    for uses in edges.chunk_by(|a, b| a == b) {
        let role = if uses.len() == 1 { VertexRole::Border } else { VertexRole::Interior };
        let [a, b] = uses[0].map(|v| mesh.at(v));
        middles.push((uses[0], net.add(0.5 * (a + b), role)));
    }
    let middle = |edge: [u32; 2]| {
        middles.binary_search_by_key(&edge, |m| m.0).map_or(u32::MAX, |i| middles[i].1)
    };
    for face in faces {
        let n = face.len();
        let sum: Vec3 = face.iter().map(|&v| mesh.at(v)).sum();
        let centre = net.add(sum / n as f64, VertexRole::Interior);
        for k in 0..n {
            let [after, before] = [k, (k + n - 1) % n].map(|k| middle(ends(face, k)));
            net.quads.push([index[face[k] as usize], after, centre, before]);
        }
    }
    net
}
