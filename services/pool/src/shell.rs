//! The thread that owns the pool: hears, steps the machine, does what it says.

use super::at_work::AtWork;
use super::bulk::Bulk;
use super::cache::Cache;
use super::children::Children;
use super::drained::DrainedLives;
use super::inbox::Inbox;
use super::ledger::Ledger;
use super::lives::Lives;
use super::net::Net;
use super::openings::Opening;
use super::questions::Heed;
use super::roster::Roster;
use super::run::AttemptNews;
use super::skill_table::SkillTable;
use super::{LinkError, PoolConfig, PoolStats, Refusals, RunStats, Settlement, quarantine};
use cullet_dispatch::{
    Claimant, Dispatch, Event, Job, Millis, Receipt, Run, Share, Skills, Timing, Worker,
};
use cullet_proto::pool::{Grant, RenewAnswer};
use cullet_proto::{JobId, SessionId, WorkerId};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
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
    Link { name: WorkerId, session: SessionId, up: bool },
    /// A run begins: its settlements go there.
    Begin(Run, Share, Listener),
    /// A run wants a job.
    Open(Run, JobId, Opening),
    /// Something about a run, or a wish about a worker.
    Say(Event),
    /// Of the runs of earlier lives only these want anything.
    Claimants(BTreeSet<u64>),
    /// The worker of that name gets no further job.
    Drain(WorkerId, Sender<()>),
    /// No worker is answered any more: another coordinator has this one's name, or will.
    Leave,
    /// The end.
    Quit,
}

/// Who hears of a run.
#[derive(Debug)]
pub(super) struct Listener {
    pub(super) settle: Sender<(JobId, Settlement)>,
    pub(super) stats: Arc<Mutex<RunStats>>,
    pub(super) attempts: AttemptNews,
    pub(super) over: bool,
    /// Its number for people, in log lines.
    pub(super) label: u64,
    /// What it wants and there was no room for, in order.
    pub(super) held: VecDeque<(JobId, Opening)>,
    /// Why it gets nothing any more, if it wanted too much.
    pub(super) out: Option<String>,
    /// Sum of how far the jobs at work are \[1/1000\].
    pub(super) permille: i64,
    /// What its jobs have asked of workers.
    pub(super) needs: BTreeSet<Skills>,
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
    /// Workers that want to hear when a job is not wanted any more.
    pub(super) heeds: BTreeMap<Worker, Heed>,
    pub(super) refusals: Refusals,
    /// Bytes of meshes sent to workers.
    pub(super) mesh_bytes: u64,
    pub(super) roster: Roster,
    pub(super) skill_table: SkillTable,
    pub(super) names: BTreeMap<Worker, WorkerId>,
    pub(super) lives: Lives,
    pub(super) ledger: Ledger,
    pub(super) cache: Cache,
    pub(super) quarantine: Option<PathBuf>,
    pub(super) at_work: Option<AtWork>,
    pub(super) drained: Option<DrainedLives>,
    pub(super) children: Option<Children>,
    net: Net,
    pub(super) runs: BTreeMap<Run, Listener>,
    /// Openings that had to wait for room.
    pub(super) queued: u64,
    /// Openings of a run that may wait.
    pub(super) most: usize,
    pub(super) settled: Vec<(Run, JobId, Settlement)>,
    stats: Arc<Mutex<PoolStats>>,
    pids: Arc<Mutex<Vec<u32>>>,
    start: Instant,
}

impl Shell {
    pub(super) fn new(config: &PoolConfig, net: Net) -> Result<Self, LinkError> {
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
            inbox: Inbox::default(),
            bulk: Bulk::start()?,
            polls: BTreeMap::new(),
            heeds: BTreeMap::new(),
            refusals: Refusals::default(),
            mesh_bytes: 0,
            roster: Roster::default(),
            skill_table: SkillTable::default(),
            names: BTreeMap::new(),
            lives: Lives::new(Duration::from_millis(closing)),
            ledger: Ledger::default(),
            cache,
            at_work,
            drained,
            quarantine: config.quarantine.clone(),
            children,
            net,
            runs: BTreeMap::new(),
            queued: 0,
            most: config.held,
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
            self.open_held();
            self.publish();
            self.roster.publish(&self.lives);
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
        self.heeds.clear();
        drop(self.bulk);
        self.net.close();
    }

