//! The queue of runs as a state machine: what somebody wants becomes an event or a refusal, an
//! event changes the board. It has no clock and no files; events are what the journal keeps, and
//! the same events in the same order make the same board.
//!
//! Invariants: a ticket of a user is one run as long as that is remembered; a run that is over
//! changes by `retry` and `delete` alone; no two runs write into one folder, and no number comes
//! again; what was wished of a run while it ran is done when it ends, also across a crash.

mod deaths;
mod suspects;

use cullet_proto::service::{FileInfo, JobCounts, MAX_PRIORITY, State};
pub(crate) use deaths::{CoordinatorDeaths, Reached};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::{BTreeMap, VecDeque};

/// Runs that may wait; a further one is refused for now.
pub(super) const MAX_WAITING: usize = 1_024;
/// Of these, those of one user: nobody fills the queue alone.
pub(super) const MAX_WAITING_OF_ONE: usize = 768;
/// Runs remembered; beyond it the oldest that is over is forgotten, of the user who has most.
pub(super) const MAX_KEPT: usize = 4_096;
/// Waiting this long counts as much as one step of priority \[ms\], so that nobody waits for ever.
const AGEING_MS: u64 = 600_000;

/// A run, as the journal has it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct RunEntry {
    pub(super) run: u64,
    pub(super) order: Submission,
    pub(super) state: State,
    pub(super) wish: Option<Wish>,
    pub(super) attempt: u32,
    pub(super) folder: Option<String>,
    pub(super) started: Option<u64>,
    pub(super) ended: Option<u64>,
    pub(super) end: RunEnd,
    /// None in a line that is older than this field.
    #[serde(default)]
    pub(super) deaths: CoordinatorDeaths,
}

/// A scene as a user submitted it, with its options.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Submission {
    pub(super) ticket: String,
    pub(super) user: String,
    pub(super) name: String,
    pub(super) sweep: String,
    pub(super) priority: i32,
    pub(super) overrides: Vec<String>,
    pub(super) at: u64,
    /// Digest of its bundle in hex; none in a line that is older than this field.
    #[serde(default)]
    pub(super) bundle: String,
}

/// What somebody wants of a run that goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Wish {
    Cancel,
    Pause,
}

/// How an attempt at a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum AttemptEnd {
    /// At the end of the scene.
    Done,
    /// It could not go on.
    Failed,
    /// The pool gave a job up.
    Stalled,
    /// It was asked to stop: by a wish, or because the coordinator leaves.
    Stopped,
}

/// How a run that is over ended, and what it left.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct RunEnd {
    pub(super) code: Option<u8>,
    pub(super) text: String,
    pub(super) files: Vec<FileInfo>,
    /// Fracture jobs of its last attempt; none in a line that is older than this field.
    #[serde(default)]
    pub(super) jobs: JobCounts,
}

/// A change of the board: what the journal keeps.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "lowercase")]
pub(super) enum BoardEvent {
    /// Somebody handed a run in.
    Submitted { run: u64, order: Submission },
    /// An attempt began, in that folder.
    Started { run: u64, folder: String, at: u64 },
    /// It ended.
    Ended { run: u64, how: AttemptEnd, end: RunEnd, at: u64 },
    /// Somebody wants something of a run that goes on.
    Wished { run: u64, wish: Wish },
    /// A run that waited was paused.
    Paused { run: u64 },
    /// A run that was paused or over is back in the queue.
    Queued { run: u64 },
    /// A run that did not go on is not wanted any more.
    Cancelled { run: u64, end: RunEnd, at: u64 },
    /// A run that is over is not remembered any more; what it left is still on the disk.
    Forgotten { run: u64 },
    /// Now it is not.
    Removed { run: u64 },
    /// Numbers up to this one were given.
    Numbered { last: u64 },
    /// The coordinator died while it went on, after it had come so far.
    Died { run: u64, reached: Reached },
    /// The coordinator came back: what went on then does not now.
    Returned { at: u64 },
    /// All there is to know of a run: what a journal that was written anew begins with.
    Kept { entry: Box<RunEntry> },
}

impl BoardEvent {
    /// The run that it is about, if it is about one.
    pub(super) fn run(&self) -> Option<u64> {
        match self {
            Self::Kept { entry } => Some(entry.run),
            Self::Numbered { .. } | Self::Returned { .. } => None,
            Self::Submitted { run, .. }
            | Self::Started { run, .. }
            | Self::Ended { run, .. }
            | Self::Wished { run, .. }
            | Self::Paused { run }
            | Self::Queued { run }
            | Self::Cancelled { run, .. }
            | Self::Forgotten { run }
            | Self::Removed { run }
            | Self::Died { run, .. } => Some(*run),
        }
    }
}

