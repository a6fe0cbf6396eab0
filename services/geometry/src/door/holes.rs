//! T-junctions and holes.

use super::RepairReport;
use crate::math::Vec3;
use crate::mesh::{TriMesh, bounds};
use crate::polygon::triangulate_uncrossed;
use std::collections::{BTreeMap, BTreeSet};

/// Passes over T-junctions; each divides a triangle at one corner a side.
const MAX_PASSES: usize = 16;
/// Open edges beyond which T-junctions are not looked for: the search is quadratic.
const MAX_OPEN: usize = 20_000;

/// Divides triangles whose open edge has a corner of another open edge on it, within `reach` \[m\].
pub(super) fn divide_at_junctions(mesh: &mut TriMesh, reach: f64, report: &mut RepairReport) {
    for _ in 0..MAX_PASSES {
        let open = mesh.open_edges();
        if open.is_empty() || open.len() > MAX_OPEN {
            return;
        }
        let on_edge: BTreeMap<[u32; 2], u32> = open
            .iter()
            .filter_map(|&edge| corner_on(mesh, edge, &open, reach).map(|v| (edge, v)))
            .collect();
        if on_edge.is_empty() {
            return;
        }
        let mut triangles = Vec::with_capacity(mesh.triangles.len() + on_edge.len());
        for &corners in &mesh.triangles {
            let side = |i: usize| [corners[i], corners[(i + 1) % 3]];
            match (0..3).find_map(|i| on_edge.get(&side(i)).map(|&v| (i, v))) {
                Some((i, v)) if !corners.contains(&v) => {
                    let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
                    triangles.extend([[a, v, c], [v, b, c]]);
                    report.junctions += 1;
                }
                _ => triangles.push(corners),
            }
        }
        if triangles.len() == mesh.triangles.len() {
            return;
        }
        mesh.triangles = triangles;
    }
}

/// The end of another open edge that lies nearest to the middle of this one, if any lies on it.
fn corner_on(mesh: &TriMesh, [a, b]: [u32; 2], open: &[[u32; 2]], reach: f64) -> Option<u32> {
    let (p, q) = (mesh.vertices[a as usize], mesh.vertices[b as usize]);
    let along = q - p;
    let length = along.norm();
    let mut best: Option<(f64, u32)> = None;
    for &[v, _] in open {
        let d = mesh.vertices[v as usize] - p;
        let s = d.dot(&along) / length;
        let inside = v != a && v != b && s > reach && s < length - reach;
        if inside && (d - s / length * along).norm() <= reach {
            let off_middle = (s - 0.5 * length).abs();
            if best.is_none_or(|(least, _)| off_middle < least) {
                best = Some((off_middle, v));
            }
        }
    }
    best.map(|(_, v)| v)
}

/// Closes every loop of open edges: flat-ish ones with the triangles of a polygon, others with a
/// fan from their middle, and those where such triangles would lie on the surface's own.
pub(super) fn fill(mesh: &mut TriMesh, report: &mut RepairReport) {
    let rims = loops(&mesh.open_edges());
    let mut edges: BTreeSet<[u32; 2]> = BTreeSet::new();
    if !rims.is_empty() {
        edges.extend(mesh.triangles.iter().flat_map(|t| sides(*t)));
    }
    for rim in rims {
        let points: Vec<Vec3> = rim.iter().map(|&i| mesh.vertices[i as usize]).collect();
        report.holes += 1;
        report.hole_edges += rim.len();
        let width = bounds(&points).map_or(0.0, |(low, high)| (high - low).norm());
        report.widest_hole = report.widest_hole.max(width);
        let n = rim.len() as u32;
        let doubled = |[a, b]: [u32; 2]| {
            let inner = b - a != 1 && b - a != n - 1;
            inner && edges.contains(&sorted([rim[a as usize], rim[b as usize]]))
        };
        let fill = flat_fill(&points)
            .filter(|fill| !fill.iter().any(|t| sides(*t).into_iter().any(doubled)))
            .map(|fill| fill.into_iter().map(|t| t.map(|k| rim[k as usize])));
        match fill {
            Some(fill) => {
                let fill: Vec<_> = fill.collect();
                edges.extend(fill.iter().flat_map(|t| sides(*t)));
                mesh.triangles.extend(fill);
            }
            None => {
                let hub = mesh.vertices.len() as u32;
                mesh.vertices.push(points.iter().sum::<Vec3>() / points.len() as f64);
                let n = rim.len();
                mesh.triangles.extend((0..n).map(|k| [rim[k], rim[(k + 1) % n], hub]));
            }
        }
    }
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(sorted)
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Closed loops of open edges, each in the direction that the filling triangles must use: against
/// that of the edges. A loop that meets itself in a vertex is taken apart there.
fn loops(open: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut onward: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &[a, b] in open {
        onward.entry(b).or_default().push(a);
    }
    let mut found = Vec::new();
    let starts: Vec<u32> = onward.keys().copied().collect();
    for start in starts {
        let mut path: Vec<u32> = vec![start];
        while let Some(next) = path.last().and_then(|at| onward.get_mut(at)).and_then(Vec::pop) {
            match path.iter().position(|&v| v == next) {
                Some(first) => {
                    let rim = path.split_off(first);
                    path.push(next);
                    if rim.len() >= 3 {
                        found.push(rim);
                    }
                }
                None => path.push(next),
            }
        }
    }
    found
}

/// Triangles of a loop seen along an axis, if it is a simple polygon from there.
fn flat_fill(points: &[Vec3]) -> Option<Vec<[u32; 3]>> {
    let triangles = triangulate_uncrossed(points)?;
    (triangles.len() == points.len() - 2).then_some(triangles)
}
