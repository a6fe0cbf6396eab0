//! Joints between bodies.

use super::schema::{EnumDeclaration, MessageDeclaration, enumeration, message};
use super::vector::Vector3;

enumeration! {
    /// What a joint leaves free.
    JointType {
        /// Not said.
        Unspecified = 0,
        /// Nothing.
        Rigid = 1,
        /// Turning about an axis.
        Hinge = 2,
        /// Turning about a point.
        Ball = 3,
        /// Everything, up to a distance.
        Rope = 4,
    }
}

message! {
    /// A joint between two bodies, or of a body and the world, when it is made. Its end is an
    /// event.
    BodyJoint {
        /// Steps taken.
        "1" [uint64] step: u64,
        /// Simulated time \[s\].
        "2" [double] time: f64,
        /// Its number, never reused in a run.
        "3" [uint64] id: u64,
        /// What it leaves free.
        "4" [enumeration = "JointType"] kind: i32,
        /// One body.
        "5" [uint64] body: u64,
        /// The other; nothing stands for the world.
        "6" [uint64, optional] other: Option<u64>,
        /// Where it is fastened to `body` at this step, in the world \[m\].
        "7" [message, optional] point: Option<Vector3>,
        /// Where it is fastened to `other` at this step, in the world \[m\].
        "8" [message, optional] other_point: Option<Vector3>,
        /// Unit axis of a hinge at this step, in the world.
        "9" [message, optional] axis: Option<Vector3>,
        /// Length of a rope \[m\].
        "10" [double] length: f64,
        /// True of glue, whose limits do not count what presses its faces together.
        "11" [bool] glue: bool,
        /// Area of the faces that glue joins \[m²\]; 0 where not known.
        "12" [double] area: f64,
        /// Greatest force \[N\]; nothing where any.
        "13" [double, optional] force: Option<f64>,
        /// Greatest moment \[N·m\]; nothing where any.
        "14" [double, optional] torque: Option<f64>,
        /// Greatest tension \[Pa\]; nothing where its limits are forces.
        "15" [double, optional] tensile: Option<f64>,
        /// Greatest shear \[Pa\]; nothing where its limits are forces.
        "16" [double, optional] shear: Option<f64>,
        /// True of one that fragments have from a joint of the body that broke; false of one that
        /// the scene made.
        "17" [bool] inherited: bool,
    }
}

pub(super) fn declarations() -> (MessageDeclaration, EnumDeclaration) {
    (BodyJoint::declaration(), JointType::declaration())
}
