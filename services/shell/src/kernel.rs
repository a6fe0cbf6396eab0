//! The points' pass: strains of the midsurface, stress resultants, forces on control points.
//!
//! Cells lie side by side, one in each lane of a register (see `cullet_simd`), and a tile's cells
//! share their functions. No sum runs across lanes, and blocks are summed in order: so the bits
//! depend neither on the registers' width nor on the number of threads.
//!
//! Points whose material is not simply elastic are handed, one by one, to a
//! [`SectionLaw`](crate::section::SectionLaw).

mod block;
mod damping;
mod elastic;
mod pass;
mod slot;
mod strain;

pub(crate) use block::CellSide;
pub(crate) use pass::ShellKernel;

use crate::midsurface::MidsurfacePoint;

/// Isotropic elasticity in plane stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneStress {
    /// E/(1 − ν²) \[Pa\].
    pub modulus: f64,
    /// Poisson's ratio ν \[1\].
    pub poisson: f64,
}

impl PlaneStress {
    /// Of Young's modulus E \[Pa\] and Poisson's ratio ν.
    #[must_use]
    pub fn new(young: f64, poisson: f64) -> Self {
        Self { modulus: young / (1.0 - poisson * poisson), poisson }
    }

    /// Ŝ = E/(1−ν²) [(1−ν) Ê + ν tr(Ê) 1]: 11, 22, 12.
    #[must_use]
    pub fn stress(&self, strain: &[f64; 3]) -> [f64; 3] {
        let [e11, e22, e12] = *strain;
        let Self { modulus, poisson } = *self;
        [
            modulus * (e11 + poisson * e22),
            modulus * (e22 + poisson * e11),
            modulus * (1.0 - poisson) * e12,
        ]
    }

    /// Elastic energy a volume of a strain \[J/m³\].
    #[must_use]
    pub fn energy(&self, strain: &[f64; 3]) -> f64 {
        let s = self.stress(strain);
        0.5 * (s[0] * strain[0] + s[1] * strain[1]) + s[2] * strain[2]
    }
}

/// Strain of the midsurface and change of curvature at a point, Cartesian: 11, 22, 12.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceStrain {
    /// ε \[1\].
    pub membrane: [f64; 3],
    /// κ \[1/m\].
    pub bending: [f64; 3],
}

impl SurfaceStrain {
    /// The mean of two.
    #[must_use]
    pub fn middle(&self, other: &Self) -> Self {
        let mean = |a: &[f64; 3], b: &[f64; 3]| [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
        Self {
            membrane: mean(&self.membrane, &other.membrane),
            bending: mean(&self.bending, &other.bending),
        }
    }

    /// E(z) = ε + z κ.
    #[must_use]
    pub fn at(&self, z: f64) -> [f64; 3] {
        [0, 1, 2].map(|k| self.membrane[k] + z * self.bending[k])
    }
}

/// What a section bears, Cartesian: 11, 22, 12.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resultants {
    /// n \[N/m\].
    pub force: [f64; 3],
    /// m \[N\].
    pub moment: [f64; 3],
}

impl Resultants {
    /// Adds the share `w` of a thickness of `t` \[m\], at the height `z` over `t`.
    pub(crate) fn add(&mut self, t: f64, (z, w): (f64, f64), stress: &[f64; 3]) {
        for (k, stress) in stress.iter().enumerate() {
            self.force[k] += w * t * stress;
            self.moment[k] += w * t * t * z * stress;
        }
    }
}

/// Where a point is in the lists of the kernel: element times points a cell plus place in the cell.
pub(crate) type Seat = usize;

/// What the kernel knows of a point before anything moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointSetup {
    pub(crate) surface: MidsurfacePoint,
    /// t \[m\].
    pub(crate) thickness: f64,
}
