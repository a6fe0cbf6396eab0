//! Where methods fail: a minimal reproduction of each failure mode that no other test holds, bad
//! input of every kind, and bounded fuzzing of everything that reads bytes. `docs/failures.md` is
//! the table of modes.

mod atlas;
mod corpus;
mod crack;
mod cut;
mod fuzz;
mod kit;
mod law;
mod system;
mod world;
