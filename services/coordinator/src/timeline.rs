//! Who solved what and when in a run, in all its attempts: as a picture (SVG) and as a trace that
//! Chrome and Perfetto open.

mod history;
mod picture;

pub(super) use history::RunHistory;
pub(super) use picture::{svg, trace};

use serde::{Deserialize, Serialize};

/// A job at a worker.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Stretch {
    /// Whose.
    pub(super) worker: String,
    /// Wall time since the run's attempt began at which the worker got the job \[s\].
    pub(super) from: f64,
    /// The same at which it was over \[s\].
    pub(super) to: f64,
    /// How it was lost; empty: it was not.
    pub(super) lost: String,
}

/// An attempt at a job that has not settled: that it began, or how it was lost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct JobAttempt {
    /// The first digits of its id.
    pub(super) job: String,
    /// By which grant.
    pub(super) grant: u64,
    /// Whose attempt.
    pub(super) worker: String,
    /// Wall time since the run's attempt began \[s\].
    pub(super) at: f64,
    /// How it was lost; `None`: it began.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) lost: Option<String>,
}

/// The attempts at a job that has not settled, by their grants.
#[derive(Clone, Debug, Default)]
pub(super) struct Attempts(Vec<(u64, Stretch)>);

impl Attempts {
    /// Takes in what befalls the job; whether that is news.
    pub(super) fn take(&mut self, news: &JobAttempt) -> bool {
        let JobAttempt { grant, worker, at, lost, .. } = news;
        let known = self.0.iter_mut().find(|(of, _)| of == grant);
        match (known, lost) {
            (Some((_, one)), Some(how)) if one.lost.is_empty() => {
                (one.to, one.lost) = (*at, how.clone());
                true
            }
            (None, None) => {
                let (worker, lost) = (worker.clone(), String::new());
                self.0.push((*grant, Stretch { worker, from: *at, to: *at, lost }));
                true
            }
            (Some(_), _) | (None, Some(_)) => false,
        }
    }

    /// The same of a job that was wanted between these times, and not settled \[s\].
    pub(super) fn stretches(&self, opened: f64, settled: f64) -> Vec<Stretch> {
        let told = |(_, one): &(u64, Stretch)| {
            let to = if one.lost.is_empty() { settled } else { one.to };
            Stretch { from: one.from.max(opened), to: to.max(opened), ..one.clone() }
        };
        self.0.iter().map(told).collect()
    }
}

/// How a job ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum JobFate {
    /// With fragments, or numbers.
    Solved,
    /// No solver took it.
    Refused,
    /// In the solver.
    Failed,
    /// The pool gave it up.
    Abandoned,
    /// The run did not want it any more.
    Cancelled,
    /// It had not when its attempt was over.
    Unsettled,
    /// It had not when the coordinator died.
    CutOff,
}

impl JobFate {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Refused => "refused",
            Self::Failed => "failed",
            Self::Abandoned => "abandoned",
            Self::Cancelled => "cancelled",
            Self::Unsettled => "unsettled",
            Self::CutOff => "cut off",
        }
    }

    fn sentence(self) -> &'static str {
        match self {
            Self::Unsettled => "not settled when the run was over",
            Self::CutOff => "not settled when the coordinator died",
            _ => self.word(),
        }
    }
}

/// A fracture job of a run that settled, or that an attempt wanted to its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct JobTimes {
    /// The first digits of its id.
    pub(super) job: String,
    /// Whose result counts.
    pub(super) worker: String,
    /// Wall time since the attempt began at which it was wanted \[s\].
    pub(super) opened: f64,
    /// The same at which the run had its verdict \[s\].
    pub(super) settled: f64,
    /// Attempts made.
    pub(super) attempts: u32,
    /// Whether it was answered from what had been kept.
    pub(super) kept: bool,
    /// When it was at which worker.
    pub(super) tries: Vec<Stretch>,
    /// How it ended.
    pub(super) ending: JobFate,
}

/// One attempt at the run, in wall times since the first one began \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    /// Which attempt, from 1.
    attempt: u32,
    from: f64,
    to: f64,
    /// Whether the coordinator died then.
    cut_off: bool,
}

/// A run's attempts and jobs. Times are since the first attempt began.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Timeline {
    /// When that was \[ms since 1970\].
    began: Option<u64>,
    spans: Vec<Span>,
    jobs: Vec<JobTimes>,
    /// Whether there was no room to write down all jobs of an earlier attempt.
    untold: bool,
}

impl Timeline {
    /// Of a run with one attempt.
    pub(super) fn of(jobs: Vec<JobTimes>) -> Self {
        let mut all = Self::default();
        all.add((1, 0), jobs, 0.0, false);
        all
    }

    /// A further attempt: its number, when it began \[ms since 1970\], and its jobs, in times since
    /// then. It lasted as long as they did, and at least so long \[s\].
    fn add(
        &mut self,
        (attempt, began): (u32, u64),
        jobs: Vec<JobTimes>,
        lasted: f64,
        cut_off: bool,
    ) {
        let first = *self.began.get_or_insert(began);
        let before = self.spans.last().map_or(0.0, |span| span.to);
        // Clocks are set back, too.
        let from = (began.saturating_sub(first) as f64 / 1e3).max(before);
        let lasted = jobs.iter().map(|job| job.settled).fold(lasted, f64::max);
        self.spans.push(Span { attempt, from, to: from + lasted, cut_off });
        self.jobs.extend(jobs.into_iter().map(|job| job.later(from)));
    }

    fn end(&self) -> f64 {
        self.spans.last().map_or(0.0, |span| span.to)
    }

