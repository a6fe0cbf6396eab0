//! The surface half way between two walls.

use super::pairing::{WallFace, WallPairs};
use crate::inside::Nearest;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::remesh::curved::{area_vector, triangles_around, unit_or};
use crate::remesh::fans;
use crate::remesh::reference_surface::boundary_loops;

/// Steps in which a point finds the middle; parallel walls need one or two.
const STEPS: usize = 12;
/// The middle is found when the walls are equally far to this share of the thickness.
const EQUAL: f64 = 1e-4;
/// Rounds in which folds are spread.
const UNFOLDS: usize = 20;
/// A face has folded if less than this share of its area is left in its old direction \[1\].
const FOLDED: f64 = 0.25;
/// Halvings of the way to the rim of what folds on it, before it stays.
const STRETCHES: usize = 12;
/// How far a rim may lie beyond the last pairs, over the thickness: half of it for a round rim.
const REACH: f64 = 1.5;

/// One wall moved to the middle.
#[derive(Clone, Debug)]
pub(super) struct MiddleSurface {
    pub(super) mesh: TriMesh,
    /// At each vertex: the sum of the distances to both walls \[m\].
    pub(super) thickness: Vec<f64>,
}

impl MiddleSurface {
    /// Moves the side of a body to half way between its walls and leads it to the rim. `None` if
    /// there is no wall across.
    pub(super) fn between(mesh: &TriMesh, pairs: &WallPairs) -> Option<Self> {
        let of = |kind: WallFace| -> Vec<usize> {
            (0..pairs.kind.len()).filter(|&t| pairs.kind[t] == kind).collect()
        };
        let kept = without_pinches(mesh, of(WallFace::Side));
        let (side, other) = (mesh.submesh(&kept), mesh.submesh(&of(WallFace::Opposite)));
        if side.triangles.is_empty() || other.triangles.is_empty() {
            return None;
        }
        let walls = [Nearest::new(&side), Nearest::new(&other)];
        let around = triangles_around(&side);
        let start = |v: usize| {
            let faces = around[v].iter().map(|&t| t as usize);
            let normal: Vec3 = faces.clone().map(|t| area_vector(&side, t)).sum();
            let sum: f64 = faces.map(|t| pairs.thickness[kept[t]]).sum();
            side.vertices[v] - unit_or(normal, Vec3::zeros()) * (0.5 * sum / around[v].len() as f64)
        };
        let found = (0..side.vertices.len()).map(|v| middle(&walls, start(v)));
        let (vertices, thickness) = found.unzip();
        let mesh_of_side = TriMesh { vertices, triangles: side.triangles.clone() };
        let mut surface = Self { mesh: mesh_of_side, thickness };
        surface.unfold(&side, &walls);
        surface.extend_to_rim(mesh);
        Some(surface)
    }

    /// Spreads out what folded: near a sharp convex edge faces of the wall move in past each other.
    fn unfold(&mut self, side: &TriMesh, walls: &[Nearest; 2]) {
        let around = triangles_around(&self.mesh);
        for _ in 0..UNFOLDS {
            let is_folded = |t: usize| {
                let (old, new) = (area_vector(side, t), area_vector(&self.mesh, t));
                new.dot(&old) < FOLDED * old.norm_squared()
            };
            let folds = (0..self.mesh.triangles.len()).filter(|&t| is_folded(t));
            let mut moved: Vec<u32> = folds.flat_map(|t| self.mesh.triangles[t]).collect();
            moved.sort_unstable();
            moved.dedup();
            if moved.is_empty() {
                return;
            }
            for v in moved.into_iter().map(|v| v as usize) {
                let near = around[v].iter().flat_map(|&t| self.mesh.triangles[t as usize]);
                let sum: Vec3 = near.map(|w| self.mesh.vertices[w as usize]).sum();
                let mean = sum / (3 * around[v].len()) as f64;
                (self.mesh.vertices[v], self.thickness[v]) = middle(walls, mean);
            }
        }
    }

    /// Moves the vertices of the boundary outwards in the surface to the skin of the body.
    fn extend_to_rim(&mut self, body: &TriMesh) {
        let skin = Nearest::new(body);
        let around = triangles_around(&self.mesh);
        let mut moved = Vec::new();
        for points in boundary_loops(&self.mesh) {
            let n = points.len();
            let at = |i: usize| self.mesh.vertices[points[i % n] as usize];
            for (i, &v) in points.iter().enumerate() {
                let (v, p) = (v as usize, at(i));
                let faces = around[v].iter().map(|&t| area_vector(&self.mesh, t as usize));
                let normal: Vec3 = faces.sum();
                let edge = |a: Vec3, b: Vec3| unit_or(b - a, Vec3::zeros());
                let along = edge(at(i + n - 1), p) + edge(p, at(i + 1));
                let out = unit_or(along.cross(&normal), Vec3::zeros());
                // From within, so that a point that is on the skin already finds it.
                let back = 0.25 * self.thickness[v];
                let hit = skin.first_hit(p - out * back, out, |_| true);
                let reach = hit.map_or(0.0, |(distance, _)| distance - back);
                if reach > 0.0 && reach <= REACH * self.thickness[v] {
                    moved.push((v, out * reach));
                }
            }
        }
        self.stretch(moved);
    }

