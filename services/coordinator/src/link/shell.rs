//! The thread that owns the pool: hears, steps the machine, does what it says.

use super::bulk::{Bulk, reply};
use super::cache::Cache;
use super::children::Children;
use super::inbox::Inbox;
use super::ledger::{Ledger, Wanted};
use super::net::Net;
use super::quarantine;
use super::roster::Roster;
use super::{Ending, LinkError, PoolConfig, PoolStats, RunStats, Settlement};
use cullet_dispatch::{Bound, Digest, Dispatch, Effect, Event, Job, Loss, Millis, Outcome, Prior};
use cullet_dispatch::{Reason, Receipt, Run, Share, Timing, Verdict as Decision, Worker};
use cullet_proto::pool::{self, Grant, OVERDUE, PollAnswer, RenewAnswer};
use cullet_proto::{Epoch, JobId, SessionId, Verdict, WorkerId};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use zenoh::query::Query;

/// Inputs that may wait. Each is a message of at most 1 MiB and a bit; beyond it questions are
/// dropped, and asked again.
pub(super) const QUEUE: usize = 512;
/// Inputs taken in one go before the clock is looked at.
const BATCH: usize = 256;
/// Names of workers kept; beyond it those whose link is down are forgotten.
const MAX_NAMES: usize = 4_096;
/// How often the clock is looked at: a small part of the shortest time in a test's profile.
const TICK: Duration = Duration::from_millis(25);

/// Something for the thread to take in.
#[derive(Debug)]
pub(super) enum Input {
    /// A question from a worker or client.
    Question(Query),
    /// A sign of life came or went.
    Link { session: SessionId, up: bool },
    /// A run begins: its settlements go there.
    Begin(Run, Share, Listener),
    /// A run wants a job: its encoding, or why it has none.
    Open(Run, JobId, Result<Vec<u8>, String>),
    /// Something about a run, or a wish about a worker.
    Say(Event),
    /// The worker of that name gets no further job.
    Drain(WorkerId),
    /// The end.
    Quit,
}

/// Who hears of a run.
#[derive(Debug)]
pub(super) struct Listener {
    pub(super) settle: Sender<(JobId, Settlement)>,
    pub(super) stats: Arc<Mutex<RunStats>>,
    pub(super) over: bool,
    /// Sum of how far the jobs at work are \[1/1000\].
    pub(super) permille: i64,
}

/// What a step of the machine said to whom it listened to.
#[derive(Debug, Default)]
pub(super) struct Said {
    pub(super) renew: Option<RenewAnswer>,
    pub(super) receipt: Option<Receipt>,
    pub(super) grant: Option<Grant>,
}

pub(super) struct Shell {
    pub(super) dispatch: Dispatch,
    pub(super) timing: Timing,
    pub(super) inbox: Inbox,
    pub(super) bulk: Bulk,
    pub(super) polls: BTreeMap<Worker, (u64, Query)>,
    pub(super) refusals: u64,
    pub(super) roster: Roster,
    names: BTreeMap<Worker, WorkerId>,
    up: BTreeSet<SessionId>,
    pub(super) ledger: Ledger,
    pub(super) cache: Cache,
    quarantine: Option<PathBuf>,
    children: Option<Children>,
    net: Net,
    runs: BTreeMap<Run, Listener>,
    settled: Vec<(Run, JobId, Settlement)>,
    stats: Arc<Mutex<PoolStats>>,
    pids: Arc<Mutex<Vec<u32>>>,
    start: Instant,
}

impl Shell {
    pub(super) fn new(config: &PoolConfig, net: Net) -> Result<Self, LinkError> {
        let spawn = config.spawn.clone();
        let children = spawn.map(|spawn| Children::start(spawn, net.endpoint())).transpose()?;
        let pids = children.as_ref().map(Children::pids).unwrap_or_default();
        Ok(Self {
            dispatch: Dispatch::new(config.timing, config.incarnation.unwrap_or_else(drawn)),
            timing: config.timing,
            inbox: Inbox::default(),
            bulk: Bulk::start()?,
            polls: BTreeMap::new(),
            refusals: 0,
            roster: Roster::default(),
            names: BTreeMap::new(),
            up: BTreeSet::new(),
            ledger: Ledger::default(),
            cache: Cache::open(&config.cache),
            quarantine: config.quarantine.clone(),
            children,
            net,
            runs: BTreeMap::new(),
            settled: Vec::new(),
            stats: Arc::default(),
            pids: Arc::new(Mutex::new(pids)),
            start: Instant::now(),
        })
    }

