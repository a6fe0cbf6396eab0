//! The TLS link between two ends on loopback.

mod flips;