    fn take(&mut self, input: Input) {
        match input {
            Input::Question(query) => self.question(query),
            Input::Link { name, session, up } => {
                self.lives.sign(name, session, up, Instant::now());
                self.roster.changed();
                if up {
                    return;
                }
                let worker = Worker(session.0);
                self.polls.remove(&worker);
                self.heeds.remove(&worker);
                self.step(Event::Suspect(worker));
            }
            Input::Begin(run, share, listener) => {
                self.runs.insert(run, listener);
                self.step(Event::Begin { run, share });
            }
            Input::Open(run, id, opening) => self.want(run, id, opening),
            Input::Say(event) => self.say(event),
            Input::Claimants(runs) => {
                for claimant in
                    self.dispatch.claimants().into_iter().filter(|of| !runs.contains(&of.0))
                {
                    self.say(Event::Release(claimant));
                }
            }
            Input::Drain(name, done) => {
                for worker in self.named(name.as_str()) {
                    self.step(Event::Drain(worker));
                }
                let _gone = done.send(());
            }
            Input::Leave => {
                // Workers that asked here ask again, and the other answers.
                self.net.hush();
                self.polls.clear();
                self.heeds.clear();
            }
            Input::Quit => {}
        }
    }

    fn tick(&mut self) {
        for name in self.children.as_mut().map(Children::tend).unwrap_or_default() {
            // Of several that are called so it is none whose link is up: where that one's still is,
            // the link says so itself.
            let named = self.named(&name);
            let alone = named.len() == 1;
            for worker in named {
                if !alone && self.lives.up.contains(&SessionId(worker.0)) {
                    continue;
                }
                self.polls.remove(&worker);
                self.heeds.remove(&worker);
                self.skill_table.gone(worker);
                self.roster.gone(worker);
                self.step(Event::Down(worker));
                // What is told of its jobs has its name.
                self.names.remove(&worker);
            }
        }
        self.forsake();
        self.step(Event::Tick);
        self.answer_old_heeds();
        self.tell_twins();
        self.skill_table.tell(self.dispatch.unschedulable());
        self.inbox.sweep();
    }

    /// Says aloud, once, that workers have one name, and that they do not any more.
    fn tell_twins(&mut self) {
        for (name, lives) in self.lives.tick(Instant::now()) {
            self.roster.changed();
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

    /// The lives of workers of that name.
    fn named(&self, name: &str) -> Vec<Worker> {
        let known = self.names.iter().filter(|(_, known)| known.as_str() == name);
        known.map(|(worker, _)| *worker).collect()
    }

    pub(super) fn say(&mut self, event: Event) {
        self.step(event);
        match event {
            Event::Cancel(run) => {
                self.cancel_held(run);
                self.say(Event::Release(Claimant(self.label(run))));
            }
            Event::End(run) => {
                if let Some(listener) = self.runs.get_mut(&run) {
                    listener.over = true;
                    listener.held.clear();
                }
                self.say(Event::Release(Claimant(self.label(run))));
            }
            Event::Release(_) => self.heed_again(),
            Event::Pardon(job) => self.pardon(JobId(job.0)),
            _ => {}
        }
    }

    /// Gives every job up if no worker of ours comes to life and nobody else is there.
    fn forsake(&mut self) {
        let Some(text) = self.children.as_ref().and_then(Children::hopeless) else {
            return;
        };
        if self.lives.up.is_empty() && !self.ledger.is_empty() {
            self.ledger.trouble_all(&text);
            self.step(Event::Forsaken);
        }
    }

    fn publish(&self) {
        let counts = self.dispatch.counts();
        let children = self.children.as_ref();
        let pids = children.map(Children::pids).unwrap_or_default();
        let (mut held, mut permille) = (0, 0);
        let (workers, ready) = (self.lives.up.len() as u64, self.roster.ready(&self.lives));
        let stranded: Vec<Skills> = self.dispatch.unschedulable().map(|(need, _)| need).collect();
        for (run, listener) in &self.runs {
            held += listener.held.len() as u64;
            permille += listener.permille;
            if let Some(counts) = self.dispatch.counts_of(*run) {
                let stats = RunStats::of(&counts, listener.held.len() as u64, listener.permille);
                let lacks = stranded.iter().any(|need| listener.needs.contains(need));
                let unable = lacks && stats.running == 0 && stats.waiting > 0;
                *listener.stats.lock().unwrap_or_else(PoisonError::into_inner) =
                    RunStats { workers, ready, unable, ..stats };
            }
        }
        let stats = PoolStats {
            jobs: RunStats::of(&counts, held, permille),
            workers: self.lives.up.len() as u64,
            respawned: children.map_or(0, |c| c.respawned),
            alarms: counts.alarms,
            fenced: counts.fenced,
            stranded: counts.unschedulable,
            quarantined: counts.quarantined,
            hedged: counts.hedged,
            adopted: counts.adopted,
            queued: self.queued,
            cached: self.cache.hits,
            damaged: self.inbox.damaged,
            lost: self.lives.lost,
            back: self.lives.back,
            twins: self.lives.twins(),
            refusals: self.refusals,
            mesh_bytes: self.mesh_bytes,
            children: pids.len() as u64,
        };
        *self.stats.lock().unwrap_or_else(PoisonError::into_inner) = stats;
        *self.pids.lock().unwrap_or_else(PoisonError::into_inner) = pids;
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
            let up = &self.lives.up;
            self.names.retain(|known, _| *known == worker || up.contains(&SessionId(known.0)));
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
