//! Blobs that come in pieces from workers and clients.

use cullet_proto::WireError;
use cullet_proto::chunks::Assembly;
use cullet_proto::ids::digest;
use cullet_proto::pool::{Chunk, ChunkAnswer, MAX_MISSING};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Bytes of unfinished blobs held.
const MAX_HELD: usize = 1 << 30;
/// Of these, those of one sender: one blob of any length fits.
const MAX_OWN: usize = MAX_HELD / 2;
/// Unfinished blobs, of all and of one sender: beyond it the one that waits longest is forgotten.
const MAX_OPEN: usize = 4_096;
const MAX_OPEN_OF_ONE: usize = 64;
/// An unfinished blob that nobody adds to is forgotten after this.
const STALE: Duration = Duration::from_secs(120);
/// Its own sender displaces it after this.
const IDLE: Duration = Duration::from_secs(5);

/// What there is of a blob.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Blob {
    /// All of it, and it matches its digest.
    Whole(Vec<u8>),
    /// Not these pieces (perhaps more).
    Missing(Vec<u32>),
    /// All of it, but it does not match: thrown away.
    Damaged,
}

/// A blob that was asked for, by who sends it and its digest.
type BlobKey = (String, [u8; 32]);

/// A blob whose chunks have not all arrived.
#[derive(Debug)]
struct OpenBlob {
    blob: Assembly,
    touched: Instant,
}

#[derive(Debug)]
pub(super) struct Inbox {
    bound: usize,
    own: usize,
    blobs: BTreeMap<BlobKey, OpenBlob>,
    pub(super) damaged: u64,
}

impl Default for Inbox {
    fn default() -> Self {
        Self { bound: MAX_HELD, own: MAX_OWN, blobs: BTreeMap::new(), damaged: 0 }
    }
}

impl Inbox {
    /// Takes a piece. One of a blob that its sender has not been asked for is held to what a piece
    /// is, and dropped: it takes no room, and nobody waits for it.
    pub(super) fn put(
        &mut self,
        sender: &str,
        chunk: &Chunk,
        bytes: &[u8],
    ) -> Result<ChunkAnswer, WireError> {
        let key = (sender.to_owned(), chunk.digest);
        let said = match self.blobs.get_mut(&key) {
            None => Assembly::new(chunk.length)?.check(chunk.index, chunk.sum, bytes),
            Some(open) if open.blob.length() != chunk.length => {
                let (value, limit) = (chunk.length, open.blob.length());
                return Err(WireError::Limit { what: "a blob's length", value, limit });
            }
            Some(open) => open.blob.check(chunk.index, chunk.sum, bytes),
        };
        match said {
            Ok(()) => {}
            Err(WireError::Checksum { .. }) => {
                self.damaged += 1;
                return Ok(ChunkAnswer::Damaged);
            }
            Err(error) => return Err(error),
        }
        if self.blobs.contains_key(&key) && !self.makes_room(&key, bytes.len()) {
            return Ok(ChunkAnswer::Busy);
        }
        if let Some(open) = self.blobs.get_mut(&key) {
            open.touched = Instant::now();
            open.blob.put(chunk.index, chunk.sum, bytes)?;
        }
        Ok(ChunkAnswer::Have)
    }

    /// Takes a blob out if it is whole and sound; where it is not, its sender is asked for it.
    pub(super) fn take(
        &mut self,
        sender: &str,
        name: &[u8; 32],
        length: u64,
    ) -> Result<Blob, WireError> {
        let key = (sender.to_owned(), *name);
        let known = self.blobs.get_mut(&key).filter(|open| open.blob.length() == length);
        let Some(open) = known else {
            // Held to the limit here, so that an absurd length is refused and not sent.
            let open = OpenBlob { blob: Assembly::new(length)?, touched: Instant::now() };
            let missing = open.blob.missing(MAX_MISSING);
            self.blobs.remove(&key);
            self.bound_open(sender);
            self.blobs.insert(key, open);
            return Ok(Blob::Missing(missing));
        };
        open.touched = Instant::now();
        let Some(bytes) = open.blob.whole() else {
            return Ok(Blob::Missing(open.blob.missing(MAX_MISSING)));
        };
        if digest(&bytes) == *name {
            self.blobs.remove(&key);
            return Ok(Blob::Whole(bytes));
        }
        open.blob = Assembly::new(length)?;
        self.damaged += 1;
        Ok(Blob::Damaged)
    }

    /// Forgets a blob that is not needed any more.
    pub(super) fn forget(&mut self, sender: &str, name: &[u8; 32]) {
        self.blobs.remove(&(sender.to_owned(), *name));
    }

