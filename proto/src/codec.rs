//! Headers to bytes and back. The only file that names bincode.
//!
//! bincode 2.0.1 is the last that works and is no longer maintained; its legacy layout is what
//! `wincode` writes too (a test holds us to it), so leaving is a change of this file.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Most bytes of a header. Bulk travels as slabs behind it; a larger header is a mistake or an
/// attack, and without the limit a length field alone could make the decoder take all memory.
pub const MAX_HEADER: usize = 65_536;

/// Why bytes were not taken, with the bound they broke.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WireError {
    /// Not one of our messages.
    #[error("this is not a cullet message")]
    Magic,
    /// Another generation of the wire.
    #[error("wire version {theirs} is not spoken here; this is version {ours}")]
    Version {
        /// The version given.
        theirs: u16,
        /// The version spoken.
        ours: u16,
    },
    /// A message of another kind.
    #[error("message kind {given} where kind {wanted} belongs")]
    Kind {
        /// The kind given.
        given: u16,
        /// The kind that belongs there.
        wanted: u16,
    },
    /// Fewer bytes than announced.
    #[error("{what}: {have} bytes of {need}")]
    Short {
        /// Of what.
        what: &'static str,
        /// Bytes there.
        have: usize,
        /// Bytes announced.
        need: usize,
    },
    /// Bytes that nothing announced.
    #[error("{what}: {extra} bytes too many")]
    Trailing {
        /// Behind what.
        what: &'static str,
        /// How many bytes there are too many.
        extra: usize,
    },
    /// The header was damaged on the way.
    #[error("header checksum {found:08x}, announced {announced:08x}")]
    Checksum {
        /// Of the bytes there.
        found: u32,
        /// As announced.
        announced: u32,
    },
    /// The header does not decode.
    #[error("the header does not decode: {0}")]
    Header(String),
    /// A count or length over its limit.
    #[error("{what} is {value}; the limit is {limit}")]
    Limit {
        /// Of what.
        what: &'static str,
        /// The count.
        value: u64,
        /// The bound.
        limit: u64,
    },
    /// A kind of body or law that does not travel yet.
    #[error("{what} is of the kind {kind}, which this version does not send")]
    Unknown {
        /// What the value is.
        what: &'static str,
        /// Of which kind.
        kind: &'static str,
    },
    /// A number that is none.
    #[error("{what} is not finite")]
    NotFinite {
        /// What the value is.
        what: &'static str,
    },
    /// An index beyond the vertices.
    #[error("triangle {triangle} names vertex {index} of {vertices}")]
    Index {
        /// Which triangle.
        triangle: usize,
        /// Which vertex it names.
        index: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A time or speed that is none.
    #[error("number {index} of {what} is {value}; it must be finite and not negative")]
    Mark {
        /// Which list.
        what: &'static str,
        /// Which entry.
        index: usize,
        /// What it says.
        value: f32,
    },
    /// A name that cannot be part of a key.
    #[error("{name:?} is no name: 1 to 40 of a-z, 0-9 and - are")]
    Name {
        /// As given.
        name: String,
    },
}

/// Most bytes of what is encoded as a slab: a body's numbers, or those of a window.
pub const MAX_RECORD: usize = 4 << 20;

/// The bytes of a header.
///
/// # Errors
/// [`WireError::Limit`] if it is larger than [`MAX_HEADER`].
pub fn encode<T: Serialize>(header: &T) -> Result<Vec<u8>, WireError> {
    let bytes = encode_any(header)?;
    limit("a header's length", bytes.len() as u64, MAX_HEADER as u64)?;
    Ok(bytes)
}

/// The bytes of a record that is a slab.
///
/// # Errors
/// [`WireError::Limit`] if it is larger than [`MAX_RECORD`].
pub fn encode_record<T: Serialize>(record: &T) -> Result<Vec<u8>, WireError> {
    let bytes = encode_any(record)?;
    limit("a record's length", bytes.len() as u64, MAX_RECORD as u64)?;
    Ok(bytes)
}

fn encode_any<T: Serialize>(value: &T) -> Result<Vec<u8>, WireError> {
    bincode::serde::encode_to_vec(value, bincode::config::legacy())
        .map_err(|e| WireError::Header(e.to_string()))
}

