//! The machine of the pool, from outside.

mod common;

mod deaths;
mod idle;
mod machine;
mod makers;
