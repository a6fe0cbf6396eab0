//! Slow tests of sheets, by what the crate gives to others. `CULLET_SEEDS` says over how
//! many seeds some of them go.

mod kit;
mod mud;
mod notches;
mod quench;
mod strip;
mod towel;
mod trouser;
mod wrinkles;
