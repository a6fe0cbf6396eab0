//! What a family of solvers may be given to break.

use cullet_geometry::Solid;
use std::sync::Arc;

/// The shape of a body, in its own frame (origin at the centre of mass). Shapes of further kinds
/// will follow: a family refuses those that it does not know.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BodyShape {
    /// What a closed surface encloses \[m\].
    Solid(Arc<Solid>),
}

impl BodyShape {
    /// The solid, if it is one.
    #[must_use]
    pub fn solid(&self) -> Option<&Arc<Solid>> {
        match self {
            Self::Solid(solid) => Some(solid),
        }
    }

    /// What it is called in messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Solid(_) => "solid",
        }
    }
}

impl From<Solid> for BodyShape {
    fn from(solid: Solid) -> Self {
        Self::Solid(Arc::new(solid))
    }
}
