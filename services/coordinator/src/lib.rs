//! The service: runs that anybody may hand in, watch and fetch, several at once on one pool, and
//! a state folder from which they all go on after the coordinator was killed.
//!
//! [`serve`] is one thread that owns the board, the journal and the door; each run has a thread of
//! its own. A run that was cut off begins anew from its scene, which is deterministic, and gets the
//! verdicts that were kept: nothing that had settled is computed again, and the digest is the same.

mod answer;
mod aside;
mod attempt;
mod board;
mod cutoff;
mod error;
mod forget;
mod here;
mod journal;
mod keeper;
mod live;
mod memory;
pub mod metrics;
mod quota;
mod store;
pub mod sweep;
mod tell;
mod timeline;

pub use error::ServiceError;
pub use here::run_here;
pub use store::{Store, free, total};

use answer::Watcher;
use aside::ends_here;
use attempt::{Attempt, Ended};
use board::{Board, Entry, Event, How, Wish};
use cullet_files::clock::unix_ms;
use cullet_files::output::next_folder;
use cullet_pool::users::RequestServer;
use cullet_pool::{LinkError, Pool, Share, Tenant};
use cullet_proto::WorkerId;
use cullet_proto::service::{JobCounts, State, codes};
use cutoff::Reach;
use journal::Journal;
use live::RunStatus;
use metrics::Metrics;
use quota::Quota;
use std::collections::{BTreeMap, BTreeSet};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tell::tell;
use timeline::RunHistory;

/// Between looks at the runs, where no question comes.
const PERIOD: Duration = Duration::from_millis(20);
/// Questions answered between looks at the runs.
const BATCH: usize = 64;
/// Between looks at what is old.
const SWEEP: Duration = Duration::from_secs(1);
/// A client that has not asked for this long is gone: nobody waits for it before leaving.
const LINGER: Duration = Duration::from_secs(10);

/// How the service is set up.
#[derive(Clone, Debug, Default)]
pub struct ServiceConfig {
    /// Folder for recordings; without one it is `recordings` in the state folder.
    pub out: Option<PathBuf>,
    /// Runs at once.
    pub runs: usize,
    /// Leave after so many runs.
    pub stop_after: Option<u32>,
    /// Where metrics and health can be asked for.
    pub metrics: Option<SocketAddr>,
    /// Who may control the runs of others and drain workers; `None`: anybody, where no certificate
    /// says who somebody is.
    pub operators: Option<BTreeSet<WorkerId>>,
    /// Most bytes of the disk that the runs of one user may hold; `None`: no bound.
    pub quota: Option<u64>,
    /// Most memory that this process may hold before the largest run is stopped \[bytes\]; `None`:
    /// no bound.
    pub memory: Option<u64>,
    /// Bytes of the disk that are kept for runs that go on; `None`: a twentieth of it, at least
    /// 32 MiB and at most 2 GiB.
    pub reserve: Option<u64>,
    /// Runs remembered, if fewer than 4096: beyond it the oldest that is over goes.
    pub keep: Option<usize>,
    /// Bytes of the journal beyond which no run is handed in, if fewer than 256 MiB.
    pub journal: Option<u64>,
}

/// A run that goes on.
struct Going {
    stop: Arc<AtomicBool>,
    /// Why it was stopped, where nobody wished it: a code and words.
    over: Option<(u8, String)>,
    thread: JoinHandle<Ended>,
}

struct Service<'a> {
    pool: &'a Arc<Pool>,
    config: &'a ServiceConfig,
    out: PathBuf,
    store: Store,
    journal: Journal,
    board: Board,
    quota: Quota,
    door: RequestServer,
    lives: BTreeMap<u64, Arc<RunStatus>>,
    going: BTreeMap<u64, Going>,
    watchers: Vec<Watcher>,
    awaited: BTreeMap<u64, Instant>,
    /// Runs whose files did not go, and when that was tried.
    stuck: BTreeMap<u64, Instant>,
    /// Memory that was held when a run was last stopped for it \[bytes\].
    heaviest: u64,
    /// Up to which number it is on the disk beside the journal that they were given.
    given: u64,
    metrics: Option<Metrics>,
    since: Instant,
    begin_at: Instant,
    /// Whether it was told that runs wait for room on the disk.
    short: bool,
    swept: Instant,
    ended: u32,
    leaving: bool,
    say: &'a mut dyn FnMut(&str),
}

