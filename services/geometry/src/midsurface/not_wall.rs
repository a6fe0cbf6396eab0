//! What a body may lack that has a midsurface, and the bounds.

use crate::remesh::SurfaceError;
use thiserror::Error;

/// Greatest cosine between the outward normals of two faces across a wall \[1\].
pub(super) const OPPOSED: f64 = -0.8;

/// Least share of the area outside the rim that has a partner across the wall \[1\] (F91).
pub const PAIRED_SHARE: f64 = 0.9;

/// Greatest median thickness over the width of the body \[1\]: beyond it the body is a solid.
pub const THICK_RATIO: f64 = 0.125;

/// Greatest thickness over least thickness, 95th over 5th percentile of the area \[1\] (F91).
pub const THICKNESS_SPREAD: f64 = 2.0;

/// Least radius of curvature over thickness \[1\] (F95) …
pub const LEAST_RADIUS: f64 = 5.0;

/// … and the greatest share of the area that may bend more sharply \[1\]: the heel and the neck of
/// a bottle.
pub const SHARP_SHARE: f64 = 0.2;

/// How far the volume of the body may be from thickness times area \[1\] (F91).
pub const VOLUME_ERROR: f64 = 0.03;
/// The same once rims that cracks left are smooth.
pub const RAGGED: f64 = 0.1;

/// Why a body has no midsurface here.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NotWall {
    /// The mesh is not closed.
    #[error("its mesh has {edges} edges without exactly two triangles; a wall is a closed mesh")]
    Open {
        /// Edges that are open or crowded.
        edges: usize,
    },
    /// Too little of its surface faces another wall.
    #[error(
        "{share:.2} of its surface without the rim faces another wall; a thin wall has at least \
         {PAIRED_SHARE}"
    )]
    Unpaired {
        /// Paired area over area without rim \[1\].
        share: f64,
    },
    /// It is too thick for its width.
    #[error("it is {ratio:.3} times as thick as it is wide; a thin wall is at most {THICK_RATIO}")]
    Thick {
        /// Median thickness over the lesser of √area and the middle extent of its box \[1\].
        ratio: f64,
    },
    /// Its thickness varies too much.
    #[error(
        "its thickness varies {ratio:.2} to 1 (95th to 5th percentile); a thin wall at most \
         {THICKNESS_SPREAD} to 1"
    )]
    Varies {
        /// 95th over 5th percentile of the thickness over the area \[1\].
        ratio: f64,
    },
    /// It is bent too sharply for its thickness.
    #[error(
        "{share:.2} of it has a radius of curvature under {LEAST_RADIUS} times its thickness; at \
         most {SHARP_SHARE} may"
    )]
    Sharp {
        /// Share of the area \[1\].
        share: f64,
    },
    /// Thickness times area is not its volume.
    #[error(
        "thickness times area of its midsurface is {share:.3} of its volume; a thin wall has \
         {least:.2} to {most:.2}",
        least = 1.0 - VOLUME_ERROR, most = 1.0 + VOLUME_ERROR
    )]
    Volume {
        /// Σ t A over volume \[1\].
        share: f64,
    },
    /// Rims that cracks left are jagged over much of it, or it has many holes of them.
    #[error(
        "with smooth rims and small holes closed its midsurface times its thickness is {share:.3} \
         of its volume, not {least:.2} to {most:.2}",
        least = 1.0 - RAGGED, most = 1.0 + RAGGED
    )]
    Ragged {
        /// Σ t A over volume \[1\].
        share: f64,
    },
    /// The midsurface cannot be meshed.
    #[error("its midsurface cannot be meshed: {0}")]
    Surface(#[from] SurfaceError),
}
