//! Where the corners of the quads lie: a field of square lattices along the crosses.

use super::hierarchy::FieldLevel;
use super::phase;
use crate::math::Vec3;

/// Gauss–Seidel sweeps of the lattices.
const SWEEPS: usize = 6;

/// A square lattice in the tangent plane of a vertex.
#[derive(Clone, Copy, Debug)]
struct LocalLattice {
    /// Where the plane touches the surface \[m\].
    at: Vec3,
    normal: Vec3,
    /// The directions of its rows and columns.
    axes: [Vec3; 2],
    /// One of its points \[m\].
    origin: Vec3,
    /// Distance of its points \[m\].
    side: f64,
}

impl LocalLattice {
    fn new(level: &FieldLevel, v: usize, arm: Vec3, origin: Vec3, side: f64) -> Self {
        let (at, normal) = (level.points[v], level.normals[v]);
        Self { at, normal, axes: [arm, normal.cross(&arm)], origin, side }
    }

    /// The lattice point whose steps from the origin `round` makes of those to `p`.
    fn point(&self, p: Vec3, round: impl Fn(f64) -> f64) -> Vec3 {
        let way = p - self.origin;
        let step = |axis: Vec3| axis * (round(way.dot(&axis) / self.side) * self.side);
        self.origin + step(self.axes[0]) + step(self.axes[1])
    }

    /// The four lattice points around `p`.
    fn around(&self, p: Vec3) -> [Vec3; 4] {
        let low = self.point(p, f64::floor);
        let [x, y] = self.axes.map(|axis| axis * self.side);
        [low, low + x, low + y, low + x + y]
    }

    /// The nearest pair of points of two lattices, near the middle between their vertices.
    fn nearest_points(&self, other: &Self) -> (Vec3, Vec3) {
        let middle = self.middle(other);
        let (ours, theirs) = (self.around(middle), other.around(middle));
        let mut best = (f64::INFINITY, ours[0], theirs[0]);
        for a in ours {
            for b in theirs {
                let distance = (a - b).norm_squared();
                if distance < best.0 {
                    best = (distance, a, b);
                }
            }
        }
        (best.1, best.2)
    }

    /// The point of both tangent planes that is nearest to the two vertices.
    fn middle(&self, other: &Self) -> Vec3 {
        let (way, cosine) = (other.at - self.at, self.normal.dot(&other.normal));
        let (rise, fall) = (self.normal.dot(&way), -other.normal.dot(&way));
        // Parallel planes have no common line: the small term takes the point between them.
        let scale = 2.0 / (1.0 - cosine * cosine + 1e-4);
        let ours = scale * (rise - cosine * fall);
        let theirs = scale * (fall - cosine * rise);
        0.5 * (self.at + other.at) - 0.25 * (self.normal * ours + other.normal * theirs)
    }
}

/// For each vertex the nearest point of its lattice of this `side` \[m\], on the finest level.
/// Neighbours' lattices fit each other, and rows lie on rims \[Jakob et al. 2015, section 4.2\].
pub(super) fn positions(
    levels: &[FieldLevel],
    directions: &[Vec<Vec3>],
    side: f64,
    seed: u64,
) -> Vec<Vec3> {
    let mut field = phase::lattice_points(levels, directions, side, seed);
    for _ in 0..SWEEPS {
        sweep(&levels[0], &directions[0], side, &mut field);
    }
    field
}

/// Replaces each lattice by the mean of those around it.
fn sweep(level: &FieldLevel, arms: &[Vec3], side: f64, field: &mut [Vec3]) {
    for v in 0..field.len() {
        let mut own = LocalLattice::new(level, v, arms[v], field[v], side);
        let mut whole = 0.0;
        for &(w, weight) in level.neighbours(v) {
            let w = w as usize;
            let other = LocalLattice::new(level, w, arms[w], field[w], side);
            let (a, b) = own.nearest_points(&other);
            let mean = (a * whole + b * weight) / (whole + weight);
            own.origin = mean - own.normal * (mean - own.at).dot(&own.normal);
            whole += weight;
        }
        if let Some(hold) = level.holds[v] {
            let along = if hold.is_corner { 0.0 } else { hold.along.dot(&(own.origin - hold.at)) };
            own.origin = hold.at + hold.along * along;
        }
        field[v] = own.point(own.at, f64::round);
    }
}
