//! The midsurface as lists: control points, cells with their functions, quadrature points.
//!
//! The kernel knows nothing of patches: whatever gives functions with two derivatives can be built
//! into a [`Midsurface`].

mod build;
mod doo_sabin;
mod net;
mod plate;
mod quads;

pub use net::MidsurfaceError;
pub(crate) use plate::placed;

use cullet_continuum::bytes::{held, held_lists};
use cullet_geometry::Vec3;
use cullet_geometry::nurbs::{MOST_FUNCTIONS, PatchBasis};

/// Stable step of cells of two Gauss points a direction: the lesser of these times l/c_p and
/// l²/(t c_p), for cells of size l and thickness t and c_p = √(E/ρ(1 − ν²))  \[1\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepBounds {
    /// In the plane.
    pub membrane: f64,
    /// In bending.
    pub bending: f64,
}

impl StepBounds {
    /// Of patches whose control points gather at the rim (open knots)  \[measured: S19\].
    pub const PATCH: Self = Self { membrane: 0.837, bending: 0.882 };

    /// Of control points that are as far apart at the rim as inside  \[measured: S19\].
    pub const EVEN: Self = Self { membrane: 1.25, bending: 1.32 };

    /// Stable step of cells of a size and thickness \[m\] at a speed c_p \[m/s\] \[s\].
    #[must_use]
    pub fn step(self, size: f64, thickness: f64, speed: f64) -> f64 {
        (self.membrane * size).min(self.bending * size * size / thickness) / speed
    }
}

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
    /// Share of each point's area that is of the shell \[1\]; points with none are off.
    pub share: Vec<f64>,
    /// Area that each control point would see more if the surface went on \[m²\], at the rim of a
    /// surface of quadrilaterals; empty on others.
    pub missing: Vec<f64>,
    /// Its stable step.
    pub steps: StepBounds,
    /// Control points around each vertex, on a surface of quadrilaterals.
    faces: Vec<Vec<u32>>,
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
    /// Extent of the cell in its parameters.
    pub extent: [f64; 2],
    /// Quadrature points.
    pub points: Vec<TablePoint>,
    /// R at the corners of the cell, the middles of its sides and its own, in three rows of rising
    /// second parameter; none of cells of patches.
    pub corners: Vec<[f64; MOST_FUNCTIONS]>,
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
    /// Least extent of its cell: its shorter side \[m\].
    pub extent: f64,
    /// S₁₁, S₂₂, S₁₂ of S = Σ s sᵀ over the two sides s of its cell, in the frame of e₁ and e₂
    /// \[m²\].
    pub spread: [f64; 3],
}

impl MidsurfacePoint {
    /// e₁ and e₂.
    #[must_use]
    pub fn frame(&self) -> [Vec3; 2] {
        let first = self.tangents[0].normalize();
        [first, self.normal.cross(&first)]
    }

    /// Extent of its cell along a unit vector of its frame, √(n·S n) \[m\].
    #[must_use]
    pub fn extent_along(&self, [x, y]: [f64; 2]) -> f64 {
        let [s11, s22, s12] = self.spread;
        (s11 * x * x + s22 * y * y + 2.0 * s12 * x * y).sqrt()
    }
}

impl Midsurface {
    /// Memory that it takes, about \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let table = |table: &CellTable| held(&table.points) + held(&table.corners);
        let tables = held(&self.tables) + self.tables.iter().map(table).sum::<u64>();
        let cells = held(&self.nodes) + held(&self.cells) + held_lists(&self.faces);
        let lists = held(&self.starts) + held(&self.neighbours);
        tables + cells + lists + held(&self.share) + held(&self.missing)
    }

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
        let extent = self.tables[cell.table as usize].extent;
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
            extent: (first * extent[0]).min(a2.norm() * extent[1]),
            spread: [
                (first * extent[0]).powi(2) + (f12 * extent[1]).powi(2),
                (f22 * extent[1]).powi(2),
                f12 * f22 * extent[1] * extent[1],
            ],
        }
    }
}
