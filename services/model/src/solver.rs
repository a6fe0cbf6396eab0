//! The contract between a fracture problem and the ways to solve it.

use crate::{Detail, Material, Precision, StrengthField, Tolerance};
use cullet_geometry::{Sheet, Solid, Vec3};
use std::sync::Arc;

/// One hit, in the body's own frame (origin at the centre of mass).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Where the striker touched \[m\].
    pub point: Vec3,
    /// Unit direction of the push, *into* the body.
    pub normal: Vec3,
    /// Impulse along `normal` over the contact episode \[N·s\].
    pub impulse: f64,
    /// Hertz contact duration t_c \[s\].
    pub duration: f64,
    /// Greatest Hertz contact radius a \[m\].
    pub radius: f64,
    /// Kinetic energy of the approach, ½ m* v² \[J\]: no crack can cost more.
    pub energy: f64,
    /// How fast the surfaces closed before they touched \[m/s\].
    pub closing_speed: f64,
    /// Pressure in the middle of the contact at which it crushes, body or striker \[Pa\].
    pub crushing_pressure: f64,
}

/// Where a body rests on another: a disc that holds the surface under it against moving into it,
/// and lets it leave. In the body's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Middle of the disc, on the surface \[m\].
    pub point: Vec3,
    /// Unit direction in which it can push, *into* the body.
    pub normal: Vec3,
    /// Radius of the disc \[m\].
    pub radius: f64,
    /// Velocity against `normal` that it takes up over the impulse it has given \[1/kg\]; 0 if it
    /// does not move.
    pub mobility: f64,
}

/// What the scene decides about a solve. `None` means "let the solver choose".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Grid spacing h \[m\].
    pub spacing: Option<f64>,
    /// Particle budget; the solver coarsens `spacing` to stay under it when it chose it itself.
    pub max_particles: u32,
    /// Budget of time steps.
    pub max_steps: u32,
    /// Fragments below this share of the body's volume are merged into a neighbour \[1\].
    pub min_volume_ratio: f64,
    /// At most this many fragments; the smallest are merged first.
    pub max_fragments: u32,
    /// How crack faces look closer than the grid resolves.
    pub detail: Detail,
    /// Parts below this share of the body's volume become debris \[1\]; 0 makes none.
    pub debris: f64,
    /// Size of a grain of it, half the mass being in larger ones \[m\]; `None`: half the spacing.
    pub grain: Option<f64>,
    /// Width of the slits that are cut along cracks which end inside a fragment \[m\], at most
    /// `cullet_fragment::cut::slit::WIDEST` of the spacing; `None` cuts none.
    pub hairline: Option<f64>,
    /// What points are worked out in.
    pub precision: Precision,
    /// Relative error of the fragments that is good enough, in (0, 1] \[1\]: what that lets a solve
    /// leave out is [`crate::Tolerance`]. `None`: as true as can be.
    pub error: Option<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            spacing: None,
            max_particles: 16_000,
            max_steps: 20_000,
            min_volume_ratio: 1e-4,
            max_fragments: 400,
            detail: Detail::default(),
            debris: 5e-4,
            grain: None,
            hairline: None,
            precision: Precision::Double,
            error: None,
        }
    }
}

impl Settings {
    /// How true the fragments have to be.
    #[must_use]
    pub fn tolerance(&self) -> Tolerance {
        Tolerance(self.error)
    }
}

/// A body, its hits, and how it may be solved. Everything a solver may know.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// The body in its own frame, origin at the centre of mass \[m\].
    pub solid: Arc<Solid>,
    /// Its material.
    pub material: Material,
    /// How its strength varies.
    pub strength: StrengthField,
    /// At least one hit.
    pub impacts: Vec<Impact>,
    /// What it rests on.
    pub supports: Vec<Support>,
    /// Angular velocity before the hits \[rad/s\]: zero where its stress does not matter.
    pub spin: Vec3,
    /// How it may be solved.
    pub settings: Settings,
    /// The only source of randomness.
    pub seed: u64,
}

/// One part of a broken body, in the body's frame before it broke.
#[derive(Clone, Debug, PartialEq)]
pub struct Fragment {
    /// Its closed boundary \[m\].
    pub solid: Solid,
    /// Convex parts that stand in for it in collisions: corner sets \[m\].
    pub hulls: Vec<Vec<Vec3>>,
    /// Velocity of its centroid that the hit gave it, beside the body's motion before the hit
    /// \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity that the hit gave it, likewise \[rad/s\].
    pub spin: Vec3,
    /// Cracks that end inside it; empty where there are none, or the method knows none.
    pub sheet: Sheet,
}

