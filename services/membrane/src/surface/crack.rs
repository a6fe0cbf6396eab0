//! The lines of cracks in the sheet at rest.

use super::triangulation::{NONE, SheetTriangulation};
use cullet_model::membrane::SheetPlace;

/// How often a line is smoothed, and how far it goes to the middle of its neighbours each time.
/// Four times by a half takes the zigzag of the triangles away and leaves the crack's own bends.
const PASSES: u32 = 4;
const SHARE: f64 = 0.5;
/// A part of a cell keeps at least this much of the area that it had before smoothing \[1\].
const LEAST_AREA: f64 = 0.1;
/// Nodes that take too much area go half the way back, this often; after that all of it.
const HALVINGS: u32 = 5;

/// Cracks as lines from the middles of broken edges to the middles of their triangles. There one
/// broken edge is a tip, two are a cut, three a junction.
pub(super) struct CrackNet {
    /// Node of each edge, or [`NONE`].
    pub(super) of_edge: Vec<u32>,
    /// Node of each triangle, or [`NONE`].
    pub(super) of_triangle: Vec<u32>,
    /// Of the nodes \[m\].
    pub(super) places: Vec<SheetPlace>,
    /// Neighbours of each node along its lines, [`NONE`] where it has fewer.
    links: Vec<[u32; 3]>,
}

impl CrackNet {
    /// The smoothed lines of what is broken.
    pub(super) fn new(sheet: &SheetTriangulation, dead: &[bool]) -> Self {
        let mut net = Self::unsmoothed(sheet, dead);
        net.smooth(sheet);
        net
    }

    fn unsmoothed(sheet: &SheetTriangulation, dead: &[bool]) -> Self {
        let mut net = Self {
            of_edge: vec![NONE; sheet.edges.len()],
            of_triangle: vec![NONE; sheet.triangles.len()],
            places: Vec::new(),
            links: Vec::new(),
        };
        for (t, sides) in sheet.sides.iter().enumerate() {
            if !sides.iter().any(|&e| dead[e as usize]) {
                continue;
            }
            let centre = net.add(middle(&sheet.triangles[t].map(|v| sheet.places[v as usize])));
            net.of_triangle[t] = centre;
            for e in sides.map(|e| e as usize).into_iter().filter(|&e| dead[e]) {
                if net.of_edge[e] == NONE {
                    let ends = sheet.edges[e].map(|v| sheet.places[v as usize]);
                    net.of_edge[e] = net.add(middle(&ends));
                }
                net.link(centre, net.of_edge[e]);
            }
        }
        net
    }

    fn add(&mut self, place: SheetPlace) -> u32 {
        self.places.push(place);
        self.links.push([NONE; 3]);
        self.places.len() as u32 - 1
    }

    fn link(&mut self, a: u32, b: u32) {
        for (from, to) in [(a, b), (b, a)] {
            let free = self.links[from as usize].iter_mut().find(|link| **link == NONE);
            *free.expect("an edge has two triangles and a triangle three edges") = to;
        }
    }

    /// Tips and ends on the outline, which have one neighbour, stay.
    fn smooth(&mut self, sheet: &SheetTriangulation) {
        let plain = self.places.clone();
        for _ in 0..PASSES {
            let before = self.places.clone();
            for (place, links) in self.places.iter_mut().zip(&self.links) {
                let near = links.iter().filter(|&&link| link != NONE);
                let near: Vec<_> = near.map(|&link| before[link as usize]).collect();
                if near.len() > 1 {
                    let [x, y] = middle(&near);
                    *place = [place[0] + SHARE * (x - place[0]), place[1] + SHARE * (y - place[1])];
                }
            }
        }
        self.restrain(sheet, &plain);
    }

    /// Takes nodes back to where no part of a cell is turned over or nearly lost. Ends, since
    /// every round after the first few puts a node to its plain place for good.
    fn restrain(&mut self, sheet: &SheetTriangulation, plain: &[SheetPlace]) {
        let smooth = self.places.clone();
        let mut share = vec![1.0; plain.len()];
        for round in 0.. {
            let mut back = vec![false; plain.len()];
            for t in (0..sheet.triangles.len()).filter(|&t| self.of_triangle[t] != NONE) {
                for nodes in self.crowded(sheet, t).into_iter().flatten() {
                    nodes.iter().for_each(|&node| back[node as usize] = true);
                }
            }
            let moved = |&node: &usize| back[node] && share[node] > 0.0;
            let moved: Vec<usize> = (0..plain.len()).filter(moved).collect();
            if moved.is_empty() {
                return;
            }
            for node in moved {
                share[node] = if round < HALVINGS { 0.5 * share[node] } else { 0.0 };
                let (p, s, f) = (plain[node], smooth[node], share[node]);
                self.places[node] = [p[0] + f * (s[0] - p[0]), p[1] + f * (s[1] - p[1])];
            }
        }
    }

    /// For each side of a triangle, its node and that of the triangle if they take too much area
    /// of the parts between them.
    fn crowded(&self, sheet: &SheetTriangulation, t: usize) -> [Option<[u32; 2]>; 3] {
        let corners = sheet.triangles[t].map(|v| sheet.places[v as usize]);
        let third = area(corners[0], corners[1], corners[2]) / 3.0;
        let centre = self.of_triangle[t];
        let c = self.places[centre as usize];
        [0, 1, 2].map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let node = self.of_edge[sheet.sides[t][k] as usize];
            if node == NONE {
                return (area(a, b, c) < LEAST_AREA * third).then_some([centre; 2]);
            }
            let m = self.places[node as usize];
            let least = area(a, m, c).min(area(m, b, c));
            (least < LEAST_AREA * 0.5 * third).then_some([centre, node])
        })
    }
}

fn middle(places: &[SheetPlace]) -> SheetPlace {
    let share = 1.0 / places.len() as f64;
    let sum = places.iter().fold([0.0; 2], |sum: SheetPlace, p| [sum[0] + p[0], sum[1] + p[1]]);
    sum.map(|coordinate| coordinate * share)
}

/// Positive where the corners go round counter-clockwise.
pub(super) fn area([ax, ay]: SheetPlace, b: SheetPlace, c: SheetPlace) -> f64 {
    0.5 * ((b[0] - ax) * (c[1] - ay) - (b[1] - ay) * (c[0] - ax))
}
