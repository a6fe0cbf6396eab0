//! Where bodies touch.

use cullet_geometry::Vec3;

/// Points where two bodies touch with one normal.
pub(crate) struct Patch {
    pub(crate) other: u32,
    /// World frame, before the last step \[m\].
    pub(crate) points: Vec<Vec3>,
    /// Unit, into the body asked about.
    pub(crate) normal: Vec3,
}
