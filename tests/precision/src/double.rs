//! The scenes in f64.

use rapier3d_f64 as rapier;

#[path = "scenes.rs"]
pub(crate) mod scenes;
