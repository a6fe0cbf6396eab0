//! The door for people and programs: their questions wait here for whoever answers them.

use super::bulk::{Bulk, refuse, reply};
use super::inbox::{Blob, Inbox};
use super::{LinkError, Pool, Refusals};
use cullet_proto::keys::{self, UserVerb, Verb, parse_rpc};
use cullet_proto::pool::{Chunk, ChunkAnswer, QuestionRefusal};
use cullet_proto::service::{self, BundlePiece, ErrorReply, MAX_LINE, PieceAnswer};
use cullet_proto::{WireError, WorkerId, chunks};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;
use zenoh::Wait;
use zenoh::query::Query;

/// Questions that may wait; beyond it they are dropped, and asked again.
const QUEUE: usize = 512;
/// Largest question \[bytes\]: a piece and its line.
const MAX_QUESTION: usize = chunks::CHUNK + MAX_LINE + 1;

/// The door of one coordinator.
pub struct RequestServer {
    queue: Receiver<Query>,
    inbox: Inbox,
    bulk: Arc<Bulk>,
    refusals: Refusals,
    queryable: Option<zenoh::query::Queryable<()>>,
}

/// A query of a user that waits for its answer.
pub struct UserQuery {
    query: Query,
    bulk: Arc<Bulk>,
    bytes: Vec<u8>,
    /// Who asks.
    pub user: WorkerId,
    /// What for.
    pub verb: UserVerb,
}

/// What there is of a bundle that came in pieces.
#[derive(Debug, PartialEq, Eq)]
pub enum Parcel {
    /// All of it.
    Whole(Vec<u8>),
    /// Not these pieces (perhaps more).
    Missing(Vec<u32>),
    /// All of it, but it does not match its digest: thrown away.
    Damaged,
}

impl RequestServer {
    /// Opens the door of this pool's coordinator.
    ///
    /// # Errors
    /// [`LinkError::Listen`] if the transport does not take it, [`LinkError::Thread`].
    pub fn open(pool: &Pool) -> Result<Self, LinkError> {
        let (inputs, queue) = sync_channel(QUEUE);
        let failed = |e: zenoh::Error| LinkError::Listen {
            endpoint: pool.endpoint().to_owned(),
            text: cullet_proto::transport::plain(&e.to_string()),
        };
        let queryable = pool
            .session()
            .declare_queryable(keys::user_rpcs(pool.name()))
            .callback(move |query| {
                if inputs.try_send(query).is_err() {
                    tracing::warn!("too many questions wait: one dropped");
                }
            })
            .wait()
            .map_err(failed)?;
        let bulk = Arc::new(Bulk::start()?);
        let (inbox, refusals) = (Inbox::default(), Refusals::default());
        Ok(Self { queue, inbox, bulk, refusals, queryable: Some(queryable) })
    }

    /// The next question that can be read, within `timeout`. What cannot be read is refused here,
    /// and pieces of bundles are put aside.
    pub fn next(&mut self, timeout: Duration) -> Option<UserQuery> {
        let query = match self.queue.recv_timeout(timeout) {
            Ok(query) => query,
            Err(RecvTimeoutError::Timeout) => return None,
            Err(RecvTimeoutError::Disconnected) => {
                std::thread::sleep(timeout);
                return None;
            }
        };
        let bytes = query.payload().map(|payload| payload.to_bytes().into_owned());
        let bytes = bytes.unwrap_or_default();
        let bulk = Arc::clone(&self.bulk);
        let key = query.key_expr().as_str().to_owned();
        let Some(Verb::User(user, verb)) = parse_rpc(&key) else {
            self.unread(&query, &QuestionRefusal::Malformed("no such question".to_owned()));
            return None;
        };
        if bytes.len() > MAX_QUESTION {
            let (bytes, limit) = (bytes.len() as u64, MAX_QUESTION as u64);
            self.unread(&query, &QuestionRefusal::TooLarge { bytes, limit });
            return None;
        }
        let asked = UserQuery { query, bulk, bytes, user, verb };
        if verb != UserVerb::Piece {
            return Some(asked);
        }
        let user = asked.user.as_str();
        let piece = asked.read::<BundlePiece>();
        match piece.and_then(|(piece, bytes)| self.piece(user, &piece, bytes)) {
            Ok(said) => asked.answer(&said),
            Err(error) => self.garbled(&asked, error),
        }
        None
    }

