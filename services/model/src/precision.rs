//! What a solve is worked out in.

/// The floating-point type of the passes over points; what they are summed into stays f64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum PointPrecision {
    /// f32.
    Single,
    /// f64.
    #[default]
    Double,
}

impl PointPrecision {
    /// Least that a strain differs by from none \[1\].
    #[must_use]
    pub fn epsilon(self) -> f64 {
        match self {
            Self::Single => f64::from(f32::EPSILON),
            Self::Double => f64::EPSILON,
        }
    }
}
