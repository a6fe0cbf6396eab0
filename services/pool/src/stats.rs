//! What a pool and each of its runs have done and are doing.

use cullet_dispatch::Counts;
use cullet_proto::pool::QuestionRefusal;

/// What the pool has done and is doing for one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunStats {
    /// Jobs opened.
    pub opened: u64,
    /// Jobs settled.
    pub settled: u64,
    /// Of these, refused by the solvers.
    pub refused: u64,
    /// Of these, failed in the solver.
    pub failed: u64,
    /// Of these, abandoned.
    pub abandoned: u64,
    /// Attempts beyond a job's first.
    pub resent: u64,
    /// Jobs waiting for a worker now.
    pub waiting: u64,
    /// Jobs at workers now.
    pub running: u64,
    /// How far those are, summed \[1/1000\].
    pub permille: u64,
    /// Workers whose link is up.
    pub workers: u64,
    /// Of these, those that take jobs: they were not drained.
    pub ready: u64,
    /// Whether jobs of it wait that none of these can solve.
    pub unable: bool,
}

impl RunStats {
    pub(super) fn of(counts: &Counts, held: u64, permille: i64) -> Self {
        Self {
            opened: counts.opened + held,
            settled: counts.settled,
            refused: counts.refused,
            failed: counts.failed,
            abandoned: counts.abandoned,
            resent: counts.resent,
            waiting: counts.waiting + held,
            running: counts.running,
            permille: permille.max(0) as u64,
            ..Self::default()
        }
    }
}

/// What a pool has done and is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoolStats {
    /// Of all runs.
    pub jobs: RunStats,
    /// Workers whose link is up now.
    pub workers: u64,
    /// Workers whose question for work waits for a job.
    pub asking: u64,
    /// Worker processes started again after they ended.
    pub respawned: u64,
    /// Results of a pure job that contradicted an earlier one: must be zero.
    pub alarms: u64,
    /// Late results of another build than the one that has the job, which do not count.
    pub fenced: u64,
    /// Jobs that wait though workers are here, none of which can do them.
    pub unschedulable: u64,
    /// Openings that had to wait for room.
    pub queued: u64,
    /// Jobs in quarantine.
    pub quarantined: u64,
    /// Second attempts at jobs that took long.
    pub hedged: u64,
    /// Attempts of an earlier life of the coordinator that went on in this one.
    pub adopted: u64,
    /// Openings answered from the cache.
    pub cached: u64,
    /// Chunks that came damaged and were sent again.
    pub damaged: u64,
    /// Signs of life of workers that went: a worker left, or its link did.
    pub lost: u64,
    /// Signs of life that came back: a link flapped.
    pub back: u64,
    /// Workers that are there under a name that another has too.
    pub duplicate_names: u64,
    /// Messages refused at the door.
    pub refusals: Refusals,
    /// Bytes of meshes sent to workers.
    pub mesh_bytes: u64,
    /// Worker processes kept here now; their numbers are [`crate::Pool::pids`].
    pub children: u64,
}

/// Messages refused at the door, by why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refusals {
    /// Of another generation of the wire.
    pub unsupported: u64,
    /// Larger than a message may be.
    pub too_large: u64,
    /// Not what a message is, or not to any question that there is.
    pub malformed: u64,
    /// Of a worker that has not said who it is.
    pub stranger: u64,
    /// Of a worker that speaks for a session of another name.
    pub foreign: u64,
    /// Of a worker of a name that too many have at once.
    pub too_many_sessions: u64,
}

impl Refusals {
    pub(crate) fn count(&mut self, refusal: &QuestionRefusal) {
        *match refusal {
            QuestionRefusal::Unsupported { .. } => &mut self.unsupported,
            QuestionRefusal::TooLarge { .. } => &mut self.too_large,
            QuestionRefusal::Malformed(_) => &mut self.malformed,
            QuestionRefusal::Stranger => &mut self.stranger,
            QuestionRefusal::Foreign => &mut self.foreign,
            QuestionRefusal::TooManySessions { .. } => &mut self.too_many_sessions,
        } += 1;
    }

    /// Each with its name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, u64); 6] {
        let Self { unsupported, too_large, malformed, stranger, foreign, too_many_sessions } =
            *self;
        [
            ("unsupported", unsupported),
            ("too_large", too_large),
            ("malformed", malformed),
            ("stranger", stranger),
            ("foreign", foreign),
            ("too_many_sessions", too_many_sessions),
        ]
    }
}