    pub(super) fn stats_handle(&self) -> Arc<Mutex<PoolStats>> {
        Arc::clone(&self.stats)
    }

    pub(super) fn pids_handle(&self) -> Arc<Mutex<Vec<u32>>> {
        Arc::clone(&self.pids)
    }

    /// Until told to quit.
    pub(super) fn run(mut self, queue: &Receiver<Input>) {
        let mut ticked = Instant::now();
        'life: loop {
            match queue.recv_timeout(TICK) {
                Ok(Input::Quit) | Err(RecvTimeoutError::Disconnected) => break,
                Ok(input) => self.take(input),
                Err(RecvTimeoutError::Timeout) => {}
            }
            for input in queue.try_iter().take(BATCH) {
                if let Input::Quit = input {
                    break 'life;
                }
                self.take(input);
            }
            if ticked.elapsed() >= TICK {
                ticked = Instant::now();
                self.tick();
            }
            self.publish();
            self.roster.publish(&self.up);
            for (run, id, settlement) in self.settled.drain(..) {
                // One that nobody listens for is of a run whose handle is gone.
                if let Some(listener) = self.runs.get(&run) {
                    let _closed = listener.settle.send((id, settlement));
                }
            }
            self.runs.retain(|_, listener| !listener.over);
        }
        self.children = None;
        self.polls.clear();
        drop(self.bulk);
        self.net.close();
    }

    fn take(&mut self, input: Input) {
        match input {
            Input::Question(query) => self.question(query),
            Input::Link { session, up: true } => {
                self.up.insert(session);
                self.roster.changed();
            }
            Input::Link { session, up: false } => {
                self.up.remove(&session);
                self.roster.changed();
                let worker = Worker(session.0);
                self.polls.remove(&worker);
                self.step(Event::Suspect(worker));
            }
            Input::Begin(run, share, listener) => {
                self.runs.insert(run, listener);
                self.step(Event::Begin { run, share });
            }
            Input::Open(run, id, bytes) => self.open(run, id, bytes),
            Input::Say(event) => self.say(event),
            Input::Drain(name) => {
                for worker in self.named(name.as_str()) {
                    self.step(Event::Drain(worker));
                }
            }
            Input::Quit => {}
        }
    }

    fn tick(&mut self) {
        for name in self.children.as_mut().map(Children::tend).unwrap_or_default() {
            for worker in self.named(&name) {
                self.polls.remove(&worker);
                self.names.remove(&worker);
                self.roster.gone(worker);
                self.step(Event::Down(worker));
            }
        }
        self.forsake();
        self.step(Event::Tick);
        self.inbox.sweep();
    }

    /// The lives of workers of that name.
    fn named(&self, name: &str) -> Vec<Worker> {
        let known = self.names.iter().filter(|(_, known)| known.as_str() == name);
        known.map(|(worker, _)| *worker).collect()
    }

    fn say(&mut self, event: Event) {
        self.step(event);
        if let Event::End(run) = event
            && let Some(listener) = self.runs.get_mut(&run)
        {
            listener.over = true;
        }
    }

    /// Gives every job up if no worker of ours comes to life and nobody else is there.
    fn forsake(&mut self) {
        let Some(text) = self.children.as_ref().and_then(Children::hopeless) else {
            return;
        };
        if self.up.is_empty() && !self.ledger.is_empty() {
            self.ledger.trouble_all(&text);
            self.step(Event::Forsaken);
        }
    }

    fn publish(&self) {
        let counts = self.dispatch.counts();
        let children = self.children.as_ref();
        let pids = children.map(Children::pids).unwrap_or_default();
        for (run, listener) in &self.runs {
            if let Some(counts) = self.dispatch.counts_of(*run) {
                *listener.stats.lock().unwrap_or_else(PoisonError::into_inner) =
                    RunStats::of(&counts, listener.permille);
            }
        }
        let stats = PoolStats {
            opened: counts.opened,
            settled: counts.settled,
            refused: counts.refused,
            failed: counts.failed,
            abandoned: counts.abandoned,
            resent: counts.resent,
            waiting: counts.waiting,
            running: counts.running,
            workers: self.up.len() as u64,
            respawned: children.map_or(0, |c| c.respawned),
            alarms: counts.alarms,
            quarantined: counts.quarantined,
            hedged: counts.hedged,
            cached: self.cache.hits,
            damaged: self.inbox.damaged,
            refusals: self.refusals,
            children: pids.len() as u64,
        };
        *self.stats.lock().unwrap_or_else(PoisonError::into_inner) = stats;
        *self.pids.lock().unwrap_or_else(PoisonError::into_inner) = pids;
    }

    fn open(&mut self, run: Run, id: JobId, bytes: Result<Vec<u8>, String>) {
        let job = Job(id.0);
        let prior = match bytes {
            Ok(bytes) => {
                self.ledger.open(run, id, bytes, String::new());
                self.known(id).unwrap_or(Prior::Nothing)
            }
            Err(text) => {
                self.ledger.open(run, id, Vec::new(), text);
                Prior::Unfit
            }
        };
        self.step(Event::Open { run, job, prior });
    }

    /// What the cache says of a job that is opened.
    fn known(&mut self, id: JobId) -> Option<Prior> {
        let bytes = self.cache.get(id)?;
        let verdict = Verdict::decode(&bytes).ok()?;
        let outcome = outcome_of(&verdict);
        self.ledger.keep(id, verdict);
        let digest = Digest(cullet_proto::ids::digest(&bytes));
        Some(Prior::Result { digest, outcome })
    }

    /// A worker says how far it is.
    pub(super) fn progress(&mut self, id: JobId, permille: u16) {
        for (run, gain) in self.ledger.progress(id, permille.min(1000)) {
            if let Some(listener) = self.runs.get_mut(&run) {
                listener.permille += gain;
            }
        }
    }

    pub(super) fn know(&mut self, worker: Worker, name: &WorkerId) {
        self.names.entry(worker).or_insert_with(|| name.clone());
        if let Some(children) = &mut self.children {
            children.alive(name.as_str());
        }
        if self.names.len() > MAX_NAMES {
            self.names.retain(|known, _| *known == worker || self.up.contains(&SessionId(known.0)));
        }
    }

    fn now(&self) -> Millis {
        self.start.elapsed().as_millis() as Millis
    }

    pub(super) fn step(&mut self, event: Event) -> Said {
        let now = self.now();
        let mut said = Said::default();
        for effect in self.dispatch.step(now, event) {
            self.act(effect, &mut said);
        }
        said
    }

    fn act(&mut self, effect: Effect, said: &mut Said) {
        match effect {
            Effect::Grant { worker, seq, job, epoch, lease, hard } => {
                let length = self.ledger.get(job).map_or(0, |w| w.bytes.len() as u64);
                let grant = Grant {
                    job: JobId(job.0),
                    epoch: Epoch(epoch.0),
                    length,
                    lease_ms: lease,
                    renew_ms: self.timing.renew,
                    hard_ms: hard,
                };
                self.roster.took(worker, JobId(job.0));
                if !self.answer_poll(worker, seq, PollAnswer::Grant(grant)) {
                    said.grant = Some(grant);
                }
            }
            Effect::Idle { worker, seq } => {
                self.answer_poll(worker, seq, PollAnswer::Idle);
            }
            Effect::Park { .. } => {}
            Effect::Renewed { lease, .. } => said.renew = Some(RenewAnswer::Go { lease_ms: lease }),
            Effect::Stop { .. } => said.renew = Some(RenewAnswer::Stop),
            Effect::Taken { receipt, .. } => said.receipt = Some(receipt),
            Effect::Dismiss { worker, seq } => {
                self.answer_poll(worker, seq, PollAnswer::Drain);
            }
            Effect::Drained { worker } => {
                let name = self.names.get(&worker).map_or_else(String::new, WorkerId::to_string);
                self.roster.drained(worker);
                tracing::warn!("worker {name} gets no further job");
            }
            Effect::Lost { job, worker, loss, .. } => self.lost(job, worker, loss),
            Effect::Busy { run, job, bound } => self.turn_down(run, job, bound),
            Effect::Quarantine { job, crashes } => self.isolate(job, crashes),
            Effect::Stall { job, reason, attempts } => {
                let id = JobId(job.0).short();
                tracing::error!("job {id} is abandoned after {attempts} attempts: {reason:?}");
            }
            Effect::Alarm { job, kept, other } => alarm(job, kept, other),
            Effect::Settle { run, job, verdict, attempts, .. } => {
                self.settle(run, job, verdict, attempts);
            }
        }
    }

    fn answer_poll(&mut self, worker: Worker, seq: u64, answer: PollAnswer) -> bool {
        if self.polls.get(&worker).is_none_or(|(asked, _)| *asked != seq) {
            return false;
        }
        if let Some((_, query)) = self.polls.remove(&worker)
            && let Ok(bytes) = pool::answer(&answer, &[])
        {
            reply(&query, bytes);
        }
        true
    }

    fn lost(&mut self, job: Job, worker: Worker, loss: Loss) {
        self.roster.left(worker, JobId(job.0));
        let name = self.names.get(&worker).map_or("of unknown name", WorkerId::as_str);
        let line = format!("worker {name}: {loss:?}");
        tracing::warn!("an attempt at job {} is lost: {line}", JobId(job.0).short());
        if loss == Loss::TooLong {
            self.ledger.note_trouble(JobId(job.0), OVERDUE);
        }
        self.ledger.note_attempt(job, &line);
    }

    /// Keeps what reproduces a job that killed its workers.
    fn isolate(&self, job: Job, crashes: u32) {
        let id = JobId(job.0);
        tracing::error!("job {} is put in quarantine: {crashes} attempts died", id.short());
        let (Some(folder), Some(wanted)) = (&self.quarantine, self.ledger.get(job)) else {
            return;
        };
        match quarantine::write(folder, id, &wanted.bytes, &wanted.attempts) {
            Ok(bundle) => tracing::error!("what reproduces it is in {}", bundle.display()),
            Err(error) => tracing::error!("what reproduces it is not kept: {error}"),
        }
    }

    fn settle(&mut self, run: Run, job: Job, decision: Decision, attempts: u32) {
        let Some((wanted, opened)) = self.close(run, job) else {
            return;
        };
        let cached = matches!(decision, Decision::Done { worker: None, .. });
        let (ending, worker) = match (decision, wanted.result) {
            (Decision::Done { worker, .. }, Some(verdict)) => {
                worker.into_iter().for_each(|worker| self.roster.done(worker));
                let name = worker.and_then(|worker| self.names.get(&worker));
                (Ending::Verdict(verdict), name.map(WorkerId::to_string).unwrap_or_default())
            }
            (Decision::Done { .. }, None) => {
                (Ending::Abandoned("its result was lost here".into()), String::new())
            }
            (Decision::Abandoned(reason), _) => {
                (Ending::Abandoned(words(reason, attempts, &wanted.trouble)), String::new())
            }
            (Decision::Cancelled, _) => (Ending::Cancelled, String::new()),
        };
        let settlement = Settlement { ending, attempts, worker, cached, wall: opened.elapsed() };
        // Sent once the counts that go with it can be read.
        self.settled.push((run, JobId(job.0), settlement));
    }

    fn close(&mut self, run: Run, job: Job) -> Option<(Wanted, Instant)> {
        let (wanted, opened) = self.ledger.close(run, job)?;
        if let Some(listener) = self.runs.get_mut(&run)
            && !wanted.openings.contains_key(&run)
        {
            listener.permille -= i64::from(wanted.permille);
        }
        Some((wanted, opened))
    }

    /// An opening that the machine did not take ends here.
    fn turn_down(&mut self, run: Run, job: Job, bound: Bound) {
        let text = match bound {
            Bound::Run => "the run has too many jobs open",
            Bound::Pool => "the pool has too many jobs open",
            Bound::NoRun => "the run is over",
        };
        if let Some((_, opened)) = self.close(run, job) {
            let (ending, worker) = (Ending::Abandoned(text.into()), String::new());
            let wall = opened.elapsed();
            let settlement = Settlement { ending, attempts: 0, worker, cached: false, wall };
            self.settled.push((run, JobId(job.0), settlement));
        }
    }
}