/// The header in these bytes, all of them.
///
/// # Errors
/// [`WireError::Header`] if they do not decode within [`MAX_HEADER`], [`WireError::Trailing`] if
/// some are left over.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, WireError> {
    limit("a header's length", bytes.len() as u64, MAX_HEADER as u64)?;
    let settings = bincode::config::legacy().with_limit::<MAX_HEADER>();
    whole(bincode::serde::decode_from_slice(bytes, settings), bytes.len())
}

/// The record in a slab, all of it.
///
/// # Errors
/// As [`decode`], within [`MAX_RECORD`].
pub fn decode_record<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, WireError> {
    limit("a record's length", bytes.len() as u64, MAX_RECORD as u64)?;
    let settings = bincode::config::legacy().with_limit::<MAX_RECORD>();
    whole(bincode::serde::decode_from_slice(bytes, settings), bytes.len())
}

/// The record at the beginning of a slab, and how many bytes it takes.
///
/// # Errors
/// [`WireError::Header`] if it does not decode within [`MAX_RECORD`].
pub fn decode_first_record<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, usize), WireError> {
    limit("a record's length", bytes.len() as u64, MAX_RECORD as u64)?;
    let settings = bincode::config::legacy().with_limit::<MAX_RECORD>();
    bincode::serde::decode_from_slice(bytes, settings).map_err(|e| WireError::Header(e.to_string()))
}

fn whole<T>(
    decoded: Result<(T, usize), bincode::error::DecodeError>,
    length: usize,
) -> Result<T, WireError> {
    let (value, used) = decoded.map_err(|e| WireError::Header(e.to_string()))?;
    match length - used {
        0 => Ok(value),
        extra => Err(WireError::Trailing { what: "a header", extra }),
    }
}

/// Holds a count to its limit.
///
/// # Errors
/// [`WireError::Limit`].
pub fn limit(what: &'static str, value: u64, limit: u64) -> Result<(), WireError> {
    if value > limit { Err(WireError::Limit { what, value, limit }) } else { Ok(()) }
}

/// Holds numbers to being numbers.
///
/// # Errors
/// [`WireError::NotFinite`].
pub fn finite(what: &'static str, values: &[f64]) -> Result<(), WireError> {
    let all = values.iter().all(|v| v.is_finite());
    if all { Ok(()) } else { Err(WireError::NotFinite { what }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::{Deserialize, Serialize};

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    enum Sample {
        Nothing,
        Pair { a: u16, b: Option<f64> },
        List(Vec<(u32, String)>, [u8; 4]),
    }

    #[test]
    fn the_layout_is_fixed_and_wincode_agrees() -> Result<(), Box<dyn std::error::Error>> {
        assert_eq!(encode(&Sample::Nothing)?, [0, 0, 0, 0]);
        let pair = encode(&Sample::Pair { a: 7, b: Some(1.0) })?;
        assert_eq!(pair, [1, 0, 0, 0, 7, 0, 1, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
        assert_eq!(pair, wincode::serialize(&(1u32, 7u16, Some(1.0f64)))?);
        let list = vec![(3u32, "ab".to_owned()), (9, String::new())];
        let ours = encode(&Sample::List(list.clone(), [1, 2, 3, 4]))?;
        assert_eq!(ours, wincode::serialize(&(2u32, list, [1u8, 2, 3, 4]))?);
        assert_eq!(decode::<(u32, u16, Option<f64>)>(&pair)?, (1, 7, Some(1.0)));
        Ok(())
    }

    #[test]
    fn a_length_bomb_is_refused_before_it_is_allocated() {
        let bomb = u64::MAX.to_le_bytes();
        assert!(matches!(decode::<Vec<u64>>(&bomb), Err(WireError::Header(_))));
        assert!(matches!(decode::<String>(&bomb), Err(WireError::Header(_))));
        assert_eq!(decode::<u8>(&[1, 2]), Err(WireError::Trailing { what: "a header", extra: 1 }));
        assert!(matches!(encode(&vec![0u8; MAX_HEADER]), Err(WireError::Limit { .. })));
    }
}
