//! The supervising half of a worker: does what its machine
//! ([`WorkerMachine`], `services/dispatch/src/worker_machine.rs`) says.
//!
//! Four threads beside this one: the talker asks, the renewer says how far the job is, the watcher
//! holds a question until the job is not wanted any more, the job runs. All put what they have to
//! say into one queue.

use crate::job::{AttemptResult, JobProcess, attempt};
use crate::link::CoordinatorLink;
use crate::meshes::Meshes;
use crate::solve::{JobControl, SolveFn};
use crate::talk::{Talker, TalkerResult, TalkerTask};
use crate::threads::start_threads;
use crate::{EXIT_WEDGED, WorkerConfig, WorkerError};
use cullet_dispatch::{
    Digest, Epoch, Job, Millis, Question, Trouble, WorkerInput, WorkerMachine, WorkerOutput,
};
use cullet_proto::SessionId;
use cullet_proto::ids::digest;
use cullet_proto::pool::{Grant, Hello, OVERDUE};
use rayon::ThreadPool;
use std::cell::Cell;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

/// How often a waiting supervisor looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(50);
/// Past the hard limit a slice on a thread of ours may still end by itself within this.
const GRACE: Duration = Duration::from_secs(5);

/// A job that is over by then needs no question whether it is wanted.
const SOON: Duration = Duration::from_millis(200);
/// Before that is asked again, where nobody answered.
const AGAIN: Duration = Duration::from_secs(1);

/// Where jobs run: on a thread of the worker, or in a process of their own.
enum JobRunner {
    Thread(SolveFn, ThreadPool),
    Process(JobProcess),
}

/// Which grant to renew, whether a solver has the job, and how far it is.
type Renewal = (Job, Epoch, bool, JobControl);

/// A job at work here, and the flag that cancels it.
type CancellableJob = (Job, Epoch, Arc<AtomicBool>);

/// A job for the job's thread.
type Task = (Epoch, Vec<u8>, JobControl);

pub(crate) struct Supervisor {
    config: WorkerConfig,
    machine: WorkerMachine,
    start: Instant,
    news: Receiver<TalkerResult>,
    queues: TaskQueues,
    line: Arc<CoordinatorLink>,
    current: CurrentJob,
    solver: SolverThread,
    /// Whether the process that started this one has gone or let it go.
    orphaned: Arc<AtomicBool>,
    /// Set when it leaves: no answer to a question for work is waited for then.
    leaving: Arc<AtomicBool>,
}

/// What the threads of a worker are asked to do; they end when it is dropped.
struct TaskQueues {
    /// Questions and downloads.
    orders: Sender<TalkerTask>,
    renewals: Sender<Renewal>,
    cancel_watches: Sender<CancellableJob>,
    jobs: Sender<Task>,
}

/// The job that this worker has a lease for.
struct CurrentJob {
    /// Set when it is over.
    over: Arc<AtomicBool>,
    grant: Option<Grant>,
    /// When it was granted.
    since: Instant,
    /// Its bytes, once they are here.
    bytes: Vec<u8>,
    /// Its result, once it is solved.
    result: Arc<Vec<u8>>,
    /// What went wrong with it.
    trouble: String,
    control: JobControl,
}

/// The thread that does jobs.
struct SolverThread {
    thread: Thread,
    /// The job that it solves itself, without a process; zero: none.
    busy: Arc<AtomicU64>,
    /// A job that was asked to stop at its hard limit, and when.
    overdue: Option<(Epoch, Instant)>,
}

impl CurrentJob {
    fn none() -> Self {
        Self {
            over: Arc::default(),
            grant: None,
            since: Instant::now(),
            bytes: Vec::new(),
            result: Arc::default(),
            trouble: String::new(),
            control: JobControl::default(),
        }
    }
}