/// Serves until told to stop, and then leaves in order: with a state folder the runs at hand go on
/// when it is back; without one they end with the recording so far, and those that wait are told.
/// It leaves, too, where another coordinator of its name has been there for longer.
///
/// # Errors
/// The journal or the door does not open; [`LinkError::Conflict`].
pub fn serve(
    store: Store,
    pool: &Arc<Pool>,
    config: &ServiceConfig,
    stop: &AtomicBool,
    say: &mut dyn FnMut(&str),
) -> Result<(), ServiceError> {
    let mut service = Service::open(store, pool, config, say)?;
    let enough = |ended| config.stop_after.is_some_and(|most| ended >= most);
    let mut rival = None;
    while !stop.load(Ordering::Relaxed) && !enough(service.ended) && rival.is_none() {
        service.begin();
        service.turn();
        rival = pool.conflict();
    }
    if rival.is_some() {
        service.hush();
    }
    service.leave();
    rival.map_or(Ok(()), |rival| Err(LinkError::Conflict(rival).into()))
}

impl<'a> Service<'a> {
    fn open(
        store: Store,
        pool: &'a Arc<Pool>,
        config: &'a ServiceConfig,
        say: &'a mut dyn FnMut(&str),
    ) -> Result<Self, ServiceError> {
        let (mut journal, mut board, torn) = open_journal(&store, config)?;
        if let Some(torn) = torn {
            say(&format!("{torn}: a crash tore it, nobody was told of it, it is dropped"));
        }
        let out = config.out.clone().unwrap_or_else(|| store.folder().join("recordings"));
        let back = cutoff::returned((&store, &out), &mut journal, &mut board, say)?;
        if let Some(folder) = store.named() {
            let (runs, folder) = (board.entries().count(), folder.display());
            say(&format!("{folder}: {runs} runs, {back} of them go on from where they were"));
        }
        let given = forget::numbered(&store, &mut journal, &mut board)?;
        forget::sweep(&store, &board, config.out.is_none().then_some(out.as_path()));
        let metrics = config.metrics.map(Metrics::serve).transpose()?;
        let mut service = Self {
            pool,
            config,
            out,
            store,
            journal,
            board,
            quota: Quota::new(config.quota),
            door: RequestServer::open(pool)?,
            lives: BTreeMap::new(),
            going: BTreeMap::new(),
            watchers: Vec::new(),
            awaited: BTreeMap::new(),
            stuck: BTreeMap::new(),
            heaviest: 0,
            given,
            metrics,
            since: Instant::now(),
            begin_at: Instant::now(),
            short: false,
            swept: Instant::now(),
            ended: 0,
            leaving: false,
            say,
        };
        let goes_on = |entry: &&Entry| matches!(entry.state, State::Queued | State::Running);
        pool.retain_claimants(service.board.entries().filter(goes_on).map(|entry| entry.run).collect());
        service.clear();
        Ok(service)
    }

    /// Answers what was asked, and takes in what ended.
    fn turn(&mut self) {
        let mut wait = PERIOD;
        for _ in 0..BATCH {
            let Some(asked) = self.door.next(wait) else { break };
            wait = Duration::ZERO;
            self.answer(asked);
        }
        self.reap();
        self.news();
        if self.swept.elapsed() >= SWEEP {
            self.swept = Instant::now();
            self.door.sweep();
            self.bound();
            self.lighten();
            self.clear();
            if let Err(error) = self.journal.settle() {
                tracing::error!("still not kept: {error}");
            }
            if let Some(metrics) = &self.metrics {
                let refused = (&self.pool.stats(), self.door.refusals());
                let free = self.store.free_bytes();
                metrics.publish(metrics::text(&self.board, refused, free, self.since));
            }
        }
    }

    /// Keeps what happened, then lets it happen.
    fn record(&mut self, events: &[Event]) -> Result<(), ServiceError> {
        self.journal.append(events)?;
        events.iter().for_each(|event| self.apply(event));
        self.journal.tidy(&self.board);
        Ok(())
    }

    /// What happened happened, even if it cannot be kept.
    fn admit(&mut self, event: Event) {
        if let Err(error) = self.journal.append(std::slice::from_ref(&event)) {
            tracing::error!("not kept until there is room, or done again: {error}");
            self.journal.owe(&event);
        }
        self.apply(&event);
        self.journal.tidy(&self.board);
    }

    /// What the journal has happens. A test stops the coordinator at a line of the log: kept, and
    /// not answered yet.
    fn apply(&mut self, event: &Event) {
        tell(event);
        if let Event::Cancelled { run, .. } | Event::Paused { run } = event {
            self.pool.release(*run);
        }
        if let Event::Cancelled { run, end, .. } = event
            && !end.files.is_empty()
        {
            self.quota.changed(*run);
            self.live(*run).say(&format!("cancelled: {}", ends_here(&end.files)));
        }
        if let Err(no) = self.board.apply(event) {
            tracing::error!("an event does not fit: {no}");
        }
    }

