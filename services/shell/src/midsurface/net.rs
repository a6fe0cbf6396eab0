//! Quadrilaterals, checked, with what is around each vertex and what lies beyond the rim.

use cullet_geometry::Vec3;
use std::collections::BTreeMap;
use thiserror::Error;

/// Quadrilaterals around a vertex inside a surface that all others go by.
const REGULAR: usize = 4;

/// What is wrong with quadrilaterals as a midsurface.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum MidsurfaceError {
    /// No quadrilateral.
    #[error("the midsurface has no quadrilateral")]
    Empty,
    /// A vertex that is no place.
    #[error("vertex {vertex} of the midsurface is not finite")]
    NotFinite {
        /// Which.
        vertex: usize,
    },
    /// A quadrilateral that names a vertex twice or one that there is not.
    #[error(
        "quadrilateral {quad} of the midsurface names a vertex twice or one that does not exist"
    )]
    Corners {
        /// Which.
        quad: usize,
    },
    /// An edge that two quadrilaterals run along in the same direction.
    #[error("two quadrilaterals run along the edge from vertex {from} to vertex {to} the same way")]
    Edge {
        /// Vertex.
        from: u32,
        /// Vertex.
        to: u32,
    },
    /// A vertex that has no quadrilateral, one whose quadrilaterals are no single fan, or one
    /// inside the surface with fewer than three.
    #[error(
        "the quadrilaterals around vertex {vertex} of the midsurface are not one fan of three or \
         more"
    )]
    Fan {
        /// Which.
        vertex: usize,
    },
    /// A quadrilateral with more functions than a cell can have.
    #[error(
        "quadrilateral {quad} has {found} control points around it, at most {most} are supported"
    )]
    Functions {
        /// Which.
        quad: usize,
        /// How many it has.
        found: usize,
        /// How many it may have.
        most: usize,
    },
    /// A quadrilateral that meets its own surroundings again on the other side.
    #[error("the surroundings of quadrilateral {quad} of the midsurface close on themselves")]
    Coarse {
        /// Which.
        quad: usize,
    },
    /// No control points were found.
    #[error("no smooth surface through the quadrilaterals was found: {quad} is missed")]
    Fit {
        /// The one that is missed most.
        quad: usize,
    },
}

/// A control point beyond the rim: what it continues, Σ share x.
type Beyond = Vec<(u32, f64)>;

/// Quadrilaterals and the control points around each vertex. Control points have the numbers of the
/// quadrilaterals; those beyond the rim follow.
#[derive(Clone, Debug)]
pub(super) struct CellNet<'a> {
    pub(super) vertices: &'a [Vec3],
    pub(super) quads: &'a [[u32; 4]],
    /// The quadrilateral on the left of each edge, and which of its sides that is.
    pub(super) left: BTreeMap<(u32, u32), (u32, usize)>,
    /// Quadrilaterals around each vertex, counter-clockwise; at a rim from one side of it on.
    pub(super) fans: Vec<Vec<u32>>,
    /// The control points around each vertex, counter-clockwise: those of its fan and what is
    /// beyond the rim there.
    pub(super) faces: Vec<Vec<u32>>,
    /// Control points beyond the rim.
    pub(super) beyond: Vec<Beyond>,
    /// The quadrilateral at the rim that each lies beyond.
    pub(super) inner: Vec<u32>,
}

impl<'a> CellNet<'a> {
    pub(super) fn new(
        vertices: &'a [Vec3],
        quads: &'a [[u32; 4]],
    ) -> Result<Self, MidsurfaceError> {
        if quads.is_empty() {
            return Err(MidsurfaceError::Empty);
        }
        let is_bad = |v: &Vec3| !v.iter().all(|x| x.is_finite());
        if let Some(vertex) = vertices.iter().position(is_bad) {
            return Err(MidsurfaceError::NotFinite { vertex });
        }
        let mut left = BTreeMap::new();
        for (quad, corners) in quads.iter().enumerate() {
            let mut sorted = *corners;
            sorted.sort_unstable();
            let is_twice = sorted.windows(2).any(|pair| pair[0] == pair[1]);
            if is_twice || sorted[3] as usize >= vertices.len() {
                return Err(MidsurfaceError::Corners { quad });
            }
            for side in 0..4 {
                let (from, to) = (corners[side], corners[(side + 1) % 4]);
                if left.insert((from, to), (quad as u32, side)).is_some() {
                    return Err(MidsurfaceError::Edge { from, to });
                }
            }
        }
        let empty = || vec![Vec::new(); vertices.len()];
        let (fans, faces, beyond, inner) = (empty(), empty(), Vec::new(), Vec::new());
        let mut net = Self { vertices, quads, left, fans, faces, beyond, inner };
        net.fans = (0..vertices.len()).map(|v| net.fan(v as u32)).collect::<Result<_, _>>()?;
        net.close();
        Ok(net)
    }

