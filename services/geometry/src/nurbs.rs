//! NURBS patches: tensor-product surfaces of degree 2 or 3 (Piegl and Tiller, The NURBS Book).

mod axis;
mod patch;
mod tessellate;
#[cfg(test)]
mod tests;

pub use axis::{AxisBasis, KnotSpan, SplineAxis};
pub use patch::{NurbsPatch, PatchBasis};
pub use tessellate::tessellate;

use thiserror::Error;

/// Least and greatest degree.
pub const DEGREES: (usize, usize) = (2, 3);

/// Most functions that are not zero at a point.
pub const MOST_FUNCTIONS: usize = (DEGREES.1 + 1) * (DEGREES.1 + 1);

/// What is wrong with a patch.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NurbsError {
    /// A degree that is not supported.
    #[error("a degree of {0}: it must be {least} or {most}", least = DEGREES.0, most = DEGREES.1)]
    Degree(usize),
    /// Too few cells.
    #[error("{cells} cells in a direction: at least {least} are needed")]
    Cells {
        /// Asked for.
        cells: usize,
        /// Needed.
        least: usize,
    },
    /// Knots that decrease or are no numbers.
    #[error("knot {index} is {value}: knots must be finite and must not decrease")]
    Knot {
        /// Which, from 0 on.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A knot that the surface has a crease at.
    #[error(
        "knot {value} occurs {times} times inside a patch of degree {degree}: \
             at most {most} times keep the surface smooth"
    )]
    Crease {
        /// The knot.
        value: f64,
        /// How often.
        times: usize,
        /// Of the patch, in that direction.
        degree: usize,
        /// Allowed.
        most: usize,
    },
    /// Ends that are not clamped.
    #[error("the {end} knot must occur {wanted} times, not {times}")]
    Clamped {
        /// First or last.
        end: &'static str,
        /// Degree + 1.
        wanted: usize,
        /// How often it does.
        times: usize,
    },
    /// A number of control points or weights that does not fit the knots.
    #[error("{found} {what}, but the knots ask for {wanted}")]
    Count {
        /// Control points or weights.
        what: &'static str,
        /// Given.
        found: usize,
        /// By the knots.
        wanted: usize,
    },
    /// A weight that is not positive, or a control point that is no point.
    #[error("{what} {index} is not {wanted}")]
    Value {
        /// Control point or weight.
        what: &'static str,
        /// Which, from 0 on.
        index: usize,
        /// What it must be.
        wanted: &'static str,
    },
}
