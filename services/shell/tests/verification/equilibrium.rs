//! Static equilibrium of a shell by Newton's method on the forces of the kernel itself.

use cullet_geometry::Vec3;
use cullet_geometry::nurbs::NurbsPatch;
use cullet_model::Material;
use cullet_shell::domain::{ShellDomain, ShellMaterial};
use cullet_shell::midsurface::Midsurface;
use cullet_shell::section::SectionLaw;
use cullet_simd::{Real, SimdLevel};

/// A shell that does not break.
pub(crate) fn elastic<R: Real, const N: usize>(
    surface: Midsurface,
    [young, poisson, thickness]: [f64; 3],
    level: SimdLevel,
) -> ShellDomain<R, N> {
    let points = surface.points();
    let (density, failure_stress, fracture_energy) = (1.0, f64::INFINITY, 1.0);
    let solid = Material { density, young, poisson, failure_stress, fracture_energy };
    let material = ShellMaterial {
        law: SectionLaw::new(&solid),
        density,
        thickness: vec![thickness; points],
        strength: vec![f64::INFINITY; points],
        softening_cells: 1.1,
    };
    ShellDomain::new(surface, material, level)
}

/// What each degree of freedom of each control point is: fixed, or a number that others may share.
pub(crate) struct Freedoms {
    of: Vec<[Option<usize>; 3]>,
    count: usize,
}

impl Freedoms {
    /// All free.
    pub(crate) fn new(nodes: usize) -> Self {
        let of = (0..nodes).map(|n| [0, 1, 2].map(|c| Some(3 * n + c))).collect();
        Self { of, count: 3 * nodes }
    }

    pub(crate) fn fix(&mut self, node: usize, axis: usize) {
        self.of[node][axis] = None;
    }

    /// Makes one move as another does.
    pub(crate) fn tie(&mut self, node: usize, axis: usize, other: usize) {
        self.of[node][axis] = self.of[other][axis];
    }

    /// Symmetry about the plane across `axis` that the row `edge` lies in, `next` being the row
    /// beside it: no motion across, no slope.
    pub(crate) fn mirror(&mut self, edge: &[usize], next: &[usize], axis: usize) {
        for (&a, &b) in edge.iter().zip(next) {
            self.fix(a, axis);
            for along in (0..3).filter(|&c| c != axis) {
                self.tie(b, along, a);
            }
        }
    }

    /// Numbers those that are left in the order of the control points.
    fn close(&mut self) {
        let mut numbers = std::collections::BTreeMap::new();
        for of in self.of.iter_mut().flatten().flatten() {
            let next = numbers.len();
            *of = *numbers.entry(*of).or_insert(next);
        }
        self.count = numbers.len();
    }
}

/// Control points of a patch by column and row.
pub(crate) struct Grid {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl Grid {
    pub(crate) fn of(patch: &NurbsPatch) -> Self {
        let [columns, rows] = [0, 1].map(|a| patch.axes()[a].functions());
        Self { columns, rows }
    }

    pub(crate) fn at(&self, column: usize, row: usize) -> usize {
        row * self.columns + column
    }

    pub(crate) fn column(&self, column: usize) -> Vec<usize> {
        (0..self.rows).map(|row| self.at(column, row)).collect()
    }

