//! Convex parts that stand in for a body in collisions.
//!
//! A part is a piece of the body's *surface*, clipped by planes, plus fans that close it for the
//! volume integral: a clipped surface has the same convex hull as the clipped solid, so no boolean
//! is needed and nothing can fail.

mod convex;
mod piece;
mod round;

pub use convex::{Hull, hull_volume};
pub use round::{radius_of_ball, spiral};

use crate::math::{Mat3, Vec3};
use crate::mesh::{Solid, bounds};
use piece::{HullPiece, extremes};

/// Most parts of one body; a collision engine pays for each.
pub const MAX_PARTS: u32 = 64;
/// Corners used to weigh a hull against its part; enough that a ball's hull keeps 9/10 of its
/// volume.
const PROBE_VERTICES: usize = 42;
/// A part whose corners spread less than this across their plane, over their spread in it \[1\], is
/// no part to divide off.
const FLATTEST: f64 = 1e-5;

/// How closely convex parts follow a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullSettings {
    /// At most this many parts, clamped to 1..=[`MAX_PARTS`].
    pub max_parts: u32,
    /// At most this many corners a part, at least 4.
    pub max_vertices: u32,
    /// A part is divided while its hull's volume exceeds its own by this factor \[1\].
    pub slack: f64,
    /// Each part is shrunk toward its centroid by this share \[1\], so that neighbours that share a
    /// face do not touch: contact normals at distance zero are unreliable.
    pub shrink: f64,
}

impl Default for HullSettings {
    fn default() -> Self {
        Self { max_parts: 8, max_vertices: 16, slack: 1.25, shrink: 0.005 }
    }
}

/// Corner sets \[m\] of convex parts that together stand in for the solid: at least one, each with
/// at least four corners that span a volume. The part with the greatest empty share is divided
/// first, by the best of six planes: across its three principal axes, through its centroid or
/// through its deepest hollow; a plane that cuts something flat off is none. A convex body gives
/// one part. Where no hull can be had (no volume, coordinates that are not finite), the answer is
/// the box around what is finite.
#[must_use]
pub fn convex_parts(solid: &Solid, settings: HullSettings) -> Vec<Vec<Vec3>> {
    let limit = settings.max_parts.clamp(1, MAX_PARTS) as usize;
    let max_vertices = settings.max_vertices.max(4) as usize;
    let shrink = settings.shrink.clamp(0.0, 0.5);
    let finished = |hull: &Hull| {
        let centre = hull.centroid();
        hull.vertices().iter().map(|p| centre + (1.0 - shrink) * (p - centre)).collect()
    };
    let mut parts: Vec<PieceWithHull> = match HullPiece::of(solid).and_then(weigh) {
        Some(whole) => vec![whole],
        None => return vec![box_around(&solid.mesh.vertices)],
    };
    while parts.len() < limit {
        let Some(worst) = worst(&parts, settings.slack) else {
            break;
        };
        let part = parts.swap_remove(worst);
        match divide(&part) {
            Some((a, b)) => parts.extend([a, b]),
            None => parts.push(PieceWithHull { divisible: false, ..part }),
        }
    }
    let hulls = parts.iter().filter_map(|p| Hull::of(&p.corners, max_vertices));
    let corners: Vec<Vec<Vec3>> = hulls.map(|h| finished(&h)).collect();
    if corners.is_empty() { vec![box_around(&solid.mesh.vertices)] } else { corners }
}

/// A piece beside its hull.
struct PieceWithHull {
    piece: HullPiece,
    /// Of its surface, each once.
    corners: Vec<Vec3>,
    hull: Hull,
    volume: f64,
    hull_volume: f64,
    divisible: bool,
}

impl PieceWithHull {
    /// Radius of gyration \[m\]. Weighing hulls with it breaks the tie of cuts that empty nothing
    /// yet (a ring in two half rings, or in two flat rings) in favour of compact parts.
    fn gyration(&self) -> f64 {
        (self.piece.moments().1.trace().max(0.0) / self.volume).sqrt()
    }

