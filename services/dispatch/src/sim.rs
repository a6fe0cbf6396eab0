//! The production machines, [`Dispatch`](crate::Dispatch) and
//! [`WorkerMachine`](crate::WorkerMachine), under random schedules of faults with a simulated
//! clock, network and journal; a checker keeps its own account.
//!
//! Chaos first, then everything heals and everything must be done. A schedule is its seed:
//! `CULLET_SEED=n` runs one, `CULLET_SCHEDULES=n` so many, from number `CULLET_FIRST` on. A failure
//! is told with the mildest schedule that still fails. Figures and the table of mutants:
//! `docs/pool.md`.

mod check;
mod farm;
mod plan;
mod tests;
