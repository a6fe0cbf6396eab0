//! One coordinator of a name on a network: each shows a sign of life, looks for those of others,
//! and asks those that it finds whether they live and who stays ([`Claim::stays_beside`]).
//!
//! A sign of life alone refuses nobody: that of a process that was killed may be seen until its
//! link is given up. One that stays seen, and never answers, does.
//!
//! [`ElectionState`] decides and does no I/O. A thread keeps it, so that nothing waits in a
//! callback.

mod state;

pub use state::Conflict;
use state::{AGAIN, ElectionState};

use super::error::LinkError;
use cullet_proto::claim::{Claim, MAX_HOST, Reply};
use cullet_proto::transport::{Patience, plain};
use cullet_proto::{SessionId, WorkerId, keys, pool};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zenoh::Wait;
use zenoh::qos::Priority;
use zenoh::query::{ConsolidationMode, Query};
use zenoh::sample::SampleKind;

/// Longest first look at who is there; a router without a rule for it answers nothing.
const LOOK: Duration = Duration::from_secs(1);
/// A question to another is given up after this.
const ASK: Duration = Duration::from_secs(1);
/// Beyond the time after which a silent link is given up, so long does one that begins wait for an
/// answer of whoever's sign of life is seen.
const SLACK: Duration = Duration::from_secs(2);
/// Inputs that may wait; what is lost beyond it is asked again.
const QUEUE: usize = 256;

/// How it stands.
#[derive(Debug, Default)]
struct Shared {
    /// Whether this one is to serve, and whether it has to leave.
    state: Mutex<(bool, Option<Conflict>)>,
    changed: Condvar,
}

/// An input of the election's thread.
enum ElectionInput {
    Sign(SessionId, bool),
    Question(Query),
    Reply(Reply),
    Looked,
    Quit,
}

/// A claim to a name, upheld until it is dropped.
pub(super) struct Standing {
    inputs: SyncSender<ElectionInput>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What tells whether a coordinator has to leave.
#[derive(Clone, Debug, Default)]
pub(super) struct Announcement(Arc<Shared>);

impl Announcement {
    /// Beside whom it does not stay, if there is such a one.
    pub(super) fn conflict(&self) -> Option<Conflict> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner).1.clone()
    }
}

impl Standing {
    /// Claims a name, and waits until it is clear whether this one stays. If it has to leave later,
    /// `leave` is called until it says that this was heard.
    pub(super) fn take(
        session: &zenoh::Session,
        coordinator: &WorkerId,
        patience: Patience,
        leave: impl Fn() -> bool + Send + 'static,
    ) -> Result<Self, LinkError> {
        let failed = |error: zenoh::Error| LinkError::Listen {
            endpoint: keys::claims(coordinator),
            text: plain(&error.to_string()),
        };
        let own = own();
        let (inputs, queue) = sync_channel(QUEUE);
        let shared = Arc::<Shared>::default();
        // Who is seen can be asked: first it answers, then it shows itself, then it looks.
        let questions = inputs.clone();
        let queryable = session
            .declare_queryable(keys::claim(coordinator, own.life))
            .callback(move |query| drop(questions.try_send(ElectionInput::Question(query))))
            .wait()
            .map_err(failed)?;
        let sign = keys::coordinator_live(coordinator, own.life);
        let sign = session.liveliness().declare_token(sign).wait().map_err(failed)?;
        let signs = inputs.clone();
        let watch = session
            .liveliness()
            .declare_subscriber(keys::coordinators_live(coordinator))
            .history(true)
            .callback(move |sample| {
                let life = keys::parse_coordinator_live(sample.key_expr().as_str());
                let up = sample.kind() == SampleKind::Put;
                if let Some(life) = life {
                    drop(signs.try_send(ElectionInput::Sign(life, up)));
                }
            })
            .wait()
            .map_err(failed)?;
        let closing = patience.lease_ms + patience.wait_before_close_ms;
        let closing = Duration::from_millis(closing) + SLACK;
        let election = ElectionState::new(coordinator.to_string(), own, closing);
        let line = ElectionSession { session: session.clone(), name: coordinator.clone(), inputs };
        let (inputs, told) = (line.inputs.clone(), Arc::clone(&shared));
        let looks = line.clone();
        let thread = std::thread::Builder::new()
            .name("cullet-claim".into())
            .spawn(move || {
                uphold(election, &line, &queue, &told, leave);
                drop((queryable, sign, watch));
            })
            .map_err(LinkError::Thread)?;
        let standing = Self { inputs, shared, thread: Some(thread) };
        looks.look().map_err(failed)?;
        standing.clear()?;
        Ok(standing)
    }

