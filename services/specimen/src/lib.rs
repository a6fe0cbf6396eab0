//! Benchmark specimens: a body under given supports and loads, solved by a family of solvers, with
//! probes on it. Everything is prescribed, so that what comes out can be compared with a formula.
//!
//! A family takes part by one trait, [`Discretisation`], and one row, [`SpecimenFamily`]. It makes
//! a [`SpecimenProblem`] discrete, takes steps and shows what its points carry. The
//! [`SpecimenRun`] does the rest for all families alike: the courses of loads and supports, the
//! energy books, probes, pictures, and the end. Read [`discretisation`] first.
//!
//! Places and directions are in the specimen's own frame, unless a [`GridFrame`] says otherwise.
//! Absent on purpose: how anything is solved, files, clocks.

mod books;
mod clip;
pub mod course;
pub mod discretisation;
pub mod family;
pub mod filling;
pub mod frame;
pub mod outcome;
pub mod place;
pub mod probe;
pub mod problem;
mod reading;
pub mod run;
pub mod settings;
pub mod surface;

pub use course::Amplitude;
pub use discretisation::{
    BodySums, Discrete, Discretisation, Drive, FieldValues, LocalVector, PointFields, StepTally,
};
pub use family::{Feature, SpecimenFamily, Unfit, by_name};
pub use frame::GridFrame;
pub use outcome::{Ending, Frame, SpecimenOutcome};
pub use place::{Where, idle, within};
pub use probe::{PointField, Probe, Reduce, Spot, TensorPart};
pub use problem::{
    Hold, InitialState, Load, LoadKind, Matter, Notch, Output, SpecimenBody, SpecimenProblem,
    Start, StrengthPatch, SymmetryPlane, Zone,
};
pub use run::SpecimenRun;
pub use settings::{PointLayout, PointSettings, SpecimenSettings};
