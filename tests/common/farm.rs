//! A farm around a router, whose processes come back when they end, and a trouble for each of them.

use super::history::{self, Step};
use super::proxy::{Weather, proxy};
use super::{Cullet, Going, children_of, signal};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// A sequence of numbers that a seed names.
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    /// Below `end`.
    pub(crate) fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (x ^ (x >> 31)) % end.max(1)
    }

    /// Between two times \[ms\].
    pub(crate) fn millis(&mut self, from: u64, to: u64) -> Duration {
        Duration::from_millis(from + self.below(to - from + 1))
    }
}

/// What a process is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Role {
    Router,
    Coordinator,
    Worker(usize),
}

/// A place at which a process is, one after another.
pub(crate) struct Post {
    pub(crate) role: Role,
    pub(crate) process: Going,
    /// Since when it is there.
    pub(crate) since: Instant,
    lives: u32,
    killed: bool,
}

pub(crate) struct Farm {
    pub(crate) folder: PathBuf,
    router: String,
    /// The link of each worker.
    pub(crate) links: Vec<(Arc<Weather>, String)>,
    /// The link of clients.
    pub(crate) door: (Arc<Weather>, String),
    pub(crate) posts: Vec<Post>,
    /// Runs at once that the next coordinator is told.
    pub(crate) runs: &'static str,
    /// Who ended though nobody ended it, and how.
    pub(crate) by_themselves: Vec<(Role, Option<i32>)>,
}

impl Farm {
    pub(crate) fn start(folder: PathBuf, workers: usize) -> Self {
        std::fs::create_dir_all(&folder).expect("a folder");
        let router = super::free_endpoint();
        let links = (0..workers).map(|_| proxy(&router)).collect();
        let (door, posts, by_themselves) = (proxy(&router), Vec::new(), Vec::new());
        let runs = "2";
        let mut farm = Self { folder, router, links, door, posts, runs, by_themselves };
        let workers = (0..workers).map(Role::Worker);
        for role in [Role::Router, Role::Coordinator].into_iter().chain(workers) {
            let process = farm.spawn(role, 0);
            farm.posts.push(Post { role, process, since: Instant::now(), lives: 1, killed: false });
        }
        farm
    }

    /// What a life of a process writes.
    pub(crate) fn log_of(&self, role: Role, life: u32) -> PathBuf {
        self.folder.join(format!("{role:?}-{life:04}.log"))
    }

    fn spawn(&self, role: Role, life: u32) -> Going {
        let call = match role {
            Role::Router => Cullet::new(&["router", "--listen", &self.router]),
            Role::Coordinator => {
                let call = ["coordinator", "--router", &self.router, "--runs", self.runs];
                Cullet::new(&call).args(&["--state"]).path(&self.folder.join("state"))
            }
            Role::Worker(k) => Cullet::new(&["worker", "--threads", "1", "--connect"]).args(&[
                &self.links[k].1,
                "--name",
                &format!("w{k}"),
            ]),
        };
        call.env(MARK, &self.folder.to_string_lossy()).log(&self.log_of(role, life)).spawn()
    }

    pub(crate) fn post(&mut self, role: Role) -> &mut Post {
        self.posts.iter_mut().find(|post| post.role == role).expect("a post")
    }

    /// The process at a post is ended at once.
    pub(crate) fn kill(&mut self, role: Role) {
        let post = self.post(role);
        post.process.kill();
        post.killed = true;
    }

    /// The process at a post is told to leave, and does.
    pub(crate) fn stop(&mut self, role: Role) {
        let post = self.post(role);
        signal(post.process.id(), "TERM");
        assert_eq!(post.process.wait(Duration::from_secs(30)), Some(0), "it does not leave");
        post.killed = true;
    }

    /// Ends the process in which a worker's jobs run; whether there was one.
    pub(crate) fn kill_job(&mut self, worker: usize) -> bool {
        let id = self.post(Role::Worker(worker)).process.id();
        let kill = |job: &u32| {
            let mut call = Command::new("kill");
            let status = call.args(["-KILL", &job.to_string()]).stderr(Stdio::null()).status();
            status.is_ok_and(|status| status.success())
        };
        children_of(id).first().is_some_and(kill)
    }

    /// Another in the place of each that was ended or has ended; those that did so by themselves
    /// are written down.
    pub(crate) fn tend(&mut self) {
        for index in 0..self.posts.len() {
            let post = &mut self.posts[index];
            if super::is_alive(post.process.id()) {
                continue;
            }
            let code = post.process.wait(Duration::from_millis(50));
            let (role, life) = (post.role, post.lives);
            if !std::mem::take(&mut post.killed) {
                self.by_themselves.push((role, code));
            }
            let process = self.spawn(role, life);
            self.posts[index] =
                Post { role, process, since: Instant::now(), lives: life + 1, killed: false };
        }
    }

    /// Ends everybody as people do.
    pub(crate) fn leave(&mut self) {
        let order = |post: &Post| match post.role {
            Role::Worker(_) => 0,
            Role::Coordinator => 1,
            Role::Router => 2,
        };
        self.posts.sort_by_key(order);
        for post in &mut self.posts {
            signal(post.process.id(), "TERM");
            let code = post.process.wait(Duration::from_secs(30));
            assert_eq!(code, Some(0), "{:?} does not leave", post.role);
        }
    }

    /// Processes of this farm that are there some seconds after it was left, with those that they
    /// have started: a job process ends by itself once its worker has.
    pub(crate) fn left(&self) -> Vec<u32> {
        let until = Instant::now() + Duration::from_secs(20);
        while Instant::now() < until && !self.there().is_empty() {
            std::thread::sleep(Duration::from_millis(50));
        }
        self.there()
    }

    fn there(&self) -> Vec<u32> {
        let mark = format!("{MARK}={}", self.folder.display());
        let marked = |id: &u32| {
            let all = std::fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
            super::is_alive(*id) && all.split(|byte| *byte == 0).any(|one| one == mark.as_bytes())
        };
        super::processes().filter(marked).collect()
    }

    /// What the logs say.
    pub(crate) fn steps(&self) -> Vec<Step> {
        let mut all = Vec::new();
        for post in &self.posts {
            for life in 0..post.lives {
                if post.role == Role::Coordinator {
                    all.push(Step::Life);
                }
                all.extend(history::steps(&self.log_of(post.role, life)));
            }
        }
        all
    }

    /// All links are as good as they can be.
    pub(crate) fn heal(&self) {
        let all = self.links.iter().chain([&self.door]);
        all.for_each(|(weather, _)| weather.clear());
    }
}

/// An environment variable that only processes of a farm have.
const MARK: &str = "CULLET_TEST_FARM";

impl Weather {
    pub(crate) fn clear(&self) {
        self.silent.store(false, Ordering::SeqCst);
        [&self.delay, &self.rate, &self.flips]
            .iter()
            .for_each(|one| one.store(0, Ordering::SeqCst));
    }
}

/// What a process holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Held {
    /// Memory \[KiB\].
    pub(crate) memory: u64,
    pub(crate) files: u64,
    pub(crate) threads: u64,
}

impl Held {
    pub(crate) fn by(id: u32) -> Option<Self> {
        let place = Path::new("/proc").join(id.to_string());
        let text = std::fs::read_to_string(place.join("status")).ok()?;
        let number = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name))?;
            line.split_whitespace().next()?.parse().ok()
        };
        let files = std::fs::read_dir(place.join("fd")).ok()?.count() as u64;
        Some(Self { memory: number("VmRSS:")?, files, threads: number("Threads:")? })
    }
}
