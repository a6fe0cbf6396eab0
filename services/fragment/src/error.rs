//! Why there is no cut.

use cullet_geometry::boolean::BooleanError;
use cullet_geometry::voronoi::VoronoiError;

/// The parts' volumes sum to the body's within this share of it.
pub const VOLUME_TOLERANCE: f64 = 1e-9;

/// Why there is no cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CutError {
    /// The arrays differ in length or are empty.
    #[error("arrays of {counts:?} entries; all must have the same number, at least one")]
    Lengths {
        /// Entries in each, in the order of the arguments.
        counts: [usize; 3],
    },
    /// A number is not finite or out of range.
    #[error("{what} number {index} is not finite or out of range")]
    NotFinite {
        /// Which array.
        what: &'static str,
        /// Which entry.
        index: usize,
    },
    /// A limit would be exceeded.
    #[error("too large: {value:.3e} {what}, the limit is {limit:.3e}")]
    TooLarge {
        /// What there would be.
        what: &'static str,
        /// The value itself.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// The sites have no diagram.
    #[error(transparent)]
    Voronoi(#[from] VoronoiError),
    /// The boolean kernel refused.
    #[error(transparent)]
    Boolean(#[from] BooleanError),
    /// The faces show the grid.
    #[error("crack faces lie along the grid's planes {times:.1} times as often as chance (F22)")]
    Grid {
        /// How often, over chance \[1\].
        times: f64,
    },
    /// The parts do not add up.
    #[error(
        "{parts} parts enclose {sum:.12e} m³, the body {whole:.12e} m³; \
         at most {VOLUME_TOLERANCE:.0e} of it may be missing"
    )]
    Volume {
        /// How many parts.
        parts: usize,
        /// Their volume \[m³\].
        sum: f64,
        /// The body's \[m³\].
        whole: f64,
    },
}

impl CutError {
    /// Whether other jitter could help.
    pub(crate) fn is_accident(&self) -> bool {
        match self {
            Self::Voronoi(VoronoiError::Degenerate { .. })
            | Self::Boolean(_)
            | Self::Grid { .. }
            | Self::Volume { .. } => true,
            Self::Voronoi(_)
            | Self::Lengths { .. }
            | Self::NotFinite { .. }
            | Self::TooLarge { .. } => false,
        }
    }
}