    /// Moves vertices by vectors \[m\], less far or not at all where faces would fold.
    fn stretch(&mut self, mut moves: Vec<(usize, Vec3)>) {
        let before = self.mesh.clone();
        for round in 0.. {
            for &(v, way) in &moves {
                self.mesh.vertices[v] = before.vertices[v] + way;
            }
            let mut is_folded = vec![false; before.vertices.len()];
            for (t, corners) in before.triangles.iter().enumerate() {
                let (old, new) = (area_vector(&before, t), area_vector(&self.mesh, t));
                let folds = new.dot(&old) < FOLDED * old.norm_squared();
                corners.iter().filter(|_| folds).for_each(|&v| is_folded[v as usize] = true);
            }
            // Each round after those shortens one at least to nothing.
            let share = if round < STRETCHES { 0.5 } else { 0.0 };
            let folds = moves.iter_mut().filter(|(v, way)| is_folded[*v] && *way != Vec3::zeros());
            if folds.map(|(_, way)| *way *= share).count() == 0 {
                return;
            }
        }
    }
}

/// The point half way between two walls near `p` \[m\], and the sum of its distances to them \[m\].
fn middle(walls: &[Nearest; 2], mut p: Vec3) -> (Vec3, f64) {
    let mut thickness = 0.0;
    for _ in 0..STEPS {
        let [Some((a, from, _)), Some((b, to, _))] = [0, 1].map(|k| walls[k].closest(p)) else {
            break;
        };
        thickness = from + to;
        if (from - to).abs() <= EQUAL * thickness {
            break;
        }
        p += unit_or(b - a, Vec3::zeros()) * (0.5 * (to - from));
    }
    (p, thickness)
}

/// The faces without those that hang on the others by one vertex only, and of what is left the
/// largest connected part.
fn without_pinches(mesh: &TriMesh, mut kept: Vec<usize>) -> Vec<usize> {
    loop {
        let part = mesh.submesh(&kept);
        let area = |t: usize| area_vector(&part, t).norm();
        let around = triangles_around(&part);
        let mut drop = vec![false; kept.len()];
        for (v, triangles) in (0u32..).zip(&around) {
            let mut fans = fans(&part, v, triangles);
            let size = |fan: &[u32]| fan.iter().map(|&t| area(t as usize)).sum::<f64>();
            fans.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.cmp(b)));
            fans.iter().skip(1).flatten().for_each(|&t| drop[t as usize] = true);
        }
        let size = |group: &[usize]| group.iter().map(|&t| area(t)).sum::<f64>();
        let groups = part.components();
        let largest = groups.iter().max_by(|a, b| size(a).total_cmp(&size(b)).then(b.cmp(a)));
        let largest = largest.cloned().unwrap_or_default();
        let next: Vec<usize> = largest.into_iter().filter(|&t| !drop[t]).map(|t| kept[t]).collect();
        if next.len() == kept.len() {
            return next;
        }
        kept = next;
    }
}

#[cfg(test)]
mod tests {
    use super::MiddleSurface;
    use crate::math::Vec3;
    use crate::mesh::TriMesh;
    use crate::remesh::curved::area_vector;

    /// Beside a notch two vertices of a rim are led across each other: they stop before that, and
    /// a third goes all the way.
    #[test]
    fn a_rim_that_is_led_out_does_not_fold() {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let vertices = vec![
            at(0.0, 0.0),
            at(1.0, 0.0),
            at(2.0, 0.0),
            at(0.0, 1.0),
            at(1.0, 1.0),
            at(2.0, 1.0),
        ];
        let triangles = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        let mesh = TriMesh { vertices, triangles };
        let mut surface = MiddleSurface { mesh: mesh.clone(), thickness: vec![0.1; 6] };
        surface.stretch(vec![(3, at(1.5, 0.0)), (4, at(-0.5, 0.0)), (5, at(0.0, 0.5))]);
        for t in 0..4 {
            let up = area_vector(&surface.mesh, t).z;
            assert!(up > 0.25 * area_vector(&mesh, t).z, "triangle {t}: {up}");
        }
        assert!(surface.mesh.vertices[3].x > 0.1, "it has not moved");
        assert_eq!(surface.mesh.vertices[5], at(2.0, 1.5));
        // A needle, in which nothing may move.
        let vertices = vec![at(0.0, 0.0), at(1.0, 0.0), at(0.5, 1e-9)];
        let mesh = TriMesh { vertices, triangles: vec![[0, 1, 2]] };
        let mut surface = MiddleSurface { mesh: mesh.clone(), thickness: vec![0.1; 3] };
        surface.stretch(vec![(2, at(0.0, -1.0))]);
        assert_eq!(surface.mesh, mesh);
    }
}