/// How it stands with a user.
#[derive(Clone, Copy, Default)]
struct Turn<'a> {
    /// Runs that go on.
    busy: usize,
    /// When one began last.
    began: Option<u64>,
    /// Which would be next.
    best: Option<&'a RunEntry>,
}

/// Why something is not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum No {
    #[error("there is no run {0}")]
    Unknown(u64),
    #[error("run {0} is not here any more: it was deleted, or made room for others")]
    Gone(u64),
    #[error("run {run} is {state}: it cannot be {verb}")]
    State { run: u64, state: &'static str, verb: &'static str },
    #[error("{MAX_WAITING} runs wait already, or {MAX_WAITING_OF_ONE} of this user")]
    Full,
    #[error("a priority is from -{MAX_PRIORITY} to {MAX_PRIORITY}")]
    Priority,
}

/// All runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Board {
    entries: BTreeMap<u64, RunEntry>,
    /// Not remembered any more, with something on the disk still.
    leaving: BTreeMap<u64, RunEntry>,
    last: u64,
}

impl Board {
    pub(super) fn get(&self, run: u64) -> Result<&RunEntry, No> {
        let gone = (1..=self.last).contains(&run);
        self.entries.get(&run).ok_or(if gone { No::Gone(run) } else { No::Unknown(run) })
    }

    /// The last number that was given.
    pub(super) fn last(&self) -> u64 {
        self.last
    }

    /// Those that are not remembered any more and have left something on the disk.
    pub(super) fn leaving(&self) -> impl Iterator<Item = &RunEntry> {
        self.leaving.values()
    }

    /// Events that make this board.
    pub(super) fn to_events(&self) -> Vec<BoardEvent> {
        let mut all: Vec<(u64, Vec<BoardEvent>)> = Vec::new();
        // One that nothing has befallen takes no more room than it did.
        let kept = |entry: &RunEntry| match *entry == RunEntry::new(entry.run, &entry.order) {
            true => BoardEvent::Submitted { run: entry.run, order: entry.order.clone() },
            false => BoardEvent::Kept { entry: Box::new(entry.clone()) },
        };
        all.extend(self.entries().map(|entry| (entry.run, vec![kept(entry)])));
        let forgotten = |one: &RunEntry| vec![kept(one), BoardEvent::Forgotten { run: one.run }];
        all.extend(self.leaving().map(|entry| (entry.run, forgotten(entry))));
        all.sort_by_key(|(run, _)| *run);
        let highest = all.last().map_or(0, |(run, _)| *run);
        let last = (highest < self.last).then_some(BoardEvent::Numbered { last: self.last });
        all.into_iter().flat_map(|(_, events)| events).chain(last).collect()
    }

    pub(super) fn entries(&self) -> impl Iterator<Item = &RunEntry> {
        self.entries.values()
    }

    pub(super) fn running(&self) -> impl Iterator<Item = &RunEntry> {
        self.entries().filter(|entry| entry.state == State::Running)
    }

    pub(super) fn count(&self, state: State) -> usize {
        self.entries().filter(|entry| entry.state == state).count()
    }

    /// The run of that ticket.
    pub(super) fn known(&self, user: &str, ticket: &str) -> Option<u64> {
        let same = |e: &&RunEntry| e.order.user == user && e.order.ticket == ticket;
        self.entries().find(same).map(|entry| entry.run)
    }

    /// Whether as many runs wait as may, of all or of this user.
    pub(super) fn is_full(&self, user: &str) -> bool {
        let queued = self.entries().filter(|entry| entry.state == State::Queued);
        let own = queued.filter(|entry| entry.order.user == user).count();
        self.count(State::Queued) >= MAX_WAITING || own >= MAX_WAITING_OF_ONE
    }

    /// What handing that in comes to; forgets the oldest where more than `keep` are remembered.
    pub(super) fn submit(&self, order: Submission, keep: usize) -> Result<Vec<BoardEvent>, No> {
        if !(-MAX_PRIORITY..=MAX_PRIORITY).contains(&order.priority) {
            return Err(No::Priority);
        }
        if self.is_full(&order.user) {
            return Err(No::Full);
        }
        let mut events = vec![BoardEvent::Submitted { run: self.last + 1, order }];
        let extra = (self.entries.len() + 1).saturating_sub(keep.min(MAX_KEPT));
        events.extend(self.oldest(extra).into_iter().map(|run| BoardEvent::Forgotten { run }));
        Ok(events)
    }

    /// The runs to forget next: of those that are over, the oldest of whoever has most of them, so
    /// that nobody's are forgotten for what another hands in.
    fn oldest(&self, most: usize) -> Vec<u64> {
        let mut over: BTreeMap<&str, VecDeque<u64>> = BTreeMap::new();
        for entry in self.entries().filter(|entry| most > 0 && entry.state.is_over()) {
            over.entry(entry.order.user.as_str()).or_default().push_back(entry.run);
        }
        let mut next = || over.values_mut().max_by_key(|runs| runs.len())?.pop_front();
        (0..most).map_while(|_| next()).collect()
    }

