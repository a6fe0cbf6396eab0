//! The solver against closed forms and against itself.

mod bar;
mod brittle;
mod cracks;
mod dent;
mod elastic;
mod kernel;
mod partial;
