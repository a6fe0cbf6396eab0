//! Division of long edges of a mosaic without moving its faces.

use super::Mosaic;
use cullet_geometry::Vec3;
use cullet_geometry::divide::{divide_triangle, key};

/// Passes after which division stops; each halves the longest edges.
const PASSES: usize = 12;

/// A middle of an edge: its ends, and its own number.
type Middle = ([u32; 2], u32);

impl Mosaic {
    /// Divides every edge longer than `edge` \[m\] that is `wanted` (by its ends and its middle) at
    /// its middle, longest edges of their triangles first. Returns the two ends of each new corner,
    /// in order: earlier corners.
    pub(crate) fn refine(
        &mut self,
        edge: f64,
        most: usize,
        wanted: impl Fn([Vec3; 3]) -> bool + Sync,
    ) -> Vec<[u32; 2]> {
        let mut ends = Vec::new();
        for _ in 0..PASSES {
            let middles = self.middles(edge, &wanted);
            if middles.is_empty() || self.triangles.len() + 2 * middles.len() > most {
                break;
            }
            for &([a, b], _) in &middles {
                let middle = 0.5 * (self.places[a as usize] + self.places[b as usize]);
                self.places.push(middle);
                ends.push([a, b]);
            }
            self.divide(&middles);
        }
        ends
    }

    fn middles(&self, edge: f64, wanted: &(impl Fn([Vec3; 3]) -> bool + Sync)) -> Vec<Middle> {
        use rayon::prelude::*;
        let limit = edge * edge;
        let longest = |corners: &[u32; 3]| {
            let length = |i: usize| {
                let [a, b] = key(corners[i], corners[(i + 1) % 3]).map(|v| self.places[v as usize]);
                (b - a).norm_squared()
            };
            let lengths = [length(0), length(1), length(2)];
            let i = (1..3).fold(0, |best, i| if lengths[i] > lengths[best] { i } else { best });
            (lengths[i] > limit).then(|| key(corners[i], corners[(i + 1) % 3]))
        };
        let mut edges: Vec<[u32; 2]> = self.triangles.par_iter().filter_map(longest).collect();
        edges.par_sort_unstable();
        edges.dedup();
        let some = |edge: &[u32; 2]| {
            let [a, b] = edge.map(|v| self.places[v as usize]);
            wanted([a, b, 0.5 * (a + b)])
        };
        let edges: Vec<[u32; 2]> = edges.into_par_iter().filter(some).collect();
        let first = self.places.len() as u32;
        edges.into_iter().enumerate().map(|(k, edge)| (edge, first + k as u32)).collect()
    }

    /// Divides the triangles at the middles of their edges, which are in order.
    fn divide(&mut self, middles: &[Middle]) {
        let old = std::mem::take(&mut self.triangles);
        let mut new = Vec::with_capacity(old.len() + 2 * middles.len());
        let middle = |edge: [u32; 2]| {
            let found = middles.binary_search_by_key(&edge, |entry| entry.0);
            found.ok().map(|k| middles[k].1)
        };
        for facet in &mut self.facets {
            let from = new.len() as u32;
            for &corners in &old[facet.start as usize..facet.end as usize] {
                divide_triangle(&self.places, corners, middle, &mut new);
            }
            (facet.start, facet.end) = (from, new.len() as u32);
        }
        self.triangles = new;
    }
}
