//! The decision how a hit is solved, from outside.

#[path = "../../../world/tests/fast/common/mod.rs"]
mod common;

mod brittle;
mod decide;
mod gates;