/// What a solve cost and what it found out about itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// `Solver::NAME`.
    pub solver: String,
    /// Grid spacing h \[m\]; zero where a method has none.
    pub spacing: f64,
    /// Material points; zero where a method has none.
    pub particles: u64,
    /// Time steps taken.
    pub steps: u64,
    /// Simulated time \[s\].
    pub simulated: f64,
    /// Area of the crack between fragments \[m²\] (counted once, not per side).
    pub crack_area: f64,
    /// G_f times `crack_area` \[J\].
    pub fracture_energy: f64,
    /// Energy the damage law dissipated \[J\].
    pub dissipated_energy: f64,
    /// Stress at which cracks grow over σ_f \[1\]; below 1 the solve was toughness-controlled
    /// (F01).
    pub strength_ratio: f64,
    /// Share of particles with damage above one half \[1\].
    pub damaged_fraction: f64,
    /// Impulse that the solve put into the body \[N·s\].
    pub delivered_impulse: f64,
    /// What the detectors noticed and let pass, a sentence each.
    pub warnings: Vec<String>,
}

/// A grain of debris, in the body's frame before it broke: a point with a mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Where \[m\].
    pub position: Vec3,
    /// Velocity that the hit gave it, beside the body's motion before the hit \[m/s\].
    pub velocity: Vec3,
    /// Volume \[m³\].
    pub volume: f64,
    /// Diameter of the ball of that volume \[m\].
    pub size: f64,
}

/// A body taken apart. One fragment means that nothing separated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fracture {
    /// Closed parts whose volumes, with those of the debris, sum to the body's within 1e-9 of it.
    pub fragments: Vec<Fragment>,
    /// Of each fragment: whether it was sampled, that is drawn from a law, and not solved.
    pub sampled: Vec<bool>,
    /// Parts too small to be fragments.
    pub debris: Vec<Grain>,
    /// Impulse that each support of the problem gave along its normal \[N·s\], not negative; empty
    /// where the method knows no supports.
    pub reactions: Vec<f64>,
    /// What it cost.
    pub report: Report,
}

/// Why a problem is not for this solver. Normal: another tier takes it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A section is thinner than the grid can bend (F14).
    #[error(
        "too thin: the body is {thickness:.3e} m thick, {cells:.2} cells; \
         at least {minimum} are needed"
    )]
    TooThin {
        /// Typical thickness \[m\].
        thickness: f64,
        /// Thickness over spacing \[1\].
        cells: f64,
        /// Fewest cells accepted.
        minimum: f64,
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
        /// When.
        step: u64,
    },
    /// Energy appeared from nowhere (F04).
    #[error("there is {ratio:.3} more energy than the strikers have lost at step {step}")]
    Unstable {
        /// Excess over what the strikers have lost \[1\].
        ratio: f64,
        /// When.
        step: u64,
    },
    /// The step budget ran out before the solve was over.
    #[error("not finished after {steps} steps")]
    OutOfSteps {
        /// The budget.
        steps: u64,
    },
    /// The cut did not close or did not add up.
    #[error("the cut failed: {0}")]
    Cut(String),
}

/// An estimate made before any work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Material points.
    pub particles: f64,
    /// Time steps.
    pub steps: f64,
    /// Memory \[bytes\].
    pub bytes: f64,
}

/// How far a solve has come.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// Share done \[0, 1\].
    Running(f64),
    /// Finished.
    Done(Box<Fracture>),
    /// Numerics went wrong.
    Failed(Failure),
}

/// One way to break a body. A family implements this in a crate of its own and has one line in the
/// worker's table.
pub trait Solver: Sized + 'static {
    /// Name on the wire, in charts, in recordings. Never reused for another method.
    const NAME: &'static str;
    /// What the problem would cost here, or why it is not for this solver.
    ///
    /// # Errors
    /// The bound that the problem breaks.
    fn accepts(problem: &Problem) -> Result<Cost, Refusal>;
    /// Discretise.
    ///
    /// # Errors
    /// As [`Solver::accepts`], for bounds that only show once the body is sampled.
    fn begin(problem: Problem) -> Result<Self, Refusal>;
    /// Advance by one bounded slice; the host looks for cancellation between slices.
    fn advance(&mut self) -> Progress;
}

/// A solve in progress, whatever its family.
pub trait Run {
    /// See [`Solver::advance`].
    fn advance(&mut self) -> Progress;
}

impl<S: Solver> Run for S {
    fn advance(&mut self) -> Progress {
        Solver::advance(self)
    }
}

/// One line of the table.
pub struct Entry {
    /// [`Solver::NAME`].
    pub name: &'static str,
    /// [`Solver::begin`], after [`Solver::accepts`].
    pub begin: fn(Problem) -> Result<Box<dyn Run>, Refusal>,
}

/// The line of a family.
#[must_use]
pub const fn entry<S: Solver>() -> Entry {
    Entry {
        name: S::NAME,
        begin: |problem| {
            S::accepts(&problem)?;
            Ok(Box::new(S::begin(problem)?))
        },
    }
}
