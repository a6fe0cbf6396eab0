//! Rims that cracks have left: jagged finer than cells can follow, about holes smaller than cells.

use super::WallSurface;
use crate::inside::Nearest;
use crate::math::Vec3;

/// Edges about a hole that is closed: some four cells wide.
const HOLE: usize = 12;

/// Rounds in which triangles that hang on by one edge only are taken off a rim: a tooth has up to
/// two.
const EARS: usize = 3;

/// Passes over a rim.
const PASSES: usize = 40;

/// How far a vertex goes towards the middle of its neighbours, in one pass after the other: what
/// turns within four edges is gone in the end, what does within ten stays \[Taubin 1995, *A signal
/// processing approach to fair surface design*\].
const SHARES: [f64; 2] = [0.5, -0.53];

/// Rings of vertices beside a rim that follow it.
const RINGS: usize = 3;

impl WallSurface {
    /// The same without holes of at most [`HOLE`] edges, and with rims that are smooth over some
    /// four. What is beside them follows, on the surface.
    pub(super) fn with_smooth_rims(mut self) -> Self {
        self.close_holes();
        (0..EARS).for_each(|_| self.clip_ears());
        let nearest = Nearest::new(&self.mesh());
        let (loops, around) = (self.boundary(), self.around());
        let followers = beside(&loops, &around);
        for pass in 0..PASSES {
            for points in &loops {
                let n = points.len();
                let at = |i: usize| self.vertices[points[i % n] as usize];
                let middle = |i: usize| 0.5 * (at(i + n - 1) + at(i + 1));
                let moved = |i: usize| at(i).lerp(&middle(i), SHARES[pass % 2]);
                let moved: Vec<Vec3> = (0..n).map(moved).collect();
                points.iter().zip(moved).for_each(|(&v, x)| self.vertices[v as usize] = x);
            }
            for &v in &followers {
                let list = &around[v as usize];
                let sum: Vec3 = list.iter().map(|&w| self.vertices[w as usize]).sum();
                let x = self.vertices[v as usize].lerp(&(sum / list.len() as f64), SHARES[0]);
                self.vertices[v as usize] = nearest.closest(x).map_or(x, |(q, _, _)| q);
            }
        }
        self
    }

    /// Closes holes of few edges by a fan about their middle; the longest rim is the outer one.
    fn close_holes(&mut self) {
        let mut loops = self.boundary();
        loops.sort_by_key(|points| std::cmp::Reverse(points.len()));
        for points in loops.iter().skip(1).filter(|points| points.len() <= HOLE) {
            let n = points.len();
            let middle = self.vertices.len() as u32;
            let at = |v: &u32| self.vertices[*v as usize];
            self.vertices.push(points.iter().map(at).sum::<Vec3>() / n as f64);
            let thick = |v: &u32| self.thickness[*v as usize];
            self.thickness.push(points.iter().map(thick).sum::<f64>() / n as f64);
            let fan = (0..n).map(|i| [points[(i + 1) % n], points[i], middle]);
            self.triangles.extend(fan);
        }
    }

    /// Takes off the triangles with two edges on a rim, which smoothing would turn over.
    fn clip_ears(&mut self) {
        let mut open = self.mesh().open_edges();
        open.sort_unstable();
        let is_open = |a: u32, b: u32| open.binary_search(&[a, b]).is_ok();
        let edges = |t: &[u32; 3]| (0..3).filter(|&k| is_open(t[k], t[(k + 1) % 3])).count();
        self.triangles.retain(|t| edges(t) < 2);
        let mut number = vec![u32::MAX; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&v| number[v as usize] = 0);
        let mut next = 0;
        for n in number.iter_mut().filter(|n| **n == 0) {
            (*n, next) = (next, next + 1);
        }
        let is_kept = |v: usize| number[v] != u32::MAX;
        let kept: Vec<usize> = (0..number.len()).filter(|&v| is_kept(v)).collect();
        self.vertices = kept.iter().map(|&v| self.vertices[v]).collect();
        self.thickness = kept.iter().map(|&v| self.thickness[v]).collect();
        for v in self.triangles.iter_mut().flatten() {
            *v = number[*v as usize];
        }
    }