    fn live(&mut self, run: u64) -> Arc<RunStatus> {
        let path = self.store.run(run).join("log");
        let live = self.lives.entry(run).or_insert_with(|| Arc::new(RunStatus::open(&path)));
        Arc::clone(live)
    }

    /// Fracture jobs of the attempt at hand, or of the last one.
    fn jobs(&self, run: u64) -> JobCounts {
        self.lives.get(&run).map(|live| live.jobs()).unwrap_or_default()
    }

    /// Starts runs while there is room.
    fn begin(&mut self) {
        while self.going.len() < self.config.runs && Instant::now() >= self.begin_at {
            let Some(entry) = self.board.next(unix_ms()).cloned() else { return };
            if self.waits_for_room(entry.run) {
                return;
            }
            if let Err(error) = self.start(entry) {
                tracing::error!("a run does not start, and is tried again: {error}");
                self.begin_at = Instant::now() + SWEEP;
                return;
            }
        }
    }

    /// Whether the disk has room for so many bytes more.
    fn room(&self, more: u64) -> Result<(), ServiceError> {
        let kept = (self.config.reserve, self.journal.length());
        quota::disks(more, kept, [self.store.folder(), &self.out])
    }

    /// What is left of the disk is for runs that go on: another one waits, which is told once.
    fn waits_for_room(&mut self, run: u64) -> bool {
        let Err(full) = self.room(0) else {
            self.short = false;
            return false;
        };
        self.begin_at = Instant::now() + SWEEP;
        if !std::mem::replace(&mut self.short, true) {
            tracing::warn!(run, "no run begins: {full}");
            self.live(run).say(&format!("waits for room on the coordinator's disk: {full}"));
        }
        true
    }

    fn start(&mut self, entry: Entry) -> Result<(), ServiceError> {
        let run = entry.run;
        let folder = match &entry.folder {
            Some(name) => name.clone(),
            None => {
                let made = next_folder(&self.out, &entry.order.name);
                let made = made.map_err(ServiceError::file(&self.out))?;
                made.file_name().unwrap_or_default().to_string_lossy().into_owned()
            }
        };
        let out = self.out.join(&folder);
        let live = self.live(run);
        live.begin();
        let kept = self.record(&[Event::Started { run, folder, at: unix_ms() }]);
        if let (Err(_), None) = (&kept, &entry.folder) {
            // Nobody knows of it; the next try makes one.
            let _empty = std::fs::remove_dir(&out);
        }
        kept?;
        if entry.attempt > 0 {
            live.say(&format!(
                "begins anew, attempt {}; what was settled is kept",
                entry.attempt + 1
            ));
        }
        (self.say)(&format!("run {run}: {} into {}", entry.order.name, out.display()));
        let stop = Arc::new(AtomicBool::new(false));
        let (pool, kept) = (Arc::clone(self.pool), self.store.kept(run));
        let state = self.store.run(run);
        let share = share(&entry.order.user, entry.order.priority);
        let entry = self.board.get(run).map_or(entry, Entry::clone);
        let bundle = self.store.bundle(run, &entry.order.bundle);
        let reach = self.store.named().map(|_| Reach::new(&self.store.run(run)));
        let attempt_stop = Arc::clone(&stop);
        let work = move || {
            let bundle = match bundle {
                Ok(bundle) => bundle,
                Err(error) => return Ended::failed(codes::UNKEPT, error.to_string()),
            };
            let (folder, stop) = (out, attempt_stop);
            let attempt = Attempt { entry, bundle, folder, kept, state, reach, live, stop };
            let run = attempt.entry.run;
            attempt.run(&pool.run_as(run, share))
        };
        let thread = std::thread::Builder::new().name(format!("cullet-run-{run}")).spawn(work);
        match thread {
            Ok(thread) => {
                self.going.insert(run, Going { stop, over: None, thread });
            }
            Err(error) => self.end(run, Ended::failed(codes::FAILED, error.to_string())),
        }
        Ok(())
    }

