//! The loop of the service: it answers questions, starts runs, takes in those that ended, and
//! leaves in order.

use super::attempt::{Ended, RunAttempt};
use super::board::{AttemptEnd, Board, BoardEvent, RunEntry, Wish};
use super::clients::Clients;
use super::config::ServiceConfig;
use super::error::ServiceError;
use super::journal::{self, Journal};
use super::metrics::{self, Metrics};
use super::quota::Quota;
use super::reach::ReachWriter;
use super::service::{Going, Pruning, RunTable, Service, Storage, Times};
use super::store::Store;
use super::timeline::RunHistory;
use super::web::WebPage;
use super::{prune, recovery, remains};
use cullet_files::clock::unix_ms;
use cullet_files::output::next_folder;
use cullet_pool::users::RequestServer;
use cullet_pool::{LinkError, Pool, Share, Tenant};
use cullet_proto::service::{FileInfo, State, codes};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Between looks at the runs, where no question comes.
const PERIOD: Duration = Duration::from_millis(20);
/// Questions answered between looks at the runs.
const BATCH: usize = 64;
/// Between looks at what is old.
const SWEEP: Duration = Duration::from_secs(1);
/// A client that has not asked for this long is gone: nobody waits for it before leaving.
const LINGER: Duration = Duration::from_secs(10);
/// A run that has not stopped this long after the coordinator was asked to is cut off: its scene
/// may make it work for minutes without looking up.
const LEAVE: Duration = Duration::from_secs(5);
/// After that, clients that are still there hear for this long how their runs ended.
const FAREWELL: Duration = Duration::from_secs(2);

/// Serves until asked to stop, and then leaves in order: with a state folder the runs at hand go on
/// when it is back; without one they end with the recording so far, and those that wait are
/// reported. It leaves, too, where another coordinator of its name has been there for longer, and
/// after as many runs as it was to do; then it waits for clients that still fetch what they got.
/// Once it is asked to stop it is gone within ten seconds, whatever a scene or a client does.
///
/// # Errors
/// The journal or the door does not open; [`LinkError::Conflict`].
pub fn serve(
    store: Store,
    pool: &Arc<Pool>,
    config: &ServiceConfig,
    stop: &AtomicBool,
    report: &mut dyn FnMut(&str),
) -> Result<(), ServiceError> {
    let mut service = open(store, pool, config, report)?;
    let enough = |ended| config.stop_after.is_some_and(|most| ended >= most);
    let mut conflict = None;
    while !stop.load(Ordering::Relaxed) && !enough(service.runs.ended) && conflict.is_none() {
        service.begin();
        service.turn();
        conflict = pool.conflict();
    }
    if conflict.is_some() {
        service.stop_answering();
    }
    service.leave(stop);
    conflict.map_or(Ok(()), |conflict| Err(LinkError::Conflict(conflict).into()))
}

fn open<'a>(
    store: Store,
    pool: &'a Arc<Pool>,
    config: &'a ServiceConfig,
    report: &'a mut dyn FnMut(&str),
) -> Result<Service<'a>, ServiceError> {
    let (mut journal, mut board, torn) = open_journal(&store, config)?;
    if let Some(torn) = torn {
        report(&format!("{torn}: incomplete after a crash and never announced; it is dropped"));
    }
    let out = config.out.clone().unwrap_or_else(|| store.folder().join("recordings"));
    let back = recovery::returned((&store, &out), &mut journal, &mut board, report)?;
    if let Some(folder) = store.named() {
        let (runs, folder) = (board.entries().count(), folder.display());
        report(&format!("{folder}: {runs} runs, {back} of them continue"));
    }
    let given = prune::numbered(&store, &mut journal, &mut board)?;
    prune::sweep(&store, &board, config.out.is_none().then_some(out.as_path()));
    let metrics = config.metrics.map(Metrics::serve).transpose()?;
    let now = Instant::now();
    let mut service = Service {
        pool,
        config,
        storage: Storage { out, store, quota: Quota::new(config.quota) },
        journal,
        board,
        clients: Clients {
            server: RequestServer::open(pool)?,
            followers: Vec::new(),
            awaited: BTreeMap::new(),
        },
        runs: RunTable {
            statuses: BTreeMap::new(),
            going: BTreeMap::new(),
            ended: 0,
            heaviest: 0,
            short: false,
        },
        pruning: Pruning { stuck: BTreeMap::new(), given },
        metrics,
        page: None,
        times: Times { since: now, begin_at: now, swept: now },
        leaving: false,
        report,
    };
    let goes_on = |entry: &&RunEntry| matches!(entry.state, State::Queued | State::Running);
    pool.retain_claimants(service.board.entries().filter(goes_on).map(|entry| entry.run).collect());
    service.prune();
    if let Some(web) = &config.web {
        let page = WebPage::open(web.clone(), service.farm())?;
        let scheme = if web.identity.is_some() { "https" } else { "http" };
        let address = page.address().unwrap_or(web.address);
        (service.report)(&format!("the farm's page is at {scheme}://{address}/"));
        service.page = Some(page);
    }
    Ok(service)
}

