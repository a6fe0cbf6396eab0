//! The job process: a solver where it can be killed.
//!
//! The supervisor keeps one such process and speaks to it over its standard input and output, in
//! frames: length, kind, bytes. It ends with its input, so it never outlives its supervisor. What
//! it does, panic, abort, run out of memory, hang, ends an attempt and nothing else.

use crate::error::EXIT_WEDGED;
use crate::solve::{JobControl, SolveFn, guarded};
use crate::threads::start_threads;
use cullet_proto::specimen::SpecimenJob;
use cullet_proto::{FractureJob, Verdict, WindowJob, chunks};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often the supervisor looks at the job and its memory.
const LOOK: Duration = Duration::from_millis(20);
/// A job that is asked to stop may end its slice within this.
const GRACE: Duration = Duration::from_secs(2);
/// How often a job says how far it is, at most.
const TOLD: Duration = Duration::from_millis(100);
/// Longest frame \[bytes\].
const MAX_FRAME: u64 = chunks::MAX_BLOB + 1024;

/// Longest line that it may say \[bytes\]; a longer one becomes several.
const MAX_SAID: u64 = 1024;

/// How long the last words of a process that has ended may take.
const HEARD: Duration = Duration::from_millis(500);

/// What the end of a job is called that took too much memory.
const OVER: &str = "over the limit of memory";
/// What the runtime says where the system gives no more.
const NO_MEMORY: &str = "memory allocation of";

/// To the job process.
const WORK: u8 = 1;
const CANCEL: u8 = 2;
const LIMIT: u8 = 7;
/// From the job process.
const PROGRESS: u8 = 3;
const VERDICT: u8 = 4;
const CANCELLED: u8 = 5;
const INVALID: u8 = 6;

/// How job processes are started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobCommand {
    /// The program.
    pub exe: PathBuf,
    /// Its arguments.
    pub args: Vec<String>,
    /// Most memory \[bytes\] that a job may hold; more ends the attempt. What is held is looked at;
    /// the system refuses at once what is asked for far beyond it.
    pub memory: Option<u64>,
}

/// How an attempt at a job ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum AttemptResult {
    /// With a verdict, encoded.
    Solved(Vec<u8>),
    /// It was asked to stop, and did.
    Cancelled,
    /// The job cannot be read, or its verdict cannot be sent.
    Invalid(String),
    /// It died.
    Died(String),
    /// It could not begin.
    Unable(String),
}

/// A job process, if there is one, and how to start one.
pub(crate) struct JobProcess {
    command: JobCommand,
    alive: Option<Alive>,
}

struct Alive {
    child: Child,
    input: ChildStdin,
    frames: Receiver<(u8, Vec<u8>)>,
    /// The last that it has said, and who listens.
    said: Arc<Mutex<String>>,
    relay: JoinHandle<()>,
}

impl JobProcess {
    pub(crate) fn new(command: JobCommand) -> Self {
        Self { command, alive: None }
    }

    /// Solves in the process; ends it if it does not end by itself when asked to stop. A specimen
    /// has a process of its own: what it costs is read off it.
    pub(crate) fn solve(&mut self, job: &[u8], watch: &JobControl) -> AttemptResult {
        let alone = SpecimenJob::is(job);
        if alone {
            self.end();
        }
        let attempt = self.solve_here(job, watch);
        if alone {
            self.end();
        }
        attempt
    }

    fn solve_here(&mut self, job: &[u8], watch: &JobControl) -> AttemptResult {
        let mut alive = match self.alive.take().map_or_else(|| self.start(), Ok) {
            Ok(alive) => alive,
            Err(error) => {
                let exe = self.command.exe.display();
                return AttemptResult::Unable(format!(
                    "the job process {exe} does not start: {error}"
                ));
            }
        };
        if let Err(error) = send(&mut alive.input, WORK, job) {
            return AttemptResult::Died(format!("{}: {error}", alive.end()));
        }
        let attempt = self.wait(&mut alive, watch);
        match attempt {
            AttemptResult::Solved(_) | AttemptResult::Cancelled | AttemptResult::Invalid(_) => {
                self.alive = Some(alive);
            }
            AttemptResult::Died(_) | AttemptResult::Unable(_) => drop(alive.end()),
        }
        attempt
    }

