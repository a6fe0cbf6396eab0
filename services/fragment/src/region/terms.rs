//! What relief is made from.

use cullet_geometry::Vec3;
use cullet_model::CrackFaceDetail;

/// What is known of the crack front at a place: when it passed \[s\], and the gradient of that
/// \[s/m\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FrontSample {
    pub(crate) time: f64,
    pub(crate) slope: Vec3,
}

/// What a relief is made with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReliefTerms {
    pub(crate) detail: CrackFaceDetail,
    /// h \[m\].
    pub(crate) spacing: f64,
    /// Differences of damage time over h below this tell no direction (F35) \[s\].
    pub(crate) time_step: f64,
    pub(crate) seed: u64,
}
