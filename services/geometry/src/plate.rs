//! Flat plates: bodies with two parallel faces, whatever their outline.

use crate::math::{Pose, Quat, Vec3};
use crate::mesh::TriMesh;
use thiserror::Error;

/// Largest triangles whose normals are tried as the plate's.
const TRIED: usize = 12;

/// Normals within this of one another are parallel: 1 − |n·n'|.
const PARALLEL: f64 = 1e-6;

/// How far a face may be out of its plane, over the thickness.
const FLAT: f64 = 1e-3;

/// How far the volume may be from thickness times area \[1\] (F91).
pub const VOLUME: f64 = 0.03;

/// Greatest thickness over the square root of the area of a face \[1\].
pub const SLENDER: f64 = 0.5;

/// A flat plate: a frame in which its faces are the planes z = ± t/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// From the plate's frame to the body's; its origin is the middle of the plate's box.
    pub pose: Pose,
    /// t \[m\].
    pub thickness: f64,
    /// Extent in x and y \[m\].
    pub size: [f64; 2],
    /// Area of a face, the mean of the two \[m²\].
    pub area: f64,
}

/// Why a body is no plate.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum NotPlate {
    /// Too little of its surface lies in two parallel planes.
    #[error(
        "{share:.2} of what two parallel faces of this area and distance would enclose is there; \
         a plate has {least:.2} to {most:.2}",
        least = 1.0 - VOLUME, most = 1.0 + VOLUME
    )]
    Volume {
        /// Volume over thickness times area \[1\].
        share: f64,
    },
    /// It is as thick as it is wide.
    #[error("it is {ratio:.2} times as thick as its faces are wide; a plate is at most {SLENDER}")]
    Thick {
        /// Thickness over √area \[1\].
        ratio: f64,
    },
    /// It has no two parallel faces.
    #[error("no two of its faces are parallel")]
    NoFaces,
}

impl Plate {
    /// Finds the plate that a closed mesh is.
    ///
    /// # Errors
    /// What it lacks.
    pub fn of_mesh(mesh: &TriMesh) -> Result<Self, NotPlate> {
        let areas: Vec<Vec3> = (0..mesh.triangles.len()).map(|t| area_vector(mesh, t)).collect();
        let mut order: Vec<usize> = (0..areas.len()).collect();
        let size = |t: &usize| areas[*t].norm();
        order.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.cmp(b)));
        let tried = order.iter().take(TRIED).filter(|t| size(t) > 0.0);
        let normals = tried.map(|&t| upward(areas[t].normalize()));
        let faces = normals.filter_map(|normal| ParallelFaces::across(mesh, &areas, normal));
        let best = faces.max_by(|a, b| a.area.total_cmp(&b.area)).ok_or(NotPlate::NoFaces)?;
        let share = mesh.signed_volume() / (best.area * best.thickness);
        if (share - 1.0).abs() > VOLUME {
            return Err(NotPlate::Volume { share });
        }
        let ratio = best.thickness / best.area.sqrt();
        if ratio > SLENDER {
            return Err(NotPlate::Thick { ratio });
        }
        Ok(best.plate(mesh))
    }
}

/// Half of the cross product of two edges \[m²\].
fn area_vector(mesh: &TriMesh, triangle: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(triangle);
    0.5 * (b - a).cross(&(c - a))
}

/// The normal or its opposite: the one whose largest component is positive.
fn upward(normal: Vec3) -> Vec3 {
    if normal[normal.iamax()] < 0.0 { -normal } else { normal }
}

/// Two parallel faces.
#[derive(Clone, Copy, Debug)]
struct ParallelFaces {
    normal: Vec3,
    middle: f64,
    thickness: f64,
    area: f64,
}

impl ParallelFaces {
    /// The outermost faces across a direction.
    fn across(mesh: &TriMesh, areas: &[Vec3], normal: Vec3) -> Option<Self> {
        let along = mesh.vertices.iter().map(|x| x.dot(&normal));
        let (low, high) =
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d), h.max(d)));
        let (thickness, mut sums) = (high - low, [0.0; 2]);
        for (t, area) in areas.iter().enumerate() {
            let up = area.dot(&normal);
            if up.abs() < (1.0 - PARALLEL) * area.norm() {
                continue;
            }
            let (side, plane) = if up > 0.0 { (1, high) } else { (0, low) };
            let off = mesh.corners(t).into_iter().map(|x| (x.dot(&normal) - plane).abs());
            if off.fold(0.0, f64::max) <= FLAT * thickness {
                sums[side] += up.abs();
            }
        }
        let is_plate = sums[0] > 0.0 && sums[1] > 0.0 && thickness > 0.0;
        is_plate.then(|| Self {
            normal,
            middle: 0.5 * (low + high),
            thickness,
            area: 0.5 * (sums[0] + sums[1]),
        })
    }

    /// With x along the side of the least rectangle around the plate.
    fn plate(&self, mesh: &TriMesh) -> Plate {
        let least = Vec3::ith(self.normal.iamin(), 1.0);
        let across = self.normal.cross(&least).normalize();
        let other = self.normal.cross(&across);
        let flat: Vec<[f64; 2]> =
            mesh.vertices.iter().map(|x| [x.dot(&across), x.dot(&other)]).collect();
        let hull = convex_hull(flat);
        let boxes = (0..hull.len()).map(|k| around(&hull, k));
        let area = |b: &Rectangle| (b.high[0] - b.low[0]) * (b.high[1] - b.low[1]);
        let found = boxes.min_by(|a, b| area(a).total_cmp(&area(b)));
        let Rectangle { along: [c, s], low, high } = found.unwrap_or_default();
        let (x, y) = (across * c + other * s, other * c - across * s);
        let mut axes = [x, y];
        let mut middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        let mut size = [0, 1].map(|k| high[k] - low[k]);
        if size[0] < size[1] {
            (axes, middle, size) = ([y, -x], [middle[1], -middle[0]], [size[1], size[0]]);
        }
        if axes[0][axes[0].iamax()] < 0.0 {
            (axes, middle) = (axes.map(|axis| -axis), middle.map(|m| -m));
        }
        let origin = axes[0] * middle[0] + axes[1] * middle[1] + self.normal * self.middle;
        let turn = Quat::from_basis_unchecked(&[axes[0], axes[1], self.normal]);
        let pose = Pose::from_parts(origin.into(), turn);
        Plate { pose, thickness: self.thickness, size, area: self.area }
    }
}

