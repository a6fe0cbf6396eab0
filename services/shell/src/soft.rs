//! Soft shells that move for as long as a scene lasts: thin walls at any strain and turn, which
//! yield, tear, and meet rigid bodies and themselves.
//!
//! The shell is that of [`crate::domain`], with the laws of soft walls in its sections
//! ([`crate::section::SoftSection`]). `wall` makes a body discrete, `prepared` works out once
//! what stays the same, `run` takes steps, `window` is what the worker solves: a pure function
//! of a state, which is bytes (`state`), and of the rigid bodies in reach. Neither the number of
//! threads nor the cut into windows changes a bit of it.
//!
//! A piece at rest is frozen, and may leave the shell as a rigid body of its shape (`settled`).
//! What is gone bears nothing, is in no sum, touches nothing and is not drawn, and stays in the
//! state's bytes where it was.
//!
//! Absent on purpose: exact self-contact (points repel below a distance, and a fast wall can cross
//! itself), friction of a wall on itself, and plastic strains that are large and turn.

mod books;
mod crumbs;
mod draw;
mod held;
mod pairs;
mod prepared;
mod report;
mod run;
mod settled;
mod state;
#[cfg(test)]
mod tests;
mod touch;
mod wall;
mod window;

pub use prepared::PreparedSoftShell;
pub use window::SoftShellWindow;

/// Name of the family on the wire and in recordings.
pub const NAME: &str = "soft-shell";
