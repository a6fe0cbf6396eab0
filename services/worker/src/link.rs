//! The worker's end of the transport.

use crate::{WorkerConfig, WorkerError};
use cullet_proto::keys::{self, WorkerVerb};
use cullet_proto::pool::{self, QuestionRefusal};
use cullet_proto::{SessionId, WorkerId, transport};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::ConsolidationMode;

/// A question that the coordinator may hold is answered within this.
const POLL: Duration = Duration::from_secs(30);
/// A chunk on the slowest link served.
const BULK: Duration = Duration::from_secs(30);
/// Anything small.
const CONTROL: Duration = Duration::from_secs(5);

/// How often one that waits looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(50);

/// Why there is no answer.
#[derive(Debug)]
pub(crate) enum NoAnswer {
    /// Silence: a dead coordinator, a link just gone or just back, a full queue all look the same.
    /// Ask again.
    Silence,
    /// The coordinator refuses the question as it is.
    Refused(QuestionRefusal),
    /// The answer cannot be read.
    Unreadable(String),
}

/// How the transport says that it did not connect in time.
const UNABLE: &str = "Unable to connect";

/// Settings with which a link is tried, in turn: the transport waits without end for the first of
/// several places, unless another number is given; once it was connected, it looks at them all.
fn turns(config: &WorkerConfig) -> Result<Vec<zenoh::Config>, String> {
    let mut places = config.connect.clone();
    let mut all = Vec::new();
    for _ in &config.connect {
        let pairs = match places.len() {
            1 => transport::worker(&places, config.patience),
            _ => transport::client(&places, config.patience, config.patience.open_ms),
        };
        let mut settings = zenoh::Config::default();
        for (path, value) in pairs.iter().chain(&config.rules) {
            settings.insert_json5(path, value).map_err(|e| format!("{path}: {e}"))?;
        }
        all.push(settings);
        places.rotate_left(1);
    }
    Ok(all)
}

fn first_open(turns: &[zenoh::Config], stop: &AtomicBool) -> Result<zenoh::Session, String> {
    let mut last = String::new();
    for settings in turns.iter().cycle() {
        match zenoh::open(settings.clone()).wait() {
            Ok(link) => return Ok(link),
            Err(error) => last = error.to_string(),
        }
        if stop.load(Ordering::Relaxed) || !last.contains(UNABLE) {
            break;
        }
    }
    Err(last)
}

/// Waits for the coordinator; nothing if it is to stop before, or has waited for as long as it may
/// be idle.
fn first_within(
    config: &WorkerConfig,
    turns: Vec<zenoh::Config>,
) -> Option<Result<zenoh::Session, String>> {
    // A thread that still waits ends with the process.
    let (send, opened) = channel();
    let stop = Arc::clone(&config.stop);
    std::thread::spawn(move || send.send(first_open(&turns, &stop)));
    let since = Instant::now();
    loop {
        match opened.recv_timeout(LOOK) {
            Ok(link) => return Some(link),
            Err(RecvTimeoutError::Disconnected) => return Some(Err("it broke off".to_owned())),
            Err(RecvTimeoutError::Timeout) if config.stop.load(Ordering::Relaxed) => return None,
            Err(RecvTimeoutError::Timeout) => {}
        }
        if config.idle_limit.is_some_and(|limit| since.elapsed() >= limit) {
            let (place, seconds) = (config.connect.join(", "), since.elapsed().as_secs_f64());
            tracing::warn!(seconds, "no coordinator at {place} for so long: leaving");
            return None;
        }
    }
}

/// An open link to the coordinator, with the worker's liveliness token.
pub(crate) struct CoordinatorLink {
    link: zenoh::Session,
    coordinator: WorkerId,
    worker: WorkerId,
    place: String,
    certificate: Option<String>,
    pub(crate) session: SessionId,
    _alive: LivelinessToken,
}

