//! Seeded variation of strength in space: flaws that let cracks choose and branch.

use cullet_geometry::{Vec3, math::scramble, math::unit};

/// Correlation length in spacings: shorter flaws are noise to a band four spacings wide (F23).
pub const CORRELATION: f64 = 4.0;

/// Greatest deviation of the strength from the material's \[1\].
pub const AMPLITUDE: f64 = 0.1;

/// Stream of the seed's numbers.
const STREAM: u64 = 0x57e4;

/// Local strength over the material's at `x`: trilinear in random numbers on a lattice of
/// `CORRELATION` spacings; mean 1, within 1 ± `AMPLITUDE`.
#[must_use]
pub fn strength(x: &Vec3, spacing: f64, seed: u64) -> f64 {
    let inverse = 1.0 / (CORRELATION * spacing);
    let scaled = x * inverse;
    let low = scaled.map(f64::floor);
    let f = scaled - low;
    let corner = |i: usize| {
        let d = [i & 1, i >> 1 & 1, i >> 2 & 1];
        let key = (0..3).fold(0u64, |key, a| scramble(key ^ (low[a] as i64 + d[a] as i64) as u64));
        let weight: f64 = (0..3).map(|a| if d[a] == 1 { f[a] } else { 1.0 - f[a] }).product();
        weight * (2.0 * unit(seed, STREAM, key) - 1.0)
    };
    1.0 + AMPLITUDE * (0..8).map(corner).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::{AMPLITUDE, strength};
    use cullet_geometry::{Vec3, math::unit};

    #[test]
    fn strength_varies_smoothly_about_one() {
        let n = 4000;
        let at = |i| Vec3::new(unit(5, 0, i), unit(5, 1, i), unit(5, 2, i)) * 10.0;
        let values: Vec<f64> = (0..n).map(|i| strength(&at(i), 0.05, 9)).collect();
        let mean = values.iter().sum::<f64>() / n as f64;
        assert!((mean - 1.0).abs() < 0.1 * AMPLITUDE, "mean {mean}");
        assert!(values.iter().all(|v| (v - 1.0).abs() <= AMPLITUDE));
        let spread = values.iter().map(|v| (v - mean).abs()).sum::<f64>() / n as f64;
        assert!(spread > 0.1 * AMPLITUDE, "spread {spread}");
        let step = strength(&at(1), 0.05, 9) - strength(&(at(1) + Vec3::repeat(0.005)), 0.05, 9);
        assert!(step.abs() < 0.2 * AMPLITUDE);
        assert_ne!(strength(&at(1), 0.05, 9), strength(&at(1), 0.05, 10));
    }
}
