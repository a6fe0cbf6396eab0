//! Sixteen numbers side by side, in either precision and in registers of any width.
//!
//! Each lane belongs to one element and works for it alone; sums across lanes have one order
//! ([`sum_lanes`]). So the bits do not depend on the width of the registers, and a kernel that is
//! written once runs on every processor.
//!
//! Absent on purpose: any mechanics.

mod incidence;
mod lanes;
mod level;
mod records;

pub use incidence::Incidence;
pub use lanes::{LANES, Lanes, Real, V, load, store};
pub use level::SimdLevel;
pub use records::{LaneRows, PackedRecord, RecordWindow, WINDOW, gather_records, sum_lanes};
