//! The speed–accuracy frontier: standing sets of charts, their runs, and what is read off them.
//!
//! ```text
//! standing set ─▶ runs ─▶ rows, as CSV in the tree ─▶ reading ─▶ table, SVG, PNG
//! ```
//!
//! Everything after the rows is a function of the set and the rows alone: the same CSV gives the
//! same picture, whoever ran it.

pub mod format;
mod measure;
mod reading;
mod row;
mod set;
pub mod stats;
#[cfg(test)]
mod tests;

pub use measure::measure;
pub use reading::{
    ChartPoint, Limit, Reading, TARGETS, doubt, measure as measured, percent, read, short, shown,
    text, told,
};
pub use row::{FrontierRow, csv, rows};
pub use set::{ChartWork, FINEST, FrontierChart, LEAST_SEEDS, MASSES, Planned, Set, load, schema};
