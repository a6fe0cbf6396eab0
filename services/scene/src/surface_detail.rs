//! Detail of crack faces that is finer than the grid: a named look, and what differs from it.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a number of [`Detail`] is without its key, as the schema has it.
const LOOKS: &str = "that of `look`";

/// A named set of values for the detail of crack faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Look {
    /// No detail beyond the grid; costs nothing.
    #[default]
    Plain,
    /// Smooth, with ribs along the crack front (Wallner lines).
    Glass,
    /// Long ledges in the direction in which the crack ran.
    Ice,
    /// Fine ledges with fine grain.
    Porcelain,
    /// Sugary grain over short ledges.
    Marble,
    /// High ledges with coarse grain.
    Stone,
    /// Wide, soft ledges with some coarse grain.
    Clay,
    /// Grain as of aggregates, with hardly any ledges.
    Concrete,
    /// Fine grain with low ledges.
    Brick,
}

/// Detail of crack faces that is finer than the grid of the solve. Most lengths are in grid
/// spacings, so that the detail is as fine as the solve. With `height`, `ribs` and `grain` all 0
/// there is no detail.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Detail {
    /// Named set of values for the keys that are not written here.
    pub look: Look,
    /// Longest edge of a crack face, and the step along a chevron line, d, in grid spacings \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.1, "maximum" = 2, "x-default" = LOOKS)
    )]
    pub edge: Option<f64>,
    /// Length of the longest chevron lines, `l_c`, in grid spacings \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.5, "maximum" = 100, "x-default" = LOOKS)
    )]
    pub length: Option<f64>,
    /// Distance at which a chevron line keeps others away, s, in grid spacings \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.1, "maximum" = 10, "x-default" = LOOKS)
    )]
    pub influence: Option<f64>,
    /// Length over which heights and damage times are smoothed, `h_c`, in grid spacings \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.3, "maximum" = 4, "x-default" = LOOKS)
    )]
    pub grid: Option<f64>,
    /// Height of the chevrons, G, in grid spacings \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 0.5, "x-default" = LOOKS)
    )]
    pub height: Option<f64>,
    /// Share of the chevron lines, longest first, whose height grows along them, m \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 1, "x-default" = LOOKS)
    )]
    pub share: Option<f64>,
    /// Height of the ribs, which mark the crack front at equal times, in grid spacings \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 0.5, "x-default" = LOOKS)
    )]
    pub ribs: Option<f64>,
    /// Distance between two ribs, in grid spacings \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.5, "maximum" = 100, "x-default" = LOOKS)
    )]
    pub rib_spacing: Option<f64>,
    /// Height of the grain, in grid spacings \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0, "maximum" = 0.5, "x-default" = LOOKS)
    )]
    pub grain: Option<f64>,
    /// Size of the coarsest grain, in grid spacings \[1\].
    #[schemars(
        schema_with = "unit::ratio",
        extend("minimum" = 0.2, "maximum" = 20, "x-default" = LOOKS)
    )]
    pub grain_size: Option<f64>,
    /// Width of the slits that are cut along cracks which end inside a fragment \[m\]; what is cut
    /// away becomes debris. `brittle` takes at most a fifth of a grid spacing. Without slits such
    /// cracks are lines.
    #[schemars(
        schema_with = "unit::length",
        extend("exclusiveMinimum" = 0, "x-default" = "no slits")
    )]
    pub hairline: Option<f64>,
}

impl Look {
    /// All that are more than plain, by name.
    pub const ALL: [(&'static str, Self); 8] = [
        ("glass", Self::Glass),
        ("ice", Self::Ice),
        ("porcelain", Self::Porcelain),
        ("marble", Self::Marble),
        ("stone", Self::Stone),
        ("clay", Self::Clay),
        ("concrete", Self::Concrete),
        ("brick", Self::Brick),
    ];

    /// The values of a look.
    #[must_use]
    pub fn detail(self) -> cullet_model::CrackFaceDetail {
        let mut d = cullet_model::CrackFaceDetail::default();
        match self {
            Self::Plain => {}
            Self::Glass => {
                (d.edge, d.length, d.height) = (0.35, 14.0, 0.1);
                (d.ribs, d.rib_spacing) = (0.2, 3.0);
            }
            Self::Ice => {
                (d.length, d.influence, d.height, d.share) = (20.0, 1.2, 0.45, 1.0);
                (d.ribs, d.rib_spacing) = (0.05, 3.0);
            }
            Self::Porcelain => {
                (d.length, d.influence, d.height) = (14.0, 0.8, 0.22);
                (d.grain, d.grain_size) = (0.04, 1.2);
            }
            Self::Marble => {
                (d.length, d.influence, d.height, d.share) = (6.0, 0.6, 0.25, 0.3);
                (d.grain, d.grain_size) = (0.15, 1.5);
            }
            Self::Stone => {
                (d.influence, d.grid, d.height, d.share) = (0.9, 0.8, 0.5, 0.8);
                (d.grain, d.grain_size) = (0.25, 3.0);
            }
            Self::Clay => {
                (d.influence, d.grid, d.height) = (1.5, 1.2, 0.5);
                (d.grain, d.grain_size) = (0.12, 4.0);
            }
            Self::Concrete => {
                (d.edge, d.height) = (0.35, 0.1);
                (d.grain, d.grain_size) = (0.4, 2.0);
            }
            Self::Brick => {
                (d.edge, d.height) = (0.35, 0.15);
                (d.grain, d.grain_size) = (0.2, 1.0);
            }
        }
        d
    }
}

impl Detail {
    /// The look with what differs from it.
    #[must_use]
    pub fn values(&self) -> cullet_model::CrackFaceDetail {
        let look = self.look.detail();
        cullet_model::CrackFaceDetail {
            edge: self.edge.unwrap_or(look.edge),
            length: self.length.unwrap_or(look.length),
            influence: self.influence.unwrap_or(look.influence),
            grid: self.grid.unwrap_or(look.grid),
            height: self.height.unwrap_or(look.height),
            share: self.share.unwrap_or(look.share),
            ribs: self.ribs.unwrap_or(look.ribs),
            rib_spacing: self.rib_spacing.unwrap_or(look.rib_spacing),
            grain: self.grain.unwrap_or(look.grain),
            grain_size: self.grain_size.unwrap_or(look.grain_size),
        }
    }
}