    /// Waits until it is to serve.
    fn clear(&self) -> Result<(), LinkError> {
        let state = self.shared.state.lock().unwrap_or_else(PoisonError::into_inner);
        let open = |state: &mut (bool, Option<Conflict>)| !state.0 && state.1.is_none();
        let state = self.shared.changed.wait_while(state, open);
        match &state.unwrap_or_else(PoisonError::into_inner).1 {
            Some(conflict) => Err(LinkError::Conflict(conflict.clone())),
            None => Ok(()),
        }
    }

    pub(super) fn announcement(&self) -> Announcement {
        Announcement(Arc::clone(&self.shared))
    }
}

impl Drop for Standing {
    fn drop(&mut self) {
        let _ended = self.inputs.send(ElectionInput::Quit);
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

/// What this life says of itself.
fn own() -> Claim {
    use std::hash::{BuildHasher, Hasher, RandomState};
    let since_ms = cullet_files::clock::unix_ms();
    let process = std::process::id();
    let mut hasher = RandomState::new().build_hasher();
    hasher.write_u64(since_ms ^ u64::from(process) << 40);
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host: String = host.trim().chars().filter(char::is_ascii_graphic).take(MAX_HOST).collect();
    let version = env!("CARGO_PKG_VERSION").to_owned();
    let life = SessionId(hasher.finish());
    Claim { life, since_ms, settled: false, process, host, version }
}

/// The session on which other coordinators are asked.
#[derive(Clone)]
struct ElectionSession {
    session: zenoh::Session,
    name: WorkerId,
    inputs: SyncSender<ElectionInput>,
}

impl ElectionSession {
    /// Whoever shows a sign of life now is known before [`ElectionInput::Looked`].
    fn look(&self) -> Result<(), zenoh::Error> {
        let key = keys::coordinators_live(&self.name);
        let found = self.session.liveliness().get(key).timeout(LOOK).wait()?;
        while let Ok(reply) = found.recv() {
            let Ok(sample) = reply.into_result() else { continue };
            if let Some(life) = keys::parse_coordinator_live(sample.key_expr().as_str()) {
                let _ended = self.inputs.send(ElectionInput::Sign(life, true));
            }
        }
        let _ended = self.inputs.send(ElectionInput::Looked);
        Ok(())
    }

    fn ask(&self, life: SessionId, own: &Claim) {
        let Ok(bytes) = pool::ask(own, &[]) else { return };
        let inputs = self.inputs.clone();
        let asked = self
            .session
            .get(keys::claim(&self.name, life))
            .payload(bytes)
            .consolidation(ConsolidationMode::None)
            .priority(Priority::InteractiveHigh)
            .timeout(ASK)
            .callback(move |reply| {
                let Ok(sample) = reply.into_result() else { return };
                let bytes = sample.payload().to_bytes();
                if let Ok((reply, _)) = pool::read_answer::<Reply>(&bytes)
                    && reply.claim.check().is_ok()
                    && reply.claim.life == life
                {
                    let _full = inputs.try_send(ElectionInput::Reply(reply));
                }
            })
            .wait();
        if let Err(error) = asked {
            tracing::debug!("another coordinator is not asked: {error}");
        }
    }
}

/// Keeps the state until asked to quit.
fn uphold(
    mut election: ElectionState,
    line: &ElectionSession,
    queue: &Receiver<ElectionInput>,
    shared: &Shared,
    leave: impl Fn() -> bool,
) {
    let mut heard = false;
    loop {
        let wait = AGAIN[usize::from(election.own.settled)];
        let mut next = match queue.recv_timeout(wait) {
            Ok(input) => Some(input),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        while let Some(input) = next {
            match input {
                ElectionInput::Sign(life, up) => election.sign(life, up, Instant::now()),
                ElectionInput::Question(query) => answer(&mut election, &query),
                ElectionInput::Reply(reply) => election.take_reply(reply),
                ElectionInput::Looked => election.looked = true,
                ElectionInput::Quit => return,
            }
            next = queue.try_recv().ok();
        }
        for life in election.tick(Instant::now()) {
            line.ask(life, &election.own);
        }
        let mut state = shared.state.lock().unwrap_or_else(PoisonError::into_inner);
        let news = (election.own.settled, election.lost.clone());
        if *state != news {
            *state = news;
            shared.changed.notify_all();
        }
        drop(state);
        if !heard && election.lost.as_ref().is_some_and(|conflict| conflict.late) {
            heard = leave();
        }
    }
}

fn answer(election: &mut ElectionState, query: &Query) {
    let bytes = query.payload().map(|payload| payload.to_bytes().into_owned());
    let Ok((theirs, _)) = pool::read_ask::<Claim>(&bytes.unwrap_or_default()) else { return };
    if theirs.check().is_err() || theirs.life == election.own.life {
        return;
    }
    if let Ok(bytes) = pool::answer(&election.asked(&theirs), &[]) {
        super::bulk::reply(query, bytes);
    }
}
