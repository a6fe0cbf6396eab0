//! The passes of incremental remeshing \[Botsch & Kobbelt 2004\].

use super::editable::{EditableMesh, VertexRole};
use super::reference_surface::ReferenceSurface;
use crate::math::Vec3;

/// Edges longer than this times the spacing are split.
pub(super) const SPLIT: f64 = 4.0 / 3.0;
/// Edges shorter than this times the spacing are collapsed.
pub(super) const COLLAPSE: f64 = 4.0 / 5.0;
/// Least cosine between the normal of a changed triangle and that of the place.
const TURNED: f64 = 0.3;
/// Least angle of a triangle that a flip may make \[rad\], unless it was worse: 20°.
const FLIP_ANGLE: f64 = 0.349;

/// What a corner or boundary vertex with a single triangle counts in the sum of squared deviations:
/// more than all flips around it could gain.
const LONE: i64 = 50;

/// A remeshing under way.
#[derive(Clone, Debug)]
pub(super) struct Remeshing<'a> {
    pub(super) mesh: EditableMesh,
    pub(super) surface: &'a ReferenceSurface,
    pub(super) spacing: f64,
}

impl Remeshing<'_> {
    /// Splits long edges, longest first.
    pub(super) fn split_long(&mut self) {
        let limit = SPLIT * self.spacing;
        let mut edges = self.edges_by_length(|length| length > limit);
        edges.reverse();
        for (_, edge) in edges {
            self.split(edge);
        }
    }

    /// Splits an edge at its middle, projected.
    pub(super) fn split(&mut self, edge: [u32; 2]) -> u32 {
        let middle = 0.5 * (self.mesh.at(edge[0]) + self.mesh.at(edge[1]));
        let v = self.mesh.split(edge, middle);
        let p = self.projected(v, middle);
        self.mesh.points[v as usize] = p;
        v
    }

    /// Collapses short edges, shortest first, unless that makes a long edge or a fold.
    pub(super) fn collapse_short(&mut self) {
        let limit = COLLAPSE * self.spacing;
        for (_, edge) in self.edges_by_length(|length| length < limit) {
            let [a, b] = edge;
            // Earlier collapses may have moved it.
            if !self.mesh.is_edge(a, b) || self.mesh.length(edge) >= limit {
                continue;
            }
            for (gone, keep) in [(a, b), (b, a)] {
                if self.try_collapse(gone, keep, SPLIT) {
                    break;
                }
            }
        }
    }

    /// Merges `gone` into `keep` where topology, folds and edges of up to `longest` times the
    /// spacing allow it.
    pub(super) fn try_collapse(&mut self, gone: u32, keep: u32, longest: f64) -> bool {
        if !self.mesh.can_collapse(gone, keep) {
            return false;
        }
        let same = self.mesh.role[gone as usize] == self.mesh.role[keep as usize]
            && self.mesh.role[keep as usize] != VertexRole::Corner;
        let (g, k) = (self.mesh.at(gone), self.mesh.at(keep));
        let p = if same { self.projected(keep, 0.5 * (g + k)) } else { k };
        let fits = self.fits(gone, keep, p, longest) && self.fits(keep, gone, p, longest);
        if fits {
            self.mesh.collapse(gone, keep, p);
        }
        fits
    }

    /// Whether `v` may move to `p` while the triangles that it shares with `other` vanish.
    fn fits(&self, v: u32, other: u32, p: Vec3, longest: f64) -> bool {
        let normal = self.mesh.normal(v);
        self.mesh.around[v as usize].iter().all(|&t| {
            let corners = self.mesh.triangles[t as usize];
            if corners.contains(&other) {
                return true;
            }
            let [a, b, c] = corners.map(|w| if w == v { p } else { self.mesh.at(w) });
            let area = (b - a).cross(&(c - a));
            let far = corners.iter().filter(|&&w| w != v).map(|&w| (self.mesh.at(w) - p).norm());
            area.dot(&normal) > TURNED * area.norm()
                && far.fold(0.0, f64::max) <= longest * self.spacing
        })
    }

    /// Flips edges while that brings valences nearer to their targets. Flips that change nothing
    /// are made too where `sideways`: they move a defect towards its opposite.
    pub(super) fn flip_to_valence(&mut self, sideways: bool) -> usize {
        let mut flips = 0;
        for edge in self.mesh.edges() {
            let Some((gain, made)) = self.flip_gain(edge) else {
                continue;
            };
            let wanted = gain > 0 || (sideways && gain == 0 && self.is_beside_defect(edge));
            if wanted && self.may_flip(edge, made, FLIP_ANGLE) {
                self.mesh.flip(edge);
                flips += 1;
            }
        }
        flips
    }

    fn is_beside_defect(&self, edge: [u32; 2]) -> bool {
        edge.into_iter().any(|v| self.is_defect(v))
    }

    /// Whether a valence is out of bounds: 5 to 7 inside, 3 to 5 on a boundary.
    pub(super) fn is_defect(&self, v: u32) -> bool {
        let middle = if self.mesh.is_interior(v) { 6 } else { 4 };
        let valence = self.mesh.valence(v);
        valence > 0 && valence.abs_diff(middle) > 1
    }

    /// By how much a flip lowers the sum of squared deviations of valence, and what it makes.
    pub(super) fn flip_gain(&self, edge: [u32; 2]) -> Option<(i64, [[u32; 3]; 2])> {
        let made = self.mesh.flipped(edge)?;
        let [[_, d, c], _] = made;
        let square = |v: u32, change: i64| {
            let valence = self.mesh.valence(v) as i64 + change;
            let off = valence - self.mesh.target[v as usize] as i64;
            off * off + if valence < 3 { LONE } else { 0 }
        };
        let before = [edge[0], edge[1], c, d].into_iter().map(|v| square(v, 0)).sum::<i64>();
        let after = square(edge[0], -1) + square(edge[1], -1) + square(c, 1) + square(d, 1);
        Some((before - after, made))
    }

    /// Whether the triangles of a flip have at least this least `angle` \[rad\], or no less than
    /// before, and face the way of those that they replace.
    pub(super) fn may_flip(&self, [a, b]: [u32; 2], made: [[u32; 3]; 2], angle: f64) -> bool {
        let [[_, d, c], _] = made;
        let at = |v: u32| self.mesh.at(v);
        let old = [[a, b, c], [b, a, d]].map(|t| t.map(at));
        let new = made.map(|t| t.map(at));
        let normal = old.iter().map(cross).sum::<Vec3>();
        let faces = new.iter().map(cross);
        let level = faces.clone().all(|n| n.dot(&normal) > TURNED * n.norm() * normal.norm());
        let least = |pair: &[[Vec3; 3]; 2]| pair.iter().map(least_angle).fold(f64::MAX, f64::min);
        level && least(&new) >= angle.min(least(&old))
    }

    /// Moves each vertex over the surface towards the centroid of the triangles around it, and
    /// each boundary vertex along the boundary to between its neighbours.
    pub(super) fn relax(&mut self) {
        let moved: Vec<Vec3> =
            (0..self.mesh.points.len() as u32).map(|v| self.relaxed(v)).collect();
        let old = std::mem::replace(&mut self.mesh.points, moved);
        // What folded goes back.
        for v in 0..self.mesh.points.len() {
            if self.mesh.around[v].iter().any(|&t| self.is_folded(t, &old)) {
                self.mesh.points[v] = old[v];
            }
        }
    }

    fn is_folded(&self, t: u32, old: &[Vec3]) -> bool {
        let before = self.mesh.triangles[t as usize].map(|v| old[v as usize]);
        cross(&self.mesh.corners(t)).dot(&cross(&before)) <= 0.0
    }

    fn relaxed(&self, v: u32) -> Vec3 {
        let p = self.mesh.at(v);
        let around = &self.mesh.around[v as usize];
        if around.is_empty() || self.mesh.role[v as usize] == VertexRole::Corner {
            return p;
        }
        if self.mesh.role[v as usize] == VertexRole::Border {
            let is_beside = |w: &u32| self.mesh.sides([v, *w]).iter().any(Option::is_none);
            let ends: Vec<u32> = self.mesh.neighbours(v).into_iter().filter(is_beside).collect();
            let sum: Vec3 = ends.iter().map(|&w| self.mesh.at(w)).sum();
            return self.projected(v, sum / ends.len().max(1) as f64);
        }
        let (mut sum, mut whole) = (Vec3::zeros(), 0.0);
        for &t in around {
            let [a, b, c] = self.mesh.corners(t);
            let area = self.mesh.area_vector(t).norm();
            sum += area * (a + b + c) / 3.0;
            whole += area;
        }
        if whole <= 0.0 {
            return p;
        }
        let (way, normal) = (sum / whole - p, self.mesh.normal(v));
        self.projected(v, p + way - normal * way.dot(&normal))
    }

    /// `p` \[m\] on the surface, or on the boundary for a boundary vertex.
    pub(super) fn projected(&self, v: u32, p: Vec3) -> Vec3 {
        match self.mesh.role[v as usize] {
            VertexRole::Interior => self.surface.project(p),
            VertexRole::Border => self.surface.project_on_border(p),
            VertexRole::Corner => self.mesh.at(v),
        }
    }

    /// Edges of wanted length, shortest first.
    fn edges_by_length(&self, wanted: impl Fn(f64) -> bool) -> Vec<(f64, [u32; 2])> {
        let all = self.mesh.edges().into_iter().map(|edge| (self.mesh.length(edge), edge));
        let mut edges: Vec<(f64, [u32; 2])> = all.filter(|(length, _)| wanted(*length)).collect();
        edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        edges
    }
}

/// The cross product of two edges of a triangle \[m²\].
fn cross([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a))
}

/// The least angle of a triangle \[rad\].
pub(crate) fn least_angle(corners: &[Vec3; 3]) -> f64 {
    let angle = |k: usize| {
        let (e, f) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
        libm::atan2(e.cross(&f).norm(), e.dot(&f))
    };
    angle(0).min(angle(1)).min(angle(2))
}
