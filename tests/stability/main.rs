//! Where methods fail: a minimal reproduction of each failure mode, named after it, bad input of
//! every kind, and bounded fuzzing of everything that reads bytes. `docs/failures.md` is the table
//! of modes.

mod atlas;
#[path = "../../services/world/tests/fast/common/mod.rs"]
mod bodies;
mod bonds;
mod cloud;
mod corpus;
mod crack;
mod cut;
mod fuzz;
mod grid;
mod kit;
mod law;
mod legs;
mod meet;
mod push;
mod shell;
mod system;
mod world;
