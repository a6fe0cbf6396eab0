//! Cracks that separate: Irwin's modes, one field, CPIC and ours, the grid's bias, thick bands.

mod band;
mod bias;
mod compare;
mod modes;
mod press;
mod specimen;
mod twin;