    /// The vertices beside each, ascending.
    fn around(&self) -> Vec<Vec<u32>> {
        let mut around = vec![Vec::new(); self.vertices.len()];
        for corners in &self.triangles {
            for k in 0..3 {
                let others = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
                around[corners[k] as usize].extend(others);
            }
        }
        for list in &mut around {
            list.sort_unstable();
            list.dedup();
        }
        around
    }
}

/// The vertices of the first [`RINGS`] rings beside `loops`, ascending.
fn beside(loops: &[Vec<u32>], around: &[Vec<u32>]) -> Vec<u32> {
    let mut seen = vec![false; around.len()];
    let mut front: Vec<u32> = loops.iter().flatten().copied().collect();
    front.iter().for_each(|&v| seen[v as usize] = true);
    let mut found = Vec::new();
    for _ in 0..RINGS {
        let near = front.iter().flat_map(|&v| &around[v as usize]).copied();
        let next: Vec<u32> =
            near.filter(|&w| !std::mem::replace(&mut seen[w as usize], true)).collect();
        found.extend(&next);
        front = next;
    }
    found.sort_unstable();
    found
}

#[cfg(test)]
mod tests {
    use super::super::WallSurface;
    use crate::math::Vec3;

    /// A flat sheet of 24 × 24 squares in triangles, without the squares that `is_off`.
    fn sheet(is_off: impl Fn(u32, u32) -> bool) -> WallSurface {
        let n = 24;
        let corners = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
        let place = |(i, j): (u32, u32)| Vec3::new(f64::from(i), f64::from(j), 0.0);
        let vertices: Vec<Vec3> = corners.map(place).collect();
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let squares = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let triangles = squares.filter(|&(i, j)| !is_off(i, j)).flat_map(|(i, j)| {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            [[a, b, c], [a, c, d]]
        });
        let triangles = triangles.collect();
        let thickness = vec![0.5; vertices.len()];
        WallSurface { vertices, triangles, thickness }
    }

    /// The sharpest turn of a rim: cosine, over one edge to each side.
    fn sharpest(surface: &WallSurface, points: &[u32]) -> f64 {
        let n = points.len();
        let at = |i: usize| surface.vertices[points[i % n] as usize];
        let turn = |i: usize| {
            let (a, b) = (at(i) - at(i + n - 1), at(i + 1) - at(i));
            a.dot(&b) / (a.norm() * b.norm())
        };
        (0..n).map(turn).fold(1.0, f64::min)
    }

    /// Teeth of a rim go, and the sheet keeps its area; a hole of a few cells is closed, and a
    /// large one is not.
    #[test]
    fn jagged_rims_become_smooth_and_small_holes_closed() {
        let toothed = sheet(|i, j| j == 23 && i % 2 == 0);
        let teeth = toothed.boundary();
        assert!(sharpest(&toothed, &teeth[0]) < 0.1);
        let smooth = toothed.clone().with_smooth_rims();
        let worst = sharpest(&smooth, &smooth.boundary()[0]);
        assert!(worst > 0.5, "{worst}");
        let share = smooth.area() / toothed.area();
        assert!((share - 1.0).abs() < 0.04, "{share}");
        let mesh = smooth.mesh();
        let up = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(&(c - a)).z
        };
        assert!((0..mesh.triangles.len()).all(|t| up(t) > 0.0), "a triangle lies face down");

        let holed =
            sheet(|i, j| (i, j) == (5, 5) || ((12..18).contains(&i) && (12..18).contains(&j)));
        assert_eq!(holed.boundary().len(), 3);
        let closed = holed.with_smooth_rims();
        assert_eq!(closed.boundary().len(), 2);
        assert_eq!(closed.vertices.len(), closed.thickness.len());
    }
}
