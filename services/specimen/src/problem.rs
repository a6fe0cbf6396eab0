//! What is solved: a body of some matter, how it starts, what acts on it, what is watched.

use crate::course::Amplitude;
use crate::place::Where;
use crate::probe::{PointField, Probe, TensorPart};
use crate::settings::SpecimenSettings;
use cullet_geometry::math::unit;
use cullet_geometry::{Mat3, Quat, TriMesh, Vec3};
use cullet_model::{JohnsonCook, Material, StrengthField, SurfaceLaw};

/// The shape of a specimen, and how it lies on the grid.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SpecimenBody {
    /// The body in its own frame, or several one after the other \[m\]. On the wire it travels
    /// behind the rest.
    #[cfg_attr(feature = "wire", serde(skip))]
    pub mesh: TriMesh,
    /// The first triangle of each body but the first, ascending.
    pub parts: Vec<u32>,
    /// From its own frame to the grid's.
    pub turn: Quat,
    /// Where its origin lies on the grid \[m\].
    pub shift: Vec3,
}

/// A part of the specimen that is of another material.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Zone {
    /// The part of the body that it acts on.
    pub part: Where,
    /// What it is made of.
    pub material: Material,
}

/// Strength and damage of a part of the specimen at the start.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct StrengthPatch {
    /// The part of the body that it acts on.
    pub part: Where,
    /// Strength over the material's \[1\].
    pub strength: f64,
    /// Damage \[1\].
    pub damage: f64,
}

/// What a specimen is made of.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Matter {
    /// Its material.
    pub material: Material,
    /// How its surface bears others, and its cracks their sides.
    pub surface: SurfaceLaw,
    /// How all of it flows, where it does.
    pub flow: Option<JohnsonCook>,
    /// Parts of other materials; of several at a place, the last.
    pub zones: Vec<Zone>,
    /// How strength varies; nothing painted on the surface.
    pub strength: StrengthField,
    /// Parts that are stronger, weaker or damaged.
    pub patches: Vec<StrengthPatch>,
}

impl Matter {
    /// Its materials, that of each zone after that of the whole.
    pub fn materials(&self) -> impl Iterator<Item = &Material> {
        [&self.material].into_iter().chain(self.zones.iter().map(|zone| &zone.material))
    }
}

/// A crack without width that is there from the start: a part of a plane.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Notch {
    /// A point of the plane \[m\].
    pub point: Vec3,
    /// Its unit normal.
    pub normal: Vec3,
    /// Where of the plane there is a crack.
    pub part: Where,
}

/// How a part of the specimen starts.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Start {
    /// The part of the body that it acts on.
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
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.velocity.norm_squared() == 0.0
            && self.gradient.norm_squared() == 0.0
            && self.noise == 0.0
    }

    /// What it gives a place of its part \[m/s\].
    #[must_use]
    pub fn at(&self, x: &Vec3, seed: u64) -> Vec3 {
        let bits = x.iter().fold(0_u64, |bits, c| bits.rotate_left(21) ^ c.to_bits());
        let noise = Vec3::from([0, 1, 2].map(|axis| 2.0 * unit(seed, axis, bits) - 1.0));
        self.velocity + self.gradient * (x - self.centre) + noise * self.noise
    }
}

/// What there is before anything moves.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct InitialState {
    /// Displacement gradient \[1\].
    pub stretch: Mat3,
    /// Velocities; they add up.
    pub starts: Vec<Start>,
    /// Cracks.
    pub notches: Vec<Notch>,
}

/// A part whose velocity is given along some axes; where several hold a place along the same axis,
/// their velocities add up, and the first has the whole force.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Hold {
    /// Which part, and all outside the body that lies beyond it.
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
    /// When it lets go \[s\]; never without it.
    pub until: Option<f64>,
}

/// A plane that stands for the other half of the specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SymmetryPlane {
    /// The axis that it lies across: 0, 1, 2.
    pub axis: u8,
    /// Where along it \[m\].
    pub at: f64,
}

/// What a load applies, and how much of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
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
    #[must_use]
    pub fn is_none(&self) -> bool {
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
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Load {
    /// The part of the body that it acts on.
    pub part: Where,
    /// What, at 1 of the course.
    pub push: LoadKind,
    /// Of the load.
    pub course: Amplitude,
}

/// What is watched, for how long.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Output {
    /// Simulated time \[s\].
    pub end: f64,
    /// What is sampled.
    pub probes: Vec<Probe>,
    /// Samples of the probes, beside the one at the start.
    pub samples: u32,
    /// Pictures of all points, beside the one at the start; none takes none at all.
    pub frames: u32,
    /// What colours the points in them.
    pub colour: (PointField, TensorPart),
}

/// All that decides a run.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct SpecimenProblem {
    /// Name of the family that solves it.
    pub family: String,
    /// Its shape.
    pub body: SpecimenBody,
    /// What it is made of.
    pub matter: Matter,
    /// What there is before anything moves.
    pub initial: InitialState,
    /// Supports.
    pub holds: Vec<Hold>,
    /// Planes of symmetry.
    pub symmetries: Vec<SymmetryPlane>,
    /// Loads.
    pub loads: Vec<Load>,
    /// What is watched.
    pub output: Output,
    /// How it is solved.
    pub settings: SpecimenSettings,
}