    /// Says that a question cannot be read, or goes beyond what a question may have.
    pub fn garbled(&mut self, asked: &UserQuery, why: impl std::fmt::Display) {
        self.unread(&asked.query, &QuestionRefusal::Malformed(why.to_string()));
    }

    /// Questions that were not understood.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.refusals
    }

    fn unread(&mut self, query: &Query, refusal: &QuestionRefusal) {
        self.refusals.count(refusal);
        tracing::warn!(reason = refusal.name(), "{}: {refusal}", query.key_expr());
        send(query, &refusal.to_string(), false, false);
    }

    fn piece(
        &mut self,
        user: &str,
        piece: &BundlePiece,
        bytes: &[u8],
    ) -> Result<PieceAnswer, WireError> {
        let sum = piece.sum.unwrap_or_else(|| chunks::sum(bytes));
        let digest = service::digest_of(&piece.digest)?;
        let chunk = Chunk { digest, length: piece.length, index: piece.index, sum };
        Ok(match self.inbox.put(user, &chunk, bytes)? {
            ChunkAnswer::Have => PieceAnswer::Have,
            ChunkAnswer::Damaged => PieceAnswer::Damaged,
            ChunkAnswer::Busy => PieceAnswer::Busy,
        })
    }

    /// Takes a bundle out that came in pieces of this user; from then on it is asked for what is
    /// missing, and of nobody else, and nothing before, is a piece kept.
    ///
    /// # Errors
    /// A length over the limit.
    pub fn take(
        &mut self,
        user: &str,
        digest: &[u8; 32],
        length: u64,
    ) -> Result<Parcel, WireError> {
        Ok(match self.inbox.take(user, digest, length)? {
            Blob::Whole(bytes) => Parcel::Whole(bytes),
            Blob::Missing(pieces) => Parcel::Missing(pieces),
            Blob::Damaged => Parcel::Damaged,
        })
    }

    /// Takes no further question.
    pub fn close(&mut self) {
        if let Some(queryable) = self.queryable.take()
            && let Err(error) = queryable.undeclare().wait()
        {
            tracing::debug!("closing the door: {error}");
        }
    }

    /// Forgets bundles that nobody adds to.
    pub fn sweep(&mut self) {
        self.inbox.sweep();
    }
}

impl Drop for RequestServer {
    fn drop(&mut self) {
        self.close();
    }
}

impl UserQuery {
    /// The question and its bulk.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read<T: DeserializeOwned>(&self) -> Result<(T, &[u8]), WireError> {
        service::open(&self.bytes)
    }

    /// Answers.
    pub fn answer<T: Serialize>(&self, said: &T) {
        match service::seal(said, &[]) {
            Ok(bytes) => reply(&self.query, bytes),
            Err(error) => self.refuse(error),
        }
    }

    /// Answers with bulk.
    pub fn answer_bulk<T: Serialize>(&self, said: &T, bulk: &[u8]) {
        match service::seal(said, bulk) {
            Ok(bytes) => self.bulk.send(self.query.clone(), bytes),
            Err(error) => self.refuse(error),
        }
    }

    /// Says why there is no answer.
    pub fn refuse(&self, why: impl std::fmt::Display) {
        self.deny(&why.to_string(), false, false);
    }

    /// Says that what was named is not there.
    pub fn unknown(&self, what: impl std::fmt::Display) {
        self.deny(&what.to_string(), true, false);
    }

    /// Says why there is no answer now.
    pub fn later(&self, why: impl std::fmt::Display) {
        self.deny(&why.to_string(), false, true);
    }

    fn deny(&self, why: &str, unknown: bool, later: bool) {
        tracing::info!("{}: {why}", self.query.key_expr());
        send(&self.query, why, unknown, later);
    }
}

fn send(query: &Query, why: &str, unknown: bool, later: bool) {
    let error = cullet_proto::verdict::cut(why);
    let refused = ErrorReply { error, unknown, later };
    refuse(query, service::seal(&refused, &[]).unwrap_or_default());
}
