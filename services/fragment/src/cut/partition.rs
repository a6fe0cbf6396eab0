//! How fine a cut may be, and the parts that it leaves.

use crate::grid_bias::GridBias;
use cullet_geometry::{Sheet, Solid, Vec3};
use cullet_model::CrackFaceDetail;

/// How fine a cut may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutSettings {
    /// Parts below this share of the body's volume join a neighbour \[1\].
    pub min_volume_ratio: f64,
    /// At most this many parts; the smallest join a neighbour first. Separate shells always stay.
    pub max_fragments: u32,
    /// The only source of randomness.
    pub seed: u64,
    /// How crack faces look closer up.
    pub detail: CrackFaceDetail,
}

/// One part of a body that was cut.
#[derive(Clone, Debug, PartialEq)]
pub struct CutPart {
    /// Its closed boundary \[m\].
    pub solid: Solid,
    /// Convex parts that stand in for it in collisions: corner sets \[m\].
    pub hulls: Vec<Vec<Vec3>>,
    /// Its volume \[m³\].
    pub volume: f64,
    /// Cracks that end inside it.
    pub cracks: Vec<OpenCrack>,
}

/// A crack that ends inside a part, without junctions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenCrack {
    /// What of it lies inside the part \[m\].
    pub inside: Sheet,
    /// The same before it was clipped: it reaches out of the part where it meets its surface.
    pub beyond: Sheet,
}

/// A body taken apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Partition {
    /// By falling volume, then by centroid.
    pub parts: Vec<CutPart>,
    /// For each particle, the part it lies in: an index into `parts`.
    pub particle_part: Vec<u32>,
    /// Area of the new cracks \[m²\], counted once, not per side.
    pub crack_area: f64,
    /// How its faces lie in the grid of the solve, or in the lattice of the cut where they lie in
    /// that; of damage only.
    pub bias: GridBias,
    /// What was noticed and let pass, a sentence each.
    pub warnings: Vec<String>,
}
