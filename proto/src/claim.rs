//! A coordinator's claim to its name. Coordinators of one name that find each other tell each other
//! theirs, and one of any two goes ([`Claim::stays_beside`]).

use crate::codec::{self, WireError};
use crate::ids::SessionId;
use crate::pool::MAX_VERSION;
use serde::{Deserialize, Serialize};

/// Longest name of a machine \[bytes\].
pub const MAX_HOST: usize = 64;

/// What a coordinator says of itself to others of its name: the question, and part of the answer.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Claim {
    /// Its life, chosen at random at its start.
    pub life: SessionId,
    /// When it was started \[ms since 1970, by its own clock\].
    pub since_ms: u64,
    /// Whether it has looked for others and found none beside which it would not stay.
    pub settled: bool,
    /// The number of its process.
    pub process: u32,
    /// The name of its machine; empty where that is not known.
    pub host: String,
    /// The version of its program.
    pub version: String,
}

/// The answer of one that was told another's claim.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// Its own.
    pub claim: Claim,
    /// Whether it stays, so that the other has to go.
    pub stays: bool,
}

impl Claim {
    /// Whether this one stays, and the other goes: who has settled before who only begins, then who
    /// was started first, and of two that were started in one millisecond the one of them that both
    /// of them name.
    #[must_use]
    pub fn stays_beside(&self, other: &Self) -> bool {
        let rank = |claim: &Self| (!claim.settled, claim.since_ms, claim.life);
        rank(self) < rank(other)
    }

    /// Holds what it says to the limits of the wire.
    ///
    /// # Errors
    /// [`WireError::Limit`].
    pub fn check(&self) -> Result<(), WireError> {
        codec::limit("a machine's name", self.host.len() as u64, MAX_HOST as u64)?;
        codec::limit("a version's length", self.version.len() as u64, MAX_VERSION as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_claims_one_stays_and_both_sides_know_which() {
        let claim = |life, since_ms, settled| Claim {
            life: SessionId(life),
            since_ms,
            settled,
            ..Claim::default()
        };
        // In this order each stays beside those after it.
        let all = [claim(9, 5, true), claim(1, 6, true), claim(3, 1, false), claim(4, 1, false)];
        for (k, one) in all.iter().enumerate() {
            for (l, other) in all.iter().enumerate() {
                assert_eq!(one.stays_beside(other), k < l, "{one:?} beside {other:?}");
            }
        }
        let host = "h".repeat(MAX_HOST + 1);
        assert!(Claim { host, ..Claim::default() }.check().is_err());
    }
}
