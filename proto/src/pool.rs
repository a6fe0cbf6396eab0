//! Questions and answers between the coordinator and its workers; [`crate::service`] has those of
//! clients.
//!
//! The header of each travels in an [`envelope`]; a chunk's bytes are the bulk behind it. Order of
//! fields and variants is the wire: never reorder; a new field is a new variant.

use crate::codec::{self, WireError};
use crate::envelope::{self, MessageKind};
use crate::ids::{Epoch, JobId, SessionId};
use crate::job::MAX_SOLVER;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Most chunk numbers in one list of missing chunks; the rest is asked for next time.
pub const MAX_MISSING: usize = 1_024;
/// What is said of an attempt that was ended for the time that it took, and nothing else: the pool
/// tells such attempts from others by it.
pub const OVERDUE: &str = "over the hard limit";

/// Longest version of a program \[bytes\].
pub const MAX_VERSION: usize = 64;
/// Most solver families that a worker may name.
pub const MAX_FAMILIES: usize = 32;

/// A worker says what it is and can do: first, and whenever the answer is that it is not known.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// Its life.
    pub session: SessionId,
    /// The version of its program.
    pub version: String,
    /// The digest of its program: the same program gives the same bits.
    pub build: [u8; 32],
    /// Cores of its machine.
    pub cores: u32,
    /// Threads that it gives a job.
    pub threads: u32,
    /// Most memory that a job may hold \[bytes\].
    pub memory: Option<u64>,
    /// What it can solve; `None`: whatever it is asked.
    pub families: Option<Vec<Family>>,
}

/// A family of solvers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Family {
    /// Its name.
    pub name: String,
    /// Whether it is there in f32.
    pub single: bool,
    /// Whether it is there in f64.
    pub double: bool,
}

impl Hello {
    /// Holds what it says to the limits of the wire.
    ///
    /// # Errors
    /// [`WireError::Limit`].
    pub fn check(&self) -> Result<(), WireError> {
        codec::limit("a version's length", self.version.len() as u64, MAX_VERSION as u64)?;
        let families = self.families.as_deref().unwrap_or_default();
        codec::limit("a worker's families", families.len() as u64, MAX_FAMILIES as u64)?;
        families.iter().try_for_each(|family| {
            let length = family.name.len() as u64;
            codec::limit("a solver name's length", length, MAX_SOLVER as u64)
        })
    }
}

/// A worker asks for a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Poll {
    /// Its life.
    pub session: SessionId,
    /// Its question's number; a repeat has the same.
    pub seq: u64,
    /// Jobs that it could take now.
    pub slots: u32,
    /// Threads that it gives a job.
    pub threads: u32,
}

/// A job to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Grant {
    /// Which: the digest of the whole.
    pub job: JobId,
    /// The run that it is for, by a number for people.
    pub run: u64,
    /// The number of this grant.
    pub epoch: Epoch,
    /// Bytes of its outline, to be fetched by its id ([`crate::outline`]).
    pub length: u64,
    /// The grant is good for this long without renewal \[ms\].
    pub lease_ms: u64,
    /// Renew this often \[ms\].
    pub renew_ms: u64,
    /// Give up after this long \[ms\].
    pub hard_ms: u64,
}

/// The answer to a [`Poll`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PollAnswer {
    /// Do this.
    Grant(Grant),
    /// Nothing to do; ask again.
    Idle,
    /// Nothing more to do; leave.
    Drain,
}

/// A worker asks for a piece of a job's outline, or of a part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FetchBlob {
    /// The job's id, or the part's digest.
    pub blob: [u8; 32],
    /// Which chunk.
    pub index: u32,
}

/// The answer to a [`FetchBlob`]; the chunk is the bulk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FetchAnswer {
    /// Here it is.
    Chunk {
        /// Its checksum.
        sum: u32,
    },
    /// No such thing here.
    Gone,
}

/// A worker is still at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Renew {
    /// Its life.
    pub session: SessionId,
    /// At what.
    pub job: JobId,
    /// By which grant.
    pub epoch: Epoch,
    /// How far it is \[1/1000\]; zero until a solver has it, and at least one from then on.
    pub permille: u16,
}

