//! Whose process this is. `os.fork` copies a process with one thread of it: the links and threads
//! of a pool or a client are not in the copy, and whoever waits for them would wait for ever.

use pyo3::PyResult;
use pyo3::exceptions::PyRuntimeError;
use std::process;
use std::sync::OnceLock;

/// The process in which links and threads were begun.
static OWNER: OnceLock<u32> = OnceLock::new();

/// Whether this is the process in which they were begun, or may begin.
pub(crate) fn is_own() -> bool {
    *OWNER.get_or_init(process::id) == process::id()
}

/// Refuses a process that was forked from one that had a pool or a client.
pub(crate) fn check() -> PyResult<()> {
    if is_own() {
        return Ok(());
    }
    Err(PyRuntimeError::new_err(
        "this process was forked from one that had opened a pool or a client of cullet, which does \
         not work in the copy: start processes with multiprocessing.get_context(\"spawn\"), or \
         fork before anything is opened",
    ))
}
