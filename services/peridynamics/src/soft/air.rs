//! What the air does to the outer surface of a soft solid.

use cullet_geometry::Vec3;
use cullet_model::SheetAir;

/// Drag along the surface over that across it, by area: skin friction of a plate in turbulent flow.
const SKIN: f64 = 0.02;

/// Impulse of the air in a step \[N·s\] on a point of this mass that bears the outer area `area`
/// \[m²\], outward. Air meets only what moves towards it: the lee side has no drag. The pressure is
/// that inside over that outside. Drag is implicit, as points may be light.
pub(super) fn impulse(air: &SheetAir, area: Vec3, relative: Vec3, mass: f64, dt: f64) -> Vec3 {
    let size = area.norm();
    if size == 0.0 {
        return Vec3::zeros();
    }
    let normal = area / size;
    let across = relative.dot(&normal);
    let along = relative - normal * across;
    let by = 0.5 * air.density * air.drag * size * dt;
    let strength = by * across.max(0.0);
    let skin = SKIN * by * along.norm();
    area * (air.pressure * dt)
        - normal * (strength * across / (1.0 + strength / mass))
        - along * (skin / (1.0 + skin / mass))
}
