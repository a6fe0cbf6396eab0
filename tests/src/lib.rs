//! The suites that hold the whole to its word.
