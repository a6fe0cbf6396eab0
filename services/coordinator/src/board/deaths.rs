//! Runs in the middle of which the coordinator died, and whether one of them is why.
//!
//! A scene may need more memory than there is, and then takes all other runs with it, at each start
//! anew. What a run does is the same each time, so it dies at the same place each time: a run that
//! was there at two deaths and came no further in between is a suspect. A suspect goes on alone.
//! Whoever is innocent ends then; at the third death in a row with it alone a run ends as
//! stalled, and `retry` begins it again. A run that comes further at each life, however often
//! somebody kills the coordinator, is no suspect.

use serde::{Deserialize, Serialize};

/// Deaths without getting further that make a suspect.
const SUSPECT: u32 = 2;
/// Of a suspect that went on alone, those after which it ends as stalled.
const PROOF: u32 = 3;

/// How far a run came: simulated time \[µs\], and jobs settled by then; what it did before a death
/// it does again after it, so that these compare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Reached {
    pub(crate) time: u64,
    pub(crate) settled: u64,
}

/// Deaths of the coordinator in the middle of a run, since it last came further than ever.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct CoordinatorDeaths {
    pub(crate) all: u32,
    /// Those at which it was a suspect and went on alone.
    pub(crate) alone: u32,
    pub(crate) reached: Reached,
}

impl CoordinatorDeaths {
    pub(super) fn count(&mut self, reached: Reached, alone: bool) {
        let alone = u32::from(alone && self.is_suspect());
        if reached > self.reached {
            *self = Self { all: 1, alone: 0, reached };
        } else {
            self.all = self.all.saturating_add(1);
            self.alone = self.alone.saturating_add(alone);
        }
    }

    /// Somebody wants it tried again: alone, as it is a suspect still.
    pub(super) fn pardon(&mut self) {
        self.alone = 0;
    }

    pub(crate) fn is_suspect(self) -> bool {
        self.all >= SUSPECT
    }

    pub(super) fn is_proof(self) -> bool {
        self.alone >= PROOF
    }
}
