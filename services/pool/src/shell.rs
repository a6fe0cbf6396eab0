//! The thread that owns the pool: hears, steps the machine, does what it says.

use super::at_work::AtWork;
use super::bulk::Bulk;
use super::cache::Cache;
use super::children::Children;
use super::config::PoolConfig;
use super::drained::DrainedLives;
use super::error::LinkError;
use super::inbox::Inbox;
use super::input::{Listener, PoolInput};
use super::ledger::Ledger;
use super::lives::LiveWorkers;
use super::net::Transport;
use super::quarantine;
use super::roster::Roster;
use super::session_names::SessionNames;
use super::settlement::Settlement;
use super::skill_table::SkillTable;
use super::stats::{PoolStats, Refusals, RunStats};
use super::waiting::WaitingQuestions;
use cullet_dispatch::{
    Claimant, Dispatch, Event, Job, Millis, Receipt, Run, Skills, Timing, Worker,
};
use cullet_proto::pool::{Grant, RenewAnswer};
use cullet_proto::service::WorkerInfo;
use cullet_proto::{JobId, SessionId};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Inputs that may wait. Each is a message of at most 1 MiB and a bit; beyond it questions are
/// dropped, and asked again.
pub(super) const QUEUE: usize = 512;
/// Inputs taken in one go before the clock is looked at.
const BATCH: usize = 256;
/// How often the clock is looked at: a small part of the shortest time in a test's profile.
const TICK: Duration = Duration::from_millis(25);

/// What a step of the machine answers to the question that it was about.
#[derive(Debug, Default)]
pub(super) struct StepAnswers {
    pub(super) renew: Option<RenewAnswer>,
    pub(super) receipt: Option<Receipt>,
    pub(super) grant: Option<Grant>,
}

/// The workers that are known: what each is, can do, is called, and whether its link is up.
pub(super) struct KnownWorkers {
    pub(super) roster: Roster,
    pub(super) skill_table: SkillTable,
    pub(super) names: SessionNames,
    pub(super) lives: LiveWorkers,
}

/// The runs that want jobs, and what is to be said to them.
pub(super) struct OpenRuns {
    pub(super) listeners: BTreeMap<Run, Listener>,
    /// Openings that had to wait for room.
    pub(super) queued: u64,
    /// Openings of a run that may wait.
    pub(super) most: usize,
    pub(super) settled: Vec<(Run, JobId, Settlement)>,
}

/// What is kept of jobs and workers, by which a next life goes on.
pub(super) struct KeptState {
    pub(super) cache: Cache,
    pub(super) quarantine: Option<PathBuf>,
    pub(super) at_work: Option<AtWork>,
    pub(super) drained: Option<DrainedLives>,
}

/// What comes and goes in pieces, and how much of it was refused or sent.
pub(super) struct Transfers {
    pub(super) inbox: Inbox,
    pub(super) bulk: Bulk,
    pub(super) refusals: Refusals,
    /// Bytes of meshes sent to workers.
    pub(super) mesh_bytes: u64,
}

/// What others see of the pool.
#[derive(Debug, Default)]
struct Published {
    stats: Arc<Mutex<PoolStats>>,
    pids: Arc<Mutex<Vec<u32>>>,
}

/// The pool, as its thread owns it.
pub(super) struct Shell {
    pub(super) dispatch: Dispatch,
    pub(super) timing: Timing,
    pub(super) waiting: WaitingQuestions,
    pub(super) transfers: Transfers,
    pub(super) workers: KnownWorkers,
    pub(super) ledger: Ledger,
    pub(super) kept: KeptState,
    pub(super) children: Option<Children>,
    net: Transport,
    pub(super) runs: OpenRuns,
    published: Published,
    start: Instant,
}

