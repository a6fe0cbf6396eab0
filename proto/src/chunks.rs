//! Bulk in pieces: no message is ever larger than a chunk and its header.

use crate::codec::{self, WireError};
use std::collections::BTreeMap;

/// Bytes in a chunk. A message must be queued for sending within seconds, or the whole link is
/// closed: 1 MiB passes links down to 3 Mbit/s.
pub const CHUNK: usize = 1 << 20;
/// Most bytes of one job, verdict or bundle: what a coordinator is ready to hold for one peer.
pub const MAX_BLOB: u64 = 512 << 20;
/// Largest message \[bytes\] that the transport lets in; ours stay under [`CHUNK`] + 64 KiB.
pub const MAX_MESSAGE: usize = 8 << 20;

/// Chunks in `length` bytes; at least one.
#[must_use]
pub fn count(length: u64) -> u32 {
    length.div_ceil(CHUNK as u64).max(1) as u32
}

/// The bytes of chunk `index`; `None` beyond the last.
#[must_use]
pub fn slice(bytes: &[u8], index: u32) -> Option<&[u8]> {
    let from = (index as usize).checked_mul(CHUNK)?;
    if from >= bytes.len() {
        return (index == 0).then_some(bytes);
    }
    Some(&bytes[from..bytes.len().min(from + CHUNK)])
}

/// The checksum of a chunk.
#[must_use]
pub fn sum(bytes: &[u8]) -> u32 {
    crc32c::crc32c(bytes)
}

/// A blob that comes in pieces, in any order.
#[derive(Debug)]
pub struct Assembly {
    pieces: BTreeMap<u32, Vec<u8>>,
    held: usize,
    length: u64,
}

impl Assembly {
    /// Room for a blob of `length` bytes; memory is taken as chunks come, for each its own.
    ///
    /// # Errors
    /// [`WireError::Limit`] over [`MAX_BLOB`].
    pub fn new(length: u64) -> Result<Self, WireError> {
        codec::limit("a blob's length", length, MAX_BLOB)?;
        Ok(Self { pieces: BTreeMap::new(), held: 0, length })
    }

    /// The announced length \[bytes\].
    #[must_use]
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Bytes of memory taken so far: those that have come.
    #[must_use]
    pub fn held(&self) -> usize {
        self.held
    }

    /// Holds a chunk to what this blob has at that place.
    ///
    /// # Errors
    /// [`WireError::Limit`] for an index beyond the last, [`WireError::Short`] for a wrong length,
    /// [`WireError::Checksum`] for damaged bytes.
    pub fn check(&self, index: u32, sum_announced: u32, chunk: &[u8]) -> Result<(), WireError> {
        let last = u64::from(count(self.length)) - 1;
        codec::limit("a chunk's index", u64::from(index), last)?;
        let from = index as usize * CHUNK;
        let need = (self.length as usize - from).min(CHUNK);
        if chunk.len() != need {
            return Err(WireError::Short { what: "a chunk", have: chunk.len(), need });
        }
        let found = sum(chunk);
        if found != sum_announced {
            return Err(WireError::Checksum { found, announced: sum_announced });
        }
        Ok(())
    }

    /// Takes a chunk.
    ///
    /// # Errors
    /// As [`Assembly::check`].
    pub fn put(&mut self, index: u32, sum_announced: u32, chunk: &[u8]) -> Result<(), WireError> {
        self.check(index, sum_announced, chunk)?;
        let before = self.pieces.insert(index, chunk.to_vec());
        self.held += chunk.len() - before.map_or(0, |piece| piece.len());
        Ok(())
    }

    /// The first missing chunks, at most `most`.
    #[must_use]
    pub fn missing(&self, most: usize) -> Vec<u32> {
        let all = 0..count(self.length);
        all.filter(|index| !self.pieces.contains_key(index)).take(most).collect()
    }

    /// The whole blob, once nothing is missing.
    #[must_use]
    pub fn whole(&self) -> Option<Vec<u8>> {
        let there = self.pieces.len() == count(self.length) as usize;
        there.then(|| self.pieces.values().map(Vec::as_slice).collect::<Vec<_>>().concat())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_in_any_order_make_the_whole() -> Result<(), WireError> {
        let bytes: Vec<u8> = (0..2 * CHUNK + 5).map(|i| (i * 7 + i / 251) as u8).collect();
        let mut assembly = Assembly::new(bytes.len() as u64)?;
        for index in [2u32, 0, 2, 1] {
            assert!(assembly.whole().is_none());
            // The last one alone takes the room of none before it.
            assert!(assembly.held() <= CHUNK + 5 || index == 1);
            let chunk = slice(&bytes, index).unwrap_or_default();
            assembly.put(index, sum(chunk), chunk)?;
        }
        assert_eq!(assembly.whole(), Some(bytes.clone()));
        assert_eq!(assembly.held(), bytes.len(), "the one that came twice counts once");
        assert_eq!(slice(&bytes, 3), None);
        assert_eq!((count(0), slice(&[], 0)), (1, Some(&[][..])));
        Ok(())
    }

    #[test]
    fn damaged_and_misplaced_pieces_are_refused() -> Result<(), WireError> {
        let mut assembly = Assembly::new(3)?;
        assert!(matches!(assembly.put(1, 0, b"abc"), Err(WireError::Limit { .. })));
        assert!(matches!(assembly.put(0, 0, b"ab"), Err(WireError::Short { .. })));
        assert!(matches!(assembly.put(0, 0, b"abc"), Err(WireError::Checksum { .. })));
        assert_eq!(assembly.missing(9), [0]);
        assert!(matches!(Assembly::new(MAX_BLOB + 1), Err(WireError::Limit { .. })));
        Ok(())
    }
}
