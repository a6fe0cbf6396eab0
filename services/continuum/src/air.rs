//! Air around a sheet: drag, wind with gusts, and a difference of pressure.

use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_model::SheetAir;
use cullet_simd::LANES;

/// Drag along the sheet over that across it, by area: skin friction of a plate in turbulent flow.
const SKIN: f64 = 0.02;
/// Stream of [`unit`] numbers for gusts.
const GUST_STREAM: u64 = 0x6775_7374;

/// The wind at a time \[s\]: gusts come and go smoothly, each of its own strength.
#[must_use]
pub fn wind(air: &SheetAir, seed: u64, time: f64) -> Vec3 {
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
#[must_use]
pub fn acts(air: &SheetAir) -> bool {
    (air.density > 0.0 && air.drag > 0.0) || air.pressure != 0.0
}

/// Whether it moves what is at rest.
#[must_use]
pub fn blows(air: &SheetAir) -> bool {
    acts(air) && (air.wind != Vec3::zeros() || air.pressure != 0.0)
}

/// Share of a point's velocity across the sheet that drag would take in a step \[1\]: by the old
/// velocity alone it would turn the point back where this is above 1 (F94m).
#[must_use]
pub fn drag_share(air: &SheetAir, area: Vec3, relative: Vec3, mass: f64, dt: f64) -> f64 {
    0.5 * air.density * air.drag * dt * relative.dot(&area).abs() / mass
}

/// Impulse of the air in a step \[N·s\] on a point of this mass, with the area vector `area` \[m²\]
/// of its upper side. Drag is implicit: released edges are light, and drag that is computed from
/// the old velocity alone would turn them back and forth.
#[inline(always)]
#[must_use]
pub fn impulse(air: &SheetAir, area: Vec3, relative: Vec3, mass: f64, dt: f64) -> Vec3 {
    let size = area.norm();
    if size == 0.0 {
        return Vec3::zeros();
    }
    let normal = area / size;
    let across = relative.dot(&normal);
    let along = relative - normal * across;
    let by = 0.5 * air.density * air.drag * size * dt;
    let strength = by * across.abs();
    let skin = SKIN * by * along.norm_squared().sqrt();
    area * (air.pressure * dt)
        - normal * (strength * across / (1.0 + strength / mass))
        - along * (skin / (1.0 + skin / mass))
}

/// The same of sixteen points side by side, by axis.
#[inline(always)]
#[must_use]
pub fn impulses(
    air: &SheetAir,
    area: &[[f64; LANES]; 3],
    relative: &[[f64; LANES]; 3],
    masses: &[f64; LANES],
    dt: f64,
) -> [[f64; LANES]; 3] {
    let mut all = [[0.0; LANES]; 3];
    let by_area = 0.5 * air.density * air.drag * dt;
    for lane in 0..LANES {
        let [x, y, z] = [area[0][lane], area[1][lane], area[2][lane]];
        let size = (x * x + y * y + z * z).sqrt();
        let inverse = if size > 0.0 { 1.0 / size } else { 0.0 };
        let normal = [x * inverse, y * inverse, z * inverse];
        let [u, v, w] = [relative[0][lane], relative[1][lane], relative[2][lane]];
        let across = u * normal[0] + v * normal[1] + w * normal[2];
        let along = [u - normal[0] * across, v - normal[1] * across, w - normal[2] * across];
        let sliding = (along[0] * along[0] + along[1] * along[1] + along[2] * along[2]).sqrt();
        let strength = by_area * size * across.abs();
        let skin = SKIN * by_area * size * sliding;
        let mass = masses[lane];
        let pushed = strength * across * mass / (mass + strength);
        let rubbed = skin * mass / (mass + skin);
        all[0][lane] = x * (air.pressure * dt) - normal[0] * pushed - along[0] * rubbed;
        all[1][lane] = y * (air.pressure * dt) - normal[1] * pushed - along[1] * rubbed;
        all[2][lane] = z * (air.pressure * dt) - normal[2] * pushed - along[2] * rubbed;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{impulse, impulses};
    use cullet_geometry::Vec3;
    use cullet_geometry::math::unit;
    use cullet_model::SheetAir;
    use cullet_simd::LANES;

    #[test]
    fn sixteen_points_are_blown_as_each_by_itself() {
        let wind = Vec3::zeros();
        let air = SheetAir { density: 1.2, drag: 0.8, wind, gusts: [0.0; 2], pressure: 30.0 };
        let chance = |k: u64, lane: usize| unit(5, k, lane as u64) - 0.5;
        let mut area: [[f64; LANES]; 3] =
            std::array::from_fn(|c| std::array::from_fn(|lane| 1e-5 * chance(c as u64, lane)));
        let relative: [[f64; LANES]; 3] =
            std::array::from_fn(|c| std::array::from_fn(|lane| 9.0 * chance(3 + c as u64, lane)));
        area.iter_mut().for_each(|axis| axis[3] = 0.0);
        let masses = std::array::from_fn(|lane| 1e-7 * (0.6 + chance(7, lane)));
        let found = impulses(&air, &area, &relative, &masses, 1e-3);
        for lane in 0..LANES {
            let of = |all: &[[f64; LANES]; 3]| Vec3::new(all[0][lane], all[1][lane], all[2][lane]);
            let one = impulse(&air, of(&area), of(&relative), masses[lane], 1e-3);
            assert!((of(&found) - one).norm() <= 1e-12 * one.norm(), "{lane}");
            assert_eq!(one == Vec3::zeros(), lane == 3);
        }
    }
}
