//! Slow tests of sheets, by what the crate gives to others.

mod strip;
mod towel;