    /// `end`: what is left of it if it does not go on.
    pub(super) fn cancel(&self, run: u64, end: RunEnd, at: u64) -> Result<Option<BoardEvent>, No> {
        match self.get(run)? {
            RunEntry { wish: Some(Wish::Cancel), .. } => Ok(None),
            RunEntry { state: State::Running, .. } => {
                Ok(Some(BoardEvent::Wished { run, wish: Wish::Cancel }))
            }
            RunEntry { state: State::Queued | State::Paused, .. } => {
                Ok(Some(BoardEvent::Cancelled { run, end, at }))
            }
            RunEntry { state: State::Cancelled, .. } => Ok(None),
            entry => Err(entry.refuse("cancelled")),
        }
    }

    pub(super) fn pause(&self, run: u64) -> Result<Option<BoardEvent>, No> {
        match self.get(run)? {
            RunEntry { wish: Some(Wish::Pause), .. } => Ok(None),
            RunEntry { state: State::Running, wish: None, .. } => {
                Ok(Some(BoardEvent::Wished { run, wish: Wish::Pause }))
            }
            RunEntry { state: State::Queued, .. } => Ok(Some(BoardEvent::Paused { run })),
            RunEntry { state: State::Paused, .. } => Ok(None),
            entry => Err(entry.refuse("paused")),
        }
    }

    pub(super) fn resume(&self, run: u64) -> Result<Option<BoardEvent>, No> {
        match self.get(run)? {
            RunEntry { state: State::Paused, .. } => Ok(Some(BoardEvent::Queued { run })),
            RunEntry { state: State::Queued, .. } => Ok(None),
            entry => Err(entry.refuse("resumed")),
        }
    }

    pub(super) fn retry(&self, run: u64) -> Result<Option<BoardEvent>, No> {
        match self.get(run)? {
            RunEntry { state: State::Failed | State::Stalled | State::Cancelled, .. } => {
                Ok(Some(BoardEvent::Queued { run }))
            }
            RunEntry { state: State::Queued, .. } => Ok(None),
            entry => Err(entry.refuse("tried again")),
        }
    }

    /// One that went already is gone.
    pub(super) fn delete(&self, run: u64) -> Result<Option<BoardEvent>, No> {
        match self.get(run) {
            Ok(entry) if entry.state.is_over() => Ok(Some(BoardEvent::Forgotten { run })),
            Ok(entry) => Err(entry.refuse("deleted before it is cancelled")),
            Err(No::Gone(_)) => Ok(None),
            Err(no) => Err(no),
        }
    }

    /// The run whose turn it is: of each user the one of highest priority (waiting raises it), then
    /// the oldest; between users the highest priority, raised by the time since a run of that user
    /// last began, so that many queued runs do not delay other users; then the user with the fewest
    /// running, then whose last began first. None while it must run alone and others still run.
    pub(super) fn next(&self, now: u64) -> Option<&RunEntry> {
        let rank = |entry: &RunEntry, since: u64| {
            let waited = now.saturating_sub(since) / AGEING_MS;
            Reverse(i64::from(entry.order.priority).saturating_add_unsigned(waited))
        };
        let mut users: BTreeMap<&str, Turn<'_>> = BTreeMap::new();
        for entry in self.entries() {
            let turn = users.entry(entry.order.user.as_str()).or_default();
            turn.busy += usize::from(entry.state == State::Running);
            turn.began = turn.began.max(entry.started);
            if entry.state == State::Queued {
                let own = |entry: &RunEntry| (rank(entry, entry.order.at), entry.run);
                let best = turn.best.into_iter().chain([entry]);
                turn.best = best.min_by_key(|entry| own(entry));
            }
        }
        let turns = users.into_values().filter_map(|turn| Some((turn.best?, turn)));
        let next = turns.min_by_key(|(best, turn)| {
            let since = best.order.at.max(turn.began.unwrap_or(0));
            (rank(best, since), turn.busy, turn.began, best.run)
        });
        next.map(|(best, _)| best).filter(|entry| self.may_begin(entry))
    }

