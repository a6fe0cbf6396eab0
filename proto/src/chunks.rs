//! Bulk in pieces: no message is ever larger than a chunk and its header.

use crate::codec::{self, WireError};

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
    bytes: Vec<u8>,
    have: Vec<bool>,
    length: u64,
}

impl Assembly {
    /// Room for a blob of `length` bytes; memory is taken as chunks come.
    ///
    /// # Errors
    /// [`WireError::Limit`] over [`MAX_BLOB`].
    pub fn new(length: u64) -> Result<Self, WireError> {
        codec::limit("a blob's length", length, MAX_BLOB)?;
        Ok(Self { bytes: Vec::new(), have: vec![false; count(length) as usize], length })
    }

    /// The announced length \[bytes\].
    #[must_use]
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Bytes of memory taken so far.
    #[must_use]
    pub fn held(&self) -> usize {
        self.bytes.len()
    }

    /// Takes a chunk.
    ///
    /// # Errors
    /// [`WireError::Limit`] for an index beyond the last, [`WireError::Short`] for a wrong length,
    /// [`WireError::Checksum`] for damaged bytes.
    pub fn put(&mut self, index: u32, sum_announced: u32, chunk: &[u8]) -> Result<(), WireError> {
        let last = self.have.len() as u64 - 1;
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
        if self.bytes.len() < from + need {
            self.bytes.resize(from + need, 0);
        }
        self.bytes[from..from + need].copy_from_slice(chunk);
        self.have[index as usize] = true;
        Ok(())
    }

    /// The first missing chunks, at most `most`.
    #[must_use]
    pub fn missing(&self, most: usize) -> Vec<u32> {
        let missing = self.have.iter().enumerate().filter(|(_, have)| !**have);
        missing.map(|(index, _)| index as u32).take(most).collect()
    }

    /// The whole blob, once nothing is missing.
    #[must_use]
    pub fn whole(&self) -> Option<&[u8]> {
        self.have.iter().all(|have| *have).then_some(self.bytes.as_slice())
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
            let chunk = slice(&bytes, index).unwrap_or_default();
            assembly.put(index, sum(chunk), chunk)?;
        }
        assert_eq!(assembly.whole(), Some(bytes.as_slice()));
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
