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
    /// Distinct workers under which they must have been, while there is more than one.
    pub min_killers: u32,
    /// Jobs that died under a worker and were finished by another, after which it is drained;
    /// and jobs that died under it alone and that nobody else has been free to try for a lease.
    pub max_blame: u32,
    /// A run with work that got no grant for this long goes first, every other time \[ms\].
    pub age: Millis,
    /// An attempt that takes longer than this many times its run's median may be duplicated.
    pub hedge_factor: u64,
    /// Unsettled openings that a run may have.
    pub max_open: u64,
    /// Unsettled openings of all runs together.
    pub max_pool: u64,
    /// Attempts of one job, for whatever cause, before it is abandoned.
    pub max_attempts: u32,
}

impl Timing {
    /// A worker that has no job and asks for none for this long does not count as there \[ms\].
    pub(crate) const fn patience(&self) -> Millis {
        self.park + self.lease
    }

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
            min_killers: 2,
            max_blame: 3,
            age: 60_000,
            hedge_factor: 3,
            max_open: 65_536,
            max_pool: 2_000_000,
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
            min_killers: 2,
            max_blame: 3,
            age: 6_000,
            hedge_factor: 3,
            max_open: 65_536,
            max_pool: 2_000_000,
            max_attempts: 8,
        }
    }
}

impl Default for Timing {
    fn default() -> Self {
        Self::production()
    }
}
