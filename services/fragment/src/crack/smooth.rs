//! Corners of the net on the move: to where the edges of their cubes are crossed, then smoothed.

use super::lattice::Lattice;
use crate::region::Mosaic;
use cullet_geometry::Vec3;
use cullet_geometry::voronoi::WALL;

/// Corners stay this near to the middle of their cubes along every axis \[spacings\]: a little
/// beyond their sides, for a border may run along nodes ...
const ROOM: f64 = 0.8;
/// ... and smoothing moves them by no more than this (F26).
const MOVE: f64 = 0.5;
/// Taubin's two factors (Curve and Surface Smoothing without Shrinkage, 1995): waves shorter than
/// about eight edges go, longer ones stay as they are.
const SHRINK: f64 = 0.5;
const GROW: f64 = -0.526;
/// Rounds in which corners are moved on to the borders of sampled pieces.
const ROUNDS: usize = 8;
/// Pairs of steps.
const STEPS: usize = 16;

/// The corners of a surface net.
#[derive(Debug)]
pub(super) struct SurfaceNet {
    lattice: Lattice,
    /// The middle of the corner's cube \[m\].
    pub(super) middle: Vec<Vec3>,
    pub(super) place: Vec<Vec3>,
    pulls: Vec<f64>,
    free: Vec<bool>,
    locked: Vec<bool>,
    /// Pairs of sampled pieces whose borders pass through the corner's cube.
    drawn: Vec<Vec<(u32, u32)>>,
}

impl SurfaceNet {
    pub(super) fn new(lattice: Lattice) -> Self {
        let (middle, place, pulls) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            lattice,
            middle,
            place,
            pulls,
            free: Vec::new(),
            locked: Vec::new(),
            drawn: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, middle: Vec3) -> u32 {
        self.middle.push(middle);
        self.place.push(Vec3::zeros());
        self.pulls.push(0.0);
        self.free.push(false);
        self.locked.push(false);
        self.drawn.push(Vec::new());
        self.middle.len() as u32 - 1
    }

    /// An edge of the corner's cube is crossed at `place`; `free` if there is damage near by.
    pub(super) fn pull(&mut self, corner: u32, place: Vec3, free: bool) {
        let corner = corner as usize;
        self.place[corner] += place;
        self.pulls[corner] += 1.0;
        self.free[corner] |= free;
    }

    /// The border between two sampled pieces passes through the corner's cube.
    pub(super) fn lay(&mut self, corner: u32, pair: (u32, u32)) {
        self.drawn[corner as usize].push(pair);
    }

    /// Whether all faces at a corner are borders between sampled pieces.
    fn is_drawn(&self, v: usize) -> bool {
        let faces = self.drawn[v].len();
        !self.locked[v] && faces > 0 && faces as f64 == self.pulls[v]
    }

    /// Moves corners between sampled pieces to where all their borders meet, as far as that is in
    /// their cubes; `way` leads from a place to the border of a pair.
    pub(super) fn project(&mut self, way: impl Fn((u32, u32), &Vec3) -> Vec3) {
        let drawn: Vec<usize> = (0..self.place.len()).filter(|&v| self.is_drawn(v)).collect();
        for v in drawn {
            let mut place = self.place[v];
            for _ in 0..ROUNDS {
                for &pair in &self.drawn[v] {
                    place += way(pair, &place);
                }
            }
            let (from, way) = (self.place[v] - self.middle[v], place - self.place[v]);
            let half = 0.5 * self.lattice.spacing;
            let (from, along) = (self.lattice.along(from), self.lattice.along(way));
            let share = (0..3).map(|a| {
                let room = if along[a] > 0.0 { half - from[a] } else { -half - from[a] };
                if along[a] == 0.0 { 1.0 } else { (room / along[a]).max(0.0) }
            });
            self.place[v] += way * share.fold(1.0, f64::min);
        }
    }

    /// The corner stays where it is: on a wall, or in a gap between legs.
    pub(super) fn lock(&mut self, corner: u32) {
        self.locked[corner as usize] = true;
    }

    /// Moves every corner to the mean of its pulls; those of walls to the middle of their cubes.
    pub(super) fn settle(&mut self) {
        for v in 0..self.place.len() {
            let settled = self.pulls[v] > 0.0 && !self.locked[v];
            self.place[v] = if settled { self.place[v] / self.pulls[v] } else { self.middle[v] };
        }
    }

    /// Leaves corners this share of their way from the middle of their cubes.
    pub(super) fn retreat(&mut self, corners: impl IntoIterator<Item = usize>, share: f64) {
        for v in corners {
            self.place[v] = self.middle[v] + share * (self.place[v] - self.middle[v]);
        }
    }

    fn step(&mut self, threads: &[Vec<u32>], from: &[Vec3], factor: f64) {
        let old = self.place.clone();
        for (v, along) in threads.iter().enumerate().filter(|(_, along)| !along.is_empty()) {
            let mean = along.iter().map(|&w| old[w as usize]).sum::<Vec3>() / along.len() as f64;
            let next = old[v] + factor * (mean - old[v]);
            // What goes too far does not move: bent along a side, it would leave a flat face.
            let off = self.lattice.along(next - self.middle[v]);
            let near = off.amax() <= ROOM * self.lattice.spacing;
            if near && (next - from[v]).norm() <= MOVE * self.lattice.spacing {
                self.place[v] = next;
            }
        }
    }
}

/// Smooths the faces between labels. Corners where three or more faces meet, or a face ends, move
/// along those lines; those on walls and far from damage stay.
pub(super) fn shape(net: &mut SurfaceNet, mosaic: &Mosaic) {
    let threads = threads(net, mosaic);
    let from = net.place.clone();
    for _ in 0..STEPS {
        net.step(&threads, &from, SHRINK);
        net.step(&threads, &from, GROW);
    }
}

/// For each corner that may move, the corners that it is smoothed with.
fn threads(net: &SurfaceNet, mosaic: &Mosaic) -> Vec<Vec<u32>> {
    let mut edges: Vec<(u32, u32)> = Vec::new();
    for facet in mosaic.facets.iter().filter(|facet| facet.cells.1 < WALL) {
        let [a, b, c] = mosaic.of(facet)[0];
        let d = mosaic.of(facet)[1][2];
        edges.extend([(a, b), (b, c), (c, d), (d, a)].map(|(p, q)| (p.min(q), p.max(q))));
    }
    edges.sort_unstable();
    let mut plain = vec![Vec::new(); net.place.len()];
    let mut seams = vec![Vec::new(); net.place.len()];
    for group in edges.chunk_by(|a, b| a == b) {
        let (p, q) = group[0];
        let lists = if group.len() != 2 { &mut seams } else { &mut plain };
        lists[p as usize].push(q);
        lists[q as usize].push(p);
    }
    let mut threads = plain;
    for (v, seam) in seams.into_iter().enumerate() {
        if net.locked[v] || !net.free[v] || net.is_drawn(v) || seam.len() == 1 {
            threads[v].clear();
        } else if !seam.is_empty() {
            threads[v] = seam;
        }
    }
    threads
}
