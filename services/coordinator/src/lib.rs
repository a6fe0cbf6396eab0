//! The coordinator: scene loader, pool link, recorder, run loop.

pub mod bench;
pub mod link;
pub mod plain;
pub mod preview;
pub mod record;
pub mod run;
pub mod scene;
pub mod service;
mod state_file;
