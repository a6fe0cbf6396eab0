//! The midsurface as lists: control points, cells with their functions, quadrature points.
//!
//! The kernel knows nothing of patches: whatever gives functions with two derivatives can be built
//! into a [`Midsurface`].

mod box_spline;
mod build;
mod plate;
mod rim;
mod triangle_net;
mod triangles;

pub(crate) use plate::placed;
pub use triangle_net::LoopError;

use cullet_geometry::Vec3;
use cullet_geometry::nurbs::{MOST_FUNCTIONS, PatchBasis};

/// Edge of an equilateral triangle over its height: 2/√3.
const EQUILATERAL: f64 = 1.154_700_538_379_251_5;

/// A shell's midsurface, made discrete.
#[derive(Clone, Debug, PartialEq)]
pub struct Midsurface {
    /// Control points \[m\].
    pub nodes: Vec<Vec3>,
    /// Functions of a cell: cells with fewer name their first node again, with functions of zero.
    pub functions: usize,
    /// Cells.
    pub cells: Vec<SurfaceCell>,
    /// Functions of cells at their points; cells that are alike share a table.
    pub tables: Vec<CellTable>,
    /// First entry in `neighbours` of each point, then their number.
    pub starts: Vec<u32>,
    /// Neighbours of each point, ascending.
    pub neighbours: Vec<u32>,
    /// For each neighbour, whether its cell only shares a corner: it is beside the point, but
    /// nothing joins the two.
    pub corner_only: Vec<bool>,
    /// Share of each point's area that is of the shell \[1\]; points with none are off.
    pub share: Vec<f64>,
    /// Area that each control point would see more if the surface went on \[m²\], at the rim of a
    /// surface of triangles; empty on others.
    pub missing: Vec<f64>,
    /// Neighbours of the control point of each vertex, on a surface of triangles.
    rings: Vec<Vec<u32>>,
}

/// Shape of a cell in its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CellShape {
    /// A rectangle.
    Rectangle,
    /// The triangle of area ½.
    Triangle,
}

/// A cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCell {
    /// Its control points.
    pub nodes: [u32; MOST_FUNCTIONS],
    /// Its functions, by place in [`Midsurface::tables`].
    pub table: u32,
}

/// Functions of a cell at its quadrature points.
#[derive(Clone, Debug, PartialEq)]
pub struct CellTable {
    /// Shape of the cell.
    pub shape: CellShape,
    /// Extent of the cell in its parameters.
    pub extent: [f64; 2],
    /// Quadrature points.
    pub points: Vec<TablePoint>,
}

/// Functions at a quadrature point.
#[derive(Clone, Debug, PartialEq)]
pub struct TablePoint {
    /// Share of the parameters' area that is its own.
    pub weight: f64,
    /// R.
    pub value: [f64; MOST_FUNCTIONS],
    /// R,1 R,2 R,11 R,22 R,12.
    pub derivatives: [[f64; MOST_FUNCTIONS]; 5],
}

impl TablePoint {
    fn new(weight: f64, basis: &PatchBasis) -> Self {
        Self { weight, value: basis.value, derivatives: basis.derivatives }
    }
}

/// The surface at a quadrature point, before anything moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MidsurfacePoint {
    /// Where \[m\].
    pub place: Vec3,
    /// A₁ and A₂ \[m\].
    pub tangents: [Vec3; 2],
    /// X,11 X,22 X,12 \[m\].
    pub curvatures: [Vec3; 3],
    /// Unit normal A₃.
    pub normal: Vec3,
    /// J = |A₁ × A₂| \[m²\].
    pub stretch: f64,
    /// Area that is its own \[m²\].
    pub area: f64,
    /// T₁₁, T₁₂, T₂₂ of T = F⁻¹ with F_iα = e_i·A_α, e₁ = A₁/|A₁|, e₂ = A₃ × e₁ \[1/m\].
    pub to_local: [f64; 3],
    /// Least extent of its cell: of a rectangle its shorter side, of a triangle the edge of the
    /// equilateral one that is as high \[m\].
    pub extent: f64,
}

impl MidsurfacePoint {
    /// e₁ and e₂.
    #[must_use]
    pub fn frame(&self) -> [Vec3; 2] {
        let first = self.tangents[0].normalize();
        [first, self.normal.cross(&first)]
    }

    /// |A₁ × A₂| over |A₁||A₂|: small where the parameters collapse (F62).
    #[must_use]
    pub fn openness(&self) -> f64 {
        self.stretch / (self.tangents[0].norm() * self.tangents[1].norm())
    }
}

impl Midsurface {
    /// Quadrature points of a cell.
    #[must_use]
    pub fn points_per_cell(&self) -> usize {
        self.tables[0].points.len()
    }

    /// Quadrature points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.cells.len() * self.points_per_cell()
    }

    /// The neighbours of a point.
    #[must_use]
    pub fn around(&self, point: usize) -> &[u32] {
        &self.neighbours[self.starts[point] as usize..self.starts[point + 1] as usize]
    }

    /// The functions at a point, with its cell.
    #[must_use]
    pub fn at(&self, point: usize) -> (&SurfaceCell, &TablePoint) {
        let each = self.points_per_cell();
        let cell = &self.cells[point / each];
        (cell, &self.tables[cell.table as usize].points[point % each])
    }

    /// Sum over the control points of `nodes` of a cell.
    pub(crate) fn sum(&self, cell: &SurfaceCell, row: &[f64], of: &[Vec3]) -> Vec3 {
        let mut sum = Vec3::zeros();
        for (k, share) in row.iter().enumerate().take(self.functions) {
            sum += of[cell.nodes[k] as usize] * *share;
        }
        sum
    }

    /// The surface at a point.
    #[must_use]
    pub fn surface_point(&self, point: usize) -> MidsurfacePoint {
        let (cell, table) = self.at(point);
        let &CellTable { shape, extent, .. } = &self.tables[cell.table as usize];
        let [a1, a2, x11, x22, x12] =
            [0, 1, 2, 3, 4].map(|d| self.sum(cell, &table.derivatives[d], &self.nodes));
        let across = a1.cross(&a2);
        let stretch = across.norm();
        let normal = across / stretch;
        let first = a1.norm();
        let (e1, e2) = (a1 / first, normal.cross(&a1) / first);
        let (f12, f22) = (e1.dot(&a2), e2.dot(&a2));
        MidsurfacePoint {
            place: self.sum(cell, &table.value, &self.nodes),
            tangents: [a1, a2],
            curvatures: [x11, x22, x12],
            normal,
            stretch,
            area: stretch * table.weight * self.share[point],
            to_local: [1.0 / first, -f12 / (first * f22), 1.0 / f22],
            extent: match shape {
                CellShape::Rectangle => (first * extent[0]).min(a2.norm() * extent[1]),
                CellShape::Triangle => {
                    EQUILATERAL * stretch / first.max(a2.norm()).max((a2 - a1).norm())
                }
            },
        }
    }
}
