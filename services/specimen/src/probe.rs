//! What is watched.

use crate::place::Where;
use cullet_geometry::Vec3;

/// What the points of a body may carry. A family says which of these its points do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum PointField {
    /// Displacement \[m\].
    Displacement,
    /// Velocity \[m/s\].
    Velocity,
    /// Second Piola–Kirchhoff stress, as weakened \[Pa\]; that of Cauchy where strains are small.
    Stress,
    /// Green's strain \[1\].
    Strain,
    /// Damage \[1\].
    Damage,
    /// Equivalent plastic strain \[1\].
    PlasticStrain,
    /// Volume over that at rest, J \[1\].
    VolumeRatio,
}

impl PointField {
    /// What it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::Stress => "stress",
            Self::Strain => "strain",
            Self::Damage => "damage",
            Self::PlasticStrain => "plastic strain",
            Self::VolumeRatio => "volume ratio",
        }
    }

    /// The unit of its numbers.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Displacement => "m",
            Self::Velocity => "m/s",
            Self::Stress => "Pa",
            Self::Strain | Self::Damage | Self::PlasticStrain | Self::VolumeRatio => "1",
        }
    }

    /// Whether it is one number.
    #[must_use]
    pub const fn is_number(self) -> bool {
        matches!(self, Self::Damage | Self::PlasticStrain | Self::VolumeRatio)
    }

    /// Whether it is a symmetric tensor.
    #[must_use]
    pub const fn is_tensor(self) -> bool {
        matches!(self, Self::Stress | Self::Strain)
    }
}

/// One number of a vector or of a symmetric tensor, in the specimen's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum TensorPart {
    /// A component of a vector: 0, 1, 2.
    Axis(u8),
    /// A component of a tensor: xx, yy, zz, xy, yz, zx.
    Pair(u8),
    /// Length of a vector, or norm of a tensor.
    Size,
    /// Greatest principal value.
    Greatest,
    /// Least principal value.
    Least,
    /// Von Mises' equivalent, √(3/2) of the deviator's norm.
    Mises,
    /// A third of the trace.
    Mean,
}

/// What becomes of the numbers of many points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Reduce {
    /// Their mean by volume.
    Mean,
    /// The greatest.
    Max,
    /// The least.
    Min,
}

/// Where points are looked at.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Spot {
    /// The point nearest to a place; displacement and velocity go on in a straight line from it
    /// \[m\].
    At(Vec3),
    /// All points of a part.
    Over(Where, Reduce),
}

/// One number that is sampled in time.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Probe {
    /// Of the points' fields.
    Points(PointField, TensorPart, Spot),
    /// Force of a support on the body \[N\].
    Reaction(u32, TensorPart),
    /// A load's force \[N\].
    Applied(u32, TensorPart),
    /// Kinetic energy \[J\].
    Kinetic,
    /// Elastic energy \[J\].
    Elastic,
    /// Energy that the material lost, to damage or to flow \[J\].
    Dissipated,
    /// Energy that damping took \[J\].
    Damped,
    /// Energy lost where sides of cracks, or bodies, met \[J\].
    Met,
    /// Work of loads and supports \[J\].
    Work,
    /// Energy that is there or was lost in a known way, less what was put in \[J\].
    Balance,
    /// Linear momentum \[kg·m/s\].
    Momentum(TensorPart),
    /// Angular momentum about the specimen's origin \[kg·m²/s\].
    AngularMomentum(TensorPart),
    /// Fully broken points of a part \[1\].
    Broken(Where),
    /// Volume of the points of a part whose damage is above a bound \[m³\].
    DamagedVolume(Where, f64),
    /// Area of the squares of one spacing, across a unit direction, that broken points of a part
    /// lie in \[m²\].
    CrackArea(Where, Vec3),
    /// How far broken points of a part reach along a direction \[m\]; without any, `otherwise`.
    CrackTip {
        /// Which points.
        part: Where,
        /// Unit direction.
        along: Vec3,
        /// Share of the points that lie behind \[1\].
        share: f64,
        /// Before there are any \[m\].
        otherwise: f64,
    },
    /// Angle of the mean of a part's broken points about a place, from a first unit direction
    /// towards a second \[rad\]; not a number without any.
    CrackAngle(Where, Vec3, [Vec3; 2]),
    /// Pieces of at least a share of the body \[1\].
    Pieces(f64),
    /// The largest piece's share of the body \[1\].
    Largest,
}

impl Probe {
    /// The field of the points that it is read off, if it is.
    #[must_use]
    pub const fn field(&self) -> Option<PointField> {
        match self {
            Self::Points(field, _, _) => Some(*field),
            Self::Broken(_)
            | Self::DamagedVolume(_, _)
            | Self::CrackArea(_, _)
            | Self::CrackTip { .. }
            | Self::CrackAngle(_, _, _) => Some(PointField::Damage),
            _ => None,
        }
    }
}
