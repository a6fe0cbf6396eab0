//! Where faces of solids came from, and what is known of cracks at their corners.

use crate::math::Vec3;

/// Where a face of a solid came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// The surface the object was made with.
    Outer,
    /// A crack face: interior material. Values at its three corners vary linearly between them.
    Crack {
        /// Time from the impact to full damage \[s\]; zero where a method has no time.
        damage_time: [f32; 3],
        /// How fast the front passed, 1/|∇τ| \[m/s\]; zero where it is not known.
        front_speed: [f32; 3],
        /// The number of the body that broke here, plus one; zero until it is named.
        parent: u32,
    },
}

impl Surface {
    /// A crack face of which no more is known than when it opened \[s\].
    #[must_use]
    pub fn crack(damage_time: f32) -> Self {
        Self::Crack { damage_time: [damage_time; 3], front_speed: [0.0; 3], parent: 0 }
    }

    /// The surface of a triangle `part` that lies in this one, of these `corners` \[m\].
    #[must_use]
    pub fn within(&self, corners: [Vec3; 3], part: [Vec3; 3]) -> Self {
        let Self::Crack { damage_time, front_speed, parent } = *self else {
            return *self;
        };
        let weights = part.map(|p| barycentric(p, corners));
        let at = |values: [f32; 3]| weights.map(|w| interpolate(values, w));
        Self::Crack { damage_time: at(damage_time), front_speed: at(front_speed), parent }
    }

    /// Whether this is a crack face.
    #[must_use]
    pub fn is_crack(&self) -> bool {
        matches!(self, Self::Crack { .. })
    }
}

/// The weights of a triangle's corners at the point of it below `p`, none negative; a corner has
/// all the weight at its own place.
#[must_use]
pub fn barycentric(p: Vec3, [a, b, c]: [Vec3; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (bb, bc, cc) = (ab.dot(&ab), ab.dot(&ac), ac.dot(&ac));
    let (pb, pc) = (ap.dot(&ab), ap.dot(&ac));
    let whole = bb * cc - bc * bc;
    if whole <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let v = ((cc * pb - bc * pc) / whole).max(0.0);
    let w = ((bb * pc - bc * pb) / whole).max(0.0);
    let u = (1.0 - v - w).max(0.0);
    [u, v, w].map(|weight| weight / (u + v + w))
}

/// Values at the corners of a triangle, at the point with these weights.
#[must_use]
pub fn interpolate(values: [f32; 3], weights: [f64; 3]) -> f32 {
    values.iter().zip(weights).map(|(&x, w)| w * f64::from(x)).sum::<f64>() as f32
}
