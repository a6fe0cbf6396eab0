//! Rims that cracks have left: jagged finer than cells can follow, about holes smaller than cells.

use super::WallSurface;
use crate::inside::Nearest;
use crate::math::Vec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Edges about the largest hole that is closed: some four cells wide.
const MOST_HOLE_EDGES: usize = 12;

/// Triangles of the least surface whose holes are closed: the outline of a smaller one is as short.
const LEAST_HOLED: usize = 100;

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

/// A midsurface, and which vertices of its rims a crack has left: then or before they were filled.
pub(super) struct CrackedRims {
    surface: WallSurface,
    /// Length of most edges \[m\].
    spacing: f64,
    /// By vertex.
    is_crack: Vec<bool>,
}

impl CrackedRims {
    /// Of a midsurface with edges of about `spacing` \[m\], `is_crack` saying whether a crack left
    /// the rim at a place \[m\].
    pub(super) fn new(surface: WallSurface, spacing: f64, is_crack: impl Fn(Vec3) -> bool) -> Self {
        let mut found = vec![false; surface.vertices.len()];
        for v in surface.boundary().into_iter().flatten() {
            found[v as usize] = is_crack(surface.vertices[v as usize]);
        }
        Self { surface, spacing, is_crack: found }
    }

    /// The surface with rims of cracks smooth over some four edges, and without their holes and
    /// narrow bays of at most [`MOST_HOLE_EDGES`]; shorter rims stay. What is beside them follows,
    /// on the surface.
    pub(super) fn smooth(mut self) -> WallSurface {
        self.close_holes();
        self.close_bays();
        self.close_holes();
        (0..EARS).for_each(|_| self.clip_ears());
        let Self { mut surface, is_crack, .. } = self;
        let nearest = Nearest::new(&surface.mesh());
        let mut loops = surface.boundary();
        let around = around(&surface);
        let followers = beside(&loops, &is_crack, &around);
        loops.retain(|points| points.len() > MOST_HOLE_EDGES);
        for pass in 0..PASSES {
            for points in &loops {
                let n = points.len();
                let at = |i: usize| surface.vertices[points[i % n] as usize];
                let middle = |i: usize| 0.5 * (at(i + n - 1) + at(i + 1));
                let moved = |i: usize| at(i).lerp(&middle(i), SHARES[pass % 2]);
                let moved: Vec<Vec3> = (0..n).map(moved).collect();
                let movable = points.iter().zip(moved).filter(|(v, _)| is_crack[**v as usize]);
                movable.for_each(|(&v, x)| surface.vertices[v as usize] = x);
            }
            for &v in &followers {
                let list = &around[v as usize];
                let sum: Vec3 = list.iter().map(|&w| surface.vertices[w as usize]).sum();
                let x = surface.vertices[v as usize].lerp(&(sum / list.len() as f64), SHARES[0]);
                surface.vertices[v as usize] = nearest.closest(x).map_or(x, |(q, _, _)| q);
            }
        }
        surface
    }

    /// Closes holes of few edges that cracks have left.
    fn close_holes(&mut self) {
        if self.surface.triangles.len() < LEAST_HOLED {
            return;
        }
        for points in self.surface.boundary() {
            if points.len() <= MOST_HOLE_EDGES && points.iter().all(|&v| self.is_crack[v as usize])
            {
                self.fill(&points);
            }
        }
    }

    /// Closes bays of few edges that cracks have left and whose mouth is no wider than an edge:
    /// cells could not follow both sides of it.
    fn close_bays(&mut self) {
        while let Some(points) = self.bay() {
            self.fill(&points);
        }
    }

    /// A bay, from one side of its mouth to the other.
    fn bay(&self) -> Option<Vec<u32>> {
        let surface = &self.surface;
        let around = around(surface);
        let turn = turns(surface);
        let of_loop = |points: &Vec<u32>| {
            let n = points.len();
            let at = |k: usize| points[k % n];
            let place = |k: usize| surface.vertices[at(k) as usize];
            let gap = |a: usize, b: usize| (place(a) - place(b)).norm();
            let is_bay = |&(edges, i): &(usize, usize)| {
                let (a, b) = (i, i + edges);
                gap(a, b) < self.spacing
                    && gap(a + n - 1, b + 1) >= self.spacing
                    && (a + 1..b).all(|k| self.is_crack[at(k) as usize])
                    && (a + 1..b).map(|k| turn[at(k) as usize]).sum::<f64>() < -FRAC_PI_2
                    && around[at(a) as usize].binary_search(&at(b)).is_err()
            };
            let all = (2..=MOST_HOLE_EDGES.min(n / 2)).rev();
            let found = all.flat_map(|edges| (0..n).map(move |i| (edges, i))).find(is_bay);
            found.map(|(edges, i)| (i..=i + edges).map(at).collect())
        };
        surface.boundary().iter().find_map(of_loop)
    }