impl Shell {
    pub(super) fn new(config: &PoolConfig, net: Transport) -> Result<Self, LinkError> {
        let spawn = config.spawn.clone();
        let children = spawn.map(|spawn| Children::start(spawn, net.endpoint())).transpose()?;
        let pids = children.as_ref().map(Children::pids).unwrap_or_default();
        // As long as the link of one that was killed may be seen.
        let closing = config.patience.lease_ms + config.patience.wait_before_close_ms;
        let incarnation = config.incarnation.unwrap_or_else(drawn);
        let mut dispatch = Dispatch::new(config.timing, incarnation);
        for job in held(config.quarantine.as_deref()) {
            dispatch.step(0, Event::Isolate(Job(job.0)));
        }
        let drained = config.drained.as_deref().map(DrainedLives::open);
        for worker in drained.iter().flat_map(DrainedLives::iter) {
            dispatch.step(0, Event::Bar(worker));
        }
        let cache = Cache::open(&config.cache);
        let at_work = config.at_work.as_deref().map(|path| inherited(&mut dispatch, path, &cache));
        Ok(Self {
            dispatch,
            timing: config.timing,
            waiting: WaitingQuestions::default(),
            transfers: Transfers {
                inbox: Inbox::default(),
                bulk: Bulk::start()?,
                refusals: Refusals::default(),
                mesh_bytes: 0,
            },
            workers: KnownWorkers {
                roster: Roster::default(),
                skill_table: SkillTable::default(),
                names: SessionNames::default(),
                lives: LiveWorkers::new(Duration::from_millis(closing)),
            },
            ledger: Ledger::default(),
            kept: KeptState { cache, quarantine: config.quarantine.clone(), at_work, drained },
            children,
            net,
            runs: OpenRuns {
                listeners: BTreeMap::new(),
                queued: 0,
                most: config.held,
                settled: Vec::new(),
            },
            published: Published { stats: Arc::default(), pids: Arc::new(Mutex::new(pids)) },
            start: Instant::now(),
        })
    }

    pub(super) fn stats_handle(&self) -> Arc<Mutex<PoolStats>> {
        Arc::clone(&self.published.stats)
    }

    pub(super) fn pids_handle(&self) -> Arc<Mutex<Vec<u32>>> {
        Arc::clone(&self.published.pids)
    }

    pub(super) fn workers_handle(&self) -> Arc<Mutex<Vec<WorkerInfo>>> {
        self.workers.roster.handle()
    }

