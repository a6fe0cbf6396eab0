//! What needs nothing but the sources, and a family of solvers that is as small as one can be.

mod chain;
mod modules;
mod names;
mod plates;
mod tidy;
