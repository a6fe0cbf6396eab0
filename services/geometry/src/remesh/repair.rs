//! The end of a remeshing: the last valences out of bounds, the last thin triangles.

use super::passes::{Remeshing, least_angle};
use crate::math::Vec3;

/// Rounds in which valences are repaired.
const ROUNDS: usize = 12;
/// Rounds in which thin triangles are improved.
const POLISHES: usize = 12;
/// Longest edge over the spacing that the removal of a vertex may leave.
const LONGEST: f64 = 1.6;
/// Least angle of a triangle that a flip for the sake of a boundary vertex may make \[rad\]: 6°.
/// The vertices spread out afterwards.
const FORCED_ANGLE: f64 = 0.1;
/// Triangles are polished to this least angle \[rad\], 32°, …
const ANGLE: f64 = 0.5585;
/// … and edges to between these, over the spacing.
const EDGES: [f64; 2] = [0.68, 1.35];

impl Remeshing<'_> {
    /// Brings valences to 5–7, on a boundary to 3–5.
    pub(super) fn repair_valences(&mut self) {
        for round in 0..ROUNDS {
            for _ in 0..4 {
                if self.flip_to_valence(false) == 0 {
                    break;
                }
            }
            let count = self.mesh.points.len() as u32;
            let defects: Vec<u32> = (0..count).filter(|&v| self.is_defect(v)).collect();
            if defects.is_empty() {
                break;
            }
            for v in defects {
                if self.is_defect(v) {
                    self.repair(v, round);
                }
            }
            self.flip_to_valence(round % 2 == 1);
            self.flip_to_valence(false);
            self.relax();
            self.relax();
        }
        while self.flip_to_valence(false) > 0 {}
    }

    /// Removes a vertex with too few edges; divides the longest edge of one with too many.
    fn repair(&mut self, v: u32, round: usize) {
        let neighbours = self.mesh.neighbours(v);
        let length = |w: u32| self.mesh.length([v, w]);
        if self.mesh.valence(v) > self.mesh.target[v as usize] {
            let longest = neighbours.into_iter().max_by(|&a, &b| length(a).total_cmp(&length(b)));
            if let Some(w) = longest {
                self.split([v, w]);
            }
        } else if self.mesh.is_interior(v) {
            let excess = |w: u32| self.mesh.valence(w) as i64 - self.mesh.target[w as usize] as i64;
            let mut ends = neighbours;
            // The neighbours of the one that is kept lose an edge: those of it with most to spare.
            ends.sort_by_key(|&w| {
                let sides = self.mesh.sides([v, w]).into_iter().flatten();
                (-sides.map(|s| excess(s.across)).sum::<i64>(), w)
            });
            let reach = LONGEST + 0.02 * round as f64;
            for w in ends {
                if self.try_collapse(v, w, reach) {
                    break;
                }
            }
        } else {
            self.flip_across(v);
        }
    }

    /// Gives a boundary vertex one more edge: flips the edge across one of its triangles.
    fn flip_across(&mut self, v: u32) {
        for t in self.mesh.around[v as usize].clone() {
            let corners = self.mesh.triangles[t as usize];
            let k = corners.iter().position(|&w| w == v).unwrap_or(0);
            let edge = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
            if let Some((_, made)) = self.flip_gain(edge)
                && self.may_flip(edge, made, FORCED_ANGLE)
            {
                self.mesh.flip(edge);
                return;
            }
        }
    }

    /// Moves the vertices of thin triangles and of short and long edges to better places nearby.
    pub(super) fn polish(&mut self) {
        for round in 0..POLISHES {
            let mut step = 0.2 * self.spacing;
            if round % 3 == 1 {
                step *= 0.5;
            } else if round % 3 == 2 {
                step *= 0.25;
            }
            let mut moves = 0;
            for v in 0..self.mesh.points.len() as u32 {
                let score = self.score(v, self.mesh.at(v));
                if score < 1.0 && !self.mesh.around[v as usize].is_empty() {
                    moves += usize::from(self.improve(v, score, step));
                }
            }
            if moves == 0 && round >= 2 {
                break;
            }
        }
    }

    /// The best of eight places around a vertex, if it is better than where it is.
    fn improve(&mut self, v: u32, score: f64, step: f64) -> bool {
        let (here, normal) = (self.mesh.at(v), self.mesh.normal(v));
        let x = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize() * step;
        let y = normal.cross(&x);
        let diagonal = std::f64::consts::FRAC_1_SQRT_2;
        let ways = [x, y, (x + y) * diagonal, (x - y) * diagonal];
        let mut best = (score * (1.0 + 1e-9), here);
        for way in ways.into_iter().flat_map(|w| [w, -w]) {
            let p = self.projected(v, here + way);
            let score = self.score(v, p);
            if score > best.0 {
                best = (score, p);
            }
        }
        self.mesh.points[v as usize] = best.1;
        best.1 != here
    }

    /// How good the triangles around a vertex would be with it at `p` \[m\]: at least 1 if all are
    /// good, negative if one is turned over.
    fn score(&self, v: u32, p: Vec3) -> f64 {
        let normal = self.mesh.normal(v);
        let mut worst = f64::INFINITY;
        for &t in &self.mesh.around[v as usize] {
            let corners = self.mesh.triangles[t as usize];
            let points = corners.map(|w| if w == v { p } else { self.mesh.at(w) });
            let [a, b, c] = points;
            if (b - a).cross(&(c - a)).dot(&normal) <= 0.0 {
                return -1.0;
            }
            worst = worst.min(least_angle(&points) / ANGLE);
            for w in corners.into_iter().filter(|&w| w != v) {
                let length = (self.mesh.at(w) - p).norm() / self.spacing;
                worst = worst.min(length / EDGES[0]).min(EDGES[1] / length);
            }
        }
        worst
    }
}