    /// Forgets blobs that nobody adds to.
    pub(super) fn sweep(&mut self) {
        self.blobs.retain(|_, open| open.touched.elapsed() < STALE);
    }

    /// Whether there is room for so many bytes more of that blob. A sender displaces what it has
    /// left lying itself. Where all are too many, whoever holds most makes room for who holds
    /// less: however many hold much, who holds little is never kept out.
    fn makes_room(&mut self, key: &BlobKey, more: usize) -> bool {
        while self.held(Some(&key.0)) + more > self.own {
            let idle = |(other, open): &(&BlobKey, &OpenBlob)| {
                other.0 == key.0 && *other != key && open.touched.elapsed() >= IDLE
            };
            if !self.displace(idle) {
                return false;
            }
        }
        while self.held(None) + more > self.bound {
            let mut senders: BTreeMap<&str, usize> = BTreeMap::new();
            for ((sender, _), open) in &self.blobs {
                *senders.entry(sender.as_str()).or_default() += open.blob.held();
            }
            let most = senders.into_iter().max_by_key(|(_, held)| *held);
            let Some((sender, held)) = most else { return false };
            if sender == key.0 || held <= self.held(Some(&key.0)) + more {
                return false;
            }
            let sender = sender.to_owned();
            if !self.displace(|(other, _)| other.0 == sender) {
                return false;
            }
        }
        true
    }

    /// Forgets of these, as far as they hold anything, the one that waits longest.
    fn displace(&mut self, which: impl Fn(&(&BlobKey, &OpenBlob)) -> bool) -> bool {
        let held = self.blobs.iter().filter(|(_, open)| open.blob.held() > 0).filter(which);
        let oldest = held.min_by_key(|(_, open)| open.touched).map(|(key, _)| key.clone());
        oldest.is_some_and(|key| self.blobs.remove(&key).is_some())
    }

    /// Makes room for another blob that somebody is asked for.
    fn bound_open(&mut self, sender: &str) {
        let own = self.blobs.keys().filter(|key| key.0 == sender).count();
        let all = self.blobs.len();
        let counts = |key: &BlobKey| {
            (own >= MAX_OPEN_OF_ONE && key.0 == sender)
                || (own < MAX_OPEN_OF_ONE && all >= MAX_OPEN)
        };
        let oldest = self.blobs.iter().filter(|(key, _)| counts(key));
        let oldest = oldest.min_by_key(|(_, open)| open.touched).map(|(key, _)| key.clone());
        oldest.into_iter().for_each(|key| drop(self.blobs.remove(&key)));
    }

