//! What the thread that owns the pool takes in.

use super::attempts::AttemptNews;
use super::settlement::Settlement;
use super::skill_table::Skill;
use super::stats::RunStats;
use cullet_dispatch::{Event, Run, Share, Skills};
use cullet_proto::outline::Parted;
use cullet_proto::{JobId, SessionId, WorkerId};
use std::collections::{BTreeSet, VecDeque};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};
use zenoh::query::Query;

/// An input of the pool's thread.
#[derive(Debug)]
pub(super) enum PoolInput {
    /// A question from a worker or client.
    Question(Query),
    /// A sign of life came or went.
    Link { name: WorkerId, session: SessionId, up: bool },
    /// A run begins: its settlements go there.
    Begin(Run, Share, Listener),
    /// A run wants a job.
    Open(Run, JobId, Opening),
    /// Something about a run, or a wish about a worker.
    Say(Event),
    /// Of the runs of earlier lives only these want anything.
    Claimants(BTreeSet<u64>),
    /// The worker of that name gets no further job.
    Drain(WorkerId, Sender<()>),
    /// No worker is answered any more: another coordinator has this one's name, or will.
    Leave,
    /// The end.
    Quit,
}

/// Who hears of a run.
#[derive(Debug)]
pub(super) struct Listener {
    pub(super) settle: Sender<(JobId, Settlement)>,
    pub(super) stats: Arc<Mutex<RunStats>>,
    pub(super) attempts: AttemptNews,
    pub(super) over: bool,
    /// Its number for people, in log lines.
    pub(super) label: u64,
    /// What it wants and there was no room for, in order.
    pub(super) held: VecDeque<(JobId, Opening)>,
    /// Why it gets nothing any more, if it wanted too much.
    pub(super) out: Option<String>,
    /// Sum of how far the jobs at work are \[1/1000\].
    pub(super) permille: i64,
    /// What its jobs have asked of workers.
    pub(super) needs: BTreeSet<Skills>,
}

/// A job that a run wants.
#[derive(Debug)]
pub(super) struct Opening {
    /// The job and what it asks of a worker; or why it cannot be sent.
    pub(super) content: Result<(Parted, Vec<Skill>), String>,
    /// The job whose result it starts from.
    pub(super) after: Option<JobId>,
}