    fn start(&self) -> std::io::Result<Alive> {
        let mut command = Command::new(&self.command.exe);
        // An interrupt from the terminal is for the supervisor to act on.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command
            .args(&self.command.args)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let pipes = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(mut input), Some(mut output), Some(errors)) = pipes else {
            return Err(std::io::Error::other("it has no pipes"));
        };
        let said = Arc::<Mutex<String>>::default();
        let last = Arc::clone(&said);
        let relay = move || relay(errors, &last);
        let relay = std::thread::Builder::new().name("cullet-relay".into()).spawn(relay)?;
        if let Some(memory) = self.command.memory {
            send(&mut input, LIMIT, &asked_for(memory).to_le_bytes())?;
        }
        let (send, frames) = channel();
        std::thread::Builder::new().name("cullet-frames".into()).spawn(move || {
            while let Ok(frame) = receive(&mut output) {
                if send.send(frame).is_err() {
                    break;
                }
            }
        })?;
        Ok(Alive { child, input, frames, said, relay })
    }

    fn wait(&self, alive: &mut Alive, watch: &JobControl) -> AttemptResult {
        let mut told: Option<Instant> = None;
        loop {
            match alive.frames.recv_timeout(LOOK) {
                Ok((PROGRESS, bytes)) => {
                    if let [a, b] = bytes[..] {
                        watch.progress(f64::from(u16::from_le_bytes([a, b])) / 1000.0);
                    }
                }
                Ok((VERDICT, bytes)) => return AttemptResult::Solved(bytes),
                Ok((CANCELLED, _)) => return AttemptResult::Cancelled,
                Ok((INVALID, text)) => {
                    return AttemptResult::Invalid(String::from_utf8_lossy(&text).into_owned());
                }
                Ok((kind, _)) => {
                    return AttemptResult::Died(format!("it sent a frame of kind {kind}"));
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return AttemptResult::Died(self.over_request(alive.end()));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Some(text) = self.over_memory(alive.child.id()) {
                return AttemptResult::Died(text);
            }
            match told {
                Some(since) if since.elapsed() > GRACE => {
                    return AttemptResult::Died("it did not stop when told, and was killed".into());
                }
                None if watch.cancelled() => {
                    told = Some(Instant::now());
                    // A process that is gone already shows at the other pipe.
                    let _gone = send(&mut alive.input, CANCEL, &[]);
                }
                Some(_) | None => {}
            }
        }
    }

    fn end(&mut self) {
        if let Some(alive) = self.alive.take() {
            alive.kill();
        }
    }

    /// Whether the process holds more memory than it may. Where the system does not say, it does
    /// not.
    fn over_memory(&self, id: u32) -> Option<String> {
        let limit = self.command.memory?;
        let held = resident(id)?;
        (held > limit).then(|| {
            let (held, limit) = (held >> 20, limit >> 20);
            format!("{OVER}: it held {held} MiB; the limit is {limit} MiB")
        })
    }

    /// How it ended, with its name where it asked for memory that it may not have.
    fn over_request(&self, ended: String) -> String {
        match self.command.memory {
            Some(limit) if ended.contains(NO_MEMORY) => {
                format!("{OVER}: it asked for far more than its {} MiB; {ended}", limit >> 20)
            }
            _ => ended,
        }
    }
}

impl Drop for JobProcess {
    fn drop(&mut self) {
        self.end();
    }
}

impl Alive {
    /// Ends the process, if it has not ended; how it did.
    fn end(&mut self) -> String {
        let own = self.child.try_wait().ok().flatten();
        let _ended_already = self.child.kill();
        let ended = match own.map_or_else(|| self.child.wait(), Ok) {
            Ok(status) => format!("the job process ended: {status}"),
            Err(error) => format!("the job process ended: {error}"),
        };
        // What it said is on its way still; one of its own that lives on would keep the pipe open.
        let since = Instant::now();
        while !self.relay.is_finished() && since.elapsed() < HEARD {
            std::thread::sleep(Duration::from_millis(1));
        }
        let said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        match said.is_empty() {
            true => ended,
            false => format!("{ended}; it said: {said}"),
        }
    }

    fn kill(mut self) {
        drop(self.end());
    }
}

/// What a job says as it dies, panics or aborts becomes lines of the log, so that nothing else is
/// there. The last one is kept, or the one that says that there is no memory: where the runtime is
/// told to trace, its trace follows.
fn relay(errors: impl Read, last: &Mutex<String>) {
    let mut reader = BufReader::new(errors);
    let mut line = Vec::new();
    while reader.by_ref().take(MAX_SAID).read_until(b'\n', &mut line).is_ok_and(|read| read > 0) {
        let text = String::from_utf8_lossy(&line);
        tracing::warn!("the job process says: {}", text.trim_end());
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if !last.contains(NO_MEMORY) {
            text.trim_end().clone_into(&mut last);
        }
        line.clear();
    }
}

/// Memory that a process holds \[bytes\].
fn resident(id: u32) -> Option<u64> {
    status(&format!("/proc/{id}/status"), "VmRSS:")
}

/// What a job may ask for that may hold so much: some of it is never held, such as stacks of
/// threads, what an allocator keeps, and large tables that are hardly touched.
fn asked_for(held: u64) -> u64 {
    held.saturating_add(held / 4).saturating_add(256 << 20)
}

/// Where a machine runs out of memory, jobs are ended before those who look after them.
fn volunteer() {
    let _none_but_linux = std::fs::write("/proc/self/oom_score_adj", "500");
}

/// From now on the system gives this process so many bytes more than it has for data, threads'
/// stacks among it, and no more: whoever asks for more aborts. Where it has no such limit, what is
/// held is looked at all the same.
fn limit_memory(bytes: &[u8]) {
    let Some(more) = bytes.first_chunk().map(|bytes| u64::from_le_bytes(*bytes)) else {
        return;
    };
    let has = status("/proc/self/status", "VmData:").unwrap_or(0);
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
        let maximum = getrlimit(Resource::Data).maximum;
        let limit = has.saturating_add(more).min(maximum.unwrap_or(u64::MAX));
        let limit = Rlimit { current: Some(limit), maximum };
        if let Err(error) = setrlimit(Resource::Data, limit) {
            tracing::warn!("the system does not limit memory: {error}");
        }
    }
}

