//! Whether a hit dents or bends solid metal enough to be solved \[gate 7\].

use crate::gate::{bending, hertz};
use crate::reason::RigidReason;
use cullet_world::{BodyMeasure, BodyView, Hit};

/// Depth of a dent over the length of the body below which nobody sees it \[1\].
const SEEN: f64 = 2e-3;

/// Stress of bending over the yield stress below which nothing flows \[1\]: a half, because contact
/// sizes and thicknesses are estimates.
const SAFETY: f64 = 0.5;

/// Mean pressure under a contact where all around it flows, over the yield stress \[Tabor 1951\].
const HARDNESS: f64 = 3.0;

/// Depth of the dent that a hit makes \[m\], and the force on its way \[N\]: E = ∫ 3σ_y 2πRδ dδ; no
/// more than Hertz's.
fn dent(hit: &Hit, yield_stress: f64) -> (f64, f64) {
    let (elastic, approach) = hertz(hit);
    let radius = hit.impact.radius * hit.impact.radius / approach;
    let slope = 2.0 * std::f64::consts::PI * HARDNESS * yield_stress * radius;
    let depth = (2.0 * hit.impact.energy / slope).sqrt();
    let force = slope * depth;
    if force < elastic { (depth, force) } else { (0.0, elastic) }
}

/// Why a solid of metal is solved.
///
/// # Errors
/// Why each of the hits leaves it as it is, if all do.
pub(crate) fn reason(
    view: &BodyView<'_>,
    measure: &BodyMeasure,
    hits: &[Hit],
    yield_stress: f64,
) -> Result<String, Vec<RigidReason>> {
    let poisson = view.material.solid.poisson;
    let limit = SEEN * measure.length;
    let mut kept = Vec::new();
    for hit in hits {
        let (depth, force) = dent(hit, yield_stress);
        if depth >= limit {
            return Ok(format!("a dent of about {depth:.1e} m"));
        }
        let stress = bending(force, hit.impact.radius, poisson, measure);
        if stress >= SAFETY * yield_stress {
            return Ok(format!("it bends: {stress:.1e} Pa, and yields at {yield_stress:.1e}"));
        }
        kept.push(RigidReason::Dent { depth, limit });
    }
    Err(kept)
}
