//! The rigid world, from outside.

mod common;

mod birth;
mod debris;
mod impacts;
mod late;
mod replace;
mod reshape;
mod run;
mod settling;
mod supports;
mod thin;