    /// Do its corners spread in all directions?
    fn is_thick(&self) -> bool {
        let middle = self.corners.iter().sum::<Vec3>() / self.corners.len() as f64;
        let spread = self.corners.iter().fold(Mat3::zeros(), |sum, p| {
            let arm = p - middle;
            sum + arm * arm.transpose()
        });
        let eigen = spread.symmetric_eigenvalues();
        eigen.min() > FLATTEST * FLATTEST * eigen.max()
    }
}

fn weigh(piece: HullPiece) -> Option<PieceWithHull> {
    let volume = piece.volume();
    let corners = piece.corners();
    let hull = Hull::of(&extremes(&corners), PROBE_VERTICES)?;
    let hull_volume = hull.volume();
    (volume > 0.0 && hull_volume > 0.0).then_some(PieceWithHull {
        piece,
        corners,
        hull,
        volume,
        hull_volume,
        divisible: true,
    })
}

/// The divisible part with the most empty space, if any has too much.
fn worst(parts: &[PieceWithHull], slack: f64) -> Option<usize> {
    let empty = |p: &PieceWithHull| p.hull_volume - p.volume;
    let candidates =
        parts.iter().enumerate().filter(|(_, p)| p.divisible && p.hull_volume > slack * p.volume);
    candidates.max_by(|(_, a), (_, b)| empty(a).total_cmp(&empty(b))).map(|(i, _)| i)
}

/// Divides a part by the plane that leaves the least hull volume in the most compact parts.
fn divide(part: &PieceWithHull) -> Option<(PieceWithHull, PieceWithHull)> {
    let (centroid, covariance) = part.piece.moments();
    let hollow = deepest(part);
    let axes = principal_axes(covariance);
    let mut best: Option<(f64, PieceWithHull, PieceWithHull)> = None;
    for (axis, through) in axes.iter().flat_map(|a| [(a, centroid), (a, hollow)]) {
        let (above, below) = part.piece.split(*axis, axis.dot(&through));
        let halves = (
            weigh(above).filter(PieceWithHull::is_thick),
            weigh(below).filter(PieceWithHull::is_thick),
        );
        if let (Some(a), Some(b)) = halves {
            let cost = a.hull_volume * a.gyration() + b.hull_volume * b.gyration();
            if best.as_ref().is_none_or(|(least, _, _)| cost < *least) {
                best = Some((cost, a, b));
            }
        }
    }
    best.map(|(_, a, b)| (a, b))
}

/// The surface point deepest inside the hull.
fn deepest(part: &PieceWithHull) -> Vec3 {
    let planes = part.hull.planes();
    let mut best = (f64::NEG_INFINITY, part.hull.centroid());
    for p in &part.corners {
        let depth = convex::depth(&planes, *p);
        if depth > best.0 {
            best = (depth, *p);
        }
    }
    best.1
}

/// Unit eigenvectors, made to point one way; the axes of space where there are none.
fn principal_axes(covariance: Mat3) -> [Vec3; 3] {
    let eigen = nalgebra::SymmetricEigen::new(covariance);
    let axis = |i: usize| eigen.eigenvectors.column(i).into_owned();
    let axes = [axis(0), axis(1), axis(2)];
    if axes.iter().all(|a| (a.norm() - 1.0).abs() < 1e-6) {
        axes
    } else {
        [Vec3::x(), Vec3::y(), Vec3::z()]
    }
}

/// Corners of a box around the finite points, with some thickness in every direction.
fn box_around(points: &[Vec3]) -> Vec<Vec3> {
    let finite: Vec<Vec3> =
        points.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
    let (low, high) = bounds(&finite).unwrap_or((Vec3::zeros(), Vec3::zeros()));
    let thickness = (1e-3 * (high - low).norm()).max(1e-6);
    let half = (0.5 * (high - low)).map(|h| h.max(thickness));
    let centre = 0.5 * (low + high);
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    (0..8)
        .map(|i| centre + half.component_mul(&Vec3::new(sign(i, 0), sign(i, 1), sign(i, 2))))
        .collect()
}

#[cfg(test)]
mod tests;
