//! The pool and its workers over real links on loopback.

mod desk;
mod door;
mod faults;
mod kit;
mod order;