impl Supervisor {
    /// Waits for the coordinator; nothing if it is to stop before.
    pub(crate) fn open(
        config: WorkerConfig,
        solve: SolveFn,
        orphaned: Arc<AtomicBool>,
    ) -> Result<Option<Self>, WorkerError> {
        let limit = config.idle_limit.map(|limit| limit.as_millis() as Millis);
        let machine = limit.map_or_else(WorkerMachine::default, WorkerMachine::leaving_when_idle);
        let place = match &config.job {
            Some(command) => JobRunner::Process(JobProcess::new(command.clone())),
            None => JobRunner::Thread(solve, start_threads(config.threads)?),
        };
        let Some(line) = CoordinatorLink::open(&config, draw_session())? else {
            return Ok(None);
        };
        let (line, leaving) = (Arc::new(line), Arc::<AtomicBool>::default());
        let (say, news) = channel();
        let hello = Arc::new(hello(&config, line.session));
        let talker = || Talker {
            line: Arc::clone(&line),
            hello: Arc::clone(&hello),
            known: Cell::new(false),
            unheard: Cell::new(None),
            stop: Arc::clone(&leaving),
            news: say.clone(),
        };
        let (orders, queue) = channel();
        let speaker = talker();
        let meshes = Meshes::new(config.meshes);
        start("cullet-talk", move || speaker.run(&queue, meshes))?;
        let (renewals, queue) = channel();
        let renewer = talker();
        start("cullet-renew", move || renew(&renewer, &queue))?;
        let (cancel_watches, queue) = channel();
        let watcher = talker();
        start("cullet-cancel", move || watch_for_cancel(&watcher, &queue))?;
        let (jobs, queue) = channel();
        let busy = Arc::<AtomicU64>::default();
        let mark = Arc::clone(&busy);
        let thread = start("cullet-job", move || work(place, &queue, &say, &mark))?;
        Ok(Some(Self {
            config,
            machine,
            start: Instant::now(),
            news,
            queues: TaskQueues { orders, renewals, cancel_watches, jobs },
            line,
            current: CurrentJob::none(),
            solver: SolverThread { thread, busy, overdue: None },
            orphaned,
            leaving,
        }))
    }

