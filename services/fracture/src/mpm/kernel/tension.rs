//! What many damaged points bear at once.

use crate::mpm::elastic::CRUSHED;
use cullet_simd::{Real, V};
use fearless_simd::{Select, Simd, SimdBase, SimdFloat};

/// A squared stress \[Pa²\] that is none, whose power 3/2 is a number in f32 too.
const LEAST: f64 = 1e-20;

/// The stress \[Pa\] of Green's strain `e` where damage takes the share `taken` of what is pulled:
/// as [`pulls`](crate::mpm::elastic::LameParameters::pulls), of which that share is taken where
/// they pull.
///
/// With 2μE = m I + B and p² = B:B/6 the principal value farthest from the others is m ± 2py, where
/// 4y³ − 3y = |det B|/2p³ and y ∈ \[½√3, 1\]; Newton's method finds it. It lies apart from the
/// others by √3 p at least, so that its projector N is well conditioned, and what is left in the
/// plane across it is a problem of two values.
#[inline(always)]
pub(super) fn weakened<S: Simd, R: Real>(
    simd: S,
    e: &[V<S, R>; 6],
    [shear, half_lame, _]: &[V<S, R>; 3],
    taken: V<S, R>,
) -> [V<S, R>; 6] {
    let (half, two, three) = (R::of(0.5), R::of(2.0), R::of(3.0));
    let zero = V::<S, R>::splat(simd, R::of(0.0));
    let one = V::<S, R>::splat(simd, R::of(1.0));
    let least = V::<S, R>::splat(simd, R::of(LEAST));
    let double = *shear * two;
    let s = e.map(|e| e * double);
    let mean = (s[0] + s[1] + s[2]) * R::of(1.0 / 3.0);
    // Free of trace even after rounding, where the strain is nearly a swelling.
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
    let scale = one / trace.simd_gt(least).select(trace, least);
    let n = n.map(|n| n * scale);
    let mut plane = [zero; 6];
    for k in 0..6 {
        plane[k] = s[k] - value * n[k];
    }
    let middle = (mean * three - value) * half;
    let spread = norm_squared::<S, R>(&plane) * half - middle * middle;
    let spread = spread.simd_gt(zero).select(spread, zero).sqrt();
    let (high, low) = (middle + spread, middle - spread);
    let per_shear = one / *shear;
    let u = [down.select(high, value), down.select(low, high), down.select(value, low)];
    let give = *half_lame * per_shear;
    let swell = give * swelling::<S, R>(simd, &u.map(|u| u * per_shear), give, taken);
    let left = one - taken;
    let floor = V::<S, R>::splat(simd, R::of(CRUSHED * CRUSHED));
    let bears = |value: V<S, R>| {
        let u = value * per_shear;
        let stretch = one + u;
        let pull = *shear * (u + swell) / stretch.simd_gt(floor).select(stretch, floor);
        pull.simd_gt(zero).select(left * pull, pull)
    };
    let (own, top, bottom) = (bears(value), bears(high), bears(low));
    let width = high - low;
    let slope = (top - bottom) / width.simd_gt(least).select(width, least);
    let both = (top + bottom) * half;
    let mut stress = [zero; 6];
    for k in 0..6 {
        let across = if k < 3 { one - n[k] } else { zero - n[k] };
        stress[k] = own * n[k] + both * across + slope * (plane[k] - middle * across);
    }
    stress
}

