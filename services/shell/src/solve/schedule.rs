//! How long a solve of a plate goes on.

use cullet_model::BrittleProblem;
use cullet_model::brittle::{AFTER_TRANSITS, PUSH_TRANSITS};
use cullet_model::hertz_contact;

/// Transits L/c_s without growth, after the push, that end the solve: flexural waves are slower
/// than shear waves by two or three times.
const QUIET_TRANSITS: f64 = 4.0;

/// Transits that the push on metal may take, which bends far before it comes to rest.
const METAL_TRANSITS: f64 = 100.0;

/// Share of the points that must break to count as growth.
pub(super) const GROWTH: f64 = 5e-4;

/// When the push ends and when the solve does \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShellSchedule {
    pub(super) push: f64,
    /// Without growth after the push, until the end.
    pub(super) quiet: f64,
    /// After the push, until the end in any case.
    pub(super) after: f64,
    pub(super) end: f64,
}

impl ShellSchedule {
    pub(super) fn new(problem: &BrittleProblem, is_metal: bool) -> Self {
        let transit = problem.solid.mesh.diagonal() / problem.material.shear_speed();
        let longest = problem.impacts.iter().map(hertz_contact::duration).fold(0.0, f64::max);
        let push = match is_metal {
            true => METAL_TRANSITS * transit,
            false => longest.min(PUSH_TRANSITS * transit),
        };
        let (quiet, after) = (QUIET_TRANSITS * transit, 2.0 * AFTER_TRANSITS * transit);
        Self { push, quiet, after, end: push + after }
    }
}
