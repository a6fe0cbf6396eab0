//! Everything that crosses a process boundary.
//!
//! What solvers take and give has the types of `cullet_model`; messages of our own are here. Doors
//! ([`FractureJob::decode`], [`Verdict::decode`], [`envelope::open`]) check what comes in; nothing
//! is allocated before the counts that ask for it are checked against the bytes that are there.
//!
//! Absent on purpose: mechanics, sockets, files, clocks.

mod bounds;
pub mod chunks;
pub mod claim;
pub mod codec;
pub mod envelope;
pub mod ids;
pub mod job;
pub mod keys;
pub mod mesh;
pub mod outline;
pub mod pool;
pub mod recording;
pub mod security;
pub mod service;
mod smallest;
pub mod specimen;
pub mod strength;
pub mod transport;
pub mod verdict;
pub mod window;

pub use codec::WireError;
pub use ids::{Epoch, JobId, SessionId, WorkerId};
pub use job::FractureJob;
pub use verdict::Verdict;
pub use window::WindowJob;
