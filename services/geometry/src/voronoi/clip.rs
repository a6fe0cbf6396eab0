//! One cell: the box, clipped by the bisectors of the sites around, nearest first.
//!
//! The cell is kept as its dual: corners are triples of planes. A clip removes the corners that are
//! nearer to the new site and joins the rim of the hole to the new plane.

use super::cells::{Cells, Face, Key, VoronoiError, WALL};
use super::plane::{ClipPlane, ROUNDING, meet};
use super::predicate::nearer;
use crate::math::Vec3;

/// Where three planes meet; `planes` are ordered so that their normals have a positive determinant.
#[derive(Clone, Copy, Debug)]
struct CellCorner {
    planes: [u16; 3],
    place: Vec3,
    /// Bound on the rounding error of `place` \[m\].
    slack: f64,
}

struct Clipper<'a> {
    cells: &'a Cells,
    site: u32,
    origin: Vec3,
    planes: Vec<ClipPlane>,
    corners: Vec<CellCorner>,
    /// Squared distance to the farthest corner \[m²\].
    radius2: f64,
    hit: Vec<usize>,
    rim: Vec<(u16, u16)>,
}

/// The faces of the cell of `site`.
pub(super) fn cell(cells: &Cells, site: u32) -> Result<Vec<Face>, VoronoiError> {
    let mut clipper = Clipper::new(cells, site);
    let mut near: Vec<(f64, u32)> = Vec::new();
    for radius in 0.. {
        let reach = cells.grid.reach(clipper.origin, radius);
        if reach > 0.0 && reach * reach > 4.0 * clipper.radius2 {
            break;
        }
        near.clear();
        let limit = 4.0 * clipper.radius2 * (1.0 + 1e-9);
        let met = cells.grid.ring(clipper.origin, radius, |bucket, gap| {
            if gap <= limit {
                near.extend(bucket.iter().filter(|&&other| other != site).map(|&other| {
                    ((cells.sites[other as usize] - clipper.origin).norm_squared(), other)
                }));
            }
        });
        if !met {
            break;
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for &(square, other) in &near {
            if square > 4.0 * clipper.radius2 {
                break;
            }
            clipper.clip(other)?;
        }
    }
    clipper.faces()
}

impl<'a> Clipper<'a> {
    fn new(cells: &'a Cells, site: u32) -> Self {
        let origin = cells.sites[site as usize];
        let planes: Vec<ClipPlane> = (0..6).map(|k| cells.plane(origin, WALL + k)).collect();
        let mut clipper = Self {
            cells,
            site,
            origin,
            planes,
            corners: Vec::with_capacity(64),
            radius2: 0.0,
            hit: Vec::new(),
            rim: Vec::new(),
        };
        for bits in 0..8u16 {
            let (x, y, z) = (bits & 1, 2 + (bits >> 1 & 1), 4 + (bits >> 2));
            // Outward normals of the three walls, x y z, are right-handed where the count of low
            // walls is even.
            let even = (3 - bits.count_ones()).is_multiple_of(2);
            clipper.add(if even { [x, y, z] } else { [x, z, y] });
        }
        clipper.measure();
        clipper
    }

    fn add(&mut self, planes: [u16; 3]) {
        let [a, b, c] = planes.map(|p| &self.planes[p as usize]);
        let (place, slack) = meet([a, b, c]);
        self.corners.push(CellCorner { planes, place, slack });
    }

    fn measure(&mut self) {
        let far = |c: &CellCorner| {
            let r = c.place.norm() + c.slack;
            r * r * (1.0 + 1e-12)
        };
        self.radius2 = self.corners.iter().map(far).fold(0.0, f64::max);
    }

    fn degenerate(&self) -> VoronoiError {
        VoronoiError::Degenerate { site: self.site as usize }
    }

    /// Whether the corner is nearer to the new site.
    fn conflicts(&self, corner: &CellCorner, plane: &ClipPlane) -> Result<bool, VoronoiError> {
        let height = plane.normal.dot(&corner.place) - plane.offset;
        let doubt = plane.length * corner.slack
            + ROUNDING * (plane.length * corner.place.norm() + plane.offset.abs());
        if height.abs() > doubt {
            return Ok(height > 0.0);
        }
        let ids = corner.planes.map(|p| self.planes[p as usize].id);
        let sign = nearer(self.cells, self.site, ids, plane.id);
        if sign == 0.0 { Err(self.degenerate()) } else { Ok(sign > 0.0) }
    }

    fn clip(&mut self, other: u32) -> Result<(), VoronoiError> {
        let plane = self.cells.plane(self.origin, other);
        self.hit.clear();
        for index in 0..self.corners.len() {
            if self.conflicts(&self.corners[index], &plane)? {
                self.hit.push(index);
            }
        }
        if self.hit.is_empty() {
            return Ok(());
        }
        if self.hit.len() == self.corners.len() || self.planes.len() >= usize::from(u16::MAX) {
            return Err(self.degenerate());
        }
        self.rim.clear();
        for &index in &self.hit {
            let [a, b, c] = self.corners[index].planes;
            for (p, q) in [(a, b), (b, c), (c, a)] {
                if let Some(at) = self.rim.iter().position(|&edge| edge == (q, p)) {
                    self.rim.swap_remove(at);
                } else {
                    self.rim.push((p, q));
                }
            }
        }
        if !is_one_loop(&mut self.rim) {
            return Err(self.degenerate());
        }
        for k in (0..self.hit.len()).rev() {
            self.corners.swap_remove(self.hit[k]);
        }
        let new = self.planes.len() as u16;
        self.planes.push(plane);
        for k in 0..self.rim.len() {
            let (p, q) = self.rim[k];
            self.add([p, q, new]);
        }
        self.measure();
        Ok(())
    }

    fn key(&self, corner: &CellCorner) -> Key {
        let [a, b, c] = corner.planes.map(|p| self.planes[p as usize].id);
        let mut key = [self.site, a, b, c];
        key.sort_unstable();
        key
    }

    /// The corners around each plane that still has some, in order.
    fn faces(&self) -> Result<Vec<Face>, VoronoiError> {
        let mut faces = Vec::new();
        // For each corner of a plane p: the planes (q, r) that follow p in it, and its index.
        let mut around: Vec<Vec<(u16, u16, usize)>> = vec![Vec::new(); self.planes.len()];
        for (index, corner) in self.corners.iter().enumerate() {
            let [a, b, c] = corner.planes;
            around[usize::from(a)].push((b, c, index));
            around[usize::from(b)].push((c, a, index));
            around[usize::from(c)].push((a, b, index));
        }
        for (plane, mut links) in self.planes.iter().zip(around) {
            if links.is_empty() {
                continue;
            }
            for at in 1..links.len() {
                let joint = links[at - 1].1;
                let next = links[at..].iter().position(|link| link.0 == joint);
                links.swap(at, at + next.ok_or_else(|| self.degenerate())?);
            }
            let corners = links.iter().map(|link| self.key(&self.corners[link.2])).collect();
            faces.push(Face { neighbour: plane.id, corners });
        }
        faces.sort_unstable_by_key(|face| face.neighbour);
        Ok(faces)
    }
}

/// Orders directed edges head to tail; false if they are not one closed loop.
fn is_one_loop(rim: &mut [(u16, u16)]) -> bool {
    for at in 1..rim.len() {
        let joint = rim[at - 1].1;
        let Some(next) = rim[at..].iter().position(|edge| edge.0 == joint) else {
            return false;
        };
        rim.swap(at, at + next);
    }
    rim.len() >= 3 && rim[0].0 == rim[rim.len() - 1].1
}
