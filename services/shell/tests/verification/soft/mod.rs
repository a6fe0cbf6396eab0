//! Soft shells, a window at a time, against closed forms and their own books.

mod harness;

mod determinism;
mod motion;
mod stretching;
mod tearing;
