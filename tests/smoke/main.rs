//! A small part of the farm and verification tiers, for the first minutes of a clone: each family
//! of solvers once, at few points, through the program and its worker processes, one benchmark of
//! the laboratory, and a pool that loses a worker. `cargo test --release --workspace --test smoke`.

#[path = "../common/mod.rs"]
mod common;

mod families;
mod pool;
mod results;
