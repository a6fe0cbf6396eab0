//! What drawings for viewers may take of a recording.

use super::meta::RunMeta;
use super::object;

/// What viewers' drawings may still take.
pub(super) struct DrawBudget {
    /// Whether objects are drawn at all; numbers and centres always are.
    pub(super) objects: bool,
    /// Bytes a simulated second \[bytes/s\].
    pub(super) rate: f64,
    /// Bytes saved up.
    pub(super) left: f64,
    /// When that was \[s\].
    pub(super) at: f64,
    /// When all centres were last drawn \[s\].
    pub(super) overview_at: f64,
}

impl DrawBudget {
    /// What a run may draw.
    pub(super) fn new(meta: &RunMeta) -> Self {
        let (rate, overview_at) = (object::rate(meta.duration), f64::NEG_INFINITY);
        Self { objects: meta.drawings, rate, left: 0.0, at: 0.0, overview_at }
    }
}
