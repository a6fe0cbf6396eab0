//! Jobs from their outlines: the large parts that this worker has seen before are at hand, the
//! others are asked for, a piece at a time.

use crate::link::NoAnswer;
use cullet_dispatch::{Job, LruIndex, Trouble};
use cullet_proto::ids::digest;
use cullet_proto::outline::{LARGE, Outline};
use cullet_proto::pool::{FetchAnswer, FetchBlob, Grant};
use cullet_proto::{JobId, chunks};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// Pause before a piece is asked for again.
const PAUSE: Duration = Duration::from_millis(100);
/// Answers in a row to one piece that are no good, after which the job is given back.
const MAX_TRIES: u32 = 20;
/// Times that a blob may come whole and be another than its name says.
const MAX_FALSE: u32 = 3;

/// Why a job's bytes are not here.
type Lack = (Trouble, String);

/// Large parts by digest: the most recently used, as much as fits.
pub(crate) struct Meshes {
    index: LruIndex,
    held: BTreeMap<[u8; 32], Arc<Vec<u8>>>,
}

impl Meshes {
    /// Room for so many bytes.
    pub(crate) fn new(bound: u64) -> Self {
        Self { index: LruIndex::new(bound), held: BTreeMap::new() }
    }

    fn get(&mut self, name: &[u8; 32]) -> Option<Arc<Vec<u8>>> {
        self.index.touch(Job(*name));
        self.held.get(name).map(Arc::clone)
    }

    /// Keeps what this worker made and will most likely be asked to go on from.
    pub(crate) fn keep(&mut self, part: &[u8]) {
        if part.len() >= LARGE {
            self.put(digest(part), &Arc::new(part.to_vec()));
        }
    }

    fn put(&mut self, name: [u8; 32], part: &Arc<Vec<u8>>) {
        self.held.insert(name, Arc::clone(part));
        for gone in self.index.put(Job(name), part.len() as u64) {
            self.held.remove(&gone.0);
        }
    }
}

/// Brings what a worker lacks of a job. Each question is for one piece and is asked until it is
/// answered with a sound one: nothing else acknowledges it.
pub(crate) struct Fetcher<'a> {
    pub(crate) meshes: &'a mut Meshes,
    pub(crate) ask: &'a dyn Fn(FetchBlob) -> Result<(FetchAnswer, Vec<u8>), NoAnswer>,
    pub(crate) stop: &'a dyn Fn() -> bool,
}

impl Fetcher<'_> {
    /// All bytes of a job.
    pub(crate) fn job(&mut self, grant: &Grant) -> Result<Vec<u8>, Lack> {
        for _ in 0..MAX_FALSE {
            let bytes = self.blob(grant.job.0, grant.length)?;
            let Ok(outline) = Outline::open(&bytes) else {
                continue;
            };
            let parts = outline.parts.iter().map(|part| self.part(part.digest, part.length));
            let parts = parts.collect::<Result<Vec<_>, _>>()?;
            let parts: Vec<&[u8]> = parts.iter().map(|part| part.as_slice()).collect();
            if let Some(job) = outline.whole(&parts)
                && JobId::of(&job) == grant.job
            {
                return Ok(job);
            }
        }
        dropped("its bytes do not match its id")
    }

    fn part(&mut self, name: [u8; 32], length: u64) -> Result<Arc<Vec<u8>>, Lack> {
        if let Some(part) = self.meshes.get(&name) {
            return Ok(part);
        }
        for _ in 0..MAX_FALSE {
            let bytes = self.blob(name, length)?;
            if digest(&bytes) == name {
                let part = Arc::new(bytes);
                self.meshes.put(name, &part);
                return Ok(part);
            }
        }
        dropped("a part of it does not match its digest")
    }

    fn blob(&self, blob: [u8; 32], length: u64) -> Result<Vec<u8>, Lack> {
        if length > chunks::MAX_BLOB {
            return Err((Trouble::Invalid, "it is too long".into()));
        }
        let mut bytes = Vec::new();
        for index in 0..chunks::count(length) {
            let need = (length as usize - bytes.len()).min(chunks::CHUNK);
            bytes.extend_from_slice(&self.piece(FetchBlob { blob, index }, need)?);
        }
        Ok(bytes)
    }

    fn piece(&self, fetch: FetchBlob, need: usize) -> Result<Vec<u8>, Lack> {
        let mut last = String::new();
        for _ in 0..MAX_TRIES {
            if (self.stop)() {
                return dropped("its bytes are not waited for");
            }
            last = match (self.ask)(fetch) {
                Ok((FetchAnswer::Chunk { sum }, piece))
                    if piece.len() == need && sum == chunks::sum(&piece) =>
                {
                    return Ok(piece);
                }
                Ok((FetchAnswer::Chunk { .. }, _)) => {
                    tracing::warn!("a piece of a job came damaged, and is asked for again");
                    "it came damaged".into()
                }
                Ok((FetchAnswer::Gone, _)) => return dropped("its bytes are gone"),
                Err(NoAnswer::Silence) => "nobody answers".into(),
                Err(NoAnswer::Refused(refusal)) => return dropped(&refusal.to_string()),
                // Damaged too, in what goes before the piece.
                Err(NoAnswer::Unreadable(text)) => text,
            };
            tracing::debug!("piece {} is asked for again: {last}", fetch.index);
            thread::sleep(PAUSE);
        }
        dropped(&format!("its bytes do not come: {last}"))
    }
}

