//! Welding, repeated and flat triangles, orientation.

use super::RepairReport;
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Merges vertices with equal coordinates and leaves out unused ones. The second value is how many
/// were merged.
pub(super) fn weld(mesh: &TriMesh) -> (TriMesh, usize) {
    // Adding zero makes −0 and 0 one.
    let key = |i: u32| {
        let p = mesh.vertices[i as usize];
        [p.x + 0.0, p.y + 0.0, p.z + 0.0]
    };
    let compare = |a: &u32, b: &u32| {
        let (p, q) = (key(*a), key(*b));
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(p[2].total_cmp(&q[2]))
    };
    let mut order: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    order.sort_by(|a, b| compare(a, b).then(a.cmp(b)));
    let mut same_as: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for pair in order.windows(2) {
        if key(pair[0]) == key(pair[1]) {
            same_as[pair[1] as usize] = same_as[pair[0] as usize];
        }
    }
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    let merged = (0..used.len()).filter(|&i| used[i] && same_as[i] as usize != i).count();
    let triangles = mesh.triangles.iter().map(|t| t.map(|i| same_as[i as usize])).collect();
    (compacted(&TriMesh { vertices: mesh.vertices.clone(), triangles }), merged)
}

/// The mesh without unused vertices; the others keep their order.
pub(super) fn compacted(mesh: &TriMesh) -> TriMesh {
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    let mut next = 0;
    let index: Vec<u32> = used
        .iter()
        .map(|&u| {
            let i = next;
            next += u32::from(u);
            i
        })
        .collect();
    let vertices = mesh.vertices.iter().zip(&used).filter(|(_, u)| **u).map(|(p, _)| *p).collect();
    let triangles = mesh.triangles.iter().map(|t| t.map(|i| index[i as usize])).collect();
    TriMesh { vertices, triangles }
}

/// Triangles whose height is below rounding: they have no direction.
pub(super) fn flat(mesh: &TriMesh) -> Vec<usize> {
    (0..mesh.triangles.len()).filter(|&t| is_flat(mesh.corners(t))).collect()
}

fn is_flat([a, b, c]: [Vec3; 3]) -> bool {
    let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
    // Twice the area is longest side times height; heights under 1e-14 of the side are rounding.
    (b - a).cross(&(c - a)).norm() <= 1e-14 * longest
}

/// Triangles that have the same three corners as an earlier one.
pub(super) fn repeated(mesh: &TriMesh) -> Vec<usize> {
    let mut found: Vec<usize> = same_corners(mesh).iter().flat_map(|g| g[1..].to_vec()).collect();
    found.sort_unstable();
    found
}

/// Groups of two and more triangles with the same three corners.
fn same_corners(mesh: &TriMesh) -> Vec<Vec<usize>> {
    let key = |t: usize| {
        let mut corners = mesh.triangles[t];
        corners.sort_unstable();
        corners
    };
    let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
    order.sort_by_key(|&t| (key(t), t));
    let groups = order.chunk_by(|&a, &b| key(a) == key(b));
    groups.filter(|g| g.len() > 1).map(<[usize]>::to_vec).collect()
}

/// Drops triangles that name one vertex twice.
pub(super) fn drop_collapsed(mesh: &mut TriMesh, report: &mut RepairReport) {
    let before = mesh.triangles.len();
    mesh.triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    report.degenerate += before - mesh.triangles.len();
}

/// Drops triangles without area.
pub(super) fn drop_flat(mesh: &mut TriMesh, report: &mut RepairReport) {
    keep_where(mesh, |mesh, t| !is_flat(mesh.corners(t)), &mut report.degenerate);
}

/// Of triangles with the same corners, those that face opposite ways cancel; of what is left, one
/// stays.
pub(super) fn cancel_repeated(mesh: &mut TriMesh, report: &mut RepairReport) {
    let mut keep = vec![true; mesh.triangles.len()];
    for group in same_corners(mesh) {
        let (even, odd): (Vec<usize>, Vec<usize>) =
            group.iter().partition(|&&t| is_even(mesh.triangles[t]));
        group.iter().for_each(|&t| keep[t] = false);
        let majority = if even.len() >= odd.len() { &even } else { &odd };
        if even.len() != odd.len() {
            keep[majority[0]] = true;
        }
    }
    keep_where(mesh, |_, t| keep[t], &mut report.duplicates);
}

