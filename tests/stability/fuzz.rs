//! Fuzz targets over everything that reads bytes from elsewhere. In a test run each takes a fixed
//! number of random inputs; `docs/failures.md` says how to go on for longer. Inputs are lists of
//! edits of valid files.
//!
//! What holds: no panic, no more than [`LIMIT`] of time and [`MEMORY`], and an error that says what
//! and where.

mod bytes;
mod mesh;
mod recording;
mod text;
mod wire;

use std::time::{Duration, Instant};

/// Longest that any reader may take over an input of a few kilobytes.
const LIMIT: Duration = Duration::from_secs(60);

/// Most memory that the process may ever have held \[KiB\]; the suite takes a tenth of it.
const MEMORY: u64 = 1 << 20;

/// Most memory that the process has held so far \[KiB\], where the system tells.
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// Calls, and holds the call to its time and its memory.
fn timed<T>(what: &str, call: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let value = call();
    assert!(start.elapsed() < LIMIT, "{what} took {:?}", start.elapsed());
    assert!(memory() < MEMORY, "{what} took {} KiB", memory());
    value
}
