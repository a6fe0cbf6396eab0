//! The midsurface of a mesh of quadrilaterals: Doo & Sabin's subdivision surface with two Gauss
//! points a direction in each, as a patch of degree 2 has.
//!
//! A control point belongs to each quadrilateral. Beyond a rim lies one row of control points of
//! their own, so that every vertex has a closed face around it. Nothing else is beyond the rim: an
//! edge is free by itself.

use super::build::gauss;
use super::doo_sabin::CellFaces;
use super::net::{CellNet, MidsurfaceError};
use super::{CellTable, Midsurface, StepBounds, SurfaceCell, TablePoint};
use cullet_geometry::Vec3;
use cullet_geometry::nurbs::MOST_FUNCTIONS;
use std::collections::BTreeMap;

/// Steps of the search for control points whose cells have the middles of the quadrilaterals.
const FITS: usize = 2000;

/// How far a cell may miss a middle, over the length of its side.
const MISS: f64 = 1e-10;

/// How far inside of a cell its corners are taken: no number of divisions reaches the very corner
/// where other than four cells meet.
const INWARD: f64 = 1e-6;

/// Point of a cell at each corner of its quadrilateral.
const AT_CORNER: [u32; 4] = [0, 1, 3, 2];

/// Corner of a quadrilateral in each of its cell's faces.
const CORNER_OF_FACE: [usize; 4] = [2, 3, 0, 1];

impl Midsurface {
    /// The smooth surface through the middles of `quads` between `vertices` \[m\], which lie on it
    /// but for what the fit leaves. They must be oriented alike and form a manifold, with or
    /// without a rim. A vertex inside has four quadrilaterals where it can, three or more
    /// elsewhere; at most sixteen control points may be around a quadrilateral.
    ///
    /// The first control points belong to the quadrilaterals, in their order; those beyond a rim
    /// follow.
    ///
    /// # Errors
    /// What is wrong with the quadrilaterals.
    pub fn of_quads(vertices: &[Vec3], quads: &[[u32; 4]]) -> Result<Self, MidsurfaceError> {
        let net = CellNet::new(vertices, quads)?;
        let (cells, tables, functions) = cells(&net)?;
        let nodes = control_points(&net, &cells, &tables)?;
        let (starts, neighbours) = neighbours(&net);
        let inside = std::iter::repeat_n(0.0, quads.len());
        let missing = inside.chain(net.inner.iter().map(|&quad| net.area(quad))).collect();
        Ok(Self {
            nodes,
            functions,
            cells,
            tables,
            starts,
            neighbours,
            share: vec![1.0; 4 * quads.len()],
            missing,
            steps: StepBounds::EVEN,
            faces: net.faces,
        })
    }

    /// At the points of a quadrilateral, what is given at its corners.
    pub(crate) fn at_points(corners: &[f64; 4]) -> [f64; 4] {
        let [a, b, c, d] = *corners;
        let rule = gauss(2);
        std::array::from_fn(|q| {
            let (x, y) = (rule[q % 2].0, rule[q / 2].0);
            (1.0 - y) * ((1.0 - x) * a + x * b) + y * ((1.0 - x) * d + x * c)
        })
    }

    /// The shares of control points in the place of vertex `vertex` of a surface of quadrilaterals.
    #[must_use]
    pub fn vertex_shares(&self, vertex: usize) -> Vec<(u32, f64)> {
        let face = &self.faces[vertex];
        face.iter().map(|&n| (n, 1.0 / face.len() as f64)).collect()
    }

    /// What the surface has at the vertices of its quadrilaterals: their places, or their
    /// displacements from those of the control points. Empty on other surfaces.
    #[must_use]
    pub fn at_vertices(&self, of: &[Vec3]) -> Vec<Vec3> {
        let at = |vertex: usize| {
            self.vertex_shares(vertex).into_iter().map(|(n, share)| of[n as usize] * share).sum()
        };
        (0..self.faces.len()).map(at).collect()
    }
}

type CellLists = (Vec<SurfaceCell>, Vec<CellTable>, usize);

fn cells(net: &CellNet<'_>) -> Result<CellLists, MidsurfaceError> {
    let mut places: BTreeMap<[usize; 4], u32> = BTreeMap::new();
    let (mut cells, mut tables, mut functions) = (Vec::new(), Vec::new(), 0);
    for (quad, corners) in net.quads.iter().enumerate() {
        let own = quad as u32;
        let faces: [Vec<u32>; 4] = CORNER_OF_FACE.map(|k| {
            let mut face = net.faces[corners[k] as usize].clone();
            let at = face.iter().position(|&n| n == own).unwrap_or(0);
            face.rotate_left(at);
            face
        });
        let counts = [0, 1, 2, 3].map(|i| faces[i].len());
        let (found, most) = (CellFaces::functions(counts), MOST_FUNCTIONS);
        if found > most {
            return Err(MidsurfaceError::Functions { quad, found, most });
        }
        let beside = faces.iter().map(|face| face[1]);
        let rest = faces.iter().flat_map(|face| face[2..face.len() - 1].iter().copied());
        let list: Vec<u32> = [own].into_iter().chain(beside).chain(rest).collect();
        let mut sorted = list.clone();
        sorted.sort_unstable();
        sorted.dedup();
        if sorted.len() != found {
            return Err(MidsurfaceError::Coarse { quad });
        }
        functions = functions.max(found);
        let next = tables.len() as u32;
        let table = *places.entry(counts).or_insert(next);
        if table == next {
            tables.push(cell_table(counts));
        }
        let nodes = std::array::from_fn(|k| list.get(k).copied().unwrap_or(own));
        cells.push(SurfaceCell { nodes, table });
    }
    Ok((cells, tables, functions))
}

