//! The jobs that runs want: their bytes, their results, who waits for them, who tried them.

use super::attempts::Attempted;
use super::settlement::Try;
use cullet_dispatch::{Epoch, Job, Run};
use cullet_proto::outline::{Outline, Parted};
use cullet_proto::{JobId, Verdict};
use std::collections::{BTreeMap, VecDeque};
use std::iter;
use std::sync::Arc;
use std::time::Instant;

/// Attempts that are kept of a job.
const MAX_ATTEMPTS: usize = 16;

/// An attempt at a job, by a grant.
#[derive(Clone, Debug)]
struct Attempt {
    epoch: Epoch,
    worker: String,
    /// What the worker is.
    about: String,
    granted: Instant,
    /// When it was over, and how.
    ended: Option<(Instant, String)>,
}

impl Attempt {
    /// That it began, and how it was lost.
    fn news(&self, job: JobId) -> impl Iterator<Item = Attempted> {
        let (grant, worker) = (self.epoch.0, &self.worker);
        let told = |at, lost| Attempted { job, grant, worker: worker.clone(), at, lost };
        let lost = self.ended.as_ref().filter(|(_, how)| !how.is_empty());
        let lost = lost.map(|(at, how)| told(*at, Some(how.clone())));
        iter::once(told(self.granted, None)).chain(lost)
    }
}

/// What is known of a job that has openings to settle.
#[derive(Clone, Debug)]
pub(super) struct Wanted {
    /// When each opening was, by run.
    pub(super) openings: BTreeMap<Run, VecDeque<Instant>>,
    /// Everything but its large parts.
    pub(super) outline: Arc<Vec<u8>>,
    /// Digests of its large parts.
    parts: Vec<[u8; 32]>,
    /// Its last trouble.
    pub(super) trouble: String,
    /// Attempts at it, the first ones.
    attempts: Vec<Attempt>,
    /// Its verdict, before it settles.
    pub(super) result: Option<Verdict>,
    /// How far it is \[1/1000\].
    pub(super) permille: u16,
}

impl Wanted {
    /// What has befallen it so far.
    pub(super) fn news(&self, job: JobId) -> impl Iterator<Item = Attempted> {
        self.attempts.iter().flat_map(move |attempt| attempt.news(job))
    }

    /// Its attempts, in times since an opening of it.
    pub(super) fn tries(&self, opened: Instant) -> Vec<Try> {
        let since = |at: Instant| at.saturating_duration_since(opened);
        let told = |attempt: &Attempt| Try {
            worker: attempt.worker.clone(),
            granted: since(attempt.granted),
            ended: attempt.ended.as_ref().map(|(at, _)| since(*at)),
            how: attempt.ended.as_ref().map(|(_, how)| how.clone()).unwrap_or_default(),
        };
        self.attempts.iter().map(told).collect()
    }
}

/// The jobs that are wanted.
#[derive(Debug, Default)]
pub(super) struct Ledger {
    jobs: BTreeMap<Job, Wanted>,
    /// Their large parts by digest, and by how many jobs each is wanted.
    parts: BTreeMap<[u8; 32], (Arc<Vec<u8>>, usize)>,
}

impl Ledger {
    pub(super) fn is_empty(&self) -> bool {
        self.jobs.is_empty()
    }

    /// A run wants a job: its bytes, or why it has none. How far it is, where that is news to the
    /// run \[1/1000\].
    pub(super) fn open(&mut self, run: Run, id: JobId, job: Result<Parted, String>) -> u16 {
        if !self.jobs.contains_key(&Job(id.0)) {
            let trouble = job.as_ref().err().cloned().unwrap_or_default();
            let (outline, parts) = job.map(|job| (job.outline, job.parts)).unwrap_or_default();
            let names = parts.iter().map(|(name, _)| *name).collect();
            for (name, part) in parts {
                self.parts.entry(name).or_insert((part, 0)).1 += 1;
            }
            let wanted = Wanted {
                openings: BTreeMap::new(),
                outline: Arc::new(outline),
                parts: names,
                trouble,
                attempts: Vec::new(),
                result: None,
                permille: 0,
            };
            self.jobs.insert(Job(id.0), wanted);
        }
        let Some(wanted) = self.jobs.get_mut(&Job(id.0)) else {
            return 0;
        };
        let openings = wanted.openings.entry(run).or_default();
        let news = openings.is_empty();
        openings.push_back(Instant::now());
        if news { wanted.permille } else { 0 }
    }

