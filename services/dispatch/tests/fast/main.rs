//! The machine of the pool, from outside.

mod common;

mod deaths;
mod machine;
mod makers;