/// Whether the corners are an even permutation of their order.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    ((a < b) as u8 + (b < c) as u8 + (c < a) as u8) == 2
}

fn keep_where(mesh: &mut TriMesh, keep: impl Fn(&TriMesh, usize) -> bool, dropped: &mut usize) {
    let kept: Vec<[u32; 3]> =
        (0..mesh.triangles.len()).filter(|&t| keep(mesh, t)).map(|t| mesh.triangles[t]).collect();
    *dropped += mesh.triangles.len() - kept.len();
    mesh.triangles = kept;
}

/// Whether every edge is used as often one way as the other.
pub(super) fn is_balanced(mesh: &TriMesh) -> bool {
    mesh.edges().iter().all(|e| e.forward == e.backward)
        && mesh.triangles.iter().all(|&[a, b, c]| a != b && b != c && c != a)
}

/// Merges vertices of open edges that lie within `reach` \[m\] of each other.
pub(super) fn sew(mesh: &mut TriMesh, reach: f64, report: &mut RepairReport) {
    let mut rim: Vec<u32> = mesh.open_edges().into_iter().flatten().collect();
    rim.sort_unstable();
    rim.dedup();
    let at = |i: u32| mesh.vertices[i as usize];
    rim.sort_by(|&a, &b| at(a).x.total_cmp(&at(b).x).then(a.cmp(&b)));
    let mut same_as: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for (k, &i) in rim.iter().enumerate() {
        if same_as[i as usize] != i {
            continue;
        }
        for &j in rim[k + 1..].iter().take_while(|&&j| at(j).x - at(i).x <= reach) {
            let distance = (at(j) - at(i)).norm();
            if same_as[j as usize] == j && distance <= reach {
                same_as[j as usize] = i;
                report.merged_vertices += 1;
                report.moved = report.moved.max(distance);
            }
        }
    }
    for t in &mut mesh.triangles {
        *t = t.map(|i| same_as[i as usize]);
    }
}

/// Turns triangles so that neighbours across an edge of two face the same way, each connected patch
/// the way most of it faced. A one-sided surface keeps edges that disagree.
pub(super) fn orient(mesh: &mut TriMesh, report: &mut RepairReport) {
    let neighbours = neighbours(mesh);
    let mut flip: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    for seed in 0..mesh.triangles.len() {
        if flip[seed].is_some() {
            continue;
        }
        flip[seed] = Some(false);
        let mut patch = vec![seed];
        let mut next = 0;
        while next < patch.len() {
            let t = patch[next];
            next += 1;
            for &(other, agrees) in &neighbours[t] {
                if flip[other].is_none() {
                    flip[other] = flip[t].map(|f| f ^ !agrees);
                    patch.push(other);
                }
            }
        }
        let turned = patch.iter().filter(|&&t| flip[t] == Some(true)).count();
        if 2 * turned > patch.len() {
            patch.iter().for_each(|&t| flip[t] = flip[t].map(|f| !f));
        }
    }
    for (t, flip) in mesh.triangles.iter_mut().zip(flip) {
        if flip == Some(true) {
            t.swap(1, 2);
            report.flipped += 1;
        }
    }
}

/// For each triangle, those across edges that have exactly two, and whether both face the same way.
pub(super) fn neighbours(mesh: &TriMesh) -> Vec<Vec<(usize, bool)>> {
    let mut sides: Vec<(u32, u32, usize, bool)> = Vec::with_capacity(3 * mesh.triangles.len());
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        for (i, j) in [(a, b), (b, c), (c, a)] {
            sides.push((i.min(j), i.max(j), t, i < j));
        }
    }
    sides.sort_unstable();
    let mut neighbours = vec![Vec::new(); mesh.triangles.len()];
    for pair in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let [(_, _, s, forward), (_, _, t, other)] = *pair {
            neighbours[s].push((t, forward != other));
            neighbours[t].push((s, forward != other));
        }
    }
    neighbours
}
