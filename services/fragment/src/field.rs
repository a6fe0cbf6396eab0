//! The damage that a body is cut along.

use crate::pieces::Pieces;
use cullet_geometry::Vec3;
use cullet_model::strength::Region;

/// What a solver knows of the damage when it stops, in the reference configuration (body frame).
#[derive(Clone, Copy, Debug)]
pub struct DamageField<'a> {
    /// Grid spacing h \[m\].
    pub spacing: f64,
    /// Where each particle sat before the hit \[m\].
    pub positions: &'a [Vec3],
    /// Damage of each particle, in `[0, 1]`.
    pub damage: &'a [f64],
    /// When damage reached 1 \[s\]; infinite where it has not.
    pub damage_time: &'a [f64],
    /// Step of time in which it was found \[s\]; differences below it mean nothing (F35).
    pub time_step: f64,
    /// No front is faster \[m/s\].
    pub top_speed: f64,
    /// True length of a unit of this frame along each axis: 1, unless the frame is stretched.
    pub scale: Vec3,
    /// Unit normal of the crack at each broken particle, zero where it is not known; without it,
    /// cracks that end inside a part are not looked for.
    pub normals: Option<&'a [Vec3]>,
    /// The piece that each particle belongs to, and how those that were sampled were; without it,
    /// pieces are what the damage leaves connected on the lattice.
    pub pieces: Option<&'a Pieces>,
    /// Grooves that a scene scored, body frame: a crack in one lies as the scene asks, not as the
    /// grid does (F22).
    pub scored: &'a [Region],
}
