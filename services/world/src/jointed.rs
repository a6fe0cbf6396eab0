//! A joint as the world keeps it.

use crate::joint::{JointLimit, JointLoad};
use cullet_geometry::{Mat3, Pose, Quat, Vec3};

/// How a joint lets two bodies move, in the frame of its first body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum JointLink {
    Rigid,
    Hinge { axis: Vec3 },
    Ball,
    Rope { length: f64 },
}

/// What carries in a joint, about its point, in the frame of its first body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CarryingFace {
    /// Unit, from the first body to the second; none of a joint that is no face.
    pub(crate) normal: Option<Vec3>,
    /// \[m²\]
    pub(crate) area: f64,
    /// ∫ r rᵀ dA \[m⁴\].
    pub(crate) tensor: Mat3,
    /// Corners of its polygons \[m\].
    pub(crate) corners: Vec<Vec3>,
}

/// A joint as the world keeps it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Jointed {
    pub(crate) a: u32,
    /// None: the world.
    pub(crate) b: Option<u32>,
    pub(crate) link: JointLink,
    /// Where each is held, in its own frame \[m\].
    pub(crate) ends: [Vec3; 2],
    /// Turns the frame of `a` into that of `b`, as they were joined.
    pub(crate) turn: Quat,
    pub(crate) face: CarryingFace,
    pub(crate) limit: JointLimit,
    /// Of glue, how far apart the faces may be \[m\].
    pub(crate) gap: f64,
    pub(crate) collide: bool,
    pub(crate) load: JointLoad,
}

impl JointLoad {
    /// Nothing.
    pub(crate) fn zero() -> Self {
        Self { force: Vec3::zeros(), torque: Vec3::zeros(), share: 0.0 }
    }
}

impl JointLimit {
    /// Can anything break it?
    pub(crate) fn breakable(&self) -> bool {
        match self {
            Self::Whole(limits) | Self::Pull(limits) => {
                limits.force.is_some() || limits.torque.is_some()
            }
            Self::Stress { .. } => true,
        }
    }
}

impl CarryingFace {
    /// A square of that area \[m²\] that stands in no direction.
    pub(crate) fn square(area: f64) -> Self {
        let tensor = Mat3::identity() * (area * area / 12.0);
        Self { normal: None, area, tensor, corners: Vec::new() }
    }
}

/// Where the two ends of a joint are \[m\].
pub(crate) fn points(joint: &Jointed, a: &Pose, b: &Pose) -> [Vec3; 2] {
    let at = |pose: &Pose, end: &Vec3| (pose * nalgebra::Point3::from(*end)).coords;
    [at(a, &joint.ends[0]), at(b, &joint.ends[1])]
}
