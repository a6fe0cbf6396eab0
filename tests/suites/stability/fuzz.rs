//! Fuzz targets over everything that reads bytes from elsewhere. In a test run each takes a fixed
//! number of random inputs; `docs/failures.md` says how to go on for longer. Inputs are lists of
//! edits of valid files.
//!
//! What holds: no panic, no more than [`LIMIT`] of time, and an error that says what and where.

mod bytes;
mod mesh;
mod recording;
mod text;
mod wire;

use std::time::{Duration, Instant};

/// Longest that any reader may take over an input of a few kilobytes.
const LIMIT: Duration = Duration::from_secs(60);

/// Calls, and holds the call to its time.
fn timed<T>(what: &str, call: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let value = call();
    assert!(start.elapsed() < LIMIT, "{what} took {:?}", start.elapsed());
    value
}
