//! What of a specimen's surface a load acts on.

use crate::clip::{clip, measure};
use crate::place::{Where, within};
use crate::problem::LoadKind;
use cullet_geometry::{TriMesh, Vec3};

/// Longest edge of a piece of surface that takes its load at one point, in spacings.
const LONGEST: f64 = 0.3;

/// Least share of such a piece that is any of it.
const LEAST: f64 = 1e-9;

/// A small piece of the surface, in the specimen's frame.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePiece {
    corners: [Vec3; 3],
    /// Where it takes its load \[m\].
    pub middle: Vec3,
    /// Outward normal times area \[m²\].
    pub area: Vec3,
    slack: f64,
}

impl SurfacePiece {
    /// What of it lies in a part: all as it is, or what is left where the part's bounds cut it.
    #[must_use]
    pub fn within(&self, part: &Where) -> Option<Self> {
        if self.corners.iter().all(|x| within(part, x, self.slack)) {
            return Some(*self);
        }
        let mut piece = self.corners.to_vec();
        clip(&mut piece, part, self.slack);
        let (middle, area) = measure(&piece);
        (area.norm() > LEAST * self.area.norm()).then_some(Self { middle, area, ..*self })
    }

    /// The force of a load on it \[N\]; none of loads that act on mass.
    #[must_use]
    pub fn force(&self, push: &LoadKind) -> Vec3 {
        match *push {
            LoadKind::Traction(traction) => traction * self.area.norm(),
            LoadKind::Pressure(pressure) => -self.area * pressure,
            LoadKind::Force(_) | LoadKind::Acceleration(_) => Vec3::zeros(),
        }
    }
}

/// The surface of a body in pieces much smaller than the spacing \[m\].
#[must_use]
pub fn pieces(mesh: &TriMesh, spacing: f64) -> Vec<SurfacePiece> {
    let (longest, slack) = (LONGEST * spacing, 1e-6 * spacing);
    let mut pieces = Vec::new();
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let edge = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let n = (edge / longest).ceil().max(1.0) as usize;
        let (u, v) = ((b - a) / n as f64, (c - a) / n as f64);
        let area = u.cross(&v) / 2.0;
        for i in 0..n {
            for j in 0..n - i {
                let corner = a + u * i as f64 + v * j as f64;
                let (right, left) = (corner + u, corner + v);
                let middle = corner + (u + v) / 3.0;
                pieces.push(SurfacePiece { corners: [corner, right, left], middle, area, slack });
                if i + j + 1 < n {
                    let middle = corner + (u + v) * (2.0 / 3.0);
                    let corners = [right, right + v, left];
                    pieces.push(SurfacePiece { corners, middle, area, slack });
                }
            }
        }
    }
    pieces
}
