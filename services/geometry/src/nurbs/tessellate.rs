//! Triangles of patches.

use super::{KnotSpan, NurbsPatch};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Greatest angle between two edges in a row of a tessellation \[rad\].
const TURN: f64 = 0.06;

/// Edges that a span is tried with, to see how far it turns.
const TRIED: usize = 8;

/// Least and most edges of a span.
const EDGES: (usize, usize) = (2, 64);

/// Most triangles of all patches, as long as each span has the least edges.
const MOST_TRIANGLES: usize = 400_000;

/// Triangles of patches, each span of a knot divided into equally many equal parts along both axes,
/// so that patches whose common edges have the same knots and control points meet vertex on vertex.
/// Neighbouring edges along a row turn by 0.06 rad at most, as long as all has no more than 400 000
/// triangles. Vertices of different patches are not merged.
#[must_use]
pub fn tessellate(patches: &[NurbsPatch]) -> TriMesh {
    let turn = patches.iter().flat_map(|patch| [0, 1].map(|axis| greatest_turn(patch, axis)));
    let wanted = (turn.fold(0.0, f64::max) / TURN).ceil() as usize;
    let spans =
        |patch: &NurbsPatch| patch.axes().iter().map(|a| a.spans().len()).product::<usize>();
    let all: usize = patches.iter().map(spans).sum();
    let most = (MOST_TRIANGLES as f64 / (2.0 * all.max(1) as f64)).sqrt() as usize;
    let parts = wanted.min(most).clamp(EDGES.0, EDGES.1);
    let mut mesh = TriMesh::default();
    for patch in patches {
        let [first, second] = rows(patch, parts);
        let base = mesh.vertices.len() as u32;
        let wide = first.len() as u32;
        for &along in &second {
            mesh.vertices.extend(first.iter().map(|&at| place(patch, [at, along])));
        }
        for j in 1..second.len() as u32 {
            for i in 1..wide {
                let [a, b] = [base + (j - 1) * wide + i - 1, base + (j - 1) * wide + i];
                mesh.triangles.extend([[a, b, b + wide], [a, b + wide, a + wide]]);
            }
        }
    }
    mesh
}

/// Places along an axis: a span, and the share of it.
fn rows(patch: &NurbsPatch, parts: usize) -> [Vec<(KnotSpan, f64)>; 2] {
    [0, 1].map(|axis| {
        let spans = patch.axes()[axis].spans();
        let share = |k: usize| k as f64 / parts as f64;
        let inside = spans.iter().flat_map(|span| (0..parts).map(|k| (*span, share(k))));
        inside.chain(spans.last().map(|span| (*span, 1.0))).collect()
    })
}

fn place(patch: &NurbsPatch, [u, v]: [(KnotSpan, f64); 2]) -> Vec3 {
    patch.place(&patch.evaluate([&u.0, &v.0], [u.1, v.1]))
}

/// How far the surface turns along an axis within one span, at most \[rad\].
fn greatest_turn(patch: &NurbsPatch, axis: usize) -> f64 {
    let [first, second] = rows(patch, TRIED);
    let (along, across) = if axis == 0 { (first, second) } else { (second, first) };
    let mut most = 0.0_f64;
    for &other in across.iter().step_by(TRIED / 2) {
        let at = |&here: &(KnotSpan, f64)| {
            place(patch, if axis == 0 { [here, other] } else { [other, here] })
        };
        let row: Vec<Vec3> = along.iter().map(at).collect();
        for span in row.windows(TRIED + 1).step_by(TRIED) {
            let turns = span.windows(3).map(|p| (p[1] - p[0]).angle(&(p[2] - p[1])));
            most = most.max(turns.filter(|turn| turn.is_finite()).sum());
        }
    }
    most
}