pub(super) fn outcome_of(verdict: &Verdict) -> Outcome {
    match verdict {
        Verdict::Broken(_) | Verdict::Measured(_) => Outcome::Broken,
        Verdict::Refused { .. } => Outcome::Refused,
        Verdict::Failed { .. } => Outcome::Failed,
    }
}

fn alarm(job: Job, kept: Digest, other: Digest) {
    let (job, kept, other) = (JobId(job.0).short(), JobId(kept.0), JobId(other.0));
    tracing::error!("job {job} is not deterministic: results {kept} and {other}");
}

fn words(reason: Reason, attempts: u32, trouble: &str) -> String {
    let what = match reason {
        Reason::Crashes => "too many workers ended under it",
        Reason::Attempts => "too many attempts",
        Reason::Invalid => "it cannot be read",
        Reason::Forsaken => "no worker is left",
    };
    let colon = if trouble.is_empty() { "" } else { ": " };
    format!("{what} ({attempts} attempts){colon}{trouble}")
}

/// For a coordinator without a journal: differs between its lives, but for one chance in 2³².
fn drawn() -> u32 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let seconds = since.map_or(0, |since| since.as_millis() as u64);
    cullet_geometry::math::scramble(seconds ^ u64::from(std::process::id()) << 40) as u32
}