    /// Asks for jobs and does them until asked to stop, drained or idle for too long.
    pub(crate) fn work(mut self) {
        let mut quitting = false;
        self.step(WorkerInput::Begin);
        while !self.machine.left() && !self.orphaned.load(Ordering::Relaxed) {
            if !quitting && self.config.stop.load(Ordering::Relaxed) {
                quitting = true;
                self.leaving.store(true, Ordering::Relaxed);
                self.step(WorkerInput::Quit);
                continue;
            }
            let wake = self.machine.wake().map_or(Millis::MAX, |at| at.saturating_sub(self.now()));
            match self.news.recv_timeout(LOOK.min(Duration::from_millis(wake))) {
                Ok(news) => self.take(news),
                Err(RecvTimeoutError::Timeout) => self.step(WorkerInput::Tick),
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.look_at_overdue();
        }
        self.current.over.store(true, Ordering::Relaxed);
        let Self { queues, line, solver, current, orphaned, .. } = self;
        drop(queues);
        if orphaned.load(Ordering::Relaxed) {
            // The job process is waited for, so that what it cost is counted as ours.
            current.control.cancel();
            let _panicked = solver.thread.join();
        } else {
            line.close();
        }
    }

    fn now(&self) -> Millis {
        self.start.elapsed().as_millis() as Millis
    }

    fn take(&mut self, news: TalkerResult) {
        // What a job that was killed still has to say is not about the one at hand.
        let at = self.machine.at().map(|work| work.epoch);
        let next = news.grant;
        match news.heard {
            WorkerInput::Fetched { epoch } if at == Some(epoch) => self.current.bytes = news.bytes,
            WorkerInput::Solved { epoch, .. } if at == Some(epoch) => {
                self.current.result = Arc::new(news.bytes);
            }
            WorkerInput::Trouble { epoch, .. } if at == Some(epoch) => {
                self.current.trouble = news.text;
            }
            _ => {}
        }
        self.log(news.heard, at);
        if let WorkerInput::Grant { .. } | WorkerInput::Receipt { .. } = news.heard
            && next.is_some()
        {
            self.current.grant = next;
        }
        self.step(news.heard);
    }

    /// A line about the job at hand.
    fn log(&self, heard: WorkerInput, at: Option<Epoch>) {
        let Some(grant) =
            self.current.grant.filter(|grant| at.is_some_and(|at| at.0 == grant.epoch.0))
        else {
            return;
        };
        let (run, job, seconds) =
            (grant.run, grant.job.short(), self.current.since.elapsed().as_secs_f64());
        match heard {
            WorkerInput::Fetched { .. } => tracing::debug!(run, job, seconds, "job here"),
            WorkerInput::Solved { .. } => tracing::info!(run, job, seconds, "job solved"),
            WorkerInput::Receipt { .. } => tracing::debug!(run, job, seconds, "result handed in"),
            WorkerInput::Stop { .. } => {
                tracing::info!(run, job, seconds, "job not wanted any more");
            }
            WorkerInput::Trouble { trouble, .. } => {
                tracing::warn!(
                    run,
                    job,
                    seconds,
                    ?trouble,
                    text = self.current.trouble,
                    "job given back"
                );
            }
            _ => {}
        }
    }

    fn step(&mut self, heard: WorkerInput) {
        let now = self.now();
        let before = self.machine.at();
        let acts = self.machine.step(now, heard);
        let at = self.machine.at();
        if at != before {
            self.current.over.store(true, Ordering::Relaxed);
            self.current.over = Arc::default();
            let wanted = at.map(|work| (work.job, work.epoch, Arc::clone(&self.current.over)));
            let _closed = wanted.map(|wanted| self.queues.cancel_watches.send(wanted));
        }
        for act in acts {
            self.act(heard, act);
        }
    }

    /// The threads end only after this one does, so their queues are open.
    fn act(&mut self, heard: WorkerInput, act: WorkerOutput) {
        match act {
            WorkerOutput::Ask(Question::Renew { job, epoch, begun }) => {
                let _closed =
                    self.queues.renewals.send((job, epoch, begun, self.current.control.clone()));
            }
            WorkerOutput::Ask(question) => {
                // Where it is sent away, it has the answer to its question.
                if question == Question::Bye && heard == WorkerInput::Tick {
                    self.let_go();
                }
                let text = match question {
                    Question::Fail { .. } => std::mem::take(&mut self.current.trouble),
                    _ => String::new(),
                };
                let order = TalkerTask::Ask(question, text, Arc::clone(&self.current.result));
                let _closed = self.queues.orders.send(order);
            }
            WorkerOutput::Fetch(work) => {
                self.current.control = JobControl::default();
                self.current.trouble.clear();
                self.current.since = Instant::now();
                let grant = self.current.grant.filter(|grant| grant.epoch.0 == work.epoch.0);
                if let Some(grant) = grant {
                    let (run, job) = (grant.run, grant.job.short());
                    tracing::info!(run, job, epoch = grant.epoch.0, "job taken");
                    let _closed = self
                        .queues
                        .orders
                        .send(TalkerTask::Fetch(grant, self.current.control.clone()));
                }
            }
            WorkerOutput::Solve(work) => {
                let task = (
                    work.epoch,
                    std::mem::take(&mut self.current.bytes),
                    self.current.control.clone(),
                );
                let _closed = self.queues.jobs.send(task);
            }
            WorkerOutput::Kill(epoch) => {
                self.current.control.cancel();
                // Only the clock kills at the limit.
                if heard == WorkerInput::Tick {
                    self.current.trouble = OVERDUE.to_owned();
                    self.solver.overdue = Some((epoch, Instant::now()));
                }
            }
            WorkerOutput::Leave => {}
        }
    }

    /// It leaves: the answer to its last question for work, which may be held for long, is not
    /// waited for.
    fn let_go(&self) {
        let asked = self.leaving.swap(true, Ordering::Relaxed);
        if let (false, Some(limit)) = (asked, self.config.idle_limit) {
            tracing::info!(seconds = limit.as_secs_f64(), "no job for so long: leaving");
        }
    }

    /// A solver on a thread of ours that hangs can be ended with the process alone.
    fn look_at_overdue(&mut self) {
        let Some((epoch, since)) =
            self.solver.overdue.filter(|(_, since)| since.elapsed() >= GRACE)
        else {
            return;
        };
        self.solver.overdue = None;
        if self.solver.busy.load(Ordering::Relaxed) == epoch.0 && self.config.exit_when_wedged {
            tracing::error!("the solver has hung for {} s", since.elapsed().as_secs());
            std::process::exit(EXIT_WEDGED);
        }
    }
}

type Thread = thread::JoinHandle<()>;

fn start(name: &str, run: impl FnOnce() + Send + 'static) -> Result<Thread, WorkerError> {
    let spawned = thread::Builder::new().name(name.into()).spawn(run);
    spawned.map_err(|e| WorkerError::Threads { threads: 1, text: e.to_string() })
}

/// What a worker says of itself.
fn hello(config: &WorkerConfig, session: SessionId) -> Hello {
    let exe = config.job.as_ref().map(|job| job.exe.as_path());
    Hello {
        session,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        build: config.build.unwrap_or_else(|| build_of(exe)),
        cores: thread::available_parallelism().map_or(1, |cores| cores.get() as u32),
        threads: config.threads as u32,
        memory: config.job.as_ref().and_then(|job| job.memory),
        families: config.families.clone(),
    }
}

/// The digest of a program, by default of this one: what is not equal byte for byte may round
/// differently. One that cannot be read is like no other.
fn build_of(exe: Option<&Path>) -> [u8; 32] {
    static OWN: OnceLock<[u8; 32]> = OnceLock::new();
    let none = || digest(&draw_session().0.to_le_bytes());
    let of = |path: &Path| std::fs::read(path).map_or_else(|_| none(), |bytes| digest(&bytes));
    let own = || std::env::current_exe().map_or_else(|_| none(), |path| of(&path));
    exe.map_or_else(|| *OWN.get_or_init(own), of)
}

/// Says how far jobs are; hears whether they are wanted.
fn renew(talker: &Talker, queue: &Receiver<Renewal>) {
    for (job, epoch, begun, watch) in queue {
        let permille = if begun { watch.permille().max(1) } else { 0 };
        let since = Instant::now();
        let said = talker.renew((job, epoch), permille);
        let seconds = since.elapsed().as_secs_f64();
        tracing::debug!(epoch = epoch.0, seconds, heard = said.is_ok(), "renewed");
        // Silence is nothing to act on: the result will be handed in in any case.
        if let Ok(news) = said
            && talker.news.send(news).is_err()
        {
            return;
        }
    }
}

/// Hears as soon as a job is not wanted any more.
fn watch_for_cancel(talker: &Talker, queue: &Receiver<CancellableJob>) {
    for (job, epoch, over) in queue {
        let wait = |time: Duration| {
            let since = Instant::now();
            while !over.load(Ordering::Relaxed) && since.elapsed() < time {
                thread::sleep(LOOK.min(time));
            }
        };
        wait(SOON);
        while !over.load(Ordering::Relaxed) {
            match talker.watch_for_cancel((job, epoch), &over) {
                Ok(Some(false)) => {}
                Ok(Some(true)) => {
                    if talker.news.send(TalkerResult::of(WorkerInput::Stop { epoch })).is_err() {
                        return;
                    }
                    break;
                }
                Ok(None) => wait(AGAIN),
                // One that does not know the question: renewals say it, later.
                Err(error) => {
                    tracing::debug!("not told when a job is not wanted any more: {error:?}");
                    break;
                }
            }
        }
    }
}

/// Does jobs, one at a time.
fn work(
    mut place: JobRunner,
    tasks: &Receiver<Task>,
    news: &Sender<TalkerResult>,
    busy: &AtomicU64,
) {
    for (epoch, bytes, watch) in tasks {
        let ended = match &mut place {
            _ if watch.cancelled() => AttemptResult::Cancelled,
            JobRunner::Thread(solve, threads) => {
                busy.store(epoch.0, Ordering::Relaxed);
                let ended = threads.install(|| attempt(&bytes, solve, &watch));
                busy.store(0, Ordering::Relaxed);
                ended
            }
            JobRunner::Process(process) => process.solve(&bytes, &watch),
        };
        let trouble = |trouble: Trouble, text: String| TalkerResult {
            text,
            ..TalkerResult::of(WorkerInput::Trouble { epoch, trouble })
        };
        let result = match ended {
            AttemptResult::Solved(bytes) => {
                let digest = Digest(digest(&bytes));
                TalkerResult { bytes, ..TalkerResult::of(WorkerInput::Solved { epoch, digest }) }
            }
            // Whoever cancelled it has gone on.
            AttemptResult::Cancelled => continue,
            AttemptResult::Invalid(text) => trouble(Trouble::Invalid, text),
            AttemptResult::Died(text) => trouble(Trouble::Crashed, text),
            AttemptResult::Unable(text) => trouble(Trouble::Dropped, text),
        };
        if news.send(result).is_err() {
            return;
        }
    }
}

/// A number that no other life of a worker has: time, process and a counter, well mixed.
fn draw_session() -> SessionId {
    use std::hash::{BuildHasher, Hasher, RandomState};
    let mut hasher = RandomState::new().build_hasher();
    hasher.write_u32(std::process::id());
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    hasher.write_u128(since.map_or(0, |since| since.as_nanos()));
    SessionId(hasher.finish())
}
