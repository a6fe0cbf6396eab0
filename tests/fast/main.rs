//! What needs nothing but the sources.

mod modules;
mod names;
mod tidy;