    /// What lies between two attempts: from when to when, and whether the coordinator had died.
    fn gaps(&self) -> impl Iterator<Item = Span> {
        let gap = |two: &[Span]| Span { from: two[0].to, to: two[1].from, ..two[0] };
        self.spans.windows(2).map(gap)
    }
}

impl Span {
    /// What happened between two attempts.
    fn what(&self) -> &'static str {
        match self.cut_off {
            true => "the coordinator was away: it had died, and what had settled was kept",
            false => "the run did not go on: what had settled was kept",
        }
    }
}

impl JobTimes {
    /// One that had not settled when its attempt was over.
    pub(super) fn left(
        job: String,
        (opened, settled): (f64, f64),
        tries: Vec<Stretch>,
        ending: JobFate,
    ) -> Self {
        let attempts = tries.len() as u32;
        let worker = String::new();
        Self { job, worker, opened, settled, attempts, kept: false, tries, ending }
    }

    /// The same in times since something earlier.
    fn later(mut self, by: f64) -> Self {
        self.opened += by;
        self.settled += by;
        for one in &mut self.tries {
            one.from += by;
            one.to += by;
        }
        self
    }

    /// Whose it is: of who solved it, or, where nobody has, of who was at it last.
    fn who(&self) -> &str {
        let last = self.tries.last().map_or("nobody", |last| &last.worker);
        match (self.kept, self.worker.as_str()) {
            (true, _) => "kept",
            (false, "") if matches!(self.ending, JobFate::Unsettled | JobFate::CutOff) => last,
            (false, "") => "nobody",
            (false, worker) => worker,
        }
    }

    fn colour(&self) -> &'static str {
        match (self.kept, self.ending) {
            (true, _) => "#8a8f98",
            (false, JobFate::Solved) => "#3f7fb5",
            (false, JobFate::Unsettled | JobFate::CutOff) => "#c4c8ce",
            (false, _) => "#b5483f",
        }
    }

    /// When the first worker got it, or it was over without one.
    fn granted(&self) -> f64 {
        self.tries.first().map_or(self.settled, |first| first.from.max(self.opened))
    }

    /// When it was where, and what came of it.
    fn bars(&self) -> Vec<Bar<'_>> {
        let bar = |(index, one)| self.bar(index, one);
        let tries: Vec<Bar<'_>> = self.tries.iter().enumerate().map(bar).collect();
        if !tries.is_empty() {
            return tries;
        }
        let ending = self.ending.word();
        let text = match self.kept {
            true => format!("{ending} before: nobody was asked"),
            false => self.ending.sentence().to_owned(),
        };
        let (who, from, to) = (self.who(), self.opened, self.settled);
        vec![Bar { who, from, to, colour: self.colour(), ending, attempt: 0, text }]
    }

    fn bar<'a>(&'a self, index: usize, one: &'a Stretch) -> Bar<'a> {
        let from = one.from.clamp(self.opened, self.settled);
        let to = one.to.clamp(from, self.settled);
        let word = self.ending.word();
        let (ending, colour, text) = match (one.lost.as_str(), self.ending) {
            ("", _) if one.worker == self.worker => (word, self.colour(), word.to_owned()),
            ("", JobFate::Solved | JobFate::Refused | JobFate::Failed) => {
                (OVERTAKEN, LATE, "overtaken: another's result came first".to_owned())
            }
            ("", JobFate::Unsettled | JobFate::CutOff) => {
                (word, self.colour(), self.ending.sentence().to_owned())
            }
            ("", _) => (word, self.colour(), format!("stopped: the job was {word}")),
            (lost, _) => ("lost", LOST, self.lost(one, &why(lost))),
        };
        let text = format!("{text}; attempt {} of {}", index + 1, self.tries.len());
        Bar { who: &one.worker, from, to, colour, ending, attempt: index + 1, text }
    }

    /// What came of a job when one had lost it.
    fn lost(&self, one: &Stretch, why: &str) -> String {
        let next = self.tries.iter().find(|other| other.from >= one.to);
        let beside = self.tries.iter().find(|other| other.from < one.to && other.to > one.to);
        let then = match (next.or(beside), self.ending) {
            (Some(other), _) if other.from < one.to => format!("{} was at it too", other.worker),
            (Some(next), _) => format!("sent again to {}", next.worker),
            (None, JobFate::Abandoned) => "the job was given up".to_owned(),
            (None, _) => "not sent again".to_owned(),
        };
        format!("lost with {} ({why}); {then}", one.worker)
    }
}

/// A job at a worker, as it is shown.
struct Bar<'a> {
    who: &'a str,
    from: f64,
    to: f64,
    colour: &'static str,
    /// How it ended, in a word.
    ending: &'static str,
    /// Which attempt, from 1; 0: nobody was asked.
    attempt: usize,
    /// The reason, in words.
    text: String,
}

/// How an attempt ends where another one was first.
const OVERTAKEN: &str = "overtaken";
/// The colour of one.
const LATE: &str = "#9ab8d3";
/// An attempt that was lost.
const LOST: &str = "#d98b2b";

/// Why an attempt was lost, for people: what the pool says, its first word in words.
fn why(lost: &str) -> String {
    let end = lost.find([' ', ':']).unwrap_or(lost.len());
    let words = match &lost[..end] {
        "Down" => "its process or its link ended",
        "Crashed" => "its solver died",
        "Dropped" => "it gave the job back",
        "Silent" => "nothing was heard of it",
        "TooLong" => "it took longer than it may",
        other => other,
    };
    format!("{words}{}", &lost[end..])
}

#[cfg(test)]
mod tests;