    /// The quadrilateral after `quad` counter-clockwise around a vertex.
    fn after(&self, quad: u32, vertex: u32) -> Option<u32> {
        let corners = &self.quads[quad as usize];
        let k = corners.iter().position(|&v| v == vertex)?;
        self.left.get(&(vertex, corners[(k + 3) % 4])).map(|next| next.0)
    }

    fn fan(&self, vertex: u32) -> Result<Vec<u32>, MidsurfaceError> {
        let around = || self.left.range((vertex, 0)..=(vertex, u32::MAX));
        let wrong = MidsurfaceError::Fan { vertex: vertex as usize };
        // A rim starts at the edge that has nothing on its right.
        let start = around().find(|(edge, _)| !self.left.contains_key(&(edge.1, vertex)));
        let first = start.or(around().next()).map(|(_, left)| left.0).ok_or(wrong)?;
        let mut fan = vec![first];
        let mut now = first;
        while let Some(next) = self.after(now, vertex).filter(|&next| next != first) {
            fan.push(next);
            now = next;
            if fan.len() > around().count() {
                return Err(wrong);
            }
        }
        let is_closed = start.is_none();
        let is_one = fan.len() == around().count() && !(is_closed && fan.len() < 3);
        if is_one { Ok(fan) } else { Err(wrong) }
    }

    /// The quadrilateral across a side.
    pub(super) fn across(&self, quad: u32, side: usize) -> Option<(u32, usize)> {
        let corners = &self.quads[quad as usize];
        self.left.get(&(corners[(side + 1) % 4], corners[side])).copied()
    }

    /// Lays control points beyond the rim and closes the faces there.
    fn close(&mut self) {
        let mut by_side = BTreeMap::new();
        for quad in 0..self.quads.len() as u32 {
            for side in 0..4 {
                if self.across(quad, side).is_none() {
                    let shares = self.continued(quad, side);
                    by_side.insert((quad, side), self.add(quad, shares));
                }
            }
        }
        for vertex in 0..self.vertices.len() {
            let mut face = self.fans[vertex].clone();
            let (first, last) = (face[0], face[face.len() - 1]);
            let side_of = |quad: u32, before: usize| {
                let corners = &self.quads[quad as usize];
                let k = corners.iter().position(|&v| v as usize == vertex).unwrap_or(0);
                (quad, (k + before) % 4)
            };
            let ends = [by_side.get(&side_of(last, 3)), by_side.get(&side_of(first, 0))];
            if let [Some(&end), Some(&start)] = ends {
                face.push(end);
                if face.len() + 1 < REGULAR {
                    let mut shares = self.beyond[end as usize - self.quads.len()].clone();
                    shares.extend(&self.beyond[start as usize - self.quads.len()]);
                    shares.push((first, -1.0));
                    face.push(self.add(first, shares));
                }
                face.push(start);
            }
            self.faces[vertex] = face;
        }
    }

    fn add(&mut self, quad: u32, shares: Beyond) -> u32 {
        self.beyond.push(shares);
        self.inner.push(quad);
        (self.quads.len() + self.beyond.len() - 1) as u32
    }

    /// What continues the row of control points across a side: 3(x₁ − x₂) + x₃.
    fn continued(&self, quad: u32, side: usize) -> Beyond {
        let mut row = vec![quad];
        let mut now = (quad, (side + 2) % 4);
        while let (Some((next, entered)), true) = (self.across(now.0, now.1), row.len() < 3) {
            row.push(next);
            now = (next, (entered + 2) % 4);
        }
        let shares: &[f64] = match row.len() {
            1 => &[1.0],
            2 => &[2.0, -1.0],
            _ => &[3.0, -3.0, 1.0],
        };
        row.into_iter().zip(shares.iter().copied()).collect()
    }

    /// Appends the control points beyond the rim to those of the quadrilaterals.
    pub(super) fn extend(&self, points: &mut Vec<Vec3>) {
        for shares in &self.beyond {
            points.push(shares.iter().map(|&(q, share)| points[q as usize] * share).sum());
        }
    }

    /// Area of a quadrilateral \[m²\].
    pub(super) fn area(&self, quad: u32) -> f64 {
        let [a, b, c, d] = self.quads[quad as usize].map(|v| self.vertices[v as usize]);
        0.5 * (c - a).cross(&(d - b)).norm()
    }
}
