//! Worker processes kept by the pool.

use super::LinkError;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Pause before a process that ended is started again; doubles while it keeps ending early.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
/// Longest such pause.
const LAST_PAUSE: Duration = Duration::from_secs(5);
/// A process that lived this long has not ended early.
const EARLY: Duration = Duration::from_secs(10);

/// Worker processes to keep.
#[derive(Clone, Debug)]
pub struct SpawnConfig {
    /// The program.
    pub exe: PathBuf,
    /// How many.
    pub workers: usize,
    /// Threads that each gives a job.
    pub threads: usize,
    /// Arguments before ours (`--connect E --name N --threads T --parent-watch`).
    pub args: Vec<String>,
}

impl SpawnConfig {
    /// `exe worker`, so many of so many threads.
    #[must_use]
    pub fn new(exe: PathBuf, workers: usize, threads: usize) -> Self {
        Self { exe, workers, threads, args: vec!["worker".into()] }
    }
}

/// One place for a worker process; a name is used for one process only.
#[derive(Debug)]
struct Slot {
    child: Option<Child>,
    name: String,
    born: Instant,
    pause: Duration,
    next: Instant,
}

#[derive(Debug)]
pub(super) struct Children {
    config: SpawnConfig,
    endpoint: String,
    slots: Vec<Slot>,
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
            all.slots.push(Slot { child, name, born: now, pause: FIRST_PAUSE, next: now });
        }
        Ok(all)
    }

    fn name(&mut self) -> String {
        self.named += 1;
        format!("w{}", self.named)
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
            slot.next = now + slot.pause;
            let early = slot.born.elapsed() < EARLY;
            slot.pause = if early { (slot.pause * 2).min(LAST_PAUSE) } else { FIRST_PAUSE };
        }
        for index in 0..self.slots.len() {
            if self.slots[index].child.is_none() && self.slots[index].next <= now {
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
                (slot.child, slot.name, slot.born) = (Some(child), name, now);
            }
            Err(error) => {
                tracing::error!("{error}");
                self.slots[index].next = now + LAST_PAUSE;
            }
        }
    }
}

impl Drop for Children {
    /// Leaves no process behind.
    fn drop(&mut self) {
        let mut children: Vec<_> = self.slots.iter_mut().filter_map(|s| s.child.take()).collect();
        for child in &mut children {
            let _ended_already = child.kill();
        }
        for child in &mut children {
            let _reaped_already = child.wait();
        }
    }
}
