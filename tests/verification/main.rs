//! The physics over the program: the catalogue of specimens, the shipped scenes, what an artist's
//! mesh keeps, the frontier of truth and time. A suite is a module: `cargo test --release
//! --workspace --test verification scenes::`.

#[path = "../common/mod.rs"]
mod common;

mod appearance;
mod bonds;
mod coupling;
mod fidelity;
mod frontier;
mod metal;
mod scenes;
mod specimens;