/// A rectangle with a side along an edge of a hull.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    along: [f64; 2],
    low: [f64; 2],
    high: [f64; 2],
}

impl Default for Rectangle {
    fn default() -> Self {
        Self { along: [1.0, 0.0], low: [0.0; 2], high: [0.0; 2] }
    }
}

fn around(hull: &[[f64; 2]], edge: usize) -> Rectangle {
    let ([ax, ay], [bx, by]) = (hull[edge], hull[(edge + 1) % hull.len()]);
    let length = ((bx - ax) * (bx - ax) + (by - ay) * (by - ay)).sqrt();
    let [c, s] = [(bx - ax) / length, (by - ay) / length];
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for &[x, y] in hull {
        for (k, at) in [c * x + s * y, c * y - s * x].into_iter().enumerate() {
            (low[k], high[k]) = (low[k].min(at), high[k].max(at));
        }
    }
    Rectangle { along: [c, s], low, high }
}

/// The convex hull of points in a plane, counter-clockwise (Andrew's monotone chain).
fn convex_hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::{NotPlate, Plate};
    use crate::math::{Pose, Vec3};
    use crate::mesh::TriMesh;
    use crate::shapes::{self, Detail};

    fn moved(mut mesh: TriMesh, pose: &Pose) -> TriMesh {
        mesh.vertices.iter_mut().for_each(|x| *x = pose.rotation * *x + pose.translation.vector);
        mesh
    }

    #[test]
    fn a_pane_is_found_wherever_it_stands() {
        let pane = shapes::cuboid(Vec3::new(0.4, 0.008, 0.3), Detail::default()).unwrap();
        let pose = Pose::new(Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.3, -0.8, 0.4));
        for mesh in [pane.clone(), moved(pane, &pose)] {
            let plate = Plate::of_mesh(&mesh).unwrap();
            assert!((plate.thickness - 0.008).abs() < 1e-12);
            assert!((plate.size[0] - 0.4).abs() < 1e-9 && (plate.size[1] - 0.3).abs() < 1e-9);
            assert!((plate.area - 0.12).abs() < 1e-9);
            for corner in &mesh.vertices {
                let at = plate.pose.rotation.inverse() * (corner - plate.pose.translation.vector);
                assert!((at.x.abs() - 0.2).abs() < 1e-9, "{at}");
                assert!((at.y.abs() - 0.15).abs() < 1e-9, "{at}");
                assert!((at.z.abs() - 0.004).abs() < 1e-9, "{at}");
            }
        }
    }

    /// Half a turn is as good as any: the frame of every plate has its faces at z = ± t/2.
    #[test]
    fn the_frame_is_that_of_the_faces_whatever_their_axes() {
        let tilts = [Vec3::zeros(), Vec3::new(0.0, 0.7, 0.0), Vec3::new(0.0, 0.0, 3.0)];
        for size in [[0.4, 0.3, 0.01], [0.3, 0.4, 0.01], [0.01, 0.3, 0.4], [0.01, 0.4, 0.3]] {
            for tilt in tilts {
                let pane = shapes::cuboid(Vec3::from(size), Detail::default()).unwrap();
                let mesh = moved(pane, &Pose::new(Vec3::new(0.1, 0.2, 0.3), tilt));
                let pose = Plate::of_mesh(&mesh).unwrap().pose;
                for corner in &mesh.vertices {
                    let at = pose.rotation.inverse() * (corner - pose.translation.vector);
                    let off = at.abs() - Vec3::new(0.2, 0.15, 0.005);
                    assert!(off.norm() < 1e-9, "{size:?} {tilt:?}: {at}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_plate_is_refused_with_its_figure() {
        let cube = shapes::cuboid(Vec3::repeat(0.1), Detail::default()).unwrap();
        assert!(matches!(Plate::of_mesh(&cube), Err(NotPlate::Thick { .. })));
        let ball = shapes::sphere(0.1, Detail::default()).unwrap();
        assert!(Plate::of_mesh(&ball).is_err());
    }
}
