//! What a scene asks of how a body comes apart, where a solve only finds it.

use crate::soft::BodyRegion;
use cullet_geometry::Vec3;

/// How many fragments a body is to have, where, and what of it stays in one. It never decides
/// whether the body breaks, and what it changes is [`crate::FragmentOrigin::Directed`].
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct ArtDirection {
    /// Fragments that are wanted, debris aside; `None`: as many as come.
    pub pieces: Option<u32>,
    /// Points of the body that each get a fragment of their own, body frame \[m\].
    pub guides: Vec<Vec3>,
    /// Regions that each stay in one fragment, body frame.
    pub whole: Vec<BodyRegion>,
}

impl ArtDirection {
    /// The same of a body whose places have moved by `offset` \[m\].
    #[must_use]
    pub fn moved(&self, offset: &Vec3) -> Self {
        let region = |region: &BodyRegion| match *region {
            BodyRegion::Ball { centre, radius } => {
                BodyRegion::Ball { centre: centre + offset, radius }
            }
            BodyRegion::Box { low, high } => {
                BodyRegion::Box { low: low + offset, high: high + offset }
            }
        };
        Self {
            pieces: self.pieces,
            guides: self.guides.iter().map(|guide| guide + offset).collect(),
            whole: self.whole.iter().map(region).collect(),
        }
    }

    /// Whether it asks for nothing.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.pieces.is_none() && self.guides.is_empty() && self.whole.is_empty()
    }
}
