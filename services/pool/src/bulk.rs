//! Large answers, on a thread of their own: sending blocks while a link is congested.

use super::error::LinkError;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use zenoh::Wait;
use zenoh::query::Query;

/// Answers that may wait to be sent, a chunk each. Beyond it they are dropped and asked for again.
const MAX_WAITING: usize = 64;

/// The sender of large answers.
pub(super) struct Bulk {
    queue: Option<SyncSender<(Query, Vec<u8>)>>,
    thread: Option<JoinHandle<()>>,
}

impl Bulk {
    pub(super) fn start() -> Result<Self, LinkError> {
        let (queue, answers) = sync_channel::<(Query, Vec<u8>)>(MAX_WAITING);
        let thread = std::thread::Builder::new()
            .name("cullet-bulk".into())
            .spawn(move || {
                for (query, bytes) in answers {
                    reply(&query, bytes);
                }
            })
            .map_err(LinkError::Thread)?;
        Ok(Self { queue: Some(queue), thread: Some(thread) })
    }

    pub(super) fn send(&self, query: Query, bytes: Vec<u8>) {
        let Some(queue) = &self.queue else { return };
        if queue.try_send((query, bytes)).is_err() {
            tracing::warn!("too many large answers wait: one dropped");
        }
    }
}

impl Drop for Bulk {
    fn drop(&mut self) {
        self.queue = None;
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

/// Answers a question.
pub(super) fn reply(query: &Query, bytes: Vec<u8>) {
    if let Err(error) = query.reply(query.key_expr().clone(), bytes).wait() {
        tracing::debug!("an answer was not sent: {error}");
    }
}

/// Refuses a question.
pub(super) fn refuse(query: &Query, bytes: Vec<u8>) {
    if let Err(error) = query.reply_err(bytes).wait() {
        tracing::debug!("a refusal was not sent: {error}");
    }
}
