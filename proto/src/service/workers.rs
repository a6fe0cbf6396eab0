//! Questions about workers, and their answers.

use serde::{Deserialize, Serialize};

/// Bytes of JSON of a page of workers, beyond which the next one begins.
const PAGE: usize = 1 << 20;

/// For which page of the workers somebody asks.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WorkersAfter {
    /// What [`Workers::next`] said; empty for the first page.
    pub after: String,
}

/// The answer to `workers`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Workers {
    /// Workers that are known, by name.
    pub workers: Vec<WorkerInfo>,
    /// After which worker the next page begins; empty on the last one.
    #[serde(default)]
    pub next: String,
}

impl Workers {
    /// The page behind the worker that somebody names, of all that are known, which are sorted by
    /// name and session. A worker on its own always fits.
    #[must_use]
    pub fn page(all: Vec<WorkerInfo>, asked: &WorkersAfter) -> Self {
        let (mut page, mut bytes) = (Self::default(), 0);
        for worker in all.into_iter().skip_while(|worker| place(worker) <= asked.after) {
            bytes += serde_json::to_string(&worker).map_or(0, |text| text.len());
            if let Some(last) = page.workers.last().filter(|_| bytes > PAGE) {
                page.next = place(last);
                break;
            }
            page.workers.push(worker);
        }
        page
    }
}

/// Where a worker stands in the list. A name has no character that sorts before the space.
fn place(worker: &WorkerInfo) -> String {
    format!("{} {}", worker.name, worker.session)
}

/// A worker.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkerInfo {
    /// Its name.
    pub name: String,
    /// One life of its process, in hex.
    pub session: String,
    /// Whether its link is up.
    pub up: bool,
    /// Whether another that is there has had the same name for longer than a restart takes.
    #[serde(default)]
    pub twin: bool,
    /// Whether it gets no more jobs.
    pub drained: bool,
    /// Threads that it gives a job.
    pub threads: u32,
    /// Cores of its machine.
    pub cores: u32,
    /// Most memory that a job may hold \[bytes\]; `null`: no limit.
    pub memory: Option<u64>,
    /// The version of its program.
    pub version: String,
    /// The first digits of the digest of its program: results of the same one are the same bits.
    pub build: String,
    /// What it can solve, as `brittle single double`; `null`: whatever it is asked.
    pub solvers: Option<Vec<String>>,
    /// Jobs that it holds, in hex; of very many the first.
    pub jobs: Vec<String>,
    /// Results of it that count.
    pub done: u64,
}

/// Which worker gets no more jobs; of several with the name, all.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drain {
    /// Its name.
    pub worker: String,
}

/// The answer to a [`Drain`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Drained {
    /// Always true.
    pub noted: bool,
    /// The lives that are there under the name, in hex: all of them get no more jobs.
    #[serde(default)]
    pub sessions: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::super::MAX_LINE;
    use super::{WorkerInfo, Workers, WorkersAfter};

    #[test]
    fn pages_have_every_worker_once_and_each_fits_into_an_answer() {
        let worker = |n: usize| WorkerInfo {
            name: format!("w{:04}", n / 4),
            session: format!("{n:016x}"),
            solvers: Some(vec!["s".repeat(64); 32]),
            ..WorkerInfo::default()
        };
        let all: Vec<WorkerInfo> = (0..4_096).map(worker).collect();
        let (mut seen, mut asked, mut pages) = (Vec::new(), WorkersAfter::default(), 0);
        loop {
            let page = Workers::page(all.clone(), &asked);
            assert!(serde_json::to_string(&page).expect("JSON").len() < MAX_LINE / 2);
            seen.extend(page.workers);
            pages += 1;
            if page.next.is_empty() {
                break;
            }
            asked.after = page.next;
        }
        assert!(seen == all && pages > 4, "{} workers on {pages} pages", seen.len());
        assert_eq!(Workers::page(Vec::new(), &asked), Workers::default());
    }
}
