//! Numbers of a brittle solve that both its solver and the plan of its cost go by.

/// Material points of a cell: fewer widen the band of a crack and make numerical gaps, more only
/// cost (F-B, F15).
pub const POINTS_PER_CELL: f64 = 8.0;

/// Transits of a shear wave L/c_s that a longer push is shortened to: beyond about six the stress
/// follows the force and the body's own motion has died out of the ratio.
pub const PUSH_TRANSITS: f64 = 6.0;

/// Transits after the push at which a solve ends even where damage still grows (F12).
pub const AFTER_TRANSITS: f64 = 4.0;

/// Fewest cells across a section: bending needs a gradient (F14).
pub const CELLS_ACROSS: f64 = 3.0;

/// Cells that a thickness is given where it is chosen, by a solver that flattens its cells or by a
/// plan: the fewest, and a margin for how the thickness is measured.
pub const CELLS_ACROSS_CHOSEN: f64 = 3.3;
