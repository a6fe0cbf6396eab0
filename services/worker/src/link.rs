//! The worker's end of the transport.

use crate::{WorkerConfig, WorkerError};
use cullet_proto::keys::{self, WorkerVerb};
use cullet_proto::pool::{self, QuestionRefusal};
use cullet_proto::{SessionId, WorkerId, transport};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::ConsolidationMode;

/// A question that the coordinator may hold is answered within this.
const POLL: Duration = Duration::from_secs(30);
/// A chunk on the slowest link served.
const BULK: Duration = Duration::from_secs(30);
/// Anything small.
const CONTROL: Duration = Duration::from_secs(5);

/// Where the link is up and nobody has answered for so long, it is made anew: of one that was cut
/// while it was made, each end may keep a half of its own that the other knows nothing of.
const DEAF: Duration = Duration::from_secs(if cfg!(test) { 2 } else { 60 });

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
/// `soon`: nor does it wait for a single place.
fn turns(config: &WorkerConfig, soon: bool) -> Result<Vec<zenoh::Config>, String> {
    let mut places = config.connect.clone();
    let mut all = Vec::new();
    for _ in &config.connect {
        let pairs = match places.len() {
            1 if !soon => transport::worker(&places, config.patience),
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
    shared: Arc<SharedLink>,
    /// For a link that is made anew.
    turns: Vec<zenoh::Config>,
    stop: Arc<AtomicBool>,
    coordinator: WorkerId,
    worker: WorkerId,
    place: String,
    certificate: Option<String>,
    pub(crate) session: SessionId,
}

struct OpenLink {
    link: zenoh::Session,
    _alive: LivelinessToken,
    /// When somebody answered, or it was made anew, last.
    heard: Instant,
}

impl OpenLink {
    fn new(link: zenoh::Session, key: String) -> zenoh::Result<Self> {
        let _alive = link.liveliness().declare_token(key).wait()?;
        Ok(Self { link, _alive, heard: Instant::now() })
    }
}

/// The link, and what of it is going on.
struct SharedLink {
    open: Mutex<OpenLink>,
    /// It is made anew now.
    mending: AtomicBool,
    closed: AtomicBool,
}

impl SharedLink {
    fn lock(&self) -> MutexGuard<'_, OpenLink> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts another link in the place of the deaf one, if one can be had soon.
    fn make_anew(&self, turns: &[zenoh::Config], key: &str, deaf: &zenoh::Session) {
        let made = turns.iter().find_map(|settings| {
            if self.closed.load(Ordering::Relaxed) {
                return None;
            }
            let link = zenoh::open(settings.clone()).wait();
            let made = link.and_then(|link| OpenLink::new(link, key.to_owned()));
            made.map_err(|error| tracing::debug!("the link is not made anew: {error}")).ok()
        });
        let mut open = self.lock();
        let Some(made) = made.filter(|_| !self.closed.load(Ordering::Relaxed)) else {
            // The next try is due after as long a silence.
            open.heard = Instant::now();
            return;
        };
        let old = std::mem::replace(&mut *open, made);
        drop(open);
        // Telling the deaf end may take a while, and nobody waits for it.
        drop(old);
        if let Err(error) = deaf.close().wait() {
            tracing::debug!("closing the deaf link: {error}");
        }
    }
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
        let link = match first_within(config, turns(config, false).map_err(failed)?) {
            Some(opened) => opened.map_err(failed)?,
            None => return Ok(None),
        };
        let key = keys::worker_live(&coordinator, &worker, session);
        let open = OpenLink::new(link, key).map_err(|e| failed(e.to_string()))?;
        let (place, certificate) = (config.connect.join(", "), config.certificate.clone());
        let [mending, closed] = [false, false].map(AtomicBool::new);
        let shared = Arc::new(SharedLink { open: Mutex::new(open), mending, closed });
        let turns = turns(config, true).map_err(failed)?;
        let stop = Arc::clone(&config.stop);
        Ok(Some(Self { shared, turns, stop, coordinator, worker, place, certificate, session }))
    }

    fn link(&self) -> zenoh::Session {
        self.shared.lock().link.clone()
    }

    /// There was no answer. If the link is up, and nobody has answered for [`DEAF`] since it was
    /// found to be so, another thread makes it anew: nobody waits for that.
    fn mend(&self) {
        let leaves = self.stop.load(Ordering::Relaxed);
        if leaves || self.shared.mending.swap(true, Ordering::Relaxed) {
            return;
        }
        let link = self.link();
        let up = link.info().routers_zid().wait().next().is_some();
        let deaf = {
            let mut open = self.shared.lock();
            if !up {
                open.heard = Instant::now();
            }
            open.heard.elapsed() >= DEAF
        };
        let (shared, turns) = (Arc::clone(&self.shared), self.turns.clone());
        let key = keys::worker_live(&self.coordinator, &self.worker, self.session);
        let make = move || {
            shared.make_anew(&turns, &key, &link);
            shared.mending.store(false, Ordering::Relaxed);
        };
        let thread = std::thread::Builder::new().name("cullet-mend".to_owned());
        if !deaf || thread.spawn(make).is_err() {
            return self.shared.mending.store(false, Ordering::Relaxed);
        }
        let (place, seconds) = (&self.place, DEAF.as_secs());
        tracing::warn!("connected to {place}, and nobody answers for {seconds} s: once more");
    }

    /// What may be wrong when nobody answers though the link is up: a denial is silence.
    pub(crate) fn unheard(&self) -> Option<String> {
        self.link().info().routers_zid().wait().next()?;
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
        let said = self.ask_once(stop, verb, bytes);
        match &said {
            // Who says goodbye, or waits no more, has no use for another link.
            Err(NoAnswer::Silence) if verb == WorkerVerb::Bye || stop.load(Ordering::Relaxed) => {}
            Err(NoAnswer::Silence) => self.mend(),
            Ok(_) | Err(_) => self.shared.lock().heard = Instant::now(),
        }
        let bytes = said?;
        let bytes = bytes.to_bytes();
        let (answer, bulk) = pool::read_answer(&bytes).map_err(unreadable)?;
        Ok((answer, bulk.to_vec()))
    }

    fn ask_once(
        &self,
        stop: &AtomicBool,
        verb: WorkerVerb,
        bytes: Vec<u8>,
    ) -> Result<ZBytes, NoAnswer> {
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
        self.link()
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
            Ok(sample) => Ok(sample.payload().clone()),
            // A refusal that is none of ours is Zenoh's own: a timeout.
            Err(error) => Err(pool::read_refusal(&error.payload().to_bytes())
                .map_or(NoAnswer::Silence, NoAnswer::Refused)),
        }
    }

    pub(crate) fn close(&self) {
        self.shared.closed.store(true, Ordering::Relaxed);
        if let Err(error) = self.link().close().wait() {
            tracing::debug!("closing the link: {error}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_proto::pool::{Acknowledged, Bye};
    use cullet_proto::transport::Patience;

    /// A router of which nobody answers stands for a link of which the coordinator hears nothing.
    #[test]
    fn a_link_that_is_up_and_deaf_is_made_anew() {
        let port = std::net::TcpListener::bind("127.0.0.1:0").and_then(|it| it.local_addr());
        let place = format!("tcp/{}", port.expect("a port"));
        let mut settings = zenoh::Config::default();
        for (path, value) in transport::router(&place, Patience::test()) {
            settings.insert_json5(path, &value).expect("a setting");
        }
        let router = zenoh::open(settings).wait().expect("a router");
        let (connect, patience) = (vec![place], Patience::test());
        let config = WorkerConfig { connect, patience, ..WorkerConfig::default() };
        let session = SessionId(7);
        let begun = Instant::now();
        let link = CoordinatorLink::open(&config, session).expect("a link").expect("it is there");
        let first = link.link().zid();
        let ask = || {
            let bye = Bye { session };
            std::thread::sleep(LOOK);
            link.ask::<_, Acknowledged>(WorkerVerb::Fail, &bye, &[])
        };
        while link.link().zid() == first {
            assert!(matches!(ask(), Err(NoAnswer::Silence)));
            assert!(begun.elapsed() < 20 * DEAF, "it is the same link still");
        }
        assert!(begun.elapsed() >= DEAF, "{:?}", begun.elapsed());
        // One that was answered a moment ago stays, also when it was up for long.
        let key = keys::worker_rpc(&link.coordinator, &link.worker, WorkerVerb::Fail);
        let answer = pool::answer(&Acknowledged, &[]).expect("an answer");
        let answering = router.declare_queryable(&key).callback(move |query| {
            query.reply(query.key_expr().clone(), answer.clone()).wait().expect("it answers");
        });
        let answering = answering.wait().expect("somebody answers");
        let second = link.link().zid();
        std::thread::sleep(DEAF);
        ask().expect("an answer");
        answering.undeclare().wait().expect("nobody answers any more");
        assert!(matches!(ask(), Err(NoAnswer::Silence)));
        std::thread::sleep(5 * LOOK);
        assert_eq!(link.link().zid(), second);
    }
}
