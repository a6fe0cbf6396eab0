//! The pool and its workers over real links on loopback.

mod desk;
mod door;
mod faults;
mod keep;
mod kit;
mod mixed;
mod order;
