//! What is kept of the tips of cracks.

use std::collections::BTreeMap;

/// What is kept for tips.
#[derive(Clone, Debug, Default)]
pub(super) struct CrackTips {
    /// Steps taken.
    pub(super) steps: u64,
    /// Points that feel a tip from a step on, with their strength then \[Pa\].
    pub(super) due: BTreeMap<u64, Vec<(u32, f64)>>,
    /// The step in which each broken point broke.
    pub(super) times: BTreeMap<u32, u64>,
    /// Points that have broken or died since control points were last parted.
    pub(super) changed: Vec<u32>,
}
