//! Worker processes kept by the pool.

use super::error::LinkError;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Pause before a process that ended is started again; doubles while it keeps ending early.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
/// Longest such pause.
const LAST_PAUSE: Duration = Duration::from_secs(5);
/// A process that lived this long has not ended early.
const EARLY: Duration = Duration::from_secs(10);

/// Processes in a row that may end before they ask for work: after them a place stays empty, for
/// the next one would end too.
const MAX_STILLBORN: u32 = 6;

/// How long a process that is let go may take to end.
const LET_GO: Duration = Duration::from_millis(1500);

/// Worker processes to keep.
#[derive(Clone, Debug)]
pub struct SpawnConfig {
    /// The program.
    pub exe: PathBuf,
    /// How many workers there are.
    pub workers: usize,
    /// Threads that each gives a job.
    pub threads: usize,
    /// Arguments before ours (`--connect E --name N --threads T --parent-watch`).
    pub args: Vec<String>,
    /// What their names begin with.
    pub prefix: String,
}

impl SpawnConfig {
    /// `exe worker`, so many of so many threads.
    #[must_use]
    pub fn new(exe: PathBuf, workers: usize, threads: usize) -> Self {
        Self { exe, workers, threads, args: vec!["worker".into()], prefix: String::new() }
    }
}

/// One place for a worker process; a name is used for one process only.
#[derive(Debug)]
struct ProcessSlot {
    child: Option<Child>,
    name: String,
    born: Instant,
    pause: Duration,
    next: Instant,
    /// Whether the process has asked for work.
    alive: bool,
    /// Processes in a row that ended before that, and how the last one did.
    stillborn: u32,
    ending: String,
}

#[derive(Debug)]
pub(super) struct Children {
    config: SpawnConfig,
    endpoint: String,
    slots: Vec<ProcessSlot>,
    named: u64,
    pub(super) respawned: u64,
}

impl Children {
    pub(super) fn start(config: SpawnConfig, endpoint: &str) -> Result<Self, LinkError> {
        let endpoint = endpoint.to_owned();
        let mut all = Self { config, endpoint, slots: Vec::new(), named: 0, respawned: 0 };
        for _ in 0..all.config.workers {
            let (name, now) = (all.name(), Instant::now());
            // Stopping here drops `all`, which ends those that did start.
            let child = Some(all.spawn(&name)?);
            all.slots.push(ProcessSlot {
                child,
                name,
                born: now,
                pause: FIRST_PAUSE,
                next: now,
                alive: false,
                stillborn: 0,
                ending: String::new(),
            });
        }
        Ok(all)
    }

    fn name(&mut self) -> String {
        self.named += 1;
        format!("{}w{}", self.config.prefix, self.named)
    }

    fn spawn(&self, name: &str) -> Result<Child, LinkError> {
        let mut command = Command::new(&self.config.exe);
        // An interrupt from the terminal is for us to act on: the worker is needed to the end.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command
            .args(&self.config.args)
            .args(["--connect", &self.endpoint, "--name", name])
            .args(["--threads", &self.config.threads.to_string(), "--parent-watch"])
            // What a person's shell says of an identity is not theirs.
            .env_remove("CULLET_TLS")
            // The pipe closes when this process ends, however it ends: the worker watches it.
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .map_err(|source| LinkError::Spawn { exe: self.config.exe.clone(), source })
    }

    /// Process numbers of those that live.
    pub(super) fn pids(&self) -> Vec<u32> {
        self.slots.iter().filter_map(|slot| slot.child.as_ref().map(Child::id)).collect()
    }

    /// Whether it is one of these, who end as we do.
    pub(super) fn has(&self, name: &str) -> bool {
        self.slots.iter().any(|slot| slot.name == name)
    }

    /// The process of that name asks for work.
    pub(super) fn alive(&mut self, name: &str) {
        if let Some(slot) = self.slots.iter_mut().find(|slot| slot.name == name) {
            (slot.alive, slot.stillborn) = (true, 0);
        }
    }

    /// Why no process will ever ask for work, if so.
    pub(super) fn hopeless(&self) -> Option<String> {
        let last = self.slots.last()?;
        self.slots.iter().all(ProcessSlot::given_up).then(|| {
            let exe = self.config.exe.display();
            let ending = &last.ending;
            format!(
                "{exe} ended {MAX_STILLBORN} times before it asked for work, last with {ending}"
            )
        })
    }

    /// Names of the processes that ended since the last call; starts others in their place.
    pub(super) fn tend(&mut self) -> Vec<String> {
        let now = Instant::now();
        let mut ended = Vec::new();
        for slot in &mut self.slots {
            let Some(child) = &mut slot.child else {
                continue;
            };
            let Ok(Some(status)) = child.try_wait() else {
                continue;
            };
            tracing::warn!("worker {} ended: {status}", slot.name);
            ended.push(slot.name.clone());
            slot.child = None;
            slot.ended(status.to_string(), now);
        }
        for index in 0..self.slots.len() {
            let slot = &self.slots[index];
            if slot.child.is_none() && slot.next <= now && !slot.given_up() {
                self.replace(index, now);
            }
        }
        ended
    }

    fn replace(&mut self, index: usize, now: Instant) {
        let name = self.name();
        match self.spawn(&name) {
            Ok(child) => {
                self.respawned += 1;
                let slot = &mut self.slots[index];
                (slot.child, slot.name) = (Some(child), name);
                (slot.born, slot.alive) = (now, false);
            }
            Err(error) => {
                tracing::error!("{error}");
                let slot = &mut self.slots[index];
                (slot.born, slot.alive) = (now, false);
                slot.ended(error.to_string(), now);
            }
        }
    }
}

impl ProcessSlot {
    /// Its process ended, and the next one has to wait.
    fn ended(&mut self, how: String, now: Instant) {
        self.next = now + self.pause;
        let early = self.born.elapsed() < EARLY;
        self.pause = if early { (self.pause * 2).min(LAST_PAUSE) } else { FIRST_PAUSE };
        self.stillborn = if self.alive { 0 } else { self.stillborn + 1 };
        self.ending = how;
        if self.given_up() {
            let (name, ending) = (&self.name, &self.ending);
            tracing::error!("worker {name} is not started again: {ending}");
        }
    }

    fn given_up(&self) -> bool {
        self.child.is_none() && self.stillborn >= MAX_STILLBORN
    }
}

impl Drop for Children {
    /// Leaves no process behind. Each is let go by the end of its input, so that it waits for its
    /// job process and what that cost is counted as ours; what does not end by itself is killed.
    fn drop(&mut self) {
        let mut children: Vec<_> = self.slots.iter_mut().filter_map(|s| s.child.take()).collect();
        for child in &mut children {
            drop(child.stdin.take());
        }
        let since = Instant::now();
        while since.elapsed() < LET_GO {
            children.retain_mut(|child| !matches!(child.try_wait(), Ok(Some(_))));
            if children.is_empty() {
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        for child in &mut children {
            let _ended_already = child.kill();
        }
        for child in &mut children {
            let _reaped_already = child.wait();
        }
    }
}
