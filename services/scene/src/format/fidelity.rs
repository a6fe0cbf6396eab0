//! What a scene asks of its solves.

use super::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// Least points of a fracture in a draft, the least that a scene may ask for.
const LEAST_POINTS: u32 = 64;

/// How accurate fracture solves must be, and what they may cost. Each hit gets the grid spacing
/// that the keys given here need. Without any of them `fracture.max_particles` sets the spacing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Fidelity {
    /// Accepted relative error of the crack area and of the largest fragment \[1\]. Each hit is
    /// solved on a coarse grid first, then on finer ones while two results differ by more, as far
    /// as `fracture.max_particles` and `budget_s` allow. A solve ends early when what still breaks
    /// cannot change the result by more.
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.01, "maximum" = 1, "x-default" = "none")
    )]
    pub error: Option<f64>,
    /// Most processor time for all solves of one hit \[s\], estimated for a common machine so that
    /// the result is the same on every machine.
    #[schemars(
        schema_with = "unit::time",
        extend("minimum" = 0.001, "maximum" = 1e6, "x-default" = "no limit")
    )]
    pub budget_s: Option<f64>,
    /// Size of the smallest fragment that the grid must resolve, with four cells across it \[m\].
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "none")
    )]
    pub smallest: Option<f64>,
    /// Length that one pixel of the picture covers at the bodies \[m\]. Grids are no finer than a
    /// quarter of two pixels; bodies whose halves would be smaller than two pixels are broken by
    /// `geometric`.
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "none")
    )]
    pub pixel: Option<f64>,
    /// Whether the cone crack under the contact matters: then the contact radius has four cells.
    pub cone: bool,
    /// Whether cracks must start at the material's strength, which a coarse grid lowers (F01): then
    /// the grid is fine enough for that.
    pub strength: bool,
    /// How many times cheaper all solves are than the scene asks, for a first look \[1\]: at 7
    /// the points of sheets and soft shells are 1.9 times farther apart, those of solids 1.6 times,
    /// and a fracture has a quarter of the points. Where a tear runs on from a notch the largest
    /// pieces are about those of the whole run; what breaks by itself can break otherwise.
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 1, "maximum" = 100, "x-default" = "not a draft")
    )]
    pub draft: Option<f64>,
}

impl Fidelity {
    /// Whether the scene asks for anything of the grids of fractures.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        Self { draft: None, ..*self } != Self::default()
    }

    /// What is said of a draft.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let of = "times cheaper: what breaks, and where, can differ from the whole run";
        self.draft.map(|draft| format!("a draft, {draft} {of}"))
    }

    /// How many times farther apart the points of a surface are in a draft \[1\]: their number
    /// and that of the steps makes a cost of h⁻³.
    #[must_use]
    pub fn coarser_surface(&self) -> f64 {
        libm::cbrt(self.draft.unwrap_or(1.0))
    }

    /// Likewise those of a solid \[1\], whose cost goes with h⁻⁴.
    #[must_use]
    pub fn coarser_solid(&self) -> f64 {
        self.draft.unwrap_or(1.0).sqrt().sqrt()
    }

    /// How many material points a fracture has in a draft that otherwise has `whole`.
    #[must_use]
    pub fn drafted_points(&self, whole: u32) -> u32 {
        match self.draft {
            None => whole,
            Some(_) => {
                let points = f64::from(whole) / self.coarser_solid().powi(3);
                (points as u32).max(LEAST_POINTS.min(whole))
            }
        }
    }
}
