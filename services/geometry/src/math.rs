//! The few algebra types that the house uses, and its one source of numbers that look random.

/// A point or vector, f64 \[m unless said otherwise\].
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3×3 matrix, f64.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// A unit quaternion.
pub type Quat = nalgebra::UnitQuaternion<f64>;
/// A rotation followed by a translation \[m\]: body frame to world frame.
pub type Pose = nalgebra::Isometry3<f64>;

/// Scrambles 64 bits (the finaliser of SplitMix64): equal inputs give equal bits on every machine.
#[must_use]
pub fn scramble(key: u64) -> u64 {
    let mut z = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The number in `[0, 1)` that belongs to `(seed, stream, index)`: counter-based, so order never
/// matters.
#[must_use]
pub fn unit(seed: u64, stream: u64, index: u64) -> f64 {
    let bits = scramble(scramble(scramble(seed) ^ stream) ^ index);
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

#[cfg(test)]
mod tests {
    use super::unit;

    #[test]
    fn unit_numbers_fill_the_interval_evenly() {
        let n = 20_000;
        let mean = (0..n).map(|i| unit(7, 1, i)).sum::<f64>() / n as f64;
        assert!((mean - 0.5).abs() < 0.01, "mean {mean}");
        assert!((0..n).all(|i| (0.0..1.0).contains(&unit(7, 2, i))));
        assert_ne!(unit(7, 1, 0), unit(7, 2, 0));
        assert_ne!(unit(7, 1, 0), unit(8, 1, 0));
    }
}
