//! How finely a shape is divided, its bounds, and why one cannot be made.

/// Fewest segments that make a solid of revolution.
pub const MIN_SEGMENTS: u32 = 3;
/// Most segments a turn: finer than any solver here can see, and a torus of it is already past
/// [`MAX_TRIANGLES`].
pub const MAX_SEGMENTS: u32 = 4096;
/// Most triangles a shape may have; a boolean at this size takes seconds a piece.
pub const MAX_TRIANGLES: usize = 4_000_000;
/// Longest and shortest dimension \[m\]: beyond these, products of four lengths leave the range in
/// which f64 keeps its digits next to SI densities.
pub const SIZE_RANGE: (f64, f64) = (1e-6, 1e6);

/// How finely a shape is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Segments of a full turn, [`MIN_SEGMENTS`]..=[`MAX_SEGMENTS`].
    pub segments: u32,
    /// Edges longer than this \[m\] are divided; `None` leaves flat parts as large as they can be.
    pub edge: Option<f64>,
}

impl Default for Detail {
    fn default() -> Self {
        Self { segments: 48, edge: None }
    }
}

/// Why a shape cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A parameter is outside its bounds, or not a number.
    #[error("{what} is {value:e}; it must lie in [{low:e}, {high:e}]")]
    OutOfRange {
        /// Which parameter.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least accepted.
        low: f64,
        /// Greatest accepted.
        high: f64,
    },
    /// The shape would have too many triangles.
    #[error("the shape would have {triangles} triangles; at most {MAX_TRIANGLES} are accepted")]
    TooFine {
        /// How many it would have.
        triangles: usize,
    },
    /// An outline has too few or too many points.
    #[error("the outline has {points} distinct points; {low} to {high} are accepted")]
    Points {
        /// Points left after equal neighbours are merged.
        points: usize,
        /// Fewest accepted.
        low: usize,
        /// Most accepted.
        high: usize,
    },
    /// Two edges of an outline cross or touch.
    #[error(
        "the outline crosses itself: the edges from point {first} and from point {second} meet"
    )]
    Crossing {
        /// Start of one edge.
        first: usize,
        /// Start of the other.
        second: usize,
    },
    /// An outline encloses nothing.
    #[error("the outline encloses no area")]
    Flat,
    /// The profile of a lathe touches the axis between its ends, which would pinch the body.
    #[error("point {point} of the profile lies on the axis; only the first and last may")]
    Pinched {
        /// Which point.
        point: usize,
    },
    /// The wall of a vessel does not fit inside its profile.
    #[error("a wall of {thickness} m does not fit inside the profile")]
    Wall {
        /// Thickness asked for \[m\].
        thickness: f64,
    },
}

pub(super) fn check_range(
    what: &'static str,
    value: f64,
    low: f64,
    high: f64,
) -> Result<(), ShapeError> {
    if value >= low && value <= high {
        Ok(())
    } else {
        Err(ShapeError::OutOfRange { what, value, low, high })
    }
}

pub(super) fn check_size(what: &'static str, value: f64) -> Result<(), ShapeError> {
    check_range(what, value, SIZE_RANGE.0, SIZE_RANGE.1)
}

pub(super) fn check_segments(detail: Detail) -> Result<(), ShapeError> {
    let (low, high) = (f64::from(MIN_SEGMENTS), f64::from(MAX_SEGMENTS));
    check_range("segments", f64::from(detail.segments), low, high)
}

/// The longest edge wanted; infinite where none was given.
pub(super) fn check_edge(detail: Detail) -> Result<f64, ShapeError> {
    let Some(edge) = detail.edge else {
        return Ok(f64::INFINITY);
    };
    check_size("edge length", edge)?;
    Ok(edge)
}

pub(super) fn check_count(triangles: usize) -> Result<(), ShapeError> {
    if triangles <= MAX_TRIANGLES { Ok(()) } else { Err(ShapeError::TooFine { triangles }) }
}
