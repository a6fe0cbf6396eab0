//! How much there is of everything.

/// How many of each there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Openings so far.
    pub opened: u64,
    /// Openings settled.
    pub settled: u64,
    /// Of these, refused by the solvers.
    pub refused: u64,
    /// Of these, failed in the solver.
    pub failed: u64,
    /// Of these, abandoned.
    pub abandoned: u64,
    /// Attempts beyond the first.
    pub resent: u64,
    /// Jobs in the queue now.
    pub waiting: u64,
    /// Jobs under lease now.
    pub running: u64,
    /// Results that contradicted an earlier one.
    pub alarms: u64,
}
