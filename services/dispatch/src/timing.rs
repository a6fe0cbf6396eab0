//! How patient the pool is.

use crate::event::Millis;

/// Times \[ms\] and limits of the pool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// A grant or renewal is good for this long \[ms\].
    pub lease: Millis,
    /// The worker renews this often \[ms\]; several renewals fit a lease, so one lost is no loss.
    pub renew: Millis,
    /// What remains of a lease once its worker's link is gone \[ms\]: links flap, so not zero.
    pub suspect: Millis,
    /// A poll that finds no job is held this long before it is answered "idle" \[ms\].
    pub park: Millis,
    /// The longest one attempt may take \[ms\]: beyond it the solve counts as wedged.
    pub hard: Millis,
    /// Pause before the first repeat of a job \[ms\]; doubles with each, up to [`Timing::lease`].
    pub backoff: Millis,
    /// Crashes of workers under one job before it is abandoned: more would poison the whole pool.
    pub max_crashes: u32,
    /// Attempts of one job, for whatever cause, before it is abandoned.
    pub max_attempts: u32,
}

impl Timing {
    /// For real runs.
    #[must_use]
    pub const fn production() -> Self {
        Self {
            lease: 15_000,
            renew: 3_000,
            suspect: 3_000,
            park: 20_000,
            hard: 600_000,
            backoff: 200,
            max_crashes: 3,
            max_attempts: 8,
        }
    }

    /// A tenth of that, for tests.
    #[must_use]
    pub const fn test() -> Self {
        Self {
            lease: 1_500,
            renew: 300,
            suspect: 500,
            park: 2_000,
            hard: 20_000,
            backoff: 50,
            max_crashes: 3,
            max_attempts: 8,
        }
    }
}

impl Default for Timing {
    fn default() -> Self {
        Self::production()
    }
}
