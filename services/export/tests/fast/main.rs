//! The exports, read back.
