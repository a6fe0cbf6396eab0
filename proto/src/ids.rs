//! Names of things on the wire.

use crate::codec::WireError;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Longest worker, user or coordinator name \[bytes\]: names are parts of key expressions.
pub const MAX_NAME: usize = 40;

/// A worker's, user's or coordinator's name: 1 to 40 of `a-z`, `0-9`, `-`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WorkerId(String);

impl WorkerId {
    /// The name, if it is one.
    ///
    /// # Errors
    /// [`WireError::Name`] with what was given.
    pub fn new(name: &str) -> Result<Self, WireError> {
        let fits = (1..=MAX_NAME).contains(&name.len());
        let letter = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-';
        if fits && name.bytes().all(letter) {
            Ok(Self(name.to_owned()))
        } else {
            Err(WireError::Name { name: name.chars().take(MAX_NAME + 1).collect() })
        }
    }

    /// The name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for WorkerId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// One life of a worker process: chosen at random at its start, never used again.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
pub struct SessionId(pub u64);

impl fmt::Display for SessionId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// The number of one grant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Epoch(pub u64);

/// The blake3 digest of a job's canonical encoding: same problem, same id.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct JobId(pub [u8; 32]);

impl JobId {
    /// The id of an encoded job.
    #[must_use]
    pub fn of(encoded: &[u8]) -> Self {
        Self(digest(encoded))
    }

    /// The id that prints like this.
    #[must_use]
    pub fn from_hex(text: &str) -> Option<Self> {
        let mut bytes = [0; 32];
        if text.len() != 64 || !text.bytes().all(|b| b.is_ascii_hexdigit()) {
            return None;
        }
        for (byte, at) in bytes.iter_mut().zip((0..64).step_by(2)) {
            *byte = u8::from_str_radix(&text[at..at + 2], 16).ok()?;
        }
        Some(Self(bytes))
    }

    /// The first eight hex digits, for people.
    #[must_use]
    pub fn short(&self) -> String {
        let mut text = self.to_string();
        text.truncate(8);
        text
    }
}

impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "JobId({})", self.short())
    }
}

/// The blake3 digest of some bytes.
#[must_use]
pub fn digest(bytes: &[u8]) -> [u8; 32] {
    *blake3::hash(bytes).as_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_would_break_a_key_expression_are_refused() {
        for good in ["w1", "a-b-c", "0"] {
            assert!(WorkerId::new(good).is_ok(), "{good}");
        }
        for bad in ["", "W1", "a/b", "a*", "ä", "a b", &"x".repeat(MAX_NAME + 1)] {
            assert!(WorkerId::new(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn an_id_prints_as_hex() {
        let id = JobId([0xab; 32]);
        assert_eq!(id.to_string(), "ab".repeat(32));
        assert_eq!(id.short(), "abababab");
        assert_eq!(JobId::from_hex(&id.to_string()), Some(id));
        assert_eq!(JobId::from_hex(&"+1".repeat(32)), None);
    }
}
