//! Points of a body that lie at its surface, and carry it.

use crate::mpm::Domain;
use cullet_fragment::carriers::Carriers;
use cullet_geometry::inside::Nearest;
use cullet_geometry::shapes::refine;
use cullet_geometry::{TriMesh, Vec3};

/// Depth under the surface, in cells, down to which points lie at it \[1\]: half of their distance.
const DEPTH: f64 = 0.35;

/// Longest edge of the triangles whose areas are shared out, in cells.
const FINE: f64 = 0.5;

/// A point at the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SurfaceParticle {
    /// Its number in the order in which points were sampled.
    pub(super) id: u32,
    /// The surface that it stands for \[m²\].
    pub(super) area: f64,
    /// From it to the surface, before the hit \[m\].
    pub(super) offset: Vec3,
}

/// All of a body's.
#[derive(Clone, Debug)]
pub(super) struct SurfaceParticles {
    pub(super) all: Vec<SurfaceParticle>,
    /// The whole surface \[m²\].
    pub(super) area: f64,
    /// Size of a cell \[m\].
    pub(super) spacing: f64,
}

impl SurfaceParticle {
    /// The place of the surface at the point \[m\].
    pub(super) fn place(&self, domain: &Domain) -> Vec3 {
        let (place, motion) = domain.point(self.id);
        let offset = self.offset + motion.displacement_gradient * self.offset;
        place + motion.displacement + offset
    }
}

impl SurfaceParticles {
    /// Of a body on its grid.
    pub(super) fn new(domain: &Domain, mesh: &TriMesh) -> Self {
        let spacing = domain.grid.spacing.max();
        let nearest = Nearest::new(mesh);
        let mut all = Vec::new();
        let mut places = Vec::new();
        for id in 0..domain.particles.len() as u32 {
            let place = domain.particles.reference[domain.slot(id)];
            let Some((closest, _, _)) = nearest.closest(place) else { continue };
            let offset = closest - place;
            if offset.norm() <= DEPTH * spacing {
                all.push(SurfaceParticle { id, area: 0.0, offset });
                places.push(place);
            }
        }
        let mut points = Self { all, area: 0.0, spacing };
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
}

/// Curvature of the surface around a place, as the body curves away from `normal`, which points
/// into it, fitted over `reach` \[1/m\].
pub(super) fn curvature(mesh: &TriMesh, point: &Vec3, normal: &Vec3, reach: f64) -> f64 {
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
