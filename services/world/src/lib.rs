//! The rigid world: bodies, impacts, the replacement of a body by its fragments or by a new shape.
//!
//! Read `world.rs` first: [`World::step`] turns contacts into [`Hit`]s, [`World::replace`] puts the
//! fragments where the body was and keeps the books.
//!
//! Absent on purpose: files, clocks, threads, randomness, and any word about how a body breaks.
//! Only `rigid/` names the engine; everything public speaks `cullet_geometry`.

mod body;
mod cluster;
mod curvature;
mod debris;
mod episode;
mod error;
mod exchange;
mod frozen;
mod grains;
mod hertz;
mod id;
mod impact;
mod impulse_exchange;
mod ledger;
mod mass;
mod material;
mod measure;
mod motion;
mod places;
mod replace;
mod reshape;
mod resting;
mod rigid;
mod settings;
mod settling;
mod soft;
mod state;
mod step;
mod strikers;
mod support;
mod world;

pub use body::{BodySpec, BodyView, Tier};
pub use debris::{DebrisParticle, FreeFlight};
pub use error::{ReplaceError, WorldError};
pub use exchange::Exchange;
pub use hertz::{DURATION_OVER_APPROACH, Elastic, Hertz, effective_modulus, hertz};
pub use id::BodyId;
pub use impact::Hit;
pub use ledger::Totals;
pub use material::ContactMaterial;
pub use measure::BodyMeasure;
pub use replace::{Breakage, Replacement};
pub use reshape::Reshape;
pub use rigid::hulls_overlap;
pub use settings::{Tiers, WorldSettings};
pub use soft::BodyForWindow;
pub use support::{HeldContact, Reaction};
pub use world::World;
