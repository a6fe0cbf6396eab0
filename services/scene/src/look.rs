//! How crack faces look closer than the grid resolves: a named look, and what differs from it.

use cullet_document::unit;
use schemars::JsonSchema;
use serde::Deserialize;

/// A look of crack faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Look {
    /// As the grid resolves them: costs nothing.
    #[default]
    Plain,
    /// Smooth, with ribs where the front was at equal times (Wallner lines).
    Glass,
    /// Long ledges along the way the crack ran.
    Ice,
    /// Fine ledges, fine grain.
    Porcelain,
    /// Sugary grain over short ledges.
    Marble,
    /// High ledges, coarse grain.
    Stone,
    /// Low, wide waves.
    Clay,
    /// Grain of its aggregates, hardly any ledges.
    Concrete,
    /// Fine grain.
    Brick,
}

/// Detail of crack faces. Lengths are in grid spacings unless they have a unit: a look is as fine
/// as the solve. Zero `height`, `ribs` and `grain` are no detail.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Detail {
    /// Gives what is not said here.
    pub look: Look,
    /// Longest edge of a crack face, and the step along a chevron line, d.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.1, "maximum" = 2))]
    pub edge: Option<f64>,
    /// Longest chevron line, `l_c`.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.5, "maximum" = 100))]
    pub length: Option<f64>,
    /// How far a chevron line keeps others away, s.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.1, "maximum" = 10))]
    pub influence: Option<f64>,
    /// Over what heights and damage times are smoothed, `h_c`.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.3, "maximum" = 4))]
    pub grid: Option<f64>,
    /// Height of chevrons, G.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.5))]
    pub height: Option<f64>,
    /// Share of the chevron lines, longest first, that grow along their way, m.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 1))]
    pub share: Option<f64>,
    /// Height of ribs: where the front was at equal times.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.5))]
    pub ribs: Option<f64>,
    /// Distance between ribs.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.5, "maximum" = 100))]
    pub rib_spacing: Option<f64>,
    /// Height of grain.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0, "maximum" = 0.5))]
    pub grain: Option<f64>,
    /// Size of the coarsest grain.
    #[schemars(schema_with = "unit::ratio", extend("minimum" = 0.2, "maximum" = 20))]
    pub grain_size: Option<f64>,
    /// Cuts cracks that end inside a fragment as slits of this width, at most a fifth of a grid
    /// spacing; what is cut away becomes debris. Without it they are lines \[m\].
    #[schemars(schema_with = "unit::length", extend("exclusiveMinimum" = 0))]
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
    pub fn detail(self) -> cullet_proto::Detail {
        let mut d = cullet_proto::Detail::default();
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
    pub fn values(&self) -> cullet_proto::Detail {
        let look = self.look.detail();
        cullet_proto::Detail {
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
