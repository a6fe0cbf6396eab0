//! What the windows of all families share: rigid bodies that move in them with their own mass
//! ([`rigid`]), how grips are led ([`path`]), the air ([`air`]), how fast waves are ([`pace`]),
//! pieces and their rest ([`pieces`], [`rest`]), what becomes rigid of them ([`mod@settled`]),
//! where surfaces cross themselves ([`mod@crossings`]), and the bytes of states ([`bytes`]).
//!
//! A family brings its points and forces; see [`cullet_model::Continuum`].
//!
//! Absent on purpose: how anything deforms.

pub mod air;
pub mod bytes;
pub mod crossings;
pub mod pace;
pub mod path;
pub mod pieces;
pub mod rest;
pub mod rigid;
pub mod settled;
pub mod tree;

pub use bytes::{StateReader, StateWriter};
pub use pace::WorkingPace;
pub use path::GripPath;
pub use pieces::PieceRecord;
pub use rest::RestCheck;
pub use rigid::{RigidProxy, TouchedPoints};
pub use settled::{SettledOffer, retire, settled};