    /// A fan about the middle of `points` of a rim, one after the other, and from last to first.
    fn fill(&mut self, points: &[u32]) {
        let Self { surface, is_crack, .. } = self;
        let n = points.len();
        let middle = surface.vertices.len() as u32;
        let at = |v: &u32| surface.vertices[*v as usize];
        let place = points.iter().map(at).sum::<Vec3>() / n as f64;
        let thick = |v: &u32| surface.thickness[*v as usize];
        let thickness = points.iter().map(thick).sum::<f64>() / n as f64;
        surface.vertices.push(place);
        surface.thickness.push(thickness);
        surface.triangles.extend((0..n).map(|i| [points[(i + 1) % n], points[i], middle]));
        is_crack.push(true);
    }

    /// Takes off the triangles with two edges on a rim of a crack, which smoothing would turn over.
    fn clip_ears(&mut self) {
        let Self { surface, is_crack, .. } = self;
        let mut open = surface.mesh().open_edges();
        open.sort_unstable();
        let is_open =
            |t: &[u32; 3], k: usize| open.binary_search(&[t[k % 3], t[(k + 1) % 3]]).is_ok();
        let peak = |t: &[u32; 3]| (0..3).find(|&k| is_open(t, k + 2) && is_open(t, k));
        surface.triangles.retain(|t| peak(t).is_none_or(|k| !is_crack[t[k] as usize]));
        let mut number = vec![u32::MAX; surface.vertices.len()];
        surface.triangles.iter().flatten().for_each(|&v| number[v as usize] = 0);
        let kept: Vec<usize> = (0..number.len()).filter(|&v| number[v] == 0).collect();
        kept.iter().enumerate().for_each(|(n, &v)| number[v] = n as u32);
        surface.vertices = kept.iter().map(|&v| surface.vertices[v]).collect();
        surface.thickness = kept.iter().map(|&v| surface.thickness[v]).collect();
        *is_crack = kept.iter().map(|&v| is_crack[v]).collect();
        for v in surface.triangles.iter_mut().flatten() {
            *v = number[*v as usize];
        }
    }
}

/// How far a rim turns to the left at each of its vertices \[rad\]; within a surface, where the
/// triangles about a vertex make up a full turn, −π.
fn turns(surface: &WallSurface) -> Vec<f64> {
    let mut turn = vec![PI; surface.vertices.len()];
    for corners in &surface.triangles {
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|i| surface.vertices[corners[(k + i) % 3] as usize]);
            let (e, f) = (b - a, c - a);
            turn[corners[k] as usize] -= libm::atan2(e.cross(&f).norm(), e.dot(&f));
        }
    }
    turn
}

