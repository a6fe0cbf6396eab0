//! Points of a body that lie at its surface, and carry it.

use crate::carriers::Carriers;
use crate::pressed_body::PressedBody;
use cullet_geometry::inside::Nearest;
use cullet_geometry::shapes::refine;
use cullet_geometry::{TriMesh, Vec3};

/// Depth under the surface, in cells, down to which points lie at it \[1\]: half of their distance.
const DEPTH: f64 = 0.35;

/// Longest edge of the triangles whose areas are shared out, in cells.
const FINE: f64 = 0.5;

/// A point at the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceParticle {
    /// Its number in the order in which points were sampled.
    pub id: u32,
    /// The surface that it stands for \[m²\].
    pub area: f64,
    /// From it to the surface, before the hit \[m\].
    pub offset: Vec3,
}

/// All of a body's.
#[derive(Clone, Debug)]
pub struct SurfaceParticles {
    /// In the order of their numbers, then those that tears have laid open.
    pub all: Vec<SurfaceParticle>,
    /// The whole surface \[m²\].
    pub area: f64,
    /// Size of a cell \[m\].
    pub spacing: f64,
    /// Whether a point is one of them, by its number.
    known: Vec<bool>,
}

impl SurfaceParticle {
    /// The place of the surface at the point \[m\].
    #[must_use]
    pub fn place(&self, body: &impl PressedBody) -> Vec3 {
        let (now, gradient) = body.point_now(self.id);
        let offset = self.offset + gradient * self.offset;
        now + offset
    }
}

impl SurfaceParticles {
    /// Of points at their places before the hit, in the order of their numbers, in a body of cells
    /// of `spacing`, each as wide as two points \[m\].
    #[must_use]
    pub fn new(points: impl IntoIterator<Item = Vec3>, spacing: f64, mesh: &TriMesh) -> Self {
        let nearest = Nearest::new(mesh);
        let (mut all, mut places, mut known) = (Vec::new(), Vec::new(), Vec::new());
        for (id, place) in (0..).zip(points) {
            known.push(false);
            let Some((closest, _, _)) = nearest.closest(place) else { continue };
            let offset = closest - place;
            if offset.norm() <= DEPTH * spacing {
                all.push(SurfaceParticle { id, area: 0.0, offset });
                places.push(place);
                known[id as usize] = true;
            }
        }
        let mut points = Self { all, area: 0.0, spacing, known };
        if points.all.is_empty() {
            return points;
        }
        let carriers = Carriers::new(places, spacing);
        let fine = refine(mesh, FINE * spacing).unwrap_or_else(|_| mesh.clone());
        for t in 0..fine.triangles.len() {
            let [a, b, c] = fine.corners(t);
            let area = 0.5 * (b - a).cross(&(c - a)).norm();
            points.area += area;
            for (k, share) in carriers.shares(&((a + b + c) / 3.0)) {
                points.all[k].area += share * area;
            }
        }
        points
    }

    /// Adds a point that a tear has laid open, unless it is there; whether it was not.
    pub fn lay_open(&mut self, id: u32) -> bool {
        let new = !std::mem::replace(&mut self.known[id as usize], true);
        if new {
            // It stands for half a cell's square.
            let area = 0.25 * self.spacing * self.spacing;
            self.all.push(SurfaceParticle { id, area, offset: Vec3::zeros() });
        }
        new
    }
}

/// Curvature of the surface around a place, as the body curves away from `normal`, which points
/// into it, fitted over `reach` \[1/m\].
#[must_use]
pub fn curvature(mesh: &TriMesh, point: &Vec3, normal: &Vec3, reach: f64) -> f64 {
    let fine = refine(mesh, 0.25 * reach).unwrap_or_else(|_| mesh.clone());
    let (mut sum, mut weight) = (0.0, 0.0);
    for t in 0..fine.triangles.len() {
        let [a, b, c] = fine.corners(t);
        let across = (b - a).cross(&(c - a));
        let arm = (a + b + c) / 3.0 - point;
        let along = arm.dot(normal);
        let square = arm.norm_squared() - along * along;
        if square < reach * reach && across.dot(normal) < 0.0 {
            let area = across.norm();
            sum += 2.0 * along * square * area;
            weight += square * square * area;
        }
    }
    if weight > 0.0 { sum / weight } else { 0.0 }
}
