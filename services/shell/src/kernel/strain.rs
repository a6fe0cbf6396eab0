//! Strains of a Kirchhoff–Love shell from displacements, and forces from stress resultants, for
//! cells side by side.
//!
//! ε_αβ = ½(a_α·a_β − A_α·A_β), κ_αβ = B_αβ − b_αβ with b_αβ = x,αβ·a₃ \[Kiendl et al. 2009, with
//! the sign of κ such that E(z) = ε + zκ\]. Both are worked out from displacements, so that f32
//! sees small strains.

use cullet_simd::{Lanes, Real, V, load, store};
use fearless_simd::{Simd, SimdBase, SimdFloat};

/// Functions of a cell at a point: R,1 R,2 R,11 R,22 R,12.
pub(super) type Rows<R, const N: usize> = [[R; N]; 5];

/// Vectors at the control points of each cell: node times 3 plus axis.
pub(super) type CellVectors<R, const N: usize> = [[Lanes<R>; 3]; N];

/// A vector for each cell of a register.
pub(super) type Vectors<S, R> = [V<S, R>; 3];

/// Numbers of a point that do not change, cells side by side.
#[derive(Clone, Debug)]
pub(super) struct SurfaceLanes<R> {
    /// A₁, A₂, X,11 X,22 X,12, A₃.
    pub(super) vectors: [[Lanes<R>; 3]; 6],
    /// J.
    pub(super) stretch: Lanes<R>,
    /// T₁₁, T₁₂, T₂₂.
    pub(super) to_local: [Lanes<R>; 3],
}

/// The surface at a point now.
pub(super) struct Present<S: Simd, R: Real> {
    /// a₁ and a₂.
    tangents: [Vectors<S, R>; 2],
    /// x,11 x,22 x,12.
    curvatures: [Vectors<S, R>; 3],
    /// a₃.
    normal: Vectors<S, R>,
    /// 1/|a₁ × a₂|.
    shrink: V<S, R>,
    /// T₁₁, T₁₂, T₂₂.
    to_local: Vectors<S, R>,
    /// ε̂: 11, 22, 12.
    pub(super) membrane: Vectors<S, R>,
    /// κ̂: 11, 22, 12.
    pub(super) bending: Vectors<S, R>,
}

#[inline(always)]
fn dot<S: Simd, R: Real>(a: &Vectors<S, R>, b: &Vectors<S, R>) -> V<S, R> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<S: Simd, R: Real>(a: &Vectors<S, R>, b: &Vectors<S, R>) -> Vectors<S, R> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// An array of three, in line: closures given to `array::map` are not, and lose the path of the
/// processor.
#[inline(always)]
pub(super) fn three<T>(mut of: impl FnMut(usize) -> T) -> [T; 3] {
    [of(0), of(1), of(2)]
}

#[inline(always)]
fn add<S: Simd, R: Real>(a: &Vectors<S, R>, b: &Vectors<S, R>) -> Vectors<S, R> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(super) fn take<S: Simd, R: Real>(simd: S, from: &[Lanes<R>; 3], lane: usize) -> Vectors<S, R> {
    [load(simd, &from[0], lane), load(simd, &from[1], lane), load(simd, &from[2], lane)]
}

/// Symmetric 2×2: Tᵀ E T with T upper triangular; 11, 22, 12.
#[inline(always)]
fn localised<S: Simd, R: Real>(t: &Vectors<S, R>, e: &Vectors<S, R>) -> Vectors<S, R> {
    let [t11, t12, t22] = *t;
    let [e11, e22, e12] = *e;
    let sheared = t12 * e11 + t22 * e12;
    [t11 * t11 * e11, t12 * (sheared + t22 * e12) + t22 * t22 * e22, t11 * sheared]
}

/// Symmetric 2×2: T S Tᵀ; 11, 22, 12.
#[inline(always)]
fn curvilinear<S: Simd, R: Real>(t: &Vectors<S, R>, s: &Vectors<S, R>) -> Vectors<S, R> {
    let [t11, t12, t22] = *t;
    let [s11, s22, s12] = *s;
    let sheared = t11 * s12 + t12 * s22;
    [t11 * (t11 * s11 + t12 * s12) + t12 * sheared, t22 * t22 * s22, t22 * sheared]
}

