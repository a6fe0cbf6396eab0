//! What Python's package `cullet` does in Rust: `cullet._cullet`. Numbers leave as bytes, records
//! as dictionaries; the package in `python/cullet` makes arrays of them, and has the documentation
//! that users read. Its names are those of the facade.
//!
//! A call that takes time lets other threads of Python run. A run, and a submission that waits for
//! room in a queue, ask now and then whether Ctrl-C was pressed; the other calls of a client return
//! within its patience, and a fetch, a still and an export when they are done.

mod buffers;
mod client;
mod errors;
mod happenings;
mod own_process;
mod pool;
mod pose_rows;
mod recording;
mod scene;
mod sheets;

use pyo3::prelude::*;

/// The module `cullet._cullet`.
#[pymodule]
mod _cullet {
    #[pymodule_export]
    use crate::client::{PyClient, is_taken, sweep_rows};
    #[pymodule_export]
    use crate::pool::{PyLocalPool, spare_cores};
    #[pymodule_export]
    use crate::recording::{PyRecording, fit_masses};
    #[pymodule_export]
    use crate::scene::{PyScene, materials_json, schema_json};

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
