//! Motions that were read from files for bodies.

use cullet_assets::NodeMotion;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Motions by file, animation and node, and how many keys the bodies have so far.
#[derive(Debug, Default)]
pub(super) struct MotionCache {
    pub(super) motions: BTreeMap<(String, Option<String>, String), Arc<NodeMotion>>,
    pub(super) keys: usize,
}
