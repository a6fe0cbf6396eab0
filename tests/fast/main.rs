//! What needs nothing but the sources, and a family of solvers that is as small as one can be.

mod chain;
mod crates;
mod documents;
mod impls;
mod messages;
mod modules;
mod names;
mod plates;
mod purity;
mod reach;
mod sizes;
mod source;
mod tree;