/// The surface at a point of the cells of a register, from the displacements `field` of their
/// control points.
#[inline(always)]
pub(super) fn present<S: Simd, R: Real, const N: usize>(
    simd: S,
    rows: &Rows<R, N>,
    geometry: &SurfaceLanes<R>,
    field: &CellVectors<R, N>,
    lane: usize,
) -> Present<S, R> {
    let zero = V::<S, R>::splat(simd, R::of(0.0));
    let mut u = [[zero; 3]; 5];
    for (k, node) in field.iter().enumerate() {
        let at = take(simd, node, lane);
        for (d, row) in rows.iter().enumerate() {
            for c in 0..3 {
                u[d][c] += at[c] * row[k];
            }
        }
    }
    let [u1, u2, u11, u22, u12] = u;
    let vector = |k: usize| take(simd, &geometry.vectors[k], lane);
    let (a1, a2, a3) = (vector(0), vector(1), vector(5));
    let (x11, x22, x12) = (vector(2), vector(3), vector(4));
    let j = load(simd, &geometry.stretch, lane);
    let to_local = take(simd, &geometry.to_local, lane);
    let half = R::of(0.5);
    let faint = R::FAINT;
    let strain = [
        dot::<S, R>(&a1, &u1) + dot::<S, R>(&u1, &u1) * half + faint,
        dot::<S, R>(&a2, &u2) + dot::<S, R>(&u2, &u2) * half + faint,
        (dot::<S, R>(&a1, &u2) + dot::<S, R>(&a2, &u1) + dot::<S, R>(&u1, &u2)) * half,
    ];
    // a₁ × a₂ = N + d with N = J A₃, and a₃ − A₃ without a difference of nearly equal numbers.
    let tilt = add::<S, R>(
        &add::<S, R>(&cross::<S, R>(&a1, &u2), &cross::<S, R>(&u1, &a2)),
        &cross::<S, R>(&u1, &u2),
    );
    let before = [a3[0] * j, a3[1] * j, a3[2] * j];
    let now = add::<S, R>(&before, &tilt);
    let length = dot::<S, R>(&now, &now).sqrt();
    let shrink = V::<S, R>::splat(simd, R::of(1.0)) / length;
    let longer = dot::<S, R>(&tilt, &add::<S, R>(&before, &now)) / (j + length);
    let normal = three(|c| now[c] * shrink);
    let turned = three(|c| (tilt[c] - a3[c] * longer) * shrink);
    let change = |u: &Vectors<S, R>, x: &Vectors<S, R>| {
        zero - (dot::<S, R>(u, &normal) + dot::<S, R>(x, &turned))
    };
    let curved = [change(&u11, &x11), change(&u22, &x22), change(&u12, &x12)];
    Present {
        tangents: [add::<S, R>(&a1, &u1), add::<S, R>(&a2, &u2)],
        curvatures: [add::<S, R>(&x11, &u11), add::<S, R>(&x22, &u22), add::<S, R>(&x12, &u12)],
        normal,
        shrink,
        to_local,
        membrane: localised::<S, R>(&to_local, &strain),
        bending: localised::<S, R>(&to_local, &curved),
    }
}

/// Adds to `forces` what the resultants of a point, n̂ and m̂ (11, 22, 12), do to control points:
/// f_a = −A_q [R,1 P¹ + R,2 P² − (m^αβ R,αβ) a₃].
#[inline(always)]
pub(super) fn scatter<S: Simd, R: Real, const N: usize>(
    simd: S,
    rows: &Rows<R, N>,
    present: &Present<S, R>,
    [n, m]: [&Vectors<S, R>; 2],
    area: V<S, R>,
    forces: &mut CellVectors<R, N>,
    lane: usize,
) {
    let (n, m) =
        (curvilinear::<S, R>(&present.to_local, n), curvilinear::<S, R>(&present.to_local, m));
    let (n, m) = (three(|c| n[c] * area), three(|c| m[c] * area));
    let twice = m[2] + m[2];
    let [x11, x22, x12] = &present.curvatures;
    let pull = three(|c| m[0] * x11[c] + m[1] * x22[c] + twice * x12[c]);
    let along = dot::<S, R>(&present.normal, &pull);
    let v = three(|c| (pull[c] - present.normal[c] * along) * present.shrink);
    let [a1, a2] = &present.tangents;
    let (first, second) = (cross::<S, R>(a2, &v), cross::<S, R>(&v, a1));
    let p1 = three(|c| first[c] - (n[0] * a1[c] + n[2] * a2[c]));
    let p2 = three(|c| second[c] - (n[1] * a2[c] + n[2] * a1[c]));
    for (k, node) in forces.iter_mut().enumerate() {
        let bend = m[0] * rows[2][k] + m[1] * rows[3][k] + twice * rows[4][k];
        for c in 0..3 {
            let force = p1[c] * rows[0][k] + p2[c] * rows[1][k] + present.normal[c] * bend;
            let sum = load(simd, &node[c], lane) + force;
            store(simd, sum, &mut node[c], lane);
        }
    }
}