    /// Bytes held, of one sender or of all.
    fn held(&self, sender: Option<&str>) -> usize {
        let of = self.blobs.iter().filter(|(key, _)| sender.is_none_or(|sender| key.0 == sender));
        of.map(|(_, open)| open.blob.held()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_proto::chunks;

    fn chunk(bytes: &[u8], name: [u8; 32]) -> Chunk {
        Chunk { digest: name, length: bytes.len() as u64, index: 0, sum: chunks::sum(bytes) }
    }

    #[test]
    fn a_blob_counts_only_if_its_digest_is_right() -> Result<(), WireError> {
        let mut inbox = Inbox::default();
        let (good, name) = (b"fragments", digest(b"fragments"));
        assert_eq!(inbox.take("a", &name, 9)?, Blob::Missing(vec![0]));
        // Each piece has the right checksum, and yet the whole is not what was promised.
        inbox.put("a", &chunk(b"fragmenta", name), b"fragmenta")?;
        assert_eq!(inbox.take("a", &name, 9)?, Blob::Damaged);
        assert_eq!(inbox.put("a", &chunk(good, name), good)?, ChunkAnswer::Have);
        assert_eq!(inbox.take("a", &name, 9)?, Blob::Whole(good.to_vec()));
        assert_eq!(inbox.take("a", &name, 9)?, Blob::Missing(vec![0]));
        Ok(())
    }

    /// The last piece of a blob of three.
    fn last(inbox: &mut Inbox, sender: &str, name: u8) -> Result<ChunkAnswer, WireError> {
        let (piece, length) = (vec![1; chunks::CHUNK], 3 * chunks::CHUNK as u64);
        let sum = chunks::sum(&piece);
        inbox.put(sender, &Chunk { digest: [name; 32], length, index: 2, sum }, &piece)
    }

    fn ask(inbox: &mut Inbox, sender: &str, name: u8) -> Result<Blob, WireError> {
        inbox.take(sender, &[name; 32], 3 * chunks::CHUNK as u64)
    }

    #[test]
    fn a_piece_that_nobody_asked_for_takes_no_room() -> Result<(), WireError> {
        let mut inbox = Inbox::default();
        for name in 0..200 {
            assert_eq!(last(&mut inbox, "mallory", name)?, ChunkAnswer::Have);
        }
        assert_eq!((inbox.held(None), inbox.blobs.len()), (0, 0));
        // Nor one that another was asked for.
        ask(&mut inbox, "ann", 7)?;
        last(&mut inbox, "mallory", 7)?;
        assert_eq!(ask(&mut inbox, "ann", 7)?, Blob::Missing(vec![0, 1, 2]));
        last(&mut inbox, "ann", 7)?;
        assert_eq!(ask(&mut inbox, "ann", 7)?, Blob::Missing(vec![0, 1]));
        assert_eq!(inbox.held(None), chunks::CHUNK, "what is not there takes room");
        Ok(())
    }

    #[test]
    fn a_sender_holds_no_more_than_its_bound_and_keeps_nobody_out() -> Result<(), WireError> {
        let sizes = Inbox::default();
        assert_eq!((sizes.bound, sizes.own), (1 << 30, 1 << 29));
        let mut inbox = Inbox { bound: 8 * chunks::CHUNK, own: 4 * chunks::CHUNK, ..sizes };
        let flood = |inbox: &mut Inbox, sender: &str| {
            (0..40).try_fold(0, |taken, name| {
                ask(inbox, sender, name)?;
                Ok(taken + usize::from(last(inbox, sender, name)? == ChunkAnswer::Have))
            })
        };
        assert_eq!(flood(&mut inbox, "mallory")?, 4);
        assert_eq!(inbox.held(Some("mallory")), inbox.own);
        // All that there is, held by two who go on.
        assert_eq!(flood(&mut inbox, "trudy")?, 4);
        assert_eq!(inbox.held(None), inbox.bound);
        // Another has all the room that it needs, up to as much as those who hold most.
        for name in 0..2 {
            ask(&mut inbox, "ann", name)?;
            assert_eq!(last(&mut inbox, "ann", name)?, ChunkAnswer::Have);
            flood(&mut inbox, "mallory")?;
            flood(&mut inbox, "trudy")?;
            assert_eq!(ask(&mut inbox, "ann", name)?, Blob::Missing(vec![0, 1]), "it is gone");
            assert!(inbox.held(None) <= inbox.bound);
        }
        Ok(())
    }

    #[test]
    fn blobs_that_are_asked_for_have_a_bound_too() -> Result<(), WireError> {
        let mut inbox = Inbox::default();
        ask(&mut inbox, "ann", 0)?;
        last(&mut inbox, "ann", 0)?;
        for name in 0..200 {
            ask(&mut inbox, "mallory", name)?;
        }
        let own = |inbox: &Inbox| inbox.blobs.keys().filter(|key| key.0 == "mallory").count();
        assert_eq!((own(&inbox), inbox.blobs.len()), (MAX_OPEN_OF_ONE, MAX_OPEN_OF_ONE + 1));
        assert_eq!(ask(&mut inbox, "ann", 0)?, Blob::Missing(vec![0, 1]));
        Ok(())
    }

    #[test]
    fn what_is_left_lying_makes_room_for_its_own_sender_and_goes_in_the_end()
    -> Result<(), WireError> {
        let mut inbox = Inbox { own: chunks::CHUNK, ..Inbox::default() };
        let age = |inbox: &mut Inbox, by: Duration| {
            for open in inbox.blobs.values_mut() {
                open.touched = open.touched.checked_sub(by).unwrap_or(open.touched);
            }
        };
        for name in [1, 2] {
            ask(&mut inbox, "ann", name)?;
        }
        assert_eq!(last(&mut inbox, "ann", 1)?, ChunkAnswer::Have);
        assert_eq!(last(&mut inbox, "ann", 2)?, ChunkAnswer::Busy);
        age(&mut inbox, IDLE);
        assert_eq!(last(&mut inbox, "ann", 2)?, ChunkAnswer::Have);
        age(&mut inbox, STALE);
        inbox.sweep();
        assert_eq!((inbox.held(None), inbox.blobs.len()), (0, 0));
        Ok(())
    }

    #[test]
    fn a_damaged_piece_is_asked_for_again() -> Result<(), WireError> {
        let mut inbox = Inbox::default();
        let (good, name) = (b"fragments", digest(b"fragments"));
        for _ in 0..2 {
            let said = inbox.put("a", &chunk(good, name), b"fragmentx")?;
            assert_eq!(said, ChunkAnswer::Damaged);
            assert_eq!(inbox.take("a", &name, 9)?, Blob::Missing(vec![0]));
        }
        assert_eq!(inbox.damaged, 2);
        assert!(inbox.take("a", &[0; 32], u64::MAX).is_err());
        Ok(())
    }
}
