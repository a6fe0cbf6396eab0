//! Air around a soft solid: drag, wind with gusts, and pressure, on its outer surface.

use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_model::SheetAir;

/// Drag along the surface over that across it, by area: skin friction of a plate in turbulent flow.
const SKIN: f64 = 0.02;
/// Stream of [`unit`] numbers for gusts.
const GUST_STREAM: u64 = 0x6775_7374;

/// The wind at a time \[s\]: gusts come and go smoothly, each of its own strength.
pub(super) fn wind(air: &SheetAir, seed: u64, time: f64) -> Vec3 {
    let [greatest, rate] = air.gusts;
    if greatest == 0.0 || rate == 0.0 {
        return air.wind;
    }
    let phase = time * rate;
    let number = phase.floor();
    let share = phase - number;
    let smooth = share * share * (3.0 - 2.0 * share);
    let strength = |k: f64| unit(seed, GUST_STREAM, k as u64);
    let gust = strength(number) * (1.0 - smooth) + strength(number + 1.0) * smooth;
    air.wind * (1.0 + greatest * gust)
}

/// Whether the air does anything at all.
pub(super) fn acts(air: &SheetAir) -> bool {
    (air.density > 0.0 && air.drag > 0.0) || air.pressure != 0.0
}

/// Whether air moves what is at rest.
pub(super) fn blows(air: &SheetAir) -> bool {
    acts(air) && (air.wind != Vec3::zeros() || air.pressure != 0.0)
}

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
