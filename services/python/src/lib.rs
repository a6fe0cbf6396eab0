//! What Python's package `cullet` does in Rust: `cullet._cullet`. Numbers leave as bytes, records
//! as dictionaries; the package in `python/cullet` makes arrays of them, and has the documentation
//! that users read. Its names are those of the facade.
//!
//! A call that takes time lets other threads of Python run, and asks now and then whether Ctrl-C
//! was pressed.

mod buffers;
mod client;
mod errors;
mod happenings;
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
    use crate::client::{PyClient, sweep_rows};
    #[pymodule_export]
    use crate::pool::{PyLocalPool, spare_cores};
    #[pymodule_export]
    use crate::recording::{PyRecording, fit_masses};
    #[pymodule_export]
    use crate::scene::{PyScene, materials_json, schema_json};

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