fn cell_table(corners: [usize; 4]) -> CellTable {
    let (faces, rule) = (CellFaces::new(corners), gauss(2));
    let mut points = Vec::new();
    for &(y, wy) in &rule {
        for &(x, wx) in &rule {
            let found = faces.at([x, y]);
            let (value, derivatives) = (found.value, found.derivatives);
            points.push(TablePoint { weight: wx * wy, value, derivatives });
        }
    }
    let halves = [INWARD, 0.5, 1.0 - INWARD];
    let corners = halves.iter().flat_map(|&y| halves.map(|x| faces.at([x, y]).value)).collect();
    CellTable { extent: [1.0; 2], points, corners }
}

/// Control points whose cells have the middles of the quadrilaterals: c += x − middle(c).
fn control_points(
    net: &CellNet<'_>,
    cells: &[SurfaceCell],
    tables: &[CellTable],
) -> Result<Vec<Vec3>, MidsurfaceError> {
    let wanted = middles(net);
    let mut middle_of = vec![[0.0; MOST_FUNCTIONS]; tables.len()];
    for (quad, cell) in cells.iter().enumerate() {
        let counts = CORNER_OF_FACE.map(|k| net.faces[net.quads[quad][k] as usize].len());
        middle_of[cell.table as usize] = CellFaces::new(counts).at([0.5; 2]).value;
    }
    let mut points = wanted.clone();
    net.extend(&mut points);
    let mut worst = (0, f64::INFINITY);
    for _ in 0..FITS {
        let middle = |cell: &SurfaceCell| -> Vec3 {
            let shares = &middle_of[cell.table as usize];
            cell.nodes.iter().zip(shares).map(|(&n, share)| points[n as usize] * *share).sum()
        };
        let missed: Vec<Vec3> =
            cells.iter().zip(&wanted).map(|(cell, x)| x - middle(cell)).collect();
        worst = (0, 0.0);
        for (quad, miss) in missed.iter().enumerate() {
            points[quad] += miss;
            let far = miss.norm() / net.area(quad as u32).sqrt();
            if far > worst.1 {
                worst = (quad, far);
            }
        }
        points.truncate(net.quads.len());
        net.extend(&mut points);
        if worst.1 <= MISS {
            return Ok(points);
        }
    }
    Err(MidsurfaceError::Fit { quad: worst.0 })
}

/// Middles of the quadrilaterals on a surface through their corners that is smooth there: the mean
/// of the corners, raised by half of the rise of each side over its chord, which is
/// ((d·n_b) n_b − (d·n_a) n_a)/8 for a side d from a to b.
fn middles(net: &CellNet<'_>) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); net.vertices.len()];
    let places = |corners: &[u32; 4]| corners.map(|v| net.vertices[v as usize]);
    for corners in net.quads {
        let [a, b, c, d] = places(corners);
        let across = (c - a).cross(&(d - b));
        corners.iter().for_each(|&v| normals[v as usize] += across);
    }
    let normals: Vec<Vec3> = normals.into_iter().map(|n| n.normalize()).collect();
    let middle = |corners: &[u32; 4]| {
        let at = places(corners);
        let n = corners.map(|v| normals[v as usize]);
        let rise = (0..4).map(|k| {
            let next = (k + 1) % 4;
            let side = at[next] - at[k];
            (n[next] * side.dot(&n[next]) - n[k] * side.dot(&n[k])) / 16.0
        });
        at.iter().sum::<Vec3>() / 4.0 + rise.sum::<Vec3>()
    };
    net.quads.iter().map(middle).collect()
}

/// Points beside each, ascending: those of its cell, the two across each side of it that it lies
/// at, and those at the corner of it.
fn neighbours(net: &CellNet<'_>) -> (Vec<u32>, Vec<u32>) {
    let mut around = vec![Vec::new(); 4 * net.quads.len()];
    let point = |quad: u32, corner: usize| 4 * quad + AT_CORNER[corner % 4];
    for (quad, corners) in net.quads.iter().enumerate() {
        let own = quad as u32;
        for k in 0..4 {
            let list = &mut around[point(own, k) as usize];
            list.extend((1..4).map(|other| point(own, k + other)));
            for side in [k, (k + 3) % 4] {
                if let Some((other, entered)) = net.across(own, side) {
                    list.extend([point(other, entered), point(other, entered + 1)]);
                }
            }
            let vertex = corners[k];
            for &other in &net.fans[vertex as usize] {
                let there = net.quads[other as usize].iter().position(|&v| v == vertex);
                list.extend(there.map(|there| point(other, there)));
            }
            let me = point(own, k);
            list.retain(|&p| p != me);
            list.sort_unstable();
            list.dedup();
        }
    }
    let (mut starts, mut neighbours) = (vec![0], Vec::new());
    for own in around {
        neighbours.extend(own);
        starts.push(neighbours.len() as u32);
    }
    (starts, neighbours)
}