impl CoordinatorLink {
    /// Opens the link, for as long as it takes; nothing if it is to stop before, or has waited for
    /// as long as it may be idle.
    pub(crate) fn open(
        config: &WorkerConfig,
        session: SessionId,
    ) -> Result<Option<Self>, WorkerError> {
        if config.connect.is_empty() {
            return Err(WorkerError::NoEndpoint);
        }
        let (coordinator, worker) =
            (WorkerId::new(&config.coordinator)?, WorkerId::new(&config.name)?);
        let failed = |text: String| WorkerError::Connect {
            endpoints: config.connect.join(", "),
            text: transport::plain(&text),
        };
        let turns = turns(config).map_err(failed)?;
        let link = match first_within(config, turns) {
            Some(opened) => opened.map_err(failed)?,
            None => return Ok(None),
        };
        let key = keys::worker_live(&coordinator, &worker, session);
        let alive = link.liveliness().declare_token(key).wait();
        let _alive = alive.map_err(|e| failed(e.to_string()))?;
        let (place, certificate) = (config.connect.join(", "), config.certificate.clone());
        Ok(Some(Self { link, coordinator, worker, place, certificate, session, _alive }))
    }

    /// What may be wrong when nobody answers though the link is up: a denial is silence.
    pub(crate) fn unheard(&self) -> Option<String> {
        self.link.info().routers_zid().wait().next()?;
        let Self { place, worker, certificate, .. } = self;
        let denied = certificate.as_ref().map(|name| {
            format!(
                ", or {worker} may not work here: its certificate is of {name:?}, and roles must \
                 name it among workers"
            )
        });
        let denied = denied.unwrap_or_default();
        Some(format!("connected to {place}, and nobody answers: no coordinator is there{denied}"))
    }

    /// Asks once. Blocks while the link is congested.
    pub(crate) fn ask<Q: Serialize, A: DeserializeOwned>(
        &self,
        verb: WorkerVerb,
        question: &Q,
        bulk: &[u8],
    ) -> Result<(A, Vec<u8>), NoAnswer> {
        self.ask_unless(&AtomicBool::new(false), verb, question, bulk)
    }

    /// Asks once. Once `stop` is set the answer is not waited for any more.
    pub(crate) fn ask_unless<Q: Serialize, A: DeserializeOwned>(
        &self,
        stop: &AtomicBool,
        verb: WorkerVerb,
        question: &Q,
        bulk: &[u8],
    ) -> Result<(A, Vec<u8>), NoAnswer> {
        let unreadable = |e: cullet_proto::WireError| NoAnswer::Unreadable(e.to_string());
        let bytes = pool::ask(question, bulk).map_err(unreadable)?;
        // Bulk must not hold up renewals behind it; an answer inherits its question's priority.
        let (priority, patience) = match verb {
            WorkerVerb::Chunk | WorkerVerb::Fetch => (Priority::DataLow, BULK),
            WorkerVerb::Commit => (Priority::InteractiveHigh, BULK),
            WorkerVerb::Poll | WorkerVerb::Heed => (Priority::InteractiveHigh, POLL),
            WorkerVerb::Hello | WorkerVerb::Renew | WorkerVerb::Fail | WorkerVerb::Bye => {
                (Priority::InteractiveHigh, CONTROL)
            }
        };
        // The transport's own channel calls it an error if nobody takes a late answer.
        let (send, replies) = channel();
        self.link
            .get(keys::worker_rpc(&self.coordinator, &self.worker, verb))
            .payload(bytes)
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .priority(priority)
            .timeout(patience)
            .callback(move |reply| drop(send.send(reply)))
            .wait()
            .map_err(|_| NoAnswer::Silence)?;
        let reply = loop {
            match replies.recv_timeout(LOOK) {
                Ok(reply) => break reply,
                Err(RecvTimeoutError::Timeout) if !stop.load(Ordering::Relaxed) => {}
                Err(_) => return Err(NoAnswer::Silence),
            }
        };
        match reply.into_result() {
            Ok(sample) => {
                let bytes = sample.payload().to_bytes();
                let (answer, bulk) = pool::read_answer(&bytes).map_err(unreadable)?;
                Ok((answer, bulk.to_vec()))
            }
            // A refusal that is none of ours is Zenoh's own: a timeout.
            Err(error) => Err(pool::read_refusal(&error.payload().to_bytes())
                .map_or(NoAnswer::Silence, NoAnswer::Refused)),
        }
    }

    pub(crate) fn close(&self) {
        if let Err(error) = self.link.close().wait() {
            tracing::debug!("closing the link: {error}");
        }
    }
}