impl Service<'_> {
    /// Answers what was asked, and takes in what ended.
    fn turn(&mut self) {
        let mut wait = PERIOD;
        for _ in 0..BATCH {
            let Some(asked) = self.clients.server.next(wait) else { break };
            wait = Duration::ZERO;
            self.answer(asked);
        }
        self.reap();
        self.answer_followers();
        if let Some(page) = &self.page {
            page.publish(|| self.farm());
        }
        if self.times.swept.elapsed() >= SWEEP {
            self.times.swept = Instant::now();
            self.clients.server.sweep();
            self.stop_over_quota();
            self.stop_largest();
            self.prune();
            if let Err(error) = self.journal.settle() {
                tracing::error!("still not kept: {error}");
            }
            if let Some(metrics) = &self.metrics {
                let refused = (&self.pool.stats(), self.clients.server.refusals());
                let free = self.storage.store.free_bytes();
                metrics.publish(metrics::text(&self.board, refused, free, self.times.since));
            }
        }
    }

    /// Starts runs while there is room.
    fn begin(&mut self) {
        while self.runs.going.len() < self.config.runs && Instant::now() >= self.times.begin_at {
            let Some(entry) = self.board.next(unix_ms()).cloned() else { return };
            if self.waits_for_room(entry.run) {
                return;
            }
            if let Err(error) = self.start(entry) {
                tracing::error!("a run does not start, and is tried again: {error}");
                self.times.begin_at = Instant::now() + SWEEP;
                return;
            }
        }
    }

    /// What is left of the disk is for runs that go on: another one waits, which is logged once.
    fn waits_for_room(&mut self, run: u64) -> bool {
        let Err(full) = self.room(0) else {
            self.runs.short = false;
            return false;
        };
        self.times.begin_at = Instant::now() + SWEEP;
        if !std::mem::replace(&mut self.runs.short, true) {
            tracing::warn!(run, "no run begins: {full}");
            self.status(run).log(&format!("waits for room on the coordinator's disk: {full}"));
        }
        true
    }

    fn start(&mut self, entry: RunEntry) -> Result<(), ServiceError> {
        let run = entry.run;
        let folder = match &entry.folder {
            Some(name) => name.clone(),
            None => {
                let made = next_folder(&self.storage.out, &entry.order.name);
                let made = made.map_err(ServiceError::file(&self.storage.out))?;
                made.file_name().unwrap_or_default().to_string_lossy().into_owned()
            }
        };
        let out = self.storage.out.join(&folder);
        let live = self.status(run);
        live.begin();
        let kept = self.record(&[BoardEvent::Started { run, folder, at: unix_ms() }]);
        if let (Err(_), None) = (&kept, &entry.folder) {
            // Nobody knows of it; the next try makes one.
            let _empty = std::fs::remove_dir(&out);
        }
        kept?;
        if entry.attempt > 0 {
            live.log(&format!(
                "begins anew, attempt {}; what was settled is kept",
                entry.attempt + 1
            ));
        }
        (self.report)(&format!("run {run}: {} into {}", entry.order.name, out.display()));
        let stop = Arc::new(AtomicBool::new(false));
        let (pool, kept) = (Arc::clone(self.pool), self.storage.store.kept(run));
        let state = self.storage.store.run(run);
        let share = share(&entry.order.user, entry.order.priority);
        let entry = self.board.get(run).map_or(entry, RunEntry::clone);
        let bundle = self.storage.store.bundle(run, &entry.order.bundle);
        let reach =
            self.storage.store.named().map(|_| ReachWriter::new(&self.storage.store.run(run)));
        let attempt_stop = Arc::clone(&stop);
        let work = move || {
            let bundle = match bundle {
                Ok(bundle) => bundle,
                Err(error) => return Ended::failed(codes::UNKEPT, error.to_string()),
            };
            let (folder, stop) = (out, attempt_stop);
            let attempt = RunAttempt { entry, bundle, folder, kept, state, reach, live, stop };
            let run = attempt.entry.run;
            attempt.run(&pool.run_as(run, share))
        };
        let thread = std::thread::Builder::new().name(format!("cullet-run-{run}")).spawn(work);
        match thread {
            Ok(thread) => {
                self.runs.going.insert(run, Going { stop, over: None, thread });
            }
            Err(error) => self.end(run, Ended::failed(codes::FAILED, error.to_string())),
        }
        Ok(())
    }

    /// Takes in the runs that ended.
    fn reap(&mut self) {
        let over = |going: &Going| going.thread.is_finished();
        let ended: Vec<u64> =
            self.runs.going.iter().filter(|(_, going)| over(going)).map(|(run, _)| *run).collect();
        for run in ended {
            let Some(going) = self.runs.going.remove(&run) else { continue };
            self.left_by(&going);
            let mut ended = going.thread.join().unwrap_or_else(|_| {
                Ended::failed(codes::FAILED, "its thread panicked: a defect here".to_owned())
            });
            let wished = self.board.get(run).is_ok_and(|entry| entry.wish.is_some());
            if let (AttemptEnd::Stopped, Some((code, text)), false) =
                (ended.how, going.over, wished)
            {
                (ended.how, ended.end.code, ended.end.text) =
                    (AttemptEnd::Failed, Some(code), text);
                self.status(run).log(&format!("error: {}", ended.end.text));
            }
            self.end(run, ended);
        }
    }

    /// Stops the runs of users who hold more of the disk than they may.
    fn stop_over_quota(&mut self) {
        let place = (&self.storage.store, self.storage.out.as_path(), &self.journal);
        for (run, going) in self.runs.going.iter_mut().filter(|(_, going)| going.over.is_none()) {
            let Ok(entry) = self.board.get(*run) else { continue };
            let user = (entry.order.user.as_str(), 0);
            if let Err(error) = self.storage.quota.room(user, &self.board, place) {
                tracing::warn!(run, "stopped: {error}");
                going.over = Some((codes::UNKEPT, error.to_string()));
                going.stop.store(true, Ordering::Relaxed);
            }
        }
    }

    fn end(&mut self, run: u64, ended: Ended) {
        self.storage.quota.changed(run);
        // One that never came to the pool wants nothing either.
        self.pool.release(run);
        let Ended { how, mut end, at } = ended;
        let wish = self.board.get(run).ok().and_then(|entry| entry.wish);
        let live = self.status(run);
        end.jobs = live.jobs();
        match (how, wish) {
            (AttemptEnd::Stopped, Some(Wish::Cancel)) => {
                end.code = Some(codes::CANCELLED);
                let left = "the coordinator was stopped: the recording ends here";
                let leaves = self.leaving && self.storage.store.named().is_none();
                end.text = if leaves { left } else { "" }.to_owned();
                live.log(if leaves { left } else { "cancelled: the recording ends here" });
            }
            (AttemptEnd::Stopped, Some(Wish::Pause)) => live.log("paused"),
            (AttemptEnd::Stopped, None) => {
                live.log("the coordinator leaves; the run goes on later");
            }
            (AttemptEnd::Done | AttemptEnd::Failed | AttemptEnd::Stalled, _) => {}
        }
        if !end.text.is_empty() {
            (self.report)(&format!("run {run}: {}", end.text));
        }
        self.runs.ended += 1;
        self.admit(BoardEvent::Ended { run, how, end, at });
        if self.board.get(run).is_ok_and(|entry| entry.state == State::Done) {
            self.storage.store.kept(run).forget();
            RunHistory::forget(&self.storage.store.run(run));
        }
    }

    /// Another answers here: nobody is waited for.
    fn stop_answering(&mut self) {
        self.clients.server.close();
        self.clients.awaited.clear();
    }

    /// Leaves runs behind that do not stop. Their threads end with the process.
    fn cut_off(&mut self) {
        let keeps = self.storage.store.named().is_some();
        let going = std::mem::take(&mut self.runs.going);
        if going.is_empty() {
            return;
        }
        for run in going.into_keys() {
            tracing::warn!(run, "cut off: it did not stop within {} s", LEAVE.as_secs());
            self.status(run).log("it did not stop in time, and was cut off");
            let entry = self.board.get(run).ok().cloned();
            let wished = entry.as_ref().is_some_and(|entry| entry.wish.is_some());
            // What is left of one that is to be cancelled or paused is gathered at the next start.
            if keeps && wished {
                continue;
            }
            let files = match entry.filter(|_| !keeps) {
                Some(entry) => self.left_of(&entry),
                None => Vec::new(),
            };
            self.end(run, Ended::stopped(files));
        }
        self.storage.store.keep_locked();
    }

    /// The recording of a run that does not go on, as far as it was written.
    fn left_of(&mut self, entry: &RunEntry) -> Vec<FileInfo> {
        let live = self.status(entry.run);
        remains::left(entry, (&self.storage.store, &self.storage.out), &live)
    }

    /// `stop`: somebody wants it gone. Until then it waits for clients as long as they ask.
    fn leave(&mut self, stop: &AtomicBool) {
        self.leaving = true;
        let mut asked: Option<Instant> = None;
        let keeps = self.storage.store.named().is_some();
        if keeps {
            // Runs that are laid down want nothing any more, and no worker is to hear of that.
            self.pool.stop_answering();
        }
        for run in self.runs.going.keys().copied().collect::<Vec<_>>() {
            if !keeps {
                self.admit(BoardEvent::Wished { run, wish: Wish::Cancel });
            }
            self.stop_run(run);
        }
        loop {
            if !keeps {
                self.dismiss();
            }
            self.turn();
            let lately = |asked: &Instant| asked.elapsed() < LINGER;
            if self.runs.going.is_empty() && !self.clients.awaited.values().any(lately) {
                return;
            }
            if asked.is_none() && stop.load(Ordering::Relaxed) {
                asked = Some(Instant::now());
            }
            let since = asked.map_or(Duration::ZERO, |since| since.elapsed());
            if since >= LEAVE {
                self.cut_off();
            }
            if since >= LEAVE + FAREWELL {
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
