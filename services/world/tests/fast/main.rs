//! The rigid world, from outside.

mod common;

mod birth;
mod debris;
mod driven;
mod glue;
mod impacts;
mod joints;
mod late;
mod motion;
mod replace;
mod reshape;
mod run;
mod settling;
mod supports;
mod thin;
