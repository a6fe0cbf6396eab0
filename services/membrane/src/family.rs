//! What the family is called.

/// Name on the wire and in recordings.
pub const NAME: &str = "membrane";
