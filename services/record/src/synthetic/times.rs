//! When what happens in the run.

/// Time step of the run \[s\].
pub const STEP: f64 = 1.0 / 120.0;
/// Steps of the run.
pub const STEPS: u64 = 120;
/// The step at which the cube breaks.
pub const BREAK: u64 = 48;
