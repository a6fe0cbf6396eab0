//! Bending by curvature vectors: a quadratic fitted to the live neighbours of each point gives
//! κ_xx, κ_xy, κ_yy as sums d_j (x_j − x_i), which all but vanish for affine maps. With
//! q = |κ_xx|² + |κ_yy|² + 2ν κ_xx·κ_yy + 2(1−ν)|κ_xy|² the energy is ½ Σ A B q: a constant
//! quadratic form, so forces are linear in the places and keep momentum and angular momentum.
//!
//! Han and others' angles between normals have no stiffness by area and no momentum (F58).

use crate::bonds::MembraneBonds;
use crate::fit::cholesky;
use cullet_continuum::bytes::held;
use cullet_geometry::Vec3;
use cullet_model::SheetPlace;
use nalgebra::{SMatrix, SVector};

/// Reach of the fit over the spacing: about sixteen neighbours.
const REACH: f64 = 2.3;
/// Fewest live neighbours that a curvature is fitted to.
const LEAST_NEIGHBOURS: usize = 7;
/// Greatest coefficient, by the spacing squared. Beyond it neighbours hardly span the plane.
pub(crate) const MOST_COEFFICIENT: f64 = 12.0;
/// Greatest whole number of a coefficient: they are rounded to multiples of a small one, so that
/// two take no more than 32 bits. An affine map then has a curvature of about 1e-3 over the
/// spacing, all of it in the plane, where it is felt as a strain of 1e-6 B/(EhΔx²).
const WHOLE: f64 = 32_767.0;
/// Stiffness of the fastest bending motion over B/(ρhΔx⁴), measured.
pub(crate) const FASTEST: f64 = 160.0;

/// What one neighbour adds to the curvature and slope of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StencilTerm {
    /// Of κ_xx, κ_xy and κ_yy \[1/m²\].
    pub(crate) curvature: [f64; 3],
    /// Of ∂x/∂X and ∂x/∂Y \[1/m\].
    pub(crate) slope: [f64; 2],
}

/// The fits of all points.
#[derive(Clone, Debug)]
pub(crate) struct BendingStencils {
    /// First neighbour of each point, then their number.
    pub(crate) starts: Vec<u32>,
    pub(crate) ends: Vec<u32>,
    /// The same pair as the other end has it.
    pub(crate) twins: Vec<u32>,
    /// The bond of each.
    pub(crate) bonds: Vec<u32>,
    pub(crate) terms: Vec<StencilTerm>,
    spacing: f64,
    reach: f64,
}

