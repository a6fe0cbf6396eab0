//! The pool and its workers over real links on loopback.

mod desk;
mod door;
mod faults;
#[path = "../../../../tests/common/figures.rs"]
mod figures;
mod gates;
mod keep;
mod kit;
mod mixed;
mod order;
#[path = "../../../../tests/common/proxy.rs"]
#[allow(dead_code, reason = "each suite uses its own part")]
mod proxy;
