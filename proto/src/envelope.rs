//! Around every message: who it is for is read before what it says.
//!
//! `magic "CULT" | u16 major | u16 minor | u16 kind | u16 flags | u32 header length |
//! u32 crc32c(header) | header | bulk`, little-endian.

use crate::codec::{self, MAX_HEADER, WireError};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The first four bytes of every message.
pub const MAGIC: [u8; 4] = *b"CULT";
/// The generation of the wire; another one is not read.
pub const MAJOR: u16 = 1;
/// Additions within the generation; any is read.
pub const MINOR: u16 = 0;
/// Bytes before the header.
pub const PREFIX: usize = 20;

/// What a message is. Numbers are never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum MessageKind {
    /// A problem with its slabs.
    Job = 1,
    /// A verdict with its slabs.
    Verdict = 2,
    /// A question of a worker or client.
    Ask = 3,
    /// Its answer.
    Answer = 4,
    /// A refusal to answer.
    Refusal = 5,
    /// A file bundle's table.
    Bundle = 6,
    /// What came out of a specimen.
    SpecimenResult = 8,
    /// A job without its large parts.
    Outline = 9,
    /// A specimen with its mesh; 7 was its kind in version 0.1.
    Specimen = 10,
    /// A problem of treated glass with its slabs.
    TreatedJob = 11,
    /// A problem of metal with its slabs.
    YieldingJob = 12,
    /// A problem of metal that goes by rate and warmth or tears, with its slabs.
    JohnsonCookJob = 13,
    /// A specimen with its mesh and the horizon of its bonds.
    HorizonSpecimen = 14,
    /// A problem of points and bonds with its slabs.
    BondedJob = 15,
    /// A window of a body that moves as it deforms, with its slabs.
    WindowJob = 16,
    /// What came of a window, with its slabs.
    WindowResult = 17,
    /// How a body is to come apart, around the job of any kind that breaks it.
    DirectedJob = 18,
}

/// A message: header and bulk in an envelope.
///
/// # Errors
/// [`WireError::Limit`] if the header is too large.
pub fn seal<T: Serialize>(
    kind: MessageKind,
    header: &T,
    bulk: &[u8],
) -> Result<Vec<u8>, WireError> {
    let header = codec::encode(header)?;
    let mut out = Vec::with_capacity(PREFIX + header.len() + bulk.len());
    out.extend_from_slice(&MAGIC);
    for word in [MAJOR, MINOR, kind as u16, 0] {
        out.extend_from_slice(&word.to_le_bytes());
    }
    out.extend_from_slice(&(header.len() as u32).to_le_bytes());
    out.extend_from_slice(&crc32c::crc32c(&header).to_le_bytes());
    out.extend_from_slice(&header);
    out.extend_from_slice(bulk);
    Ok(out)
}

/// The header and the bulk of a message of this kind.
///
/// # Errors
/// The first thing wrong with it, the version before anything else of ours is read.
pub fn open<T: DeserializeOwned>(kind: MessageKind, bytes: &[u8]) -> Result<(T, &[u8]), WireError> {
    let (given, header, bulk) = split(bytes)?;
    if given != kind as u16 {
        return Err(WireError::Kind { given, wanted: kind as u16 });
    }
    Ok((codec::decode(header)?, bulk))
}

/// Whether this is a sound message of that kind.
#[must_use]
pub fn is(kind: MessageKind, bytes: &[u8]) -> bool {
    split(bytes).is_ok_and(|(given, ..)| given == kind as u16)
}

/// The kind number of a message, its header's bytes (checked against their sum) and its bulk.
///
/// # Errors
/// As [`open`].
pub fn split(bytes: &[u8]) -> Result<(u16, &[u8], &[u8]), WireError> {
    let Some((prefix, rest)) = bytes.split_at_checked(PREFIX) else {
        return Err(WireError::Short { what: "an envelope", have: bytes.len(), need: PREFIX });
    };
    if prefix[..4] != MAGIC {
        return Err(WireError::Magic);
    }
    let word = |at: usize| u16::from_le_bytes([prefix[at], prefix[at + 1]]);
    let long = |at: usize| u32::from(word(at)) | u32::from(word(at + 2)) << 16;
    if word(4) != MAJOR {
        return Err(WireError::Version { theirs: word(4), ours: MAJOR });
    }
    let (length, announced) = (long(12) as usize, long(16));
    codec::limit("a header's length", length as u64, MAX_HEADER as u64)?;
    let Some((header, bulk)) = rest.split_at_checked(length) else {
        return Err(WireError::Short { what: "a header", have: rest.len(), need: length });
    };
    let found = crc32c::crc32c(header);
    if found != announced {
        return Err(WireError::Checksum { found, announced });
    }
    Ok((word(8), header, bulk))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_envelope_is_fixed() -> Result<(), WireError> {
        let sealed = seal(MessageKind::Ask, &7u32, b"xy")?;
        assert_eq!(&sealed[..16], b"CULT\x01\0\0\0\x03\0\0\0\x04\0\0\0");
        assert_eq!(&sealed[20..], b"\x07\0\0\0xy");
        assert_eq!(open::<u32>(MessageKind::Ask, &sealed)?, (7, &b"xy"[..]));
        Ok(())
    }

    #[test]
    fn each_wrong_part_is_named() -> Result<(), WireError> {
        let good = seal(MessageKind::Ask, &7u32, b"")?;
        let with = |at: usize, byte: u8| {
            let mut bad = good.clone();
            bad[at] = byte;
            open::<u32>(MessageKind::Ask, &bad).map(|(header, _)| header)
        };
        assert_eq!(with(0, 0), Err(WireError::Magic));
        assert_eq!(with(4, 9), Err(WireError::Version { theirs: 9, ours: 1 }));
        assert_eq!(with(8, 4), Err(WireError::Kind { given: 4, wanted: 3 }));
        assert!(matches!(with(12, 9), Err(WireError::Short { .. })));
        assert!(matches!(with(15, 9), Err(WireError::Limit { .. })));
        assert!(matches!(with(20, 9), Err(WireError::Checksum { .. })));
        assert!(matches!(open::<u32>(MessageKind::Ask, &good[..9]), Err(WireError::Short { .. })));
        Ok(())
    }
}
