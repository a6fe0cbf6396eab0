//! Crack faces as a net of corners: normals, neighbours, and where faces meet.

use super::Mosaic;
use cullet_geometry::Vec3;
use cullet_geometry::voronoi::WALL;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The faces between cells.
#[derive(Debug)]
pub(super) struct CellSheet {
    pub(super) places: Vec<Vec3>,
    /// Unit normals, from the first cell to the second; zero where faces meet.
    pub(super) normal: Vec<Vec3>,
    /// Whether a corner lies on a wall.
    pub(super) wall: Vec<bool>,
    /// Whether three or more faces meet at a corner, or it lies on a wall.
    pub(super) seam: Vec<bool>,
    edges: Vec<(u32, u32)>,
    /// Where the neighbours of a corner begin in `neighbours`.
    first: Vec<u32>,
    neighbours: Vec<u32>,
}

impl CellSheet {
    pub(super) fn new(mosaic: &Mosaic) -> Self {
        let n = mosaic.places.len();
        let (mut normal, mut wall) = (vec![Vec3::zeros(); n], vec![false; n]);
        let mut edges: Vec<(u32, u32)> = Vec::new();
        for facet in &mosaic.facets {
            let (a, b) = facet.cells;
            for &t in mosaic.of(facet) {
                if b >= WALL {
                    t.iter().for_each(|&v| wall[v as usize] = true);
                    continue;
                }
                let [p, q, r] = t.map(|v| mosaic.places[v as usize]);
                let twice = (q - p).cross(&(r - p)) * if a < b { 1.0 } else { -1.0 };
                t.iter().for_each(|&v| normal[v as usize] += twice);
                let [p, q, r] = t;
                edges.extend([(p, q), (q, r), (r, p)].map(|(p, q)| (p.min(q), p.max(q))));
            }
        }
        edges.sort_unstable();
        let mut seam = wall.clone();
        for group in edges.chunk_by(|a, b| a == b).filter(|group| group.len() != 2) {
            seam[group[0].0 as usize] = true;
            seam[group[0].1 as usize] = true;
        }
        edges.dedup();
        for (normal, &seam) in normal.iter_mut().zip(&seam) {
            let unit = normal.try_normalize(0.0).unwrap_or_default();
            *normal = if seam { Vec3::zeros() } else { unit };
        }
        let (first, neighbours) = lists(n, &edges);
        Self { places: mosaic.places.clone(), normal, wall, seam, edges, first, neighbours }
    }

    fn around(&self, v: usize) -> &[u32] {
        &self.neighbours[self.first[v] as usize..self.first[v + 1] as usize]
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        (self.places[a as usize] - self.places[b as usize]).norm()
    }

    /// How far each corner is from where faces meet, along edges, up to `most` \[m\].
    pub(super) fn to_seam(&self, most: f64) -> Vec<f64> {
        let mut distance = vec![most; self.places.len()];
        // The bits of numbers >= 0 sort like the numbers.
        let mut queue = BinaryHeap::new();
        for v in (0..distance.len()).filter(|&v| self.seam[v]) {
            distance[v] = 0.0;
            queue.push(Reverse((0, v as u32)));
        }
        while let Some(Reverse((bits, v))) = queue.pop() {
            if f64::from_bits(bits) > distance[v as usize] {
                continue;
            }
            for &w in self.around(v as usize) {
                let way = distance[v as usize] + self.length(v, w);
                if way < distance[w as usize] {
                    distance[w as usize] = way;
                    queue.push(Reverse((way.to_bits(), w)));
                }
            }
        }
        distance
    }

    /// Takes away what is steeper than `steepest` between two corners, half from each.
    pub(super) fn flatten(&self, heights: &mut [f64], steepest: f64) {
        for &(a, b) in &self.edges {
            let most = steepest * self.length(a, b);
            let (a, b) = (a as usize, b as usize);
            let step = heights[a] - heights[b];
            if step.abs() > most {
                let over = 0.5 * (step - most * step.signum());
                let share = |v: usize| f64::from(u8::from(!self.seam[v]));
                heights[a] -= over * share(a);
                heights[b] += over * share(b);
            }
        }
    }
}

fn lists(n: usize, edges: &[(u32, u32)]) -> (Vec<u32>, Vec<u32>) {
    let mut first = vec![0u32; n + 1];
    for &(a, b) in edges {
        first[a as usize + 1] += 1;
        first[b as usize + 1] += 1;
    }
    for v in 0..n {
        first[v + 1] += first[v];
    }
    let mut next = first.clone();
    let mut neighbours = vec![0; 2 * edges.len()];
    for &(a, b) in edges {
        for (v, w) in [(a, b), (b, a)] {
            neighbours[next[v as usize] as usize] = w;
            next[v as usize] += 1;
        }
    }
    (first, neighbours)
}
