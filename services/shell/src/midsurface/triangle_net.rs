//! Triangles, checked, and what is around each vertex.

use cullet_geometry::Vec3;
use std::collections::BTreeMap;
use thiserror::Error;

/// What is wrong with triangles as a midsurface.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum LoopError {
    /// No triangle.
    #[error("the midsurface has no triangle")]
    Empty,
    /// A vertex that is no place.
    #[error("vertex {vertex} of the midsurface is not finite")]
    NotFinite {
        /// Which.
        vertex: usize,
    },
    /// A triangle that names a vertex twice or one that there is not.
    #[error(
        "triangle {triangle} of the midsurface names a vertex twice or one that does not exist"
    )]
    Corners {
        /// Which.
        triangle: usize,
    },
    /// An edge that two triangles run along in the same direction.
    #[error("two triangles run along the edge from vertex {from} to vertex {to} the same way")]
    Edge {
        /// Vertex.
        from: u32,
        /// Vertex.
        to: u32,
    },
    /// A vertex that has no triangle, or whose triangles are no single fan.
    #[error("the triangles around vertex {vertex} of the midsurface are not one fan")]
    Fan {
        /// Which.
        vertex: usize,
    },
    /// A triangle with more functions than a cell can have.
    #[error(
        "triangle {triangle} has {found} control points around it, at most {most} are supported: \
         the neighbours of its corners may be {} in all", most + 6
    )]
    Functions {
        /// Which.
        triangle: usize,
        /// How many it has.
        found: usize,
        /// How many it may have.
        most: usize,
    },
    /// A triangle that meets its own surroundings again on the other side.
    #[error("the surroundings of triangle {triangle} of the midsurface close on themselves")]
    Coarse {
        /// Which.
        triangle: usize,
    },
    /// No control points were found.
    #[error("no smooth surface through the vertices was found: vertex {vertex} is missed")]
    Fit {
        /// The one that is missed most.
        vertex: usize,
    },
}

/// Triangles and the closed ring of neighbours of each vertex.
#[derive(Clone, Debug)]
pub(super) struct TriangleNet<'a> {
    pub(super) vertices: &'a [Vec3],
    pub(super) triangles: &'a [[u32; 3]],
    /// The third corner of the triangle on the left of each edge, by its ends.
    pub(super) left: BTreeMap<(u32, u32), u32>,
    /// Neighbours of each vertex, counter-clockwise; at a rim from one edge of it to the other.
    pub(super) fans: Vec<Vec<u32>>,
}

impl<'a> TriangleNet<'a> {
    pub(super) fn new(vertices: &'a [Vec3], triangles: &'a [[u32; 3]]) -> Result<Self, LoopError> {
        if triangles.is_empty() {
            return Err(LoopError::Empty);
        }
        let is_bad = |v: &Vec3| !v.iter().all(|x| x.is_finite());
        if let Some(vertex) = vertices.iter().position(is_bad) {
            return Err(LoopError::NotFinite { vertex });
        }
        let mut left = BTreeMap::new();
        for (triangle, &[a, b, c]) in triangles.iter().enumerate() {
            let exists = [a, b, c].iter().all(|&v| (v as usize) < vertices.len());
            if !exists || a == b || b == c || c == a {
                return Err(LoopError::Corners { triangle });
            }
            for (from, to, across) in [(a, b, c), (b, c, a), (c, a, b)] {
                if left.insert((from, to), across).is_some() {
                    return Err(LoopError::Edge { from, to });
                }
            }
        }
        let mut net = Self { vertices, triangles, left, fans: Vec::new() };
        net.fans = (0..vertices.len()).map(|v| net.fan(v as u32)).collect::<Result<_, _>>()?;
        Ok(net)
    }

    fn fan(&self, vertex: u32) -> Result<Vec<u32>, LoopError> {
        let around = || self.left.range((vertex, 0)..=(vertex, u32::MAX));
        let wrong = LoopError::Fan { vertex: vertex as usize };
        // A rim starts at the neighbour that has no triangle on its other side.
        let start = around().map(|(edge, _)| edge.1).find(|&b| !self.has(b, vertex));
        let first = start.or(around().next().map(|(edge, _)| edge.1)).ok_or(wrong)?;
        let mut fan = vec![first];
        let mut now = first;
        while let Some(&next) = self.left.get(&(vertex, now)) {
            if next == first {
                break;
            }
            fan.push(next);
            now = next;
            if fan.len() > self.triangles.len() + 1 {
                return Err(wrong);
            }
        }
        let covered = fan.len() - usize::from(start.is_some());
        if covered == around().count() { Ok(fan) } else { Err(wrong) }
    }

    pub(super) fn has(&self, from: u32, to: u32) -> bool {
        self.left.contains_key(&(from, to))
    }

    /// Whether a vertex is on a rim.
    pub(super) fn is_rim(&self, vertex: u32) -> bool {
        let fan = &self.fans[vertex as usize];
        !self.has(vertex, fan[fan.len() - 1])
    }
}
