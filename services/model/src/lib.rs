//! What every family of fracture solvers shares: the body, its law, its hits and supports, the
//! settings of a solve, what comes of it, and the [`Solver`] trait. Read [`problem`], [`outcome`]
//! and [`solver`] in this order.
//!
//! Absent on purpose: how anything is solved.

pub mod art_direction;
pub mod body;
pub mod bonded;
pub mod brittle;
pub mod continuum;
pub mod detail;
pub mod energy;
pub mod hardening;
pub mod hertz_contact;
pub mod johnson_cook;
pub mod law;
pub mod material;
pub mod membrane;
pub mod outcome;
pub mod precision;
pub mod preconditions;
pub mod problem;
pub mod refusal;
pub mod sheet_check;
pub mod soft;
pub mod solver;
pub mod strength;
pub mod surface;
pub mod tolerance;
pub mod treatment;

pub use art_direction::ArtDirection;
pub use body::BodyShape;
pub use bonded::{BondGrain, BondProperty, BondedSolid, BoundedNumber};
pub use continuum::{
    Continuum, ContinuumBody, ContinuumEntry, ContinuumSetup, Handed, MovingSurface, PreparedBody,
    Proxy, ProxyMotion, SettledPiece, SurfaceFrame, SweptExtent, TornPiece, Window,
    WindowInProgress, WindowLedger, WindowOutcome, WindowProgress, continuum_entry,
};
pub use detail::CrackFaceDetail;
pub use energy::{EnergyAccount, EnergyBalance};
pub use hardening::Hardening;
pub use johnson_cook::{DuctileFailure, FlowHistory, JohnsonCook, ThermalSoftening};
pub use law::Law;
pub use material::Material;
pub use membrane::{
    FurtherQuantities, MembraneLaw, MembraneMaterial, MembranePace, MembraneSheet, SheetAir,
    SheetDiffusion, SheetGrip, SheetPlace, SheetQuantities, SheetRegion, SheetSource,
    SheetSourceKind,
};
pub use outcome::{
    Amount, Deformation, Figure, Fragment, FragmentOrigin, Fragmentation, Grain, Report,
    SolveOutcome, SolvedShares,
};
pub use precision::PointPrecision;
pub use problem::{BrittleProblem, BrittleSettings, Impact, Problem, Settings, Support};
pub use refusal::{Failure, Refusal};
pub use sheet_check::SheetFault;
pub use soft::{BodyCut, BodyGrip, BodyRegion, SoftBody, SoftLaw};
pub use solver::{Cost, Progress, SolveInProgress, Solver, SolverEntry, entry};
pub use strength::{PatternWeakPlane, Strength, StrengthField};
pub use surface::SurfaceLaw;
pub use tolerance::Tolerance;
pub use treatment::{Interlayer, Treatment};