    /// One opening of a job is over: what is known of the job, which is forgotten with the last.
    pub(super) fn close(&mut self, run: Run, job: Job) -> Option<(Wanted, Instant)> {
        let wanted = self.jobs.get_mut(&job)?;
        let openings = wanted.openings.get_mut(&run)?;
        let opened = openings.pop_front()?;
        if openings.is_empty() {
            wanted.openings.remove(&run);
        }
        if !wanted.openings.is_empty() {
            return Some((wanted.clone(), opened));
        }
        let kept = self.jobs.remove(&job)?;
        for name in &kept.parts {
            if let Some((_, jobs)) = self.parts.get_mut(name) {
                *jobs -= 1;
                if *jobs == 0 {
                    self.parts.remove(name);
                }
            }
        }
        Some((kept, opened))
    }

    pub(super) fn get(&self, job: Job) -> Option<&Wanted> {
        self.jobs.get(&job)
    }

    /// A large part of a job that is wanted.
    pub(super) fn part(&self, name: &[u8; 32]) -> Option<Arc<Vec<u8>>> {
        self.parts.get(name).map(|(part, _)| Arc::clone(part))
    }

    /// All bytes of a job.
    pub(super) fn whole(&self, job: Job) -> Option<Vec<u8>> {
        let wanted = self.jobs.get(&job)?;
        let parts = wanted.parts.iter().map(|name| self.part(name));
        let parts: Vec<_> = parts.collect::<Option<_>>()?;
        let parts: Vec<&[u8]> = parts.iter().map(|part| part.as_slice()).collect();
        Outline::open(&wanted.outline).ok()?.whole(&parts)
    }

    /// Keeps words about a job's last trouble, for the message if it is abandoned.
    pub(super) fn note_trouble(&mut self, id: JobId, text: &str) {
        if let Some(wanted) = self.jobs.get_mut(&Job(id.0)) {
            wanted.trouble = cullet_proto::verdict::cut(text);
        }
    }

    /// The same trouble for every job.
    pub(super) fn trouble_all(&mut self, text: &str) {
        self.jobs.values_mut().for_each(|wanted| wanted.trouble = text.to_owned());
    }

    /// An attempt begins, unless it is known; by whom, and what that one is. The news, if it is.
    pub(super) fn granted(
        &mut self,
        id: JobId,
        epoch: Epoch,
        (worker, about): (&str, String),
    ) -> Option<Attempted> {
        let attempts = &mut self.jobs.get_mut(&Job(id.0))?.attempts;
        let known = attempts.iter().any(|attempt| attempt.epoch == epoch);
        if known || attempts.len() >= MAX_ATTEMPTS {
            return None;
        }
        let (worker, granted) = (worker.to_owned(), Instant::now());
        let attempt = Attempt { epoch, worker, about, granted, ended: None };
        let news = attempt.news(id).next();
        attempts.push(attempt);
        news
    }

    /// An attempt is over; the news, if it was lost.
    pub(super) fn ended(&mut self, id: JobId, epoch: Epoch, how: &str) -> Option<Attempted> {
        let wanted = self.jobs.get_mut(&Job(id.0))?;
        let attempt = wanted.attempts.iter_mut().find(|attempt| attempt.epoch == epoch)?;
        let told = match (how, wanted.trouble.as_str()) {
            ("", _) | (_, "") => how.to_owned(),
            (how, trouble) => format!("{how}: {trouble}"),
        };
        attempt.ended = Some((Instant::now(), told));
        attempt.news(id).nth(1)
    }

    /// A line for each attempt at a job that is over: for which runs, by whom, when, for how long.
    pub(super) fn lines(&self, job: Job, runs: &str) -> String {
        let attempts = self.jobs.get(&job).map_or(&[][..], |wanted| &wanted.attempts);
        let line = |attempt: &Attempt| {
            let (at, how) = attempt.ended.as_ref()?;
            let since = |from: Instant, to: Instant| to.saturating_duration_since(from);
            let begun = since(attempts[0].granted, attempt.granted).as_secs_f64();
            let took = since(attempt.granted, *at).as_secs_f64();
            let who = format!("run {runs}, worker {} ({})", attempt.worker, attempt.about);
            Some(format!("{who}, from {begun:.2} s on for {took:.2} s: {how}\n"))
        };
        attempts.iter().filter_map(line).collect()
    }

    /// Keeps a verdict whose bytes were checked, for when the machine settles the job.
    pub(super) fn keep(&mut self, id: JobId, verdict: Verdict) {
        if let Some(wanted) = self.jobs.get_mut(&Job(id.0)) {
            wanted.result.get_or_insert(verdict);
        }
    }

    /// A worker says how far it is: how much further that is than before, for each run.
    pub(super) fn progress(&mut self, id: JobId, permille: u16) -> Vec<(Run, i64)> {
        let Some(wanted) = self.jobs.get_mut(&Job(id.0)) else {
            return Vec::new();
        };
        let gain = i64::from(permille) - i64::from(wanted.permille);
        wanted.permille = permille;
        wanted.openings.keys().map(|run| (*run, gain)).collect()
    }
}
