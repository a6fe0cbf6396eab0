//! The threads that solvers run on.

use crate::error::WorkerError;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Stack of a solver's thread \[bytes\]: recursion over meshes is deeper than the default bears.
const STACK: usize = 16 << 20;

pub(crate) fn start_threads(threads: usize) -> Result<ThreadPool, WorkerError> {
    ThreadPoolBuilder::new()
        .num_threads(threads.max(1))
        .stack_size(STACK)
        .thread_name(|index| format!("cullet-solve-{index}"))
        .build()
        .map_err(|error| WorkerError::Threads { threads, text: error.to_string() })
}
