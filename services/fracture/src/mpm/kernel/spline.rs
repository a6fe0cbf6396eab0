//! Gather and scatter of many elements side by side, with the MLS gradient.
//!
//! Along an axis let t ∈ \[−½, ½\] be the point's distance from the middle node, in cells. In place
//! of the values a₀, a₁, a₂ at the three nodes take a₁, α = (a₂ − a₀)/2 and β = a₀ − 2a₁ + a₂. Then
//!
//! > Σ w a = a₁ + t α + q β with q = t²/2 + 1/8,
//!
//! > 4 Σ w d a = α + g β with g = t (3/2 − 2t²), d the distance of the node in cells:
//!
//! half the work of three weights and three distances. Forces go the transposed way.

use super::NodeVectors;
use cullet_simd::{Lanes, Real, V, load, store};
use fearless_simd::Simd;

/// The functions t, q and g of a point, by axis.
pub(super) struct Basis<V> {
    t: [V; 3],
    q: [V; 3],
    g: [V; 3],
}

/// The basis of points at `t`, in cells from the middle node.
#[inline(always)]
pub(super) fn basis<S: Simd, R: Real>(t: [V<S, R>; 3]) -> Basis<V<S, R>> {
    let (eighth, half) = (R::of(0.125), R::of(0.5));
    let (slope, two) = (R::of(1.5), R::of(2.0));
    let s = [t[0] * t[0], t[1] * t[1], t[2] * t[2]];
    let q = [s[0] * half + eighth, s[1] * half + eighth, s[2] * half + eighth];
    let u = [s[0] * two, s[1] * two, s[2] * two];
    let g = [t[0] * slope - t[0] * u[0], t[1] * slope - t[1] * u[1], t[2] * slope - t[2] * u[2]];
    Basis { t, q, g }
}

/// Where the three nodes of a line along an axis are; lines 0 to 26 along z, y, x, by component.
#[inline(always)]
fn line(stride: usize, line: usize, component: usize) -> [usize; 3] {
    let first = line % stride + line / stride * stride * 3;
    [first, first + stride, first + 2 * stride].map(|node| node * 3 + component)
}

/// Values at nodes to a₁, α, β along every axis.
#[inline(always)]
pub(super) fn rise<S: Simd, R: Real>(simd: S, field: &mut NodeVectors<R>, lane: usize) {
    for stride in [1, 3, 9] {
        for k in 0..27 {
            let [i0, i1, i2] = line(stride, k / 3, k % 3);
            let (a0, a1) = (load(simd, &field[i0], lane), load(simd, &field[i1], lane));
            let a2 = load(simd, &field[i2], lane);
            store(simd, a1, &mut field[i0], lane);
            store(simd, (a2 - a0) * R::of(0.5), &mut field[i1], lane);
            store(simd, (a0 - a1) + (a2 - a1), &mut field[i2], lane);
        }
    }
}

/// The transpose of [`rise`]: forces on a₁, α, β to forces on nodes.
#[inline(always)]
pub(super) fn fall<S: Simd, R: Real>(simd: S, field: &mut NodeVectors<R>, lane: usize) {
    for stride in [1, 3, 9] {
        for k in 0..27 {
            let [i0, i1, i2] = line(stride, k / 3, k % 3);
            let middle = load(simd, &field[i0], lane);
            let slope = load(simd, &field[i1], lane) * R::of(0.5);
            let bend = load(simd, &field[i2], lane);
            store(simd, bend - slope, &mut field[i0], lane);
            store(simd, middle - (bend + bend), &mut field[i1], lane);
            store(simd, bend + slope, &mut field[i2], lane);
        }
    }
}

/// Sum and gradient along z of the three values of row `ij`.
#[inline(always)]
fn row<S: Simd, R: Real>(
    simd: S,
    b: &Basis<V<S, R>>,
    field: &NodeVectors<R>,
    [ij, component, lane]: [usize; 3],
) -> [V<S, R>; 2] {
    let first = ij * 9 + component;
    let (middle, slope) = (load(simd, &field[first], lane), load(simd, &field[first + 3], lane));
    let bend = load(simd, &field[first + 6], lane);
    [middle + b.t[2] * slope + b.q[2] * bend, slope + b.g[2] * bend]
}

