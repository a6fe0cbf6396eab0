//! What can go wrong, with the place, the value and the bound.

use crate::id::BodyId;
use cullet_geometry::Vec3;

/// A body or a setting that the world does not take, or a world that came to grief.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// A setting lies outside its range.
    #[error("world setting {what} is {value:.6e}; it must lie in [{low:.3e}, {high:.3e}]")]
    Setting {
        /// What the value is.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least accepted.
        low: f64,
        /// Greatest accepted.
        high: f64,
    },
    /// A property of a body lies outside its range (or is not a number).
    #[error("body {name:?}: {what} is {value:.6e}; it must lie in [{low:.3e}, {high:.3e}]")]
    OutOfRange {
        /// The body's name.
        name: String,
        /// Which property.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least accepted.
        low: f64,
        /// Greatest accepted.
        high: f64,
    },
    /// The origin of the body frame is not the centre of mass.
    #[error(
        "body {name:?}: the centre of mass is {offset:.3e} m from the origin; at most {bound:.3e} m"
    )]
    OffCentre {
        /// The body's name.
        name: String,
        /// Distance from the origin \[m\].
        offset: f64,
        /// Greatest accepted \[m\].
        bound: f64,
    },
    /// A convex part has no volume, too few corners, or corners that are not numbers.
    #[error("body {name:?}: convex part {index} of {count} {why}")]
    Hull {
        /// The body's name.
        name: String,
        /// Which part.
        index: usize,
        /// How many there are.
        count: usize,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A body on a path is also something that a path rules out.
    #[error("body {name:?} is driven by keyframes; it must not be {what}")]
    Driven {
        /// The body's name.
        name: String,
        /// What it also is.
        what: &'static str,
    },
    /// The budget of bodies is spent.
    #[error("there would be {count} bodies; the limit max_bodies is {limit}")]
    TooManyBodies {
        /// How many there would be.
        count: usize,
        /// The budget.
        limit: usize,
    },
    /// No such body (any more).
    #[error("there is no body {0}")]
    Unknown(BodyId),
    /// A body's pose or velocity stopped being a number (F76).
    #[error("the motion of body {name:?} is not finite at step {step}")]
    NotFinite {
        /// The body's name.
        name: String,
        /// The step at which it happened.
        step: u64,
    },
    /// A body's place does not follow its velocity (F42).
    #[error(
        "body {name:?} is frozen at step {step}: its velocity is ({:.3}, {:.3}, {:.3}) m/s, but \
         over the last five steps or more it moved {moved:.3e} m instead of {due:.3e} m; it must \
         move at least a fifth of that",
        .velocity.x, .velocity.y, .velocity.z
    )]
    Frozen {
        /// The body's name.
        name: String,
        /// The step at which it happened.
        step: u64,
        /// Its velocity \[m/s\].
        velocity: Vec3,
        /// How far it moved while it did not follow its velocity \[m\].
        moved: f64,
        /// How far its velocity would have taken it in that time \[m\].
        due: f64,
    },
    /// The rigid-body engine panicked; the world must not be used further.
    #[error("the rigid-body engine failed at step {step}")]
    Engine {
        /// The step at which it happened.
        step: u64,
    },
}

/// Why a body was not replaced. The body stays whole, as the engine left it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReplaceError {
    /// No such body (any more).
    #[error("there is no body {0}")]
    Unknown(BodyId),
    /// A body that moves by keyframes keeps its shape.
    #[error("body {0} is driven by keyframes; it is neither broken nor reshaped")]
    Driven(BodyId),
    /// Fewer than two pieces: nothing separated.
    #[error("{0} pieces are no fracture; at least two are needed")]
    TooFew(usize),
    /// The pieces do not fill the body.
    #[error(
        "the pieces fill {ratio:.12} of the body's volume; \
         the difference may be at most {bound:.1e}"
    )]
    Volume {
        /// Σ volumes over the body's volume \[1\].
        ratio: f64,
        /// Greatest accepted difference from one.
        bound: f64,
    },
    /// A piece has no volume, is inside out, or has numbers that are none.
    #[error("piece {index}: {what} is {value:.6e}")]
    Piece {
        /// Which piece.
        index: usize,
        /// What about it.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A grain of debris has no volume, or numbers that are none.
    #[error("grain {index} of debris, of {value:.6e} m³, has no volume, size, place or speed")]
    Grain {
        /// Which grain.
        index: usize,
        /// Its volume \[m³\].
        value: f64,
    },
    /// A support that pulls, or gave no number.
    #[error("support {index} gave an impulse of {value:.6e} N s; it must not be negative")]
    Reaction {
        /// Which support.
        index: usize,
        /// Its impulse \[N·s\].
        value: f64,
    },
    /// The budget of bodies is spent.
    #[error("{pieces} pieces would make {count} bodies; the limit max_bodies is {limit}")]
    Budget {
        /// How many pieces.
        pieces: usize,
        /// How many bodies there would be.
        count: usize,
        /// The budget.
        limit: usize,
    },
    /// The motion of the pair cannot pay for the crack (F41).
    #[error(
        "unaffordable: cracks and flow cost {fracture_energy:.6e} J; \
         of {available:.6e} J in the pair's motion at most {payable:.6e} J can be freed"
    )]
    Unaffordable {
        /// G_f times the crack area, or the work of flow \[J\].
        fracture_energy: f64,
        /// Kinetic energy of the pair before the hit \[J\].
        available: f64,
        /// The most that the delivered impulse can free \[J\].
        payable: f64,
    },
    /// A fragment was refused as a body.
    #[error("a fragment was refused: {0}")]
    Fragment(#[from] WorldError),
}
