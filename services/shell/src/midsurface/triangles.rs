//! The midsurface of a mesh of triangles: Loop's subdivision surface, one quadrature point in the
//! middle of each triangle \[Cirak, Ortiz & Schröder 2000\].
//!
//! Beyond a rim lies one layer of control points of their own, so that every corner of a triangle
//! has a closed ring of neighbours. Nothing else is beyond the rim: an edge is free by itself.

use super::box_spline::{TriangleCount, limit_share};
use super::rim::Rim;
use super::triangle_net::{LoopError, TriangleNet};
use super::{CellShape, CellTable, Midsurface, SurfaceCell};
use cullet_geometry::Vec3;
use cullet_geometry::nurbs::MOST_FUNCTIONS;
use std::collections::BTreeMap;

/// Steps of the search for control points whose surface has the vertices on it: each takes a
/// quarter off what is missing, or more.
const FITS: usize = 2000;

/// How far the surface may miss a vertex, over the length of an edge.
const MISS: f64 = 1e-10;

impl Midsurface {
    /// The smooth surface through `vertices` \[m\] that `triangles` span, with one point a
    /// triangle. They must be oriented alike and form a manifold, with or without a rim; at most
    /// sixteen control points may be around a triangle (22 neighbours of its corners in all).
    ///
    /// The first control points belong to the vertices, in their order; those beyond a rim follow.
    ///
    /// # Errors
    /// What is wrong with the triangles.
    pub fn of_triangles(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, LoopError> {
        let net = TriangleNet::new(vertices, triangles)?;
        let rim = Rim::new(&net);
        let rings: Vec<Vec<u32>> = (0..vertices.len() as u32).map(|v| rim.ring(&net, v)).collect();
        let (cells, tables) = cells(&net, &rings)?;
        let nodes = control_points(&net, &rim, &rings)?;
        let (starts, neighbours, corner_only) = neighbours(&net);
        let share = vec![1.0; triangles.len()];
        let missing = rim.missing(&net);
        let functions = MOST_FUNCTIONS;
        Ok(Self {
            nodes,
            functions,
            cells,
            tables,
            starts,
            neighbours,
            corner_only,
            share,
            missing,
            rings,
        })
    }

    /// Places on a surface of triangles that the control points of its vertices tend to: the
    /// vertices themselves before anything moved, their displacements from those of the control
    /// points. Empty on other surfaces.
    #[must_use]
    pub fn at_vertices(&self, of: &[Vec3]) -> Vec<Vec3> {
        limits(&self.rings, of)
    }

    /// The shares of control points in the place of vertex `vertex`.
    #[must_use]
    pub fn vertex_shares(&self, vertex: usize) -> Vec<(u32, f64)> {
        let ring = &self.rings[vertex];
        let share = limit_share(ring.len());
        let own = (vertex as u32, 1.0 - ring.len() as f64 * share);
        ring.iter().map(|&n| (n, share)).chain([own]).collect()
    }
}

fn limits(rings: &[Vec<u32>], of: &[Vec3]) -> Vec<Vec3> {
    let at = |(vertex, ring): (usize, &Vec<u32>)| {
        let sum: Vec3 = ring.iter().map(|&n| of[n as usize]).sum();
        of[vertex] + (sum - of[vertex] * ring.len() as f64) * limit_share(ring.len())
    };
    rings.iter().enumerate().map(at).collect()
}

fn cells(
    net: &TriangleNet<'_>,
    rings: &[Vec<u32>],
) -> Result<(Vec<SurfaceCell>, Vec<CellTable>), LoopError> {
    let mut places: BTreeMap<[usize; 3], u32> = BTreeMap::new();
    let (mut cells, mut tables) = (Vec::new(), Vec::new());
    for (triangle, &corners) in net.triangles.iter().enumerate() {
        let valence = |v: u32| rings[v as usize].len();
        // The corner that it starts from is such that like triangles share a table.
        let turned = |r: usize| [0, 1, 2].map(|k| corners[(k + r) % 3]);
        let start = (0..3).min_by_key(|&r| turned(r).map(valence)).unwrap_or(0);
        let corners = turned(start);
        let count = TriangleCount { valences: corners.map(valence) };
        let (found, most) = (count.all(), MOST_FUNCTIONS);
        if found > most {
            return Err(LoopError::Functions { triangle, found, most });
        }
        let mut list: Vec<u32> = corners.to_vec();
        for (k, &corner) in corners.iter().enumerate() {
            let ring = &rings[corner as usize];
            let next = ring.iter().position(|&n| n == corners[(k + 1) % 3]).unwrap_or(0);
            let turned = ring.iter().cycle().skip(next).take(ring.len());
            list.extend(turned.skip(2).take(ring.len().saturating_sub(3)));
        }
        let mut sorted = list.clone();
        sorted.sort_unstable();
        sorted.dedup();
        if sorted.len() != found || count.valences.iter().any(|&n| n < 3) {
            return Err(LoopError::Coarse { triangle });
        }
        let nodes = std::array::from_fn(|k| list.get(k).copied().unwrap_or(list[0]));
        let next = tables.len() as u32;
        let table = *places.entry(count.valences).or_insert(next);
        if table == next {
            let points = vec![count.middle()];
            tables.push(CellTable { shape: CellShape::Triangle, extent: [1.0; 2], points });
        }
        cells.push(SurfaceCell { nodes, table });
    }
    Ok((cells, tables))
}

/// Control points whose surface has the vertices on it: c += x − limit(c).
fn control_points(
    net: &TriangleNet<'_>,
    rim: &Rim,
    rings: &[Vec<u32>],
) -> Result<Vec<Vec3>, LoopError> {
    let mut points = net.vertices.to_vec();
    rim.extend(&mut points);
    let edges =
        || net.left.keys().map(|&(a, b)| net.vertices[a as usize] - net.vertices[b as usize]);
    let length = edges().map(|edge| edge.norm()).sum::<f64>() / net.left.len() as f64;
    let mut worst = (0, f64::INFINITY);
    for _ in 0..FITS {
        let limits = limits(rings, &points);
        worst = (0, 0.0);
        for (vertex, (limit, wanted)) in limits.iter().zip(net.vertices).enumerate() {
            let miss = wanted - limit;
            points[vertex] += miss;
            if miss.norm() > worst.1 {
                worst = (vertex, miss.norm());
            }
        }
        points.truncate(net.vertices.len());
        rim.extend(&mut points);
        if worst.1 <= MISS * length {
            return Ok(points);
        }
    }
    Err(LoopError::Fit { vertex: worst.0 })
}

/// Triangles that share a corner with each, ascending, and whether that is all that they share.
fn neighbours(net: &TriangleNet<'_>) -> (Vec<u32>, Vec<u32>, Vec<bool>) {
    let mut at_vertex = vec![Vec::new(); net.vertices.len()];
    for (triangle, corners) in net.triangles.iter().enumerate() {
        corners.iter().for_each(|&v| at_vertex[v as usize].push(triangle as u32));
    }
    let (mut starts, mut neighbours, mut corner_only) = (vec![0], Vec::new(), Vec::new());
    for (triangle, corners) in net.triangles.iter().enumerate() {
        let mut around: Vec<u32> =
            corners.iter().flat_map(|&v| at_vertex[v as usize].iter().copied()).collect();
        around.sort_unstable();
        for same in around.chunk_by(|a, b| a == b) {
            if same[0] as usize != triangle {
                neighbours.push(same[0]);
                corner_only.push(same.len() < 2);
            }
        }
        starts.push(neighbours.len() as u32);
    }
    (starts, neighbours, corner_only)
}
