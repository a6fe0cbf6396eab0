//! Slow tests of sheets, by what the crate gives to others. `--ignored` runs those over seeds, too.

mod kit;
mod mud;
mod notches;
mod quench;
mod strip;
mod towel;
mod trouser;
mod wrinkles;
