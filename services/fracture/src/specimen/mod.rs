//! A specimen: a body under given supports and loads, advanced by a solver, with probes on it.
//!
//! What a laboratory does to a solver: everything is prescribed, so that what comes out can be held
//! against a formula. Lengths, places and directions are in the specimen's own frame; the grid sees
//! it turned and shifted.

mod amplitude;
mod build;
mod clip;
mod hold;
mod probe;
mod push;
mod run;
#[cfg(test)]
mod tests;

pub use amplitude::Amplitude;
pub use probe::{Field, Part, Probe, Reduce, Spot};
pub use run::{Ending, Frame, Outcome, SpecimenRun, Step};

use crate::mpm::domain::Fields;
use cullet_geometry::{Mat3, Quat, TriMesh, Vec3};
use cullet_model::strength::Region;
use cullet_model::{Material, Precision, StrengthField};

/// A part of the specimen: the points in all of these regions; none means everywhere.
pub type Where = Vec<Region>;

/// Whether a place is in a part, or no farther outside of it than `slack` \[m\].
#[must_use]
pub fn within(part: &Where, x: &Vec3, slack: f64) -> bool {
    part.iter().all(|region| region.contains(x, slack))
}

/// A part of the specimen that is of another material.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// Where.
    pub part: Where,
    /// What it is made of.
    pub material: Material,
}

/// Strength and damage of a part of the specimen at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Where.
    pub part: Where,
    /// Strength over the material's \[1\].
    pub strength: f64,
    /// Damage \[1\].
    pub damage: f64,
}

/// A crack without width that is there from the start: a part of a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Notch {
    /// A point of the plane \[m\].
    pub point: Vec3,
    /// Its unit normal.
    pub normal: Vec3,
    /// Where of the plane there is a crack.
    pub part: Where,
}

/// Nodes whose velocity is given along some axes; where several hold a node along the same axis,
/// their velocities add up.
#[derive(Clone, Debug, PartialEq)]
pub struct DirichletBc {
    /// Which nodes.
    pub part: Where,
    /// Which axes of the specimen's frame.
    pub axes: [bool; 3],
    /// Velocity at 1 of the course \[m/s\].
    pub velocity: Vec3,
    /// Its gradient by place \[1/s\].
    pub gradient: Mat3,
    /// Place where the velocity is `velocity` \[m\].
    pub centre: Vec3,
    /// Of the velocity.
    pub course: Amplitude,
    /// When it lets go \[s\].
    pub until: f64,
}

/// What a load is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadKind {
    /// On the surface in the part \[Pa\].
    Traction(Vec3),
    /// On the surface in the part, against its outward normal \[Pa\].
    Pressure(f64),
    /// Spread evenly by mass over the part \[N\].
    Force(Vec3),
    /// On all mass of the part \[m/s²\].
    Acceleration(Vec3),
}

impl LoadKind {
    /// Whether it is nothing, wherever it is.
    pub(super) fn is_none(&self) -> bool {
        match *self {
            Self::Traction(all) | Self::Force(all) | Self::Acceleration(all) => {
                all.norm_squared() == 0.0
            }
            Self::Pressure(pressure) => pressure == 0.0,
        }
    }
}

/// A load on a part of the specimen.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Where.
    pub part: Where,
    /// What, at 1 of the course.
    pub push: LoadKind,
    /// Of the load.
    pub course: Amplitude,
}

/// How a part of the specimen starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Where.
    pub part: Where,
    /// Velocity \[m/s\].
    pub velocity: Vec3,
    /// Its gradient by place \[1/s\].
    pub gradient: Mat3,
    /// Place where the velocity is `velocity` \[m\].
    pub centre: Vec3,
    /// Greatest size of a random velocity on top, by component \[m/s\].
    pub noise: f64,
}

impl Start {
    /// Whether it moves nothing, wherever it is.
    pub(super) fn is_none(&self) -> bool {
        self.velocity.norm_squared() == 0.0
            && self.gradient.norm_squared() == 0.0
            && self.noise == 0.0
    }
}

/// Points in a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// Scattered at random, even in number, with volumes fitted to the grid.
    Scattered,
    /// In rows along the axes of the grid, of equal volumes.
    Rows,
}

/// How it is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Grid spacing h \[m\].
    pub spacing: f64,
    /// Time step over the bound of `stable_step` \[1\].
    pub step_factor: f64,
    /// Points a cell.
    pub per_cell: f64,
    /// How they lie.
    pub points: Points,
    /// Of the points' pass.
    pub precision: Precision,
    /// What becomes of the velocity field at cracks.
    pub fields: Fields,
    /// Whether the material can break.
    pub breaks: bool,
    /// Length over which a crack is spread in place of the calibrated one \[m\].
    pub softening_length: Option<f64>,
    /// Rate at which velocities fall off by themselves \[1/s\].
    pub damping: f64,
    /// Until when \[s\].
    pub damped_until: f64,
    /// Most points.
    pub max_points: f64,
    /// Most steps.
    pub max_steps: f64,
    /// The only source of randomness.
    pub seed: u64,
    /// Steps from one look at what has parted to the next.
    pub look: u64,
}

/// All that decides a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Specimen {
    /// The body in its own frame, or several one after the other \[m\].
    pub mesh: TriMesh,
    /// The first triangle of each body but the first, ascending.
    pub bodies: Vec<u32>,
    /// From its own frame to the grid's.
    pub turn: Quat,
    /// Where its origin lies on the grid \[m\].
    pub shift: Vec3,
    /// What it is made of.
    pub material: Material,
    /// Parts of other materials; of several at a place, the last.
    pub zones: Vec<Zone>,
    /// How strength varies.
    pub strength: StrengthField,
    /// Parts that are stronger, weaker or damaged.
    pub patches: Vec<Patch>,
    /// Cracks from the start.
    pub notches: Vec<Notch>,
    /// Planes of symmetry: axis and place along it \[m\].
    pub symmetries: Vec<(usize, f64)>,
    /// Displacement gradient at the start \[1\].
    pub stretch: Mat3,
    /// Velocities at the start; they add up.
    pub starts: Vec<Start>,
    /// Prescribed velocities.
    pub holds: Vec<DirichletBc>,
    /// Loads.
    pub loads: Vec<Load>,
    /// What is watched.
    pub probes: Vec<Probe>,
    /// How it is solved.
    pub settings: Settings,
    /// Simulated time \[s\].
    pub end: f64,
    /// Samples of the probes, beside the one at the start.
    pub samples: u32,
    /// Pictures of all points, beside the one at the start; none takes none at all.
    pub frames: u32,
    /// What colours the points in them.
    pub colour: (Field, Part),
}