/// As in `crate::mpm::elastic`, of `u` that falls.
#[inline(always)]
fn swelling<S: Simd, R: Real>(simd: S, u: &[V<S, R>; 3], half: V<S, R>, taken: V<S, R>) -> V<S, R> {
    let (two, three, four) = (R::of(2.0), R::of(3.0), R::of(4.0));
    let zero = V::<S, R>::splat(simd, R::of(0.0));
    let one = V::<S, R>::splat(simd, R::of(1.0));
    let (left, give) = (one - taken, half * taken);
    let [v, w, z] = u.map(|u| left * u);
    let rest = u[1] + u[2] + u[1] * u[2];
    let share = one + rest;
    let none = u[0] + rest * (one + u[0]);
    let single = (rest + v * share) / (one + give * share);
    let share = one + u[2];
    let sum = u[2] + share * (v + w + v * w);
    let slope = one + give * share * (v + w + two);
    let root = slope * slope - give * give * share * sum * four;
    let root = root.simd_gt(zero).select(root, zero).sqrt();
    let both = sum * two / (slope + root);
    let small = (v + w + z) / (one + give * three);
    let shift = give * small;
    let (a, b, c) = (v - shift, w - shift, z - shift);
    let (pairs, sum) = (a * b + b * c + c * a, a + b + c);
    let slope = one + give * (sum * two + pairs + three);
    let all = small - (small - (sum + pairs + a * b * c)) / slope;
    let first = none.simd_gt(single).select(single, none);
    let last = both.simd_gt(all).select(all, both);
    first.simd_gt(last).select(last, first)
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
    use super::weakened;
    use crate::mpm::elastic::LameParameters;
    use crate::mpm::symmetric::{Sym3, eigen};
    use cullet_geometry::math::unit;
    use cullet_simd::{Lanes, Real, load};
    use fearless_simd::{Level, Simd, SimdBase, dispatch};

    /// The slow twin: Jacobi's method.
    fn naive(elastic: &LameParameters, e: &Sym3, taken: f64) -> Sym3 {
        let (values, v) = eigen(e);
        let bears = elastic.pulls(values, taken);
        let bears = bears.map(|pull| if pull > 0.0 { (1.0 - taken) * pull } else { pull });
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
        pairs.map(|(i, j)| (0..3).map(|n| bears[n] * v[n][i] * v[n][j]).sum())
    }

    #[inline(always)]
    fn first<S: Simd, R: Real>(simd: S, elastic: &LameParameters, e: &Sym3, taken: f64) -> Sym3 {
        let lanes = |x: f64| load(simd, &Lanes([R::of(x); 16]), 0);
        let own = [elastic.shear, 0.5 * elastic.lame, 0.0].map(lanes);
        weakened::<S, R>(simd, &e.map(lanes), &own, lanes(taken)).map(|x| x.as_slice()[0].wide())
    }

    /// Random, nearly degenerate and exactly degenerate strains.
    fn strain(index: u64) -> Sym3 {
        let mut s = [0, 1, 2, 3, 4, 5].map(|k| 2e-3 * unit(11, k, index) - 1e-3);
        match index % 8 {
            0 => s = [s[0], 0.0, 0.0, 0.0, 0.0, 0.0],
            1 => s = [s[0], s[0], s[1], 0.0, 0.0, 0.0],
            2 => s = [s[0], s[0], s[0], 1e-15 * s[3], 0.0, 0.0],
            3 => s = [s[0], 1e-6 * s[1], -1e-6 * s[2], 1e-3 * s[3], 0.0, s[5]],
            4 => s = s.map(|x| 1e-6 * x),
            5 if index == 5 => s = [0.0; 6],
            6 => s = [s[0] + 0.2, 1e1 * s[1], 1e1 * s[2], 1e1 * s[3], s[4], 3e1 * s[5]],
            _ => {}
        }
        s
    }

    #[test]
    fn what_damaged_points_bear_agrees_with_the_eigenvectors() {
        let level = Level::new();
        for index in 0..4000 {
            let s = strain(index);
            let single = s.map(|x| f64::from(x as f32));
            let size = s.iter().fold(1e-5_f64, |m, x| m.max(x.abs()));
            let poisson = [0.2, 0.0, 0.45, -0.3][(index / 8 % 4) as usize];
            let shear = 1e10;
            let elastic =
                LameParameters { shear, lame: 2.0 * shear * poisson / (1.0 - 2.0 * poisson) };
            let taken = [1.0, 0.5, 0.9][(index / 32 % 3) as usize];
            let double = dispatch!(level, simd => first::<_, f64>(simd, &elastic, &s, taken));
            let rough = dispatch!(level, simd => first::<_, f32>(simd, &elastic, &single, taken));
            let wanted = [naive(&elastic, &s, taken), naive(&elastic, &single, taken)];
            for k in 0..6 {
                let scale = size * (elastic.lame.abs() + 2.0 * shear);
                let error = [double[k] - wanted[0][k], rough[k] - wanted[1][k]].map(|e| e / scale);
                assert!(error[0].abs() < 1e-12, "case {index}: {} of {s:?}", error[0]);
                assert!(error[1].abs() < 4e-6, "case {index}: {} of {s:?}", error[1]);
            }
        }
    }
}