fn dropped<T>(text: &str) -> Result<T, Lack> {
    Err((Trouble::Dropped, text.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_geometry::{Solid, Vec3, shapes};
    use cullet_proto::outline::Parted;
    use cullet_proto::{Epoch, FractureJob, WireError};
    use std::cell::RefCell;

    fn jobs() -> Result<[Parted; 2], WireError> {
        let detail = shapes::Detail { segments: 48, edge: Some(0.003) };
        let solid = shapes::cuboid(Vec3::repeat(0.2), detail).expect("a box");
        let job = |seed| {
            let mut job = FractureJob::smallest("echo", seed);
            job.problem.body = Solid::outer(solid.clone()).into();
            Parted::of(&job)
        };
        Ok([job(1)?, job(2)?])
    }

    fn grant(job: &Parted) -> Grant {
        let (length, epoch) = (job.outline.len() as u64, Epoch(1));
        Grant { job: job.id, run: 1, epoch, length, lease_ms: 1, renew_ms: 1, hard_ms: 1 }
    }

    /// Fetches a job from somebody who has it; `harm` may change an answer. Pieces asked for.
    fn fetch(
        meshes: &mut Meshes,
        job: &Parted,
        harm: impl Fn(usize, &mut Vec<u8>),
    ) -> (Result<Vec<u8>, Lack>, Vec<FetchBlob>) {
        let asked = RefCell::new(Vec::new());
        let ask = |fetch: FetchBlob| {
            asked.borrow_mut().push(fetch);
            let part = job.parts.iter().find(|(name, _)| *name == fetch.blob);
            let blob = part.map_or(job.outline.as_slice(), |(_, part)| part.as_slice());
            let Some(piece) = chunks::slice(blob, fetch.index) else {
                return Ok((FetchAnswer::Gone, Vec::new()));
            };
            let (sum, mut piece) = (chunks::sum(piece), piece.to_vec());
            harm(asked.borrow().len(), &mut piece);
            Ok((FetchAnswer::Chunk { sum }, piece))
        };
        let got = Fetcher { meshes, ask: &ask, stop: &|| false }.job(&grant(job));
        (got, asked.into_inner())
    }

    #[test]
    fn a_mesh_is_asked_for_once_and_again_by_who_lost_it() -> Result<(), WireError> {
        let [one, two] = jobs()?;
        let pieces = chunks::count(one.parts[0].1.len() as u64) as usize;
        assert!(pieces > 1, "{pieces}");
        let mut meshes = Meshes::new(64 << 20);
        for (job, count) in [(&one, 1 + pieces), (&two, 1), (&one, 1)] {
            let (got, asked) = fetch(&mut meshes, job, |_, _| ());
            assert_eq!(got.map(|bytes| JobId::of(&bytes)), Ok(job.id));
            assert_eq!(asked.len(), count);
        }
        // One that has no room, or has lost what it had, asks for all.
        for mut meshes in [Meshes::new(64 << 20), Meshes::new(100)] {
            fetch(&mut meshes, &one, |_, _| ()).0.expect("a job");
            meshes.held.retain(|_, _| false);
            let (got, asked) = fetch(&mut meshes, &two, |_, _| ());
            assert_eq!(got.map(|bytes| JobId::of(&bytes)), Ok(two.id));
            assert_eq!(asked.len(), 1 + pieces);
        }
        Ok(())
    }

    #[test]
    fn a_bit_turned_over_is_noticed_and_the_piece_asked_for_again() -> Result<(), WireError> {
        let [one, _] = jobs()?;
        let pieces = chunks::count(one.parts[0].1.len() as u64) as usize;
        for sick in 1..=1 + pieces {
            let flip = |at: usize, piece: &mut Vec<u8>| {
                if at == sick {
                    let middle = piece.len() / 2;
                    piece[middle] ^= 1;
                }
            };
            let (got, asked) = fetch(&mut Meshes::new(64 << 20), &one, flip);
            assert_eq!(got.map(|bytes| JobId::of(&bytes)), Ok(one.id));
            assert_eq!(asked.len(), 2 + pieces);
            assert_eq!(asked[sick], asked[sick - 1], "the same piece, once more");
        }
        Ok(())
    }

    #[test]
    fn a_mesh_that_is_not_what_its_name_says_is_never_kept() -> Result<(), WireError> {
        let [mut one, _] = jobs()?;
        let sound = Arc::clone(&one.parts[0].1);
        let mut false_one = sound.to_vec();
        false_one[7] ^= 1;
        // Its checksums are right: only the digest tells.
        one.parts[0].1 = Arc::new(false_one);
        let mut meshes = Meshes::new(64 << 20);
        let (got, _) = fetch(&mut meshes, &one, |_, _| ());
        assert!(
            matches!(&got, Err((Trouble::Dropped, text)) if text.contains("digest")),
            "{got:?}"
        );
        assert!(meshes.held.is_empty());
        one.parts[0].1 = sound;
        assert!(fetch(&mut meshes, &one, |_, _| ()).0.is_ok());
        Ok(())
    }
}
