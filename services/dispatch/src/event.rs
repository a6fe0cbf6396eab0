//! What the machine can hear.

/// Milliseconds on the shell's own steady clock; only differences matter.
pub type Millis = u64;

/// A job, named by the digest of its problem: same problem, same job.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Job(pub [u8; 32]);

impl std::fmt::Debug for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c, d, ..] = self.0;
        write!(f, "Job({a:02x}{b:02x}{c:02x}{d:02x})")
    }
}

/// The digest of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest(pub [u8; 32]);

/// A worker process, by the number it drew at its start: it lasts one process lifetime.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Worker(pub u64);

/// The name of a worker, as a number: several processes may have it, beside one another or one
/// after another, and whose they are is the same. What dies under one of them counts for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WorkerName(pub u64);

/// The program that a worker runs, by a digest: the same program gives the same bits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Build(pub [u8; 32]);

impl std::fmt::Debug for Build {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c, d, ..] = self.0;
        write!(f, "Build({a:02x}{b:02x}{c:02x}{d:02x})")
    }
}

/// Things that a worker can do, a bit each, by numbers that the shell gives out.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Skills(pub u64);

impl std::fmt::Debug for Skills {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Skills({:b})", self.0)
    }
}

impl Skills {
    /// None.
    pub const NONE: Self = Self(0);
    /// All.
    pub const ALL: Self = Self(u64::MAX);

    /// Whether all of `need` are among them.
    #[must_use]
    pub fn meet(self, need: Self) -> bool {
        need.0 & !self.0 == 0
    }
}

/// A run: one stream of openings, settled in its own order. The shell gives numbers and never
/// reuses one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Run(pub u64);

/// A run by the number that it keeps in all lives of the coordinator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Claimant(pub u64);

/// On whose behalf runs are made: the pool is shared evenly between tenants first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tenant(pub u64);

/// A run's claim on the pool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// On whose behalf.
    pub tenant: Tenant,
    /// Each step up doubles the run's share among the runs of its tenant; at most
    /// [`Share::HIGHEST`].
    pub priority: u8,
}

impl Share {
    /// Highest priority.
    pub const HIGHEST: u8 = 9;
    /// Priority of a run that asks for none.
    pub const NORMAL: u8 = 4;
}

impl Default for Share {
    fn default() -> Self {
        Self { tenant: Tenant::default(), priority: Self::NORMAL }
    }
}

/// The number of one grant. Never reused, so an old holder is told from the present one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Epoch(pub u64);

/// What a finished solve came to. All three are final.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Fragments (one fragment: nothing separated).
    Broken,
    /// No solver asked took the problem.
    Refused,
    /// Numerics went wrong.
    Failed,
}

/// Why a worker gives a job back without a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The attempt died or hung: counts as a crash, another attempt may do better.
    Crashed,
    /// The worker could not take it up (input gone, shutting down): nobody's fault.
    Dropped,
    /// The job itself cannot be read: no attempt will do better.
    Invalid,
}

/// What is known of a job beside the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prior {
    /// Nothing.
    Nothing,
    /// Its result, which was kept: no worker is asked.
    Result {
        /// Of the result's bytes.
        digest: Digest,
        /// What it came to.
        outcome: Outcome,
        /// What found it, if that was kept too.
        build: Option<Build>,
    },
    /// Nobody can take it: it is over a limit of the wire.
    Unfit,
}

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A run begins, or changes its share.
    Begin {
        /// The run concerned.
        run: Run,
        /// Its claim.
        share: Share,
    },
    /// The run needs this job done. Opening the same job again, also by another run, is allowed:
    /// each opening settles, and the job is computed once.
    Open {
        /// Which run.
        run: Run,
        /// The job concerned.
        job: Job,
        /// What it asks of a worker; of a job that is open, what it asked first.
        need: Skills,
        /// The job whose result it starts from, if there is one: the worker that found that result
        /// has it already, and is preferred if its question is parked. Nobody waits for it.
        after: Option<Job>,
        /// What is known of it before anybody is asked.
        prior: Prior,
    },
    /// No job of this run is granted until it is resumed; what is under way goes on.
    Pause(Run),
    /// The run goes on.
    Resume(Run),
    /// A worker asks for one job.
    Poll {
        /// Who asks.
        worker: Worker,
        /// Its poll number: a repeat carries the same one.
        seq: u64,
        /// Jobs that it could take now; zero gets "idle".
        slots: u32,
        /// Whether the question may wait for a job to be opened.
        park: bool,
        /// What it runs.
        build: Build,
        /// What it can do.
        skills: Skills,
        /// What it is called; all three stay what they are for its lifetime.
        name: WorkerName,
    },
    /// A worker is still at it.
    Renew {
        /// The worker concerned.
        worker: Worker,
        /// At what.
        job: Job,
        /// By which grant.
        epoch: Epoch,
        /// Whether a solver has the job there.
        begun: bool,
        /// What it runs.
        build: Build,
        /// What it can do.
        skills: Skills,
        /// What it is called.
        name: WorkerName,
    },
    /// A worker asks for a cancellation as soon as its job is not wanted any more.
    WatchCancel {
        /// The worker concerned.
        worker: Worker,
        /// At what.
        job: Job,
        /// By which grant.
        epoch: Epoch,
    },
    /// A worker has a result, pieces of which are still to come: no solver has the job there.
    Offer {
        /// Of what.
        job: Job,
        /// By which grant.
        epoch: Epoch,
    },
    /// A worker hands in a result; the shell has checked its bytes against `digest`.
    Commit {
        /// The worker concerned.
        worker: Worker,
        /// What it is called.
        name: WorkerName,
        /// Of what.
        job: Job,
        /// By which grant.
        epoch: Epoch,
        /// What it runs.
        build: Build,
        /// Of the result's bytes.
        digest: Digest,
        /// What it came to.
        outcome: Outcome,
        /// What is kept of a job that the machine does not know any more
        /// ([`crate::Dispatch::knows`]).
        prior: Prior,
    },
    /// A worker gives a job back.
    Fail {
        /// The worker concerned.
        worker: Worker,
        /// The job concerned.
        job: Job,
        /// By which grant.
        epoch: Epoch,
        /// What went wrong.
        trouble: Trouble,
    },
    /// The link to a worker is gone; links flap, so it may be back.
    Suspect(Worker),
    /// A worker's process is known to have ended.
    Down(Worker),
    /// A worker takes its leave.
    Bye(Worker),
    /// The run no longer needs anything: every opening of it settles now.
    Cancel(Run),
    /// The run is over: as [`Event::Cancel`], and it is forgotten.
    End(Run),
    /// This worker gets no further job: told to leave when it asks next.
    Drain(Worker),
    /// An earlier life has drained this worker; said before it can ask here.
    Bar(Worker),
    /// This job was at work when an earlier life ended, and that run wanted it; said before any run
    /// begins.
    Inherit(Job, Claimant),
    /// That run wants nothing any more of what was at work and what it has not opened since.
    Release(Claimant),
    /// An earlier life has put this job into quarantine.
    Isolate(Job),
    /// A quarantined job may be tried again.
    Pardon(Job),
    /// Nobody is left to work, and nobody will come.
    Forsaken,
    /// Time has passed. Leases run out only here, after everything that was heard before.
    Tick,
}
