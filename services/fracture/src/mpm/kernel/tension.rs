//! The pulled part of many stresses at once.

use super::lanes::{Real, V};
use fearless_simd::{Select, Simd, SimdBase, SimdFloat};

/// A squared stress \[Pa²\] that is none, whose power 3/2 is a number in f32 too.
const LEAST: f64 = 1e-20;

/// Σ ⟨σ_i⟩ n_i ⊗ n_i of the principal stresses σ_i: what damage takes from.
///
/// With σ = m I + B and p² = B:B/6 the principal value farthest from the others is m ± 2py, where
/// 4y³ − 3y = |det B|/2p³ and y ∈ \[½√3, 1\]; Newton's method finds it. It lies apart from the
/// others by √3 p at least, so that its projector N is well conditioned, and what is left in the
/// plane across it is a problem of two values a ≥ b: S⁺ = a (S − b (I − N))/(a − b) where a > 0 >
/// b.
#[inline(always)]
pub(super) fn pulled<S: Simd, R: Real>(simd: S, s: &[V<S, R>; 6]) -> [V<S, R>; 6] {
    let (half, two, three) = (R::of(0.5), R::of(2.0), R::of(3.0));
    let zero = V::<S, R>::splat(simd, R::of(0.0));
    let least = V::<S, R>::splat(simd, R::of(LEAST));
    let mean = (s[0] + s[1] + s[2]) * R::of(1.0 / 3.0);
    // Free of trace even after rounding, where the stress is nearly a pressure.
    let (x, y) = (s[0] - mean, s[1] - mean);
    let b = [x, y, zero - (x + y), s[3], s[4], s[5]];
    let square = norm_squared::<S, R>(&b) * R::of(1.0 / 6.0);
    let square = square.simd_gt(least).select(square, least);
    let p = square.sqrt();
    let cofactors = adjugate::<S, R>(&b);
    let det = b[0] * cofactors[0] + b[3] * cofactors[3] + b[5] * cofactors[5];
    let r = det * half / (square * p);
    let down = zero.simd_gt(r);
    let r = down.select(zero - r, r);
    let mut y = r * R::of(0.13) + R::of(0.87);
    for _ in 0..3 {
        let y2 = y * y;
        y = y - (y * (y2 * R::of(4.0) - three) - r) / (y2 * R::of(12.0) - three);
    }
    let apart = p * y * two;
    let apart = down.select(zero - apart, apart);
    let value = mean + apart;
    let from = [b[0] - apart, b[1] - apart, b[2] - apart, s[3], s[4], s[5]];
    let n = adjugate::<S, R>(&from);
    let trace = n[0] + n[1] + n[2];
    let scale = V::<S, R>::splat(simd, R::of(1.0)) / trace.simd_gt(least).select(trace, least);
    let n = [n[0] * scale, n[1] * scale, n[2] * scale, n[3] * scale, n[4] * scale, n[5] * scale];
    let mut plane = [zero; 6];
    for k in 0..6 {
        plane[k] = s[k] - value * n[k];
    }
    let middle = (mean * three - value) * half;
    let spread = norm_squared::<S, R>(&plane) * half - middle * middle;
    let spread = spread.simd_gt(zero).select(spread, zero).sqrt();
    let (high, low) = (middle + spread, middle - spread);
    let width = high - low;
    let share = high / width.simd_gt(least).select(width, least);
    let (none, all) = (zero.simd_ge(high), low.simd_ge(zero));
    let one = V::<S, R>::splat(simd, R::of(1.0));
    let share = none.select(zero, all.select(one, share));
    let low = all.select(zero, low);
    let own = value.simd_gt(zero).select(value, zero);
    let mut pulled = [zero; 6];
    for k in 0..6 {
        let across = if k < 3 { one - n[k] } else { zero - n[k] };
        pulled[k] = own * n[k] + share * (plane[k] - low * across);
    }
    pulled
}

/// The adjugate of a symmetric tensor.
#[inline(always)]
pub(super) fn adjugate<S: Simd, R: Real>(e: &[V<S, R>; 6]) -> [V<S, R>; 6] {
    [
        e[1] * e[2] - e[4] * e[4],
        e[2] * e[0] - e[5] * e[5],
        e[0] * e[1] - e[3] * e[3],
        e[4] * e[5] - e[2] * e[3],
        e[5] * e[3] - e[0] * e[4],
        e[3] * e[4] - e[1] * e[5],
    ]
}

#[inline(always)]
fn norm_squared<S: Simd, R: Real>(s: &[V<S, R>; 6]) -> V<S, R> {
    let off = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + off + off
}

#[cfg(test)]
mod tests {
    use super::super::lanes::{Lanes, Real, load};
    use super::pulled;
    use crate::mpm::symmetric::{Sym3, eigen};
    use cullet_geometry::math::unit;
    use fearless_simd::{Level, Simd, SimdBase, dispatch};

    /// The slow twin: Jacobi's method.
    fn naive(s: &Sym3) -> Sym3 {
        let (values, v) = eigen(s);
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
        pairs.map(|(i, j)| (0..3).map(|n| values[n].max(0.0) * v[n][i] * v[n][j]).sum())
    }

    #[inline(always)]
    fn first<S: Simd, R: Real>(simd: S, s: &Sym3) -> Sym3 {
        let s = s.map(|x| load(simd, &Lanes([R::of(x); 16]), 0));
        pulled::<S, R>(simd, &s).map(|x| x.as_slice()[0].wide())
    }

    /// Random, nearly degenerate and exactly degenerate stresses.
    fn stress(index: u64) -> Sym3 {
        let mut s = [0, 1, 2, 3, 4, 5].map(|k| 2e6 * unit(11, k, index) - 1e6);
        match index % 8 {
            0 => s = [s[0], 0.0, 0.0, 0.0, 0.0, 0.0],
            1 => s = [s[0], s[0], s[1], 0.0, 0.0, 0.0],
            2 => s = [s[0], s[0], s[0], 1e-9 * s[3], 0.0, 0.0],
            3 => s = [s[0], 1e-6 * s[1], -1e-6 * s[2], 1e-3 * s[3], 0.0, s[5]],
            4 => s = s.map(|x| 1e-6 * x),
            5 if index == 5 => s = [0.0; 6],
            _ => {}
        }
        s
    }

    #[test]
    fn the_pulled_part_agrees_with_the_eigenvectors() {
        let level = Level::new();
        for index in 0..4000 {
            let s = stress(index);
            let single = s.map(|x| f64::from(x as f32));
            let size = s.iter().fold(1e4_f64, |m, x| m.max(x.abs()));
            let double = dispatch!(level, simd => first::<_, f64>(simd, &s));
            let rough = dispatch!(level, simd => first::<_, f32>(simd, &single));
            for (k, (wanted, near)) in naive(&s).iter().zip(naive(&single)).enumerate() {
                assert!((double[k] - wanted).abs() < 1e-13 * size, "case {index}: {s:?}");
                assert!((rough[k] - near).abs() < 3e-6 * size, "case {index} in f32: {s:?}");
            }
        }
    }
}
