//! A shell in motion: control points with mass, central differences. Read [`state`], then
//! [`advance`], then how cracks part control points in [`split`].

pub mod advance;
mod arrange;
mod copies;
mod cuts;
pub mod front;
mod functional;
mod links;
mod memory;
mod removed;
mod side_pairs;
mod sides;
pub mod split;
pub mod state;
mod steady;
pub mod sums;
mod tips;

pub use advance::ShellTally;
pub use front::TIP_FACTOR;
pub use state::{STEP_SHARE, ShellDomain, ShellMaterial};
pub use sums::ShellSums;
