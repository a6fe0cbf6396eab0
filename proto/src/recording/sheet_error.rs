//! What can be wrong with what is recorded of a sheet.

/// Why a recorded surface, frame or window is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SheetError {
    /// A column has the wrong length.
    #[error("{column} has {length} entries, {wanted} are needed")]
    Length {
        /// Which column.
        column: &'static str,
        /// Its entries.
        length: usize,
        /// What the other columns call for.
        wanted: usize,
    },
    /// A triangle names a point that is not there.
    #[error("triangle {triangle} names point {point} of {points}")]
    Index {
        /// Which triangle.
        triangle: usize,
        /// What it names.
        point: u32,
        /// How many there are.
        points: usize,
    },
    /// A number that is none.
    #[error("entry {entry} of {column} is not finite")]
    NotFinite {
        /// Which column.
        column: &'static str,
        /// Which of its entries.
        entry: usize,
    },
    /// The content does not have the digest it is filed under.
    #[error("the content does not match its digest")]
    Digest,
    /// A frame of a surface that was not recorded.
    #[error("its surface was not recorded")]
    NoSurface,
    /// It does not come after the one before it.
    #[error("the one before it goes to step {last}")]
    Order {
        /// The last step of that.
        last: u64,
    },
    /// A part of a message that must be there is not.
    #[error("it has no {part}")]
    Missing {
        /// Which part.
        part: &'static str,
    },
}

/// A column is as long as the others call for.
pub(super) fn length(column: &'static str, length: usize, wanted: usize) -> Result<(), SheetError> {
    if length == wanted { Ok(()) } else { Err(SheetError::Length { column, length, wanted }) }
}

/// All numbers of a column are numbers.
pub(super) fn finite<T: Copy + Into<f64>>(
    column: &'static str,
    numbers: &[T],
) -> Result<(), SheetError> {
    match numbers.iter().position(|&number| !number.into().is_finite()) {
        Some(entry) => Err(SheetError::NotFinite { column, entry }),
        None => Ok(()),
    }
}
