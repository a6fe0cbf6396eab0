//! Why there is no outcome: the problem is not for a solver, or numerics went wrong.

/// Why a problem is not for this solver. Normal: another tier takes it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A section is thinner than the grid can bend (F14).
    #[error(
        "too thin: the body is {thickness:.3e} m thick, {:.2} cells; \
         at least {minimum} are needed",
        (cells * 100.0).floor() / 100.0
    )]
    TooThin {
        /// Typical thickness \[m\].
        thickness: f64,
        /// Thickness over spacing \[1\].
        cells: f64,
        /// Fewest cells accepted.
        minimum: f64,
    },
    /// A body or a law that the family does not know.
    #[error("`{solver}` takes no {kind} as {what}")]
    Unknown {
        /// The family.
        solver: &'static str,
        /// A body or a law.
        what: &'static str,
        /// Of what kind.
        kind: &'static str,
    },
    /// The body lacks what the family needs.
    #[error("not for `{solver}`: {lack}")]
    Unfit {
        /// The family.
        solver: &'static str,
        /// What it lacks, with figure and bound.
        lack: String,
    },
    /// The problem would exceed a limit.
    #[error("too large: {what} would be {value:.3e}, the limit is {limit:.3e}")]
    TooLarge {
        /// What would be too large.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The bound.
        limit: f64,
    },
    /// A part of a specimen takes nothing of the body.
    #[error("{what} {number} takes nothing: nothing of the body lies where it is")]
    Idle {
        /// What takes nothing.
        what: &'static str,
        /// Which, in the order in which they are given, from 1.
        number: usize,
    },
    /// An input is outside what the method holds for.
    #[error("{what} is {value:.3e}; it must lie in [{low:.3e}, {high:.3e}]")]
    OutOfRange {
        /// Which input.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least accepted.
        low: f64,
        /// Greatest accepted.
        high: f64,
    },
}

/// Numerics that went wrong. Recorded, never hidden.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// A number stopped being one (F76).
    #[error("a value of {what} is not finite at step {step}")]
    NotFinite {
        /// Which field.
        what: &'static str,
        /// The step at which it happened.
        step: u64,
    },
    /// Energy appeared from nowhere (F04).
    #[error("there is {ratio:.3} more energy than the strikers have lost at step {step}")]
    Unstable {
        /// Excess over what the strikers have lost \[1\].
        ratio: f64,
        /// The step at which it happened.
        step: u64,
    },
    /// The step budget ran out before the solve was over.
    #[error("not finished after {steps} steps")]
    OutOfSteps {
        /// The budget.
        steps: u64,
    },
    /// The body has become one that the method does not hold for: another family takes it.
    #[error("beyond what the method holds for at step {step}: {what}")]
    Beyond {
        /// What it does not hold for, with figure and bound.
        what: String,
        /// The step at which that was seen.
        step: u64,
    },
    /// The cut did not close or did not add up.
    #[error("the cut failed: {0}")]
    Cut(String),
}
