//! How a specimen is solved.

use cullet_model::PointPrecision;

/// How points lie in a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum PointLayout {
    /// Scattered at random, even in number, with volumes fitted to the grid.
    Scattered,
    /// In rows along the axes of the grid, of equal volumes.
    Rows,
}

/// Of families whose points lie in the cells of a grid; others have no use for them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct PointSettings {
    /// Points a cell.
    pub per_cell: f64,
    /// How they lie.
    pub layout: PointLayout,
    /// One velocity field, or else one for each side of a crack.
    pub welded: bool,
    /// Length over which a crack is spread in place of the calibrated one \[m\].
    pub softening_length: Option<f64>,
    /// Steps from one look at what has parted to the next.
    pub look: u32,
}

/// How a specimen is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SpecimenSettings {
    /// Spacing h of the grid, the points or the nodes \[m\].
    pub spacing: f64,
    /// Time step over the greatest stable one \[1\].
    pub step_factor: f64,
    /// What points are worked out in; a family says which it has.
    pub precision: PointPrecision,
    /// Whether the material can break.
    pub breaks: bool,
    /// Rate at which velocities fall off by themselves \[1/s\].
    pub damping: f64,
    /// Until when \[s\]; always without it.
    pub damped_until: Option<f64>,
    /// Most points.
    pub max_points: f64,
    /// Most steps.
    pub max_steps: f64,
    /// Threads; they decide nothing.
    pub threads: u32,
    /// The only source of randomness.
    pub seed: u64,
    /// Of points in cells.
    pub points: PointSettings,
    /// Horizon of bonds over the spacing; without it a family of bonds has its own, and others have
    /// no use for it \[1\]. On the wire it travels beside the rest.
    #[cfg_attr(feature = "wire", serde(skip))]
    pub horizon: Option<f64>,
}