    /// Takes an event in.
    ///
    /// # Errors
    /// It does not fit what is there: the journal is not one of this board.
    pub(super) fn apply(&mut self, event: &BoardEvent) -> Result<(), No> {
        match event {
            BoardEvent::Submitted { run, order } => self.insert(*run, RunEntry::new(*run, order)),
            BoardEvent::Kept { entry } => self.insert(entry.run, (**entry).clone()),
            BoardEvent::Died { run, reached } => {
                let alone = self.count(State::Running) == 1;
                self.change(*run, &[State::Running], "cut off", |entry| {
                    entry.deaths.count(*reached, alone);
                })
            }
            BoardEvent::Returned { at } => {
                let going = self.entries.values_mut().filter(|entry| entry.state == State::Running);
                going.for_each(|entry| entry.stopped(RunEnd::default(), *at));
                Ok(())
            }
            BoardEvent::Forgotten { run } => self.forget(*run),
            BoardEvent::Removed { run } => {
                self.leaving.remove(run).map(drop).ok_or(No::Unknown(*run))
            }
            BoardEvent::Numbered { last } => {
                self.last = self.last.max(*last);
                Ok(())
            }
            BoardEvent::Started { run, folder, at } => {
                self.change(*run, &[State::Queued], "started", |entry| {
                    entry.state = State::Running;
                    entry.attempt += 1;
                    entry.folder = Some(folder.clone());
                    entry.started = Some(*at);
                })
            }
            BoardEvent::Ended { run, how, end, at } => {
                self.change(*run, &[State::Running], "ended", |entry| match how {
                    AttemptEnd::Done => entry.over(State::Done, end, *at),
                    AttemptEnd::Failed => entry.over(State::Failed, end, *at),
                    AttemptEnd::Stalled => entry.over(State::Stalled, end, *at),
                    AttemptEnd::Stopped => entry.stopped(end.clone(), *at),
                })
            }
            BoardEvent::Wished { run, wish } => {
                self.change(*run, &[State::Running], "stopped", |entry| entry.wish = Some(*wish))
            }
            BoardEvent::Paused { run } => self.change(*run, &[State::Queued], "paused", |entry| {
                entry.state = State::Paused;
            }),
            BoardEvent::Cancelled { run, end, at } => {
                let from = [State::Queued, State::Paused];
                self.change(*run, &from, "cancelled", |entry| {
                    entry.over(State::Cancelled, end, *at);
                })
            }
            BoardEvent::Queued { run } => {
                let from = [State::Paused, State::Failed, State::Stalled, State::Cancelled];
                self.change(*run, &from, "queued", |entry| {
                    entry.requeue();
                    entry.deaths.pardon();
                })
            }
        }
    }

    fn insert(&mut self, run: u64, entry: RunEntry) -> Result<(), No> {
        if run <= self.last {
            let state = self.get(run).map_or("forgotten", |entry| entry.state.word());
            return Err(No::State { run, state, verb: "handed in" });
        }
        self.last = run;
        self.entries.insert(run, entry);
        Ok(())
    }

    fn forget(&mut self, run: u64) -> Result<(), No> {
        let entry = self.get(run)?;
        if !entry.state.is_over() {
            return Err(entry.refuse("forgotten"));
        }
        let entry = self.entries.remove(&run);
        self.leaving.extend(entry.map(|entry| (run, entry)));
        Ok(())
    }

    fn change(
        &mut self,
        run: u64,
        from: &[State],
        verb: &'static str,
        change: impl FnOnce(&mut RunEntry),
    ) -> Result<(), No> {
        let entry = self.entries.get_mut(&run).ok_or(No::Unknown(run))?;
        if !from.contains(&entry.state) {
            return Err(entry.refuse(verb));
        }
        change(entry);
        Ok(())
    }
}

impl RunEntry {
    fn new(run: u64, order: &Submission) -> Self {
        Self {
            run,
            order: order.clone(),
            state: State::Queued,
            wish: None,
            attempt: 0,
            folder: None,
            started: None,
            ended: None,
            end: RunEnd::default(),
            deaths: CoordinatorDeaths::default(),
        }
    }

    /// Whether it does not go on, and may yet.
    pub(super) fn waits(&self) -> bool {
        matches!(self.state, State::Queued | State::Paused)
    }

    fn refuse(&self, verb: &'static str) -> No {
        No::State { run: self.run, state: self.state.word(), verb }
    }

    fn over(&mut self, state: State, end: &RunEnd, at: u64) {
        self.state = state;
        self.wish = None;
        self.ended = Some(at);
        self.end = end.clone();
    }

    fn requeue(&mut self) {
        self.state = State::Queued;
        self.wish = None;
        self.ended = None;
        self.end = RunEnd::default();
    }

    /// An attempt that was stopped, or that a crash stopped.
    fn stopped(&mut self, end: RunEnd, at: u64) {
        match self.wish {
            Some(Wish::Cancel) => self.over(State::Cancelled, &end, at),
            Some(Wish::Pause) => {
                self.requeue();
                self.state = State::Paused;
            }
            None => self.requeue(),
        }
    }
}

#[cfg(test)]
mod tests;