impl BendingStencils {
    /// Memory that it takes \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let lists = [&self.starts, &self.ends, &self.twins, &self.bonds];
        lists.map(|list| held(list)).iter().sum::<u64>() + held(&self.terms)
    }

    /// Finds the neighbours among the bonds. Nothing is fitted yet.
    pub(crate) fn new(bonds: &MembraneBonds, spacing: f64, horizon: f64) -> Self {
        let reach = REACH.min(horizon) * spacing;
        let mut found = Self {
            starts: vec![0],
            ends: Vec::new(),
            twins: Vec::new(),
            bonds: Vec::new(),
            terms: Vec::new(),
            spacing,
            reach,
        };
        let mut place = vec![u32::MAX; bonds.ends.len()];
        for i in 0..bonds.starts.len() - 1 {
            for b in bonds.of(i).filter(|&b| bonds.lengths[b] < reach) {
                place[b] = found.ends.len() as u32;
                found.ends.push(bonds.ends[b]);
                found.bonds.push(b as u32);
            }
            found.starts.push(found.ends.len() as u32);
        }
        let twin = |&b: &u32| place[bonds.twins[b as usize] as usize];
        found.twins = found.bonds.iter().map(twin).collect();
        found.terms = vec![StencilTerm::default(); found.ends.len()];
        found
    }

    /// The neighbours of a point.
    #[inline(always)]
    pub(crate) fn of(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    /// What coefficients of curvatures are multiples of \[1/m²\], by numbers of 16 bits.
    pub(crate) fn unit(&self) -> f64 {
        MOST_COEFFICIENT / (self.spacing * self.spacing) / WHOLE
    }

    /// Greatest coefficient of a curvature \[1/m²\].
    pub(crate) fn most(&self) -> f64 {
        MOST_COEFFICIENT / (self.spacing * self.spacing)
    }

    /// Fits a point anew, to those of its neighbours that are alive.
    pub(crate) fn fit(&mut self, i: usize, places: &[SheetPlace], alive: impl Fn(usize) -> bool) {
        let own = self.of(i);
        self.terms[own.clone()].fill(StencilTerm::default());
        let live: Vec<usize> = own.filter(|&n| alive(self.bonds[n] as usize)).collect();
        let [x, y] = places[i];
        let off = |n: usize| {
            let [a, b] = places[self.ends[n] as usize];
            let (dx, dy) = ((a - x) / self.spacing, (b - y) / self.spacing);
            let weight = 1.0 - (dx * dx + dy * dy).sqrt() * self.spacing / self.reach;
            (dx, dy, weight.max(1e-3))
        };
        let quadratic = |n: usize| {
            let (dx, dy, weight) = off(n);
            let row = [dx, dy, 0.5 * dx * dx, dx * dy, 0.5 * dy * dy];
            (SVector::from(row), weight)
        };
        if live.len() >= LEAST_NEIGHBOURS
            && let Some(terms) = solved(&live, quadratic)
        {
            let unit = self.unit();
            let per_area = 1.0 / (self.spacing * self.spacing);
            let rounded = |coefficient: f64| (coefficient * per_area / unit).round() * unit;
            let most = terms.iter().flat_map(|t| [t[2], t[3], t[4]]).map(f64::abs);
            if most.fold(0.0, f64::max) <= MOST_COEFFICIENT {
                for (&n, t) in live.iter().zip(&terms) {
                    self.terms[n] = StencilTerm {
                        curvature: [rounded(t[2]), rounded(t[3]), rounded(t[4])],
                        slope: [t[0] / self.spacing, t[1] / self.spacing],
                    };
                }
                return;
            }
        }
        let linear = |n: usize| {
            let (dx, dy, weight) = off(n);
            (SVector::from([dx, dy]), weight)
        };
        if let Some(terms) = solved(&live, linear) {
            for (&n, t) in live.iter().zip(&terms) {
                self.terms[n].slope = [t[0] / self.spacing, t[1] / self.spacing];
            }
        }
    }

    /// κ_xx, κ_xy and κ_yy of a point \[1/m\].
    #[inline(always)]
    pub(crate) fn curvature(&self, i: usize, places: &[Vec3]) -> [Vec3; 3] {
        let mut kappa = [Vec3::zeros(); 3];
        for n in self.of(i) {
            let off = places[self.ends[n] as usize] - places[i];
            let [xx, xy, yy] = self.terms[n].curvature;
            kappa[0] += off * xx;
            kappa[1] += off * xy;
            kappa[2] += off * yy;
        }
        kappa
    }

    /// ∂x/∂X and ∂x/∂Y of a point \[1\].
    #[inline(always)]
    pub(crate) fn slopes(&self, i: usize, places: &[Vec3]) -> [Vec3; 2] {
        let mut slopes = [Vec3::zeros(); 2];
        for n in self.of(i) {
            let off = places[self.ends[n] as usize] - places[i];
            slopes[0] += off * self.terms[n].slope[0];
            slopes[1] += off * self.terms[n].slope[1];
        }
        slopes
    }
}

/// q of curvature vectors \[1/m²\], and its half's derivatives by them.
#[inline(always)]
pub(crate) fn curvature_form(kappa: &[Vec3; 3], poisson: f64) -> (f64, [Vec3; 3]) {
    let [xx, xy, yy] = kappa;
    let by = [xx + yy * poisson, xy * (2.0 * (1.0 - poisson)), yy + xx * poisson];
    (by[0].dot(xx) + by[1].dot(xy) + by[2].dot(yy), by)
}

/// Coefficients of a weighted least-squares fit: one vector a neighbour; none where the neighbours
/// do not determine it.
fn solved<const N: usize>(
    live: &[usize],
    row: impl Fn(usize) -> (SVector<f64, N>, f64),
) -> Option<Vec<SVector<f64, N>>> {
    let mut matrix = SMatrix::<f64, N, N>::zeros();
    for &n in live {
        let (b, weight) = row(n);
        matrix += b * b.transpose() * weight;
    }
    let solve = |&n: &usize| {
        let (b, weight) = row(n);
        cholesky(matrix, b * weight)
    };
    (!live.is_empty()).then(|| live.iter().map(solve).collect()).flatten()
}