/// Sum and gradients along y and z of the nine values of plane `i`.
#[inline(always)]
fn plane<S: Simd, R: Real>(
    simd: S,
    b: &Basis<V<S, R>>,
    field: &NodeVectors<R>,
    [i, component, lane]: [usize; 3],
) -> [V<S, R>; 3] {
    let [n0, d0] = row(simd, b, field, [i * 3, component, lane]);
    let [n1, d1] = row(simd, b, field, [i * 3 + 1, component, lane]);
    let [n2, d2] = row(simd, b, field, [i * 3 + 2, component, lane]);
    let (t, q, g) = (b.t[1], b.q[1], b.g[1]);
    [n0 + t * n1 + q * n2, n1 + g * n2, d0 + t * d1 + q * d2]
}

/// The gradient of one component of a risen field, in units per cell.
#[inline(always)]
pub(super) fn gather<S: Simd, R: Real>(
    simd: S,
    b: &Basis<V<S, R>>,
    field: &NodeVectors<R>,
    component: usize,
    lane: usize,
) -> [V<S, R>; 3] {
    let [_, y0, z0] = plane(simd, b, field, [0, component, lane]);
    let [n1, y1, z1] = plane(simd, b, field, [1, component, lane]);
    let [n2, y2, z2] = plane(simd, b, field, [2, component, lane]);
    let (t, q, g) = (b.t[0], b.q[0], b.g[0]);
    [n1 + g * n2, y0 + t * y1 + q * y2, z0 + t * z1 + q * z2]
}

#[inline(always)]
fn add<S: Simd, R: Real>(simd: S, value: V<S, R>, to: &mut Lanes<R>, lane: usize) {
    store(simd, load(simd, to, lane) + value, to, lane);
}

/// Gives row `ij` what goes with its sum and with its gradient along z.
#[inline(always)]
fn give<S: Simd, R: Real>(
    simd: S,
    b: &Basis<V<S, R>>,
    [sum, along]: [V<S, R>; 2],
    field: &mut NodeVectors<R>,
    [ij, component, lane]: [usize; 3],
) {
    let first = ij * 9 + component;
    add(simd, sum, &mut field[first], lane);
    add(simd, b.t[2] * sum + along, &mut field[first + 3], lane);
    add(simd, b.q[2] * sum + b.g[2] * along, &mut field[first + 6], lane);
}

/// The transpose of [`gather`]: adds what goes with the gradient to the forces on a₁, α, β.
#[inline(always)]
pub(super) fn scatter<S: Simd, R: Real>(
    simd: S,
    b: &Basis<V<S, R>>,
    [x, y, z]: [V<S, R>; 3],
    field: &mut NodeVectors<R>,
    [c, l]: [usize; 2],
) {
    let (t, q, g) = (b.t, b.q, b.g);
    // Plane 0 has no share in the gradient along x, nor row 0 in the one along y.
    add(simd, z, &mut field[3 + c], l);
    add(simd, g[2] * z, &mut field[6 + c], l);
    give(simd, b, [y, t[1] * z], field, [1, c, l]);
    give(simd, b, [g[1] * y, q[1] * z], field, [2, c, l]);
    let (y1, z1) = (t[0] * y, t[0] * z);
    give(simd, b, [x, z1], field, [3, c, l]);
    give(simd, b, [t[1] * x + y1, t[1] * z1], field, [4, c, l]);
    give(simd, b, [q[1] * x + g[1] * y1, q[1] * z1], field, [5, c, l]);
    let (x2, y2, z2) = (g[0] * x, q[0] * y, q[0] * z);
    give(simd, b, [x2, z2], field, [6, c, l]);
    give(simd, b, [t[1] * x2 + y2, t[1] * z2], field, [7, c, l]);
    give(simd, b, [q[1] * x2 + g[1] * y2, q[1] * z2], field, [8, c, l]);
}