fn status(path: &str, what: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(what))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib << 10)
}

fn send(pipe: &mut impl Write, kind: u8, bytes: &[u8]) -> std::io::Result<()> {
    pipe.write_all(&(bytes.len() as u64).to_le_bytes())?;
    pipe.write_all(&[kind])?;
    pipe.write_all(bytes)?;
    pipe.flush()
}

fn receive(pipe: &mut impl Read) -> std::io::Result<(u8, Vec<u8>)> {
    let (mut length, mut kind) = ([0; 8], [0]);
    pipe.read_exact(&mut length)?;
    pipe.read_exact(&mut kind)?;
    let length = u64::from_le_bytes(length);
    if length > MAX_FRAME {
        return Err(std::io::Error::other("a frame over the limit"));
    }
    let mut bytes = Vec::new();
    pipe.take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 != length {
        return Err(std::io::ErrorKind::UnexpectedEof.into());
    }
    Ok((kind[0], bytes))
}

/// An attempt in this process, with a solver in it.
pub(crate) fn attempt(bytes: &[u8], solve: &SolveFn, watch: &JobControl) -> AttemptResult {
    let verdict = if SpecimenJob::is(bytes) {
        SpecimenJob::decode(bytes)
            .map(|job| Some(Verdict::Measured(Box::new(crate::specimen::solve(&job)))))
    } else if WindowJob::is(bytes) {
        let solve = |job: &WindowJob| guarded(&job.family, || crate::window::solve(job, watch));
        WindowJob::decode(bytes).map(|job| solve(&job))
    } else {
        FractureJob::decode(bytes).map(|job| guarded(&job.solver, || solve(&job, watch)))
    };
    let verdict = match verdict {
        Ok(verdict) => verdict,
        Err(error) => return AttemptResult::Invalid(error.to_string()),
    };
    match verdict.map(|verdict| verdict.encode()) {
        Some(Ok(blob)) => AttemptResult::Solved(blob),
        Some(Err(error)) => AttemptResult::Invalid(format!("its verdict cannot be sent: {error}")),
        None => AttemptResult::Cancelled,
    }
}

/// What the job process does: solves what comes on its standard input until that ends.
///
/// # Errors
/// Threads do not start, or standard output is gone.
pub fn serve_jobs(threads: usize, solve: SolveFn) -> std::io::Result<()> {
    volunteer();
    let pool = start_threads(threads).map_err(std::io::Error::other)?;
    let current = Arc::new(Mutex::new(JobControl::default()));
    let seen = Arc::clone(&current);
    let (send_work, work) = channel::<Vec<u8>>();
    std::thread::Builder::new().name("cullet-orders".into()).spawn(move || {
        let mut input = std::io::stdin().lock();
        while let Ok((kind, bytes)) = receive(&mut input) {
            match kind {
                WORK => {
                    *seen.lock().unwrap_or_else(PoisonError::into_inner) = JobControl::default();
                    if send_work.send(bytes).is_err() {
                        break;
                    }
                }
                LIMIT => limit_memory(&bytes),
                _ => seen.lock().unwrap_or_else(PoisonError::into_inner).cancel(),
            }
        }
        // The supervisor is gone, and whatever is being solved is for nobody.
        std::process::exit(0);
    })?;
    for bytes in work {
        let watch = current.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let (done, over) = channel::<()>();
        let (teller, solve) = (watch.clone(), &solve);
        let attempt = std::thread::scope(|scope| {
            scope.spawn(move || tell_progress(&teller, &over));
            let attempt = pool.install(|| attempt(&bytes, solve, &watch));
            drop(done);
            attempt
        });
        let (kind, bytes) = match attempt {
            AttemptResult::Solved(blob) => (VERDICT, blob),
            AttemptResult::Cancelled => (CANCELLED, Vec::new()),
            AttemptResult::Invalid(text)
            | AttemptResult::Died(text)
            | AttemptResult::Unable(text) => (INVALID, text.into_bytes()),
        };
        send(&mut std::io::stdout().lock(), kind, &bytes)?;
    }
    Ok(())
}

fn tell_progress(watch: &JobControl, over: &Receiver<()>) {
    let mut last = 0;
    while let Err(RecvTimeoutError::Timeout) = over.recv_timeout(TOLD) {
        let permille = watch.permille();
        if permille != last {
            last = permille;
            if send(&mut std::io::stdout().lock(), PROGRESS, &permille.to_le_bytes()).is_err() {
                std::process::exit(EXIT_WEDGED);
            }
        }
    }
}