/// The answer to a [`Renew`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RenewAnswer {
    /// Go on.
    Go {
        /// For this long without renewal \[ms\].
        lease_ms: u64,
    },
    /// The result is not wanted.
    Stop,
}

/// A worker wants to hear as soon as its job is not wanted any more: a question that is held until
/// then, or for a while. A coordinator that does not know it refuses; renewals do as well, later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heed {
    /// Its life.
    pub session: SessionId,
    /// The job concerned.
    pub job: JobId,
    /// By which grant.
    pub epoch: Epoch,
}

/// The answer to a [`Heed`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum HeedAnswer {
    /// Go on, and ask again.
    Go,
    /// The result is not wanted.
    Stop,
}

/// A worker hands over a piece of a blob; the piece is the bulk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Chunk {
    /// The digest of the whole blob.
    pub digest: [u8; 32],
    /// Bytes of the whole blob.
    pub length: u64,
    /// Which piece.
    pub index: u32,
    /// Its checksum.
    pub sum: u32,
}

/// The answer to a [`Chunk`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ChunkAnswer {
    /// It is here.
    Have,
    /// It was damaged on the way: send it again.
    Damaged,
    /// There is no room now: try later.
    Busy,
}

/// A worker says that its result is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Commit {
    /// Its life.
    pub session: SessionId,
    /// Of which job.
    pub job: JobId,
    /// By which grant.
    pub epoch: Epoch,
    /// The digest of the result.
    pub digest: [u8; 32],
    /// Its bytes.
    pub length: u64,
    /// Its next question, to save a round.
    pub next: Option<Poll>,
}

/// What became of a result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CommitAnswer {
    /// It counts, or is no longer needed: forget it. With an answer to `next`, if there is a job.
    Done(Option<Grant>),
    /// These chunks are not here (perhaps more).
    Missing(Vec<u32>),
    /// It does not match its digest: send all of it again.
    Damaged,
    /// It cannot be read: give the job back.
    Unreadable(String),
}

/// Why a job is given back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum GiveBackReason {
    /// The attempt died or hung.
    Crashed,
    /// The worker could not take it up.
    Dropped,
    /// The job cannot be read.
    Invalid,
}

/// A worker gives a job back.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fail {
    /// Its life.
    pub session: SessionId,
    /// The job concerned.
    pub job: JobId,
    /// By which grant.
    pub epoch: Epoch,
    /// What went wrong.
    pub trouble: GiveBackReason,
    /// In words.
    pub text: String,
}

/// A worker leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bye {
    /// Its life.
    pub session: SessionId,
}

/// The answer to [`Fail`] and [`Bye`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Acknowledged;

/// Why a question was not answered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum QuestionRefusal {
    /// Another generation of the wire.
    #[error("the coordinator speaks wire version {ours}")]
    Unsupported {
        /// The version spoken.
        ours: u16,
    },
    /// More bytes than a message may have.
    #[error("the message has {bytes} bytes; the limit is {limit}")]
    TooLarge {
        /// Bytes given.
        bytes: u64,
        /// The bound.
        limit: u64,
    },
    /// Something else is wrong with it.
    #[error("the message was not understood: {0}")]
    Malformed(String),
    /// The worker has to say [`Hello`] first; after a restart of the coordinator, again.
    #[error("the coordinator does not know this worker")]
    Stranger,
    /// The session is of a worker of another name.
    #[error("the session belongs to a worker of another name")]
    Foreign,
    /// So many workers of this name are there already.
    #[error(
        "{limit} workers of this name, or of all names, are connected already, which is the limit; \
         give each worker a --name of its own"
    )]
    TooManySessions {
        /// The bound.
        limit: u64,
    },
}

impl QuestionRefusal {
    /// Its name, as it is counted and logged.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Unsupported { .. } => "unsupported",
            Self::TooLarge { .. } => "too_large",
            Self::Malformed(_) => "malformed",
            Self::Stranger => "stranger",
            Self::Foreign => "foreign",
            Self::TooManySessions { .. } => "too_many_sessions",
        }
    }
}

impl From<WireError> for QuestionRefusal {
    fn from(error: WireError) -> Self {
        match error {
            WireError::Version { ours, .. } => Self::Unsupported { ours },
            other => Self::Malformed(other.to_string()),
        }
    }
}

