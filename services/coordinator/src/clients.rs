//! Who asks, and who waits for an answer.

use cullet_pool::users::{RequestServer, UserQuery};
use cullet_proto::service::Follow;
use std::collections::BTreeMap;
use std::time::Instant;

/// A client that follows a run, and waits for news of it.
pub(super) struct Follower {
    pub(super) asked: UserQuery,
    pub(super) follow: Follow,
    pub(super) until: Instant,
}

/// Clients of the service.
pub(super) struct Clients {
    pub(super) server: RequestServer,
    pub(super) followers: Vec<Follower>,
    /// Runs that somebody waits for, and when that one asked last.
    pub(super) awaited: BTreeMap<u64, Instant>,
}