    /// Takes in the runs that ended.
    fn reap(&mut self) {
        let over = |going: &Going| going.thread.is_finished();
        let ended: Vec<u64> =
            self.going.iter().filter(|(_, going)| over(going)).map(|(run, _)| *run).collect();
        for run in ended {
            let Some(going) = self.going.remove(&run) else { continue };
            let mut ended = going.thread.join().unwrap_or_else(|_| {
                Ended::failed(codes::FAILED, "its thread panicked: a defect here".to_owned())
            });
            let wished = self.board.get(run).is_ok_and(|entry| entry.wish.is_some());
            if let (How::Stopped, Some((code, text)), false) = (ended.how, going.over, wished) {
                (ended.how, ended.end.code, ended.end.text) = (How::Failed, Some(code), text);
                self.live(run).say(&format!("error: {}", ended.end.text));
            }
            self.end(run, ended);
        }
    }

    /// Stops the runs of users who hold more of the disk than they may.
    fn bound(&mut self) {
        let place = (&self.store, self.out.as_path(), &self.journal);
        for (run, going) in self.going.iter_mut().filter(|(_, going)| going.over.is_none()) {
            let Ok(entry) = self.board.get(*run) else { continue };
            let user = (entry.order.user.as_str(), 0);
            if let Err(error) = self.quota.room(user, &self.board, place) {
                tracing::warn!(run, "stopped: {error}");
                going.over = Some((codes::UNKEPT, error.to_string()));
                going.stop.store(true, Ordering::Relaxed);
            }
        }
    }

    fn end(&mut self, run: u64, ended: Ended) {
        self.quota.changed(run);
        // One that never came to the pool wants nothing either.
        self.pool.release(run);
        let Ended { how, mut end, at } = ended;
        let wish = self.board.get(run).ok().and_then(|entry| entry.wish);
        let live = self.live(run);
        end.jobs = live.jobs();
        match (how, wish) {
            (How::Stopped, Some(Wish::Cancel)) => {
                end.code = Some(codes::CANCELLED);
                let left = "the coordinator was told to stop: the recording ends here";
                let leaves = self.leaving && self.store.named().is_none();
                end.text = if leaves { left } else { "" }.to_owned();
                live.say(if leaves { left } else { "cancelled: the recording ends here" });
            }
            (How::Stopped, Some(Wish::Pause)) => live.say("paused"),
            (How::Stopped, None) => live.say("the coordinator leaves; the run goes on later"),
            (How::Done | How::Failed | How::Stalled, _) => {}
        }
        if !end.text.is_empty() {
            (self.say)(&format!("run {run}: {}", end.text));
        }
        self.ended += 1;
        self.admit(Event::Ended { run, how, end, at });
        if self.board.get(run).is_ok_and(|entry| entry.state == State::Done) {
            self.store.kept(run).forget();
            RunHistory::forget(&self.store.run(run));
        }
    }

    /// Makes the runs at hand do what somebody wishes of them.
    fn stop_run(&self, run: u64) {
        if let Some(going) = self.going.get(&run) {
            going.stop.store(true, Ordering::Relaxed);
        }
    }

    /// Another answers here: nobody is waited for.
    fn hush(&mut self) {
        self.door.close();
        self.awaited.clear();
    }

    fn leave(&mut self) {
        self.leaving = true;
        let keeps = self.store.named().is_some();
        if keeps {
            // Runs that are laid down want nothing any more, and no worker is to hear of that.
            self.pool.stop_answering();
        }
        for run in self.going.keys().copied().collect::<Vec<_>>() {
            if !keeps {
                self.admit(Event::Wished { run, wish: Wish::Cancel });
            }
            self.stop_run(run);
        }
        loop {
            if !keeps {
                self.dismiss();
            }
            self.turn();
            let lately = |asked: &Instant| asked.elapsed() < LINGER;
            if self.going.is_empty() && !self.awaited.values().any(lately) {
                return;
            }
        }
    }
}

/// What happened in the lives before this one.
fn open_journal(
    store: &Store,
    config: &ServiceConfig,
) -> Result<(Journal, Board, Option<String>), ServiceError> {
    let bound = config.journal.unwrap_or(journal::MAX_BYTES).min(journal::MAX_BYTES);
    Journal::open(&store.folder().join("journal"), bound)
}

/// What a run may claim of the pool: users share it evenly; priorities beyond what the pool tells
/// apart decide in the queue alone.
fn share(user: &str, priority: i32) -> Share {
    let name = cullet_proto::ids::digest(user.as_bytes());
    let tenant = Tenant(u64::from_le_bytes([0, 1, 2, 3, 4, 5, 6, 7].map(|at| name[at])));
    let priority = i32::from(Share::NORMAL).saturating_add(priority);
    Share { tenant, priority: priority.clamp(0, i32::from(Share::HIGHEST)) as u8 }
}