/// The bytes of a question.
///
/// # Errors
/// [`WireError::Limit`] if its header is too large.
pub fn ask<T: Serialize>(question: &T, bulk: &[u8]) -> Result<Vec<u8>, WireError> {
    envelope::seal(MessageKind::Ask, question, bulk)
}

/// The bytes of an answer.
///
/// # Errors
/// [`WireError::Limit`] if its header is too large.
pub fn answer<T: Serialize>(answer: &T, bulk: &[u8]) -> Result<Vec<u8>, WireError> {
    envelope::seal(MessageKind::Answer, answer, bulk)
}

/// The question in these bytes, and its bulk.
///
/// # Errors
/// What is to be answered instead.
pub fn read_ask<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), QuestionRefusal> {
    Ok(envelope::open(MessageKind::Ask, bytes)?)
}

/// The answer in these bytes, and its bulk.
///
/// # Errors
/// What is wrong with them.
pub fn read_answer<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), WireError> {
    envelope::open(MessageKind::Answer, bytes)
}

/// The bytes of a refusal.
#[must_use]
pub fn refuse(refusal: &QuestionRefusal) -> Vec<u8> {
    envelope::seal(MessageKind::Refusal, refusal, &[]).unwrap_or_default()
}

/// The refusal in these bytes.
///
/// # Errors
/// What is wrong with them.
pub fn read_refusal(bytes: &[u8]) -> Result<QuestionRefusal, WireError> {
    Ok(envelope::open(MessageKind::Refusal, bytes)?.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_the_bytes_they_always_had() -> Result<(), WireError> {
        let golden = |bytes: Vec<u8>, text: &str| {
            // Behind the envelope, field by field.
            let hex: String = bytes[20..].iter().map(|b| format!("{b:02x}")).collect();
            assert_eq!(hex, text.replace('-', ""));
        };
        let z = "00000000000000";
        let (session, epoch, job) = (SessionId(1), Epoch(2), JobId([3; 32]));
        golden(
            ask(&Poll { session, seq: 5, slots: 1, threads: 2 }, &[])?,
            "0100000000000000-0500000000000000-01000000-02000000",
        );
        let (run, length) = (8, 4);
        let grant = Grant { job, run, epoch, length, lease_ms: 5, renew_ms: 6, hard_ms: 7 };
        golden(
            answer(&PollAnswer::Grant(grant), &[])?,
            &format!("00000000-{}-08{z}-02{z}-04{z}-05{z}-06{z}-07{z}", "03".repeat(32)),
        );
        golden(
            ask(&Renew { session, job, epoch, permille: 500 }, &[])?,
            &format!("01{z}-{}-02{z}-f401", "03".repeat(32)),
        );
        golden(
            ask(&Heed { session, job, epoch }, &[])?,
            &format!("01{z}-{}-02{z}", "03".repeat(32)),
        );
        golden(answer(&HeedAnswer::Stop, &[])?, "01000000");
        golden(
            answer(&CommitAnswer::Missing(vec![7, 9]), &[])?,
            "01000000-0200000000000000-07000000-09000000",
        );
        golden(refuse(&QuestionRefusal::Unsupported { ours: 1 }), "00000000-0100");
        golden(refuse(&QuestionRefusal::Stranger), "03000000");
        golden(refuse(&QuestionRefusal::Foreign), "04000000");
        let family = Family { name: "a".into(), single: false, double: true };
        let hello = Hello { session, cores: 2, families: Some(vec![family]), ..Hello::default() };
        let none = format!("01{z}-00{z}-{}-02000000-00000000-00", "00".repeat(32));
        golden(ask(&hello, &[])?, &format!("{none}-01-01{z}-01{z}-61-00-01"));
        Ok(())
    }

    #[test]
    fn another_generation_is_told_which_one_is_spoken() -> Result<(), WireError> {
        let mut old = ask(&Bye { session: SessionId(1) }, &[])?;
        old[4] = 0;
        assert_eq!(read_ask::<Bye>(&old), Err(QuestionRefusal::Unsupported { ours: 1 }));
        let bytes = refuse(&QuestionRefusal::Unsupported { ours: 1 });
        assert_eq!(read_refusal(&bytes)?, QuestionRefusal::Unsupported { ours: 1 });
        Ok(())
    }
}
