//! Numbers of a brittle solve that both its solver and the plan of its cost go by.

/// Material points of a cell.
pub const POINTS_PER_CELL: f64 = 8.0;

/// Most transits of a shear wave that a push is followed for (F12).
pub const PUSH_TRANSITS: f64 = 6.0;

/// Transits that a solve goes on for after the push.
pub const AFTER_TRANSITS: f64 = 4.0;

/// Fewest cells across a section: bending needs a gradient (F14).
pub const CELLS_ACROSS: f64 = 3.0;

/// Cells that a thickness is given where it is chosen, by a solver that flattens its cells or by a
/// plan: the fewest, and a margin for how the thickness is measured.
pub const CELLS_ACROSS_CHOSEN: f64 = 3.3;