    /// Until asked to quit.
    pub(super) fn run(mut self, queue: &Receiver<PoolInput>) {
        let mut ticked = Instant::now();
        'life: loop {
            match queue.recv_timeout(TICK) {
                Ok(PoolInput::Quit) | Err(RecvTimeoutError::Disconnected) => break,
                Ok(input) => self.take(input),
                Err(RecvTimeoutError::Timeout) => {}
            }
            for input in queue.try_iter().take(BATCH) {
                if let PoolInput::Quit = input {
                    break 'life;
                }
                self.take(input);
            }
            if ticked.elapsed() >= TICK {
                ticked = Instant::now();
                self.tick();
            }
            self.open_held();
            self.workers.roster.publish(&self.workers.lives);
            self.publish();
            for (run, id, settlement) in self.runs.settled.drain(..) {
                // One that nobody listens for is of a run whose handle is gone.
                if let Some(listener) = self.runs.listeners.get(&run) {
                    let _closed = listener.settle.send((id, settlement));
                }
            }
            self.runs.listeners.retain(|_, listener| !listener.over);
        }
        self.children = None;
        self.waiting.clear();
        drop(self.transfers.bulk);
        self.net.close();
    }

    fn take(&mut self, input: PoolInput) {
        match input {
            PoolInput::Question(query) => self.question(query),
            // A sign of life says no more of another's session than a question does.
            PoolInput::Link { name, session, .. }
                if self.workers.names.check(Worker(session.0), &name).is_err() =>
            {
                tracing::warn!(worker = %name, "a sign of life for a session of another name");
            }
            PoolInput::Link { name, session, up } => {
                self.workers.lives.sign(name, session, up, Instant::now());
                self.workers.roster.changed();
                if up {
                    return;
                }
                let worker = Worker(session.0);
                self.waiting.forget(worker);
                self.step(Event::Suspect(worker));
            }
            PoolInput::Begin(run, share, listener) => {
                self.runs.listeners.insert(run, listener);
                self.step(Event::Begin { run, share });
            }
            PoolInput::Open(run, id, opening) => self.want(run, id, opening),
            PoolInput::Say(event) => self.hear(event),
            PoolInput::Claimants(runs) => {
                for claimant in
                    self.dispatch.claimants().into_iter().filter(|of| !runs.contains(&of.0))
                {
                    self.hear(Event::Release(claimant));
                }
            }
            PoolInput::Drain(name, done) => {
                for worker in self.workers.names.of(name.as_str()) {
                    self.step(Event::Drain(worker));
                }
                let _gone = done.send(());
            }
            PoolInput::Leave => {
                // Workers that asked here ask again, and the other answers.
                self.net.stop_answering();
                self.waiting.clear();
            }
            PoolInput::Quit => {}
        }
    }

    fn tick(&mut self) {
        for name in self.children.as_mut().map(Children::tend).unwrap_or_default() {
            // Of several that are called so it is none whose link is up: where that one's still is,
            // the link says so itself.
            let named = self.workers.names.of(&name);
            let alone = named.len() == 1;
            for worker in named {
                if !alone && self.workers.lives.up.contains(&SessionId(worker.0)) {
                    continue;
                }
                self.waiting.forget(worker);
                self.workers.skill_table.gone(worker);
                self.workers.roster.gone(worker);
                self.step(Event::Down(worker));
                // What is logged of its jobs has its name.
                self.workers.names.forget(worker);
            }
        }
        self.forsake();
        self.step(Event::Tick);
        self.waiting.answer_old_watches(Duration::from_millis(self.timing.park));
        self.report_duplicate_names();
        self.workers.skill_table.report(self.dispatch.unschedulable());
        self.transfers.inbox.sweep();
    }

    /// Logs, once, that several workers have one name, and that they do not any more.
    fn report_duplicate_names(&mut self) {
        for (name, lives) in self.workers.lives.tick(Instant::now()) {
            self.workers.roster.changed();
            let count = lives.len();
            let sessions: Vec<String> = lives.iter().map(ToString::to_string).collect();
            let sessions = sessions.join(" ");
            match count {
                0 => tracing::info!(worker = %name, "its name is its own again"),
                _ => tracing::warn!(
                    worker = %name,
                    sessions,
                    "{count} workers are called {name}: lists, logs and timelines do not tell \
                     them apart, and one word drains them all; give each a --name of its own"
                ),
            }
        }
    }

    pub(super) fn hear(&mut self, event: Event) {
        self.step(event);
        match event {
            Event::Cancel(run) => {
                self.cancel_held(run);
                self.hear(Event::Release(Claimant(self.label(run))));
            }
            Event::End(run) => {
                if let Some(listener) = self.runs.listeners.get_mut(&run) {
                    listener.over = true;
                    listener.held.clear();
                }
                self.hear(Event::Release(Claimant(self.label(run))));
            }
            Event::Release(_) => self.renew_watches(),
            Event::Pardon(job) => self.pardon(JobId(job.0)),
            _ => {}
        }
    }

    /// Gives every job up if no worker of ours comes to life and nobody else is there.
    fn forsake(&mut self) {
        let Some(text) = self.children.as_ref().and_then(Children::hopeless) else {
            return;
        };
        if self.workers.lives.up.is_empty() && !self.ledger.is_empty() {
            self.ledger.trouble_all(&text);
            self.step(Event::Forsaken);
        }
    }

    fn publish(&self) {
        let counts = self.dispatch.counts();
        let children = self.children.as_ref();
        let pids = children.map(Children::pids).unwrap_or_default();
        let (mut held, mut permille) = (0, 0);
        let (workers, ready) = (self.workers.roster.there(), self.workers.roster.ready());
        let unschedulable: Vec<Skills> =
            self.dispatch.unschedulable().map(|(need, _)| need).collect();
        for (run, listener) in &self.runs.listeners {
            held += listener.held.len() as u64;
            permille += listener.permille;
            if let Some(counts) = self.dispatch.counts_of(*run) {
                let stats = RunStats::of(&counts, listener.held.len() as u64, listener.permille);
                let lacks = unschedulable.iter().any(|need| listener.needs.contains(need));
                let unable = lacks && stats.running == 0 && stats.waiting > 0;
                *listener.stats.lock().unwrap_or_else(PoisonError::into_inner) =
                    RunStats { workers, ready, unable, ..stats };
            }
        }
        let stats = PoolStats {
            jobs: RunStats::of(&counts, held, permille),
            workers,
            asking: self.waiting.polls() as u64,
            respawned: children.map_or(0, |c| c.respawned),
            alarms: counts.alarms,
            fenced: counts.fenced,
            unschedulable: counts.unschedulable,
            quarantined: counts.quarantined,
            hedged: counts.hedged,
            adopted: counts.adopted,
            queued: self.runs.queued,
            cached: self.kept.cache.hits,
            damaged: self.transfers.inbox.damaged,
            lost: self.workers.lives.lost,
            back: self.workers.lives.back,
            duplicate_names: self.workers.lives.duplicate_names(),
            refusals: self.transfers.refusals,
            mesh_bytes: self.transfers.mesh_bytes,
            children: pids.len() as u64,
        };
        *self.published.stats.lock().unwrap_or_else(PoisonError::into_inner) = stats;
        *self.published.pids.lock().unwrap_or_else(PoisonError::into_inner) = pids;
    }

    /// A worker says how far it is.
    pub(super) fn progress(&mut self, id: JobId, permille: u16) {
        for (run, gain) in self.ledger.progress(id, permille.min(1000)) {
            if let Some(listener) = self.runs.listeners.get_mut(&run) {
                listener.permille += gain;
            }
        }
    }

    fn now(&self) -> Millis {
        self.start.elapsed().as_millis() as Millis
    }

    pub(super) fn step(&mut self, event: Event) -> StepAnswers {
        let now = self.now();
        let mut answers = StepAnswers::default();
        for effect in self.dispatch.step(now, event) {
            self.act(effect, &mut answers);
        }
        answers
    }
}

/// The jobs that earlier lives have put into quarantine.
fn held(folder: Option<&Path>) -> Vec<JobId> {
    let Some(folder) = folder else {
        return Vec::new();
    };
    let held = quarantine::held(folder).unwrap_or_else(|error| {
        tracing::error!("{}: {error}: what is in quarantine is not known", folder.display());
        Vec::new()
    });
    for job in &held {
        tracing::warn!(job = %job.short(), "in quarantine, since an earlier life");
    }
    held
}

/// The machine hears what was at work when the last life ended.
fn inherited(dispatch: &mut Dispatch, path: &Path, cache: &Cache) -> AtWork {
    let (at_work, left) = AtWork::open(path, |job| !cache.has(*job));
    for (job, run) in &left {
        dispatch.step(0, Event::Inherit(Job(job.0), Claimant(*run)));
    }
    if !left.is_empty() {
        tracing::info!(jobs = left.len(), "were at work when the last life ended, and may go on");
    }
    at_work
}

/// For a coordinator without a journal: differs between its lives, but for one chance in 2³².
fn drawn() -> u32 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let seconds = since.map_or(0, |since| since.as_millis() as u64);
    cullet_geometry::math::scramble(seconds ^ u64::from(std::process::id()) << 40) as u32
}
