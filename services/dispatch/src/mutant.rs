//! Bugs planted on purpose: the simulation must find each of them (`docs/pool.md`).

use crate::effect::Loss;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mutant {
    /// Results settle as they come.
    SettleAsTheyCome,
    /// A repeated poll gets a second job.
    PollMintsTwice,
    /// Leases never run out.
    NoExpiry,
    /// A second result settles again.
    NoDedupe,
    /// The end of a worker takes everybody's leases.
    DownTakesAll,
    /// Crashes are not counted.
    NoLimit,
    /// A new life of the coordinator takes itself for the last one.
    IncarnationForgotten,
    /// A result is on the disk only after its receipt has gone.
    AckedBeforeKept,
    /// What one run cancels is cancelled for all.
    CancelSpreads,
    /// A paused run goes on.
    PauseIgnored,
    /// A slow job is duplicated again and again.
    HedgedAgain,
    /// A run's waiting counts for nothing.
    NoAgeing,
    /// A full queue takes more.
    NoBound,
    /// A renewal of what is over is granted.
    DeafToStop,
    /// A worker leaves a hanging solve alone.
    NoWatchdog,
    /// A worker that gets no receipt forgets its result.
    ResultForgotten,
    /// A late result counts, whatever made it.
    ForeignTaken,
    /// A job goes to whoever asks.
    AnybodyWill,
    /// A new life does not know what was in quarantine.
    QuarantineForgotten,
    /// The end of a worker counts against what it was granted, begun or not.
    ChargedUnbegun,
    /// Only what a living worker reports counts against a job.
    VanishedUncharged,
    /// Who has a job that nobody wants any more is not told at once.
    CancelUnsaid,
    /// Nobody knows what found a result that was kept.
    KeptOfNobody,
    /// A job goes to those under whom it died as soon as nobody else is idle.
    KillerAgain,
    /// A worker under which one job after another dies gets more.
    NeverDrained,
    /// A worker that can do what nobody else can gets all the rest, whatever dies under it.
    DoubtUnheeded,
    /// A job that died under others too counts against each, and at once.
    BlameStays,
    /// Each process of a name counts for itself.
    BlameBySession,
    /// A slow job's duplicate goes to another process of the same name.
    HedgedAtHome,
    /// A worker whose end nobody has noticed is waited for.
    GhostAwaited,
    /// A new life does not know who was drained.
    DrainForgotten,
    /// A new life gives a job that was at work to whoever asks, at once.
    InheritedUnawaited,
    /// A new life stops what the last one has granted.
    InheritedSuperseded,
    /// A new life knows nothing of a job before a run has opened it.
    InheritedUnknown,
    /// A new life lets a job go on whose runs are over.
    InheritedKept,
    /// A run that does not want a job any more ends it for a claimant, too.
    ClaimantPassedOver,
    /// A job goes to whoever has waited longest, whoever found what it starts from.
    MakerPassedOver,
    /// A job goes to nobody but the worker that found what it starts from.
    MakerAwaited,
}

impl Mutant {
    /// Whether an attempt that ended so counts against its job.
    pub(crate) fn charges(self, charged: bool, loss: Loss) -> bool {
        match self {
            Self::ChargedUnbegun => charged || loss == Loss::Down,
            Self::VanishedUncharged => charged && loss == Loss::Crashed,
            _ => charged,
        }
    }
}