    pub(crate) fn row(&self, row: usize) -> Vec<usize> {
        (0..self.columns).map(|column| self.at(column, row)).collect()
    }
}

/// Forces on the degrees of freedom \[N\].
fn forces<R: Real, const N: usize>(
    shell: &mut ShellDomain<R, N>,
    freedoms: &Freedoms,
    external: &dyn Fn(&ShellDomain<R, N>) -> Vec<Vec3>,
) -> Vec<f64> {
    shell.strain();
    let outside = external(shell);
    let mut sum = vec![0.0; freedoms.count];
    for (node, of) in freedoms.of.iter().enumerate() {
        let force = shell.force(node) + outside[node];
        for (dof, force) in of.iter().zip(&force) {
            if let Some(dof) = dof {
                sum[*dof] += force;
            }
        }
    }
    sum
}

fn displace<R: Real, const N: usize>(
    shell: &mut ShellDomain<R, N>,
    freedoms: &Freedoms,
    u: &[f64],
) {
    for (node, of) in freedoms.of.iter().enumerate() {
        for (moved, dof) in shell.displacement[node].iter_mut().zip(of) {
            *moved = dof.map_or(0.0, |dof| u[dof]);
        }
    }
}

/// The displacements at which all forces vanish, from `start`; `nudge` is a small displacement.
pub(crate) fn solve<R: Real, const N: usize>(
    shell: &mut ShellDomain<R, N>,
    freedoms: &mut Freedoms,
    external: &dyn Fn(&ShellDomain<R, N>) -> Vec<Vec3>,
    start: &mut Vec<f64>,
    [nudge, iterations]: [f64; 2],
) {
    freedoms.close();
    start.resize(freedoms.count, 0.0);
    for _ in 0..iterations as usize {
        displace(shell, freedoms, start);
        let residual = forces(shell, freedoms, external);
        let tangent = tangent(shell, freedoms, external, start, nudge);
        let change = tangent.solved(residual);
        start.iter_mut().zip(&change).for_each(|(u, d)| *u += d);
        let size = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if size(&change) < 1e-9 * size(start) {
            break;
        }
    }
    displace(shell, freedoms, start);
}

/// −∂f/∂u by central differences, banded.
fn tangent<R: Real, const N: usize>(
    shell: &mut ShellDomain<R, N>,
    freedoms: &Freedoms,
    external: &dyn Fn(&ShellDomain<R, N>) -> Vec<Vec3>,
    u: &[f64],
    nudge: f64,
) -> Banded {
    let mut at = u.to_vec();
    let mut columns = Vec::new();
    let mut width = 0;
    for dof in 0..freedoms.count {
        let mut side = |sign: f64| {
            at[dof] = u[dof] + sign * nudge;
            displace(shell, freedoms, &at);
            forces(shell, freedoms, external)
        };
        let (more, less) = (side(1.0), side(-1.0));
        at[dof] = u[dof];
        let column: Vec<(usize, f64)> = more
            .iter()
            .zip(&less)
            .map(|(a, b)| (b - a) / (2.0 * nudge))
            .enumerate()
            .filter(|(_, k)| *k != 0.0)
            .collect();
        width = column.iter().map(|(row, _)| row.abs_diff(dof)).fold(width, usize::max);
        columns.push(column);
    }
    let mut banded = Banded::new(freedoms.count, width);
    for (dof, column) in columns.iter().enumerate() {
        for &(row, k) in column {
            *banded.at(row, dof) = k;
        }
    }
    banded
}

/// A banded matrix, row by row.
struct Banded {
    size: usize,
    width: usize,
    numbers: Vec<f64>,
}

impl Banded {
    fn new(size: usize, width: usize) -> Self {
        Self { size, width, numbers: vec![0.0; size * (2 * width + 1)] }
    }

    fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.numbers[row * (2 * self.width + 1) + column + self.width - row]
    }

    /// Gauss without pivots: the matrix is symmetric to rounding.
    fn solved(mut self, mut right: Vec<f64>) -> Vec<f64> {
        let (n, w) = (self.size, self.width);
        for k in 0..n {
            let pivot = *self.at(k, k);
            for row in k + 1..n.min(k + w + 1) {
                let share = *self.at(row, k) / pivot;
                if share == 0.0 {
                    continue;
                }
                for column in k..n.min(k + w + 1) {
                    let above = *self.at(k, column);
                    *self.at(row, column) -= share * above;
                }
                right[row] -= share * right[k];
            }
        }
        for k in (0..n).rev() {
            for column in k + 1..n.min(k + w + 1) {
                right[k] -= *self.at(k, column) * right[column];
            }
            right[k] /= *self.at(k, k);
        }
        right
    }
}