/// The vertices beside each, ascending.
fn around(surface: &WallSurface) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); surface.vertices.len()];
    for corners in &surface.triangles {
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

/// What was filled, and the vertices of the first [`RINGS`] rings beside that and what is a crack
/// of the rims `loops`, ascending.
fn beside(loops: &[Vec<u32>], is_crack: &[bool], around: &[Vec<u32>]) -> Vec<u32> {
    let mut seen = vec![false; around.len()];
    loops.iter().flatten().for_each(|&v| seen[v as usize] = true);
    let mut front: Vec<u32> = (0..around.len() as u32).filter(|&v| is_crack[v as usize]).collect();
    let mut found: Vec<u32> = front.iter().copied().filter(|&v| !seen[v as usize]).collect();
    found.iter().for_each(|&v| seen[v as usize] = true);
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
    use super::CrackedRims;
    use crate::math::Vec3;
    use std::f64::consts::TAU;

    /// A sheet of 24 × 24 squares in triangles, bent to a quarter of a tube, without the squares
    /// that `is_off`.
    fn sheet(is_off: impl Fn(u32, u32) -> bool) -> WallSurface {
        let (n, radius) = (24, 96.0 / TAU);
        let corners = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
        let place = |(i, j): (u32, u32)| {
            let angle = f64::from(i) / radius;
            Vec3::new(radius * angle.sin(), f64::from(j), radius * angle.cos())
        };
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

    /// The sharpest turn of a rim above y = `low`: cosine, over one edge to each side.
    fn sharpest(surface: &WallSurface, points: &[u32], low: f64) -> f64 {
        let n = points.len();
        let at = |i: usize| surface.vertices[points[i % n] as usize];
        let turn = |i: usize| {
            let (a, b) = (at(i) - at(i + n - 1), at(i + 1) - at(i));
            a.dot(&b) / (a.norm() * b.norm())
        };
        (0..n).filter(|&i| at(i).y > low).map(turn).fold(1.0, f64::min)
    }

    /// Every triangle faces outward, and the area is within a share of `area`.
    fn assert_sound(surface: &WallSurface, area: f64, off: f64) {
        let mesh = surface.mesh();
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let out = Vec3::new(a.x, 0.0, a.z);
            assert!((b - a).cross(&(c - a)).dot(&out) > 0.0, "triangle {t} is turned over");
        }
        let share = surface.area() / area;
        assert!((share - 1.0).abs() < off, "{share} of the area");
        assert_eq!(surface.vertices.len(), surface.thickness.len());
    }

    /// Teeth of a rim go that are wider than ears, and the sheet keeps its area; a rim that no
    /// crack left keeps all of them.
    #[test]
    fn jagged_rims_of_cracks_become_smooth() {
        let toothed = sheet(|i, j| j >= 22 && (i / 2) % 2 == 0);
        let area = toothed.area();
        assert!(sharpest(&toothed, &toothed.boundary()[0], 18.0) < 0.1);
        let smooth = CrackedRims::new(toothed.clone(), 1.0, |x| x.y > 18.0).smooth();
        let worst = sharpest(&smooth, &smooth.boundary()[0], 18.0);
        assert!(worst > 0.4, "{worst}");
        assert_sound(&smooth, area, 0.04);
        let low = |s: &WallSurface| {
            s.boundary()[0].iter().filter(|&&v| s.vertices[v as usize].y == 0.0).count()
        };
        assert_eq!(low(&smooth), low(&toothed), "a rim that no crack left has changed");
        let narrow = sheet(|i, j| j == 23 && i % 2 == 0);
        let area = narrow.area();
        assert_sound(&CrackedRims::new(narrow, 1.0, |x| x.y > 18.0).smooth(), area, 0.04);
        let kept = CrackedRims::new(toothed.clone(), 1.0, |_| false).smooth();
        let places = |s: &WallSurface| -> Vec<Vec3> {
            s.triangles.iter().flatten().map(|&v| s.vertices[v as usize]).collect()
        };
        assert_eq!(places(&kept), places(&toothed));
    }

    /// Holes of a few cells that cracks left are closed; others are not.
    #[test]
    fn small_holes_of_cracks_are_closed() {
        let within = |k: u32| (12..18).contains(&k);
        let holed = sheet(|i, j| (i, j) == (5, 5) || (within(i) && within(j)));
        let area = holed.area();
        assert_eq!(holed.boundary().len(), 3);
        let closed = CrackedRims::new(holed.clone(), 1.0, |_| true).smooth();
        assert_eq!(closed.boundary().len(), 2);
        assert_sound(&closed, area, 0.03);
        assert!(closed.mesh().non_manifold_edges().is_empty());
        let drilled = CrackedRims::new(holed, 1.0, |x| x.y > 8.0).smooth();
        assert_eq!(drilled.boundary().len(), 3);
    }

    /// A slit of a crack is closed if it is narrow and short; a wide one, a long one, a tongue and
    /// a rim that no crack left stay.
    #[test]
    fn narrow_bays_of_cracks_are_closed() {
        let edges = |s: &WallSurface| s.boundary()[0].len();
        let slit = |deep: u32, wide: u32| {
            sheet(move |i, j| j >= 24 - deep && (10..10 + wide).contains(&i))
        };
        // Below the rim of the sheet that it enters from.
        let closed = |surface: &WallSurface, width: f64, is_crack: bool| {
            let mut rims = CrackedRims::new(surface.clone(), width, |x| is_crack && x.y < 23.5);
            rims.close_bays();
            rims.surface
        };
        let short = slit(4, 1);
        let shut = closed(&short, 1.1, true);
        assert_eq!((edges(&short), edges(&shut)), (104, 96));
        assert_sound(&shut, short.area() + 4.0, 0.01);
        assert!(shut.mesh().non_manifold_edges().is_empty());
        let tongue = sheet(|i, j| j >= 20 && !(10..12).contains(&i));
        for (kept, width, is_crack) in [
            (&short, 1.1, false),
            (&short, 0.9, true),
            (&slit(4, 2), 1.1, true),
            (&slit(8, 1), 1.1, true),
            (&tongue, 2.1, true),
        ] {
            assert_eq!(edges(&closed(kept, width, is_crack)), edges(kept), "{width} {is_crack}");
        }
    }
}
