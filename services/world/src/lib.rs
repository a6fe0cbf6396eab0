//! The rigid world: bodies, impacts, the replacement of a body by its fragments or by a new shape.
//!
//! Read `world.rs` first: [`World::step`] turns contacts into [`Hit`]s, [`World::replace`] puts the
//! fragments where the body was and keeps the books. `world/joined.rs` has joints, glue, driven
//! bodies and fields: `loads.rs` finds what joints carry, `retake.rs` takes a step again without
//! those that break in it, and `rigid/fused.rs` lets bodies that rigid joints hold move as one.
//!
//! Absent on purpose: files, clocks, threads, randomness, and any word about how a body breaks.
//! Only `rigid/` names the engine; everything public speaks `cullet_geometry`.

mod body;
mod cluster;
mod curvature;
mod debris;
mod elastic_frame;
mod episode;
mod error;
mod exchange;
mod frozen;
mod glue;
mod grains;
mod groups;
mod hertz;
mod id;
mod impact;
mod impulse_exchange;
mod joint;
mod joint_store;
mod jointed;
mod joints;
mod ledger;
mod loads;
mod mass;
mod material;
mod measure;
mod motion;
mod over_step;
mod path;
mod placed_motion;
mod places;
mod rejoin;
mod removal;
mod replace;
mod reshape;
mod resting;
mod retake;
mod rigid;
mod settings;
mod settling;
mod shared_face;
mod skyline;
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
pub use glue::{GlueBodies, GlueLimit, GlueReport, GlueSpec};
pub use hertz::{DURATION_OVER_APPROACH, Elastic, Hertz, effective_modulus, hertz};
pub use id::BodyId;
pub use impact::Hit;
pub use joint::{
    JointBreak, JointCounts, JointError, JointId, JointKind, JointLimit, JointLimits, JointLoad,
    JointSpec, JointView,
};
pub use ledger::Totals;
pub use material::ContactMaterial;
pub use measure::BodyMeasure;
pub use path::{Keyframe, KeyframedPath, PathError, PathInterpolation};
pub use placed_motion::PlacedMotion;
pub use places::Pressed;
pub use replace::{Breakage, Replacement};
pub use reshape::Reshape;
pub use rigid::hulls_overlap;
pub use settings::{Tiers, WorldSettings};
pub use soft::BodyForWindow;
pub use support::{HeldContact, Reaction};
pub use world::World;
