//! The scenes in f32.

use rapier3d as rapier;

#[path = "scenes.rs"]
pub(crate) mod scenes;
