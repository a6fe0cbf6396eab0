//! The service: runs that anybody may hand in, watch and fetch, several at once on one pool, and
//! a state folder from which they all go on after the coordinator was killed.
//!
//! [`serve`] is one thread that owns the board, the journal and the questions of clients; each run
//! has a thread of its own. A run that was cut off begins anew from its scene, which is
//! deterministic, and gets the verdicts that were kept: nothing that had settled is computed again,
//! and the digest is the same.

mod attempt;
mod audit_log;
mod board;
mod cancel;
mod clients;
mod config;
mod error;
mod farm_news;
mod handlers;
mod journal;
mod local;
mod memory;
pub mod metrics;
mod prune;
mod quota;
mod reach;
mod recovery;
mod remains;
mod replaying_pool;
mod results;
mod run_status;
mod serve;
mod service;
mod store;
pub mod sweep;
mod timeline;
mod web;

pub use config::ServiceConfig;
pub use error::ServiceError;
pub use local::run_here;
pub use serve::serve;
pub use store::{Store, free, total};
