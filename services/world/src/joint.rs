//! Joints: what holds bodies together, how much it bears, and when it broke.

use crate::id::BodyId;
use cullet_geometry::Vec3;

/// The name of a joint in a run: increasing, never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JointId(pub u32);

impl std::fmt::Display for JointId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "joint {}", self.0)
    }
}

/// How two bodies may still move against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Not at all.
    Rigid,
    /// They turn about one axis.
    Hinge {
        /// Direction of the axis, world frame at the time of joining; need not be of length one.
        axis: Vec3,
    },
    /// They turn in any way about a point.
    Ball,
    /// Two points of theirs come no farther apart than this; it pulls, and never pushes.
    Rope {
        /// Length \[m\].
        length: f64,
    },
}

/// What a joint bears: the mean over one step. `None`: any.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointLimits {
    /// Size of the force \[N\].
    pub force: Option<f64>,
    /// Size of the torque about the anchor \[N·m\].
    pub torque: Option<f64>,
}

/// A joint to be made. Positions are in the world frame, where the bodies are when it is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSpec {
    /// One body.
    pub a: BodyId,
    /// The other; `None`: the world.
    pub b: Option<BodyId>,
    /// How they may move.
    pub kind: JointKind,
    /// Where `a` is held \[m\].
    pub anchor: Vec3,
    /// Where `b` is held \[m\]; `None`: at the same point. Only a rope may have two points.
    pub anchor_b: Option<Vec3>,
    /// What it bears.
    pub limits: JointLimits,
    /// Cross-section that carries \[m²\], taken for a square: joints side by side share a load by
    /// it. `None`: a tenth of the smaller body's extent, squared.
    pub area: Option<f64>,
    /// Do the two collide with each other? Of ball joints and ropes; bodies that a rigid joint or a
    /// hinge joins never do.
    pub collide: bool,
}

/// What a joint carries, as the mean over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLoad {
    /// Force on `b`, world frame; `a` has the opposite \[N\].
    pub force: Vec3,
    /// Torque on `b` about the joint's point, world frame \[N·m\].
    pub torque: Vec3,
    /// The load over what the joint bears \[1\]: it breaks above one. Zero of one that bears any.
    pub share: f64,
}

/// A joint as the recorder and the run loop see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointView {
    /// Its name.
    pub id: JointId,
    /// One body.
    pub a: BodyId,
    /// The other; `None`: the world.
    pub b: Option<BodyId>,
    /// How they may move; the axis is in the world frame, as they are now.
    pub kind: JointKind,
    /// Where `a` is held now, world frame; of glue, the middle of the face \[m\].
    pub point: Vec3,
    /// Where `b` is held now \[m\].
    pub point_b: Vec3,
    /// Area that carries \[m²\].
    pub area: f64,
    /// What it bears, as it was given.
    pub limit: JointLimit,
    /// What it carried over the last step in which its bodies were awake.
    pub load: JointLoad,
}

/// What a joint bears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointLimit {
    /// Force and torque.
    Whole(JointLimits),
    /// Force and torque of glue: its force counts without what presses the faces together.
    Pull(JointLimits),
    /// Stresses over the face, linear across it. Pressure does not count.
    Stress {
        /// Greatest tension across the face at any of its corners \[Pa\].
        tensile: f64,
        /// Greatest mean shear stress, with that of torsion at the farthest corner \[Pa\].
        shear: f64,
    },
}

/// A joint broke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointBreak {
    /// Which.
    pub joint: JointId,
    /// One body.
    pub a: BodyId,
    /// The other; `None`: the world.
    pub b: Option<BodyId>,
    /// In which step, counted from one.
    pub step: u64,
    /// Where, world frame, as it was before the step \[m\].
    pub point: Vec3,
    /// Size of the force that broke it: the mean over the step \[N\].
    pub force: f64,
    /// Size of the torque \[N·m\].
    pub torque: f64,
    /// The load over what it bore \[1\].
    pub share: f64,
}

/// How the loads of all joints were found, counted from the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct JointCounts {
    /// Steps that were taken again without the joints that broke in them.
    pub steps_retaken: u64,
    /// How often any of them was.
    pub retakes: u64,
    /// Groups of bodies whose loads were worked out, a step each.
    pub solves: u64,
    /// Those of them that did not converge: their loads are as good as they got.
    pub not_converged: u64,
}

/// Why a joint or glue was not made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JointError {
    /// No such body (any more).
    #[error("there is no body {0}")]
    Unknown(BodyId),
    /// The same body twice.
    #[error("body {name:?} cannot be joined to itself")]
    Itself {
        /// The body's name.
        name: String,
    },
    /// Neither of the two can be moved.
    #[error("nothing moves {a:?} or {b:?}: a joint between them would do nothing")]
    Immovable {
        /// One body's name.
        a: String,
        /// The other's; "the world" where it is that.
        b: String,
    },
    /// More than can be.
    #[error("too many {what}; at most {most} are taken")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// The bound.
        most: usize,
    },
    /// A number lies outside its range.
    #[error("{what} of a joint of {name:?} is {value:.6e}; it must lie in [{low:.3e}, {high:.3e}]")]
    OutOfRange {
        /// One body's name.
        name: String,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least accepted.
        low: f64,
        /// Greatest accepted.
        high: f64,
    },
}
