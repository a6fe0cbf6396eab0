//! Why a mesh was not admitted.

use crate::boolean::BooleanError;
use crate::math::Vec3;
use crate::mesh::MeshError;

/// Most triangles admitted; at this size, repair takes about a minute.
pub const MAX_TRIANGLES: usize = 5_000_000;
/// Diagonals admitted \[m\]: outside, products of lengths and densities lose digits in f64.
pub const DIAGONALS: (f64, f64) = (1e-7, 1e6);

/// Why a mesh was not admitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DoorError {
    /// The arrays are wrong.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Too many triangles.
    #[error("the mesh has {triangles} triangles; at most {MAX_TRIANGLES} are accepted")]
    TooMany {
        /// How many it has.
        triangles: usize,
    },
    /// Too small or too large.
    #[error(
        "the mesh is {diagonal:e} m across; {:e} to {:e} m are taken",
        DIAGONALS.0,
        DIAGONALS.1
    )]
    Size {
        /// Its diagonal \[m\].
        diagonal: f64,
    },
    /// Triangles without area.
    #[error("{count} triangles have no area, the first is triangle {first}")]
    Degenerate {
        /// How many there are.
        count: usize,
        /// The first.
        first: usize,
    },
    /// Triangles with the same three corners.
    #[error("{count} triangles have the corners of another, the first is triangle {first}")]
    Duplicate {
        /// How many there are.
        count: usize,
        /// The first.
        first: usize,
    },
    /// Edges with one triangle: the mesh has holes.
    #[error("{count} edges are open, the first at {}", place(first))]
    OpenEdges {
        /// How many there are.
        count: usize,
        /// Middle of the first \[m\].
        first: Vec3,
    },
    /// Edges with more than two triangles.
    #[error("{count} edges have more than two triangles, the first at {}", place(first))]
    NonManifold {
        /// How many there are.
        count: usize,
        /// Middle of the first \[m\].
        first: Vec3,
    },
    /// Neighbouring triangles that face opposite ways.
    #[error("{count} edges have triangles that face opposite ways, the first at {}", place(first))]
    NotOriented {
        /// How many there are.
        count: usize,
        /// Middle of the first \[m\].
        first: Vec3,
    },
    /// A closed shell faces inward where it should face outward, or lies inside another.
    #[error("shell {shell} of {shells} ({volume:e} m³) is inside out or in another")]
    Inverted {
        /// Which, in order of first triangle.
        shell: usize,
        /// Of how many.
        shells: usize,
        /// Its signed volume \[m³\].
        volume: f64,
    },
    /// The surface crosses or touches itself.
    #[error("at least {count} pairs of triangles cross, the first near {}", place(first))]
    SelfIntersecting {
        /// Pairs found (at least 1).
        count: usize,
        /// Where the first is \[m\].
        first: Vec3,
    },
    /// The only repair that is left moves the surface far.
    #[error(
        "the mesh can only be made anew on a grid, which would move its surface by {moved:.3} m, \
         {:.1} % of its size, near {}: mend it where it was made, or ask for that with \
         `repair = \"remesh\"`",
        100.0 * share, place(at)
    )]
    Moved {
        /// How far it would move \[m\].
        moved: f64,
        /// That, as a share of the diagonal of its box.
        share: f64,
        /// Where \[m\].
        at: Vec3,
    },
    /// Nothing solid is left.
    #[error("the mesh encloses no volume")]
    NoVolume,
    /// What is left is thinner than rounding lets a body be.
    #[error(
        "the mesh encloses no volume to speak of: {volume:.3e} m³; a shell as large must have at \
         least {least:.3e} m³"
    )]
    Thin {
        /// Its volume \[m³\].
        volume: f64,
        /// Least accepted: a share of its diagonal cubed \[m³\].
        least: f64,
    },
    /// Every way of repair failed; this is the last failure.
    #[error("the mesh could not be repaired: {0}")]
    Unrepairable(BooleanError),
}

/// A point as an error message shows it.
fn place(p: &Vec3) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}
