//! What strain makes of a point: stress of many at once, damage of the few that have any.

use super::tension::adjugate;
use crate::damage::{DamageState, Softening};
use crate::mpm::elastic::{CRUSHED, LameParameters};
use crate::mpm::flow::FlowLaw;
use crate::mpm::symmetric::Sym3;
use crate::mpm::tally::DomainTally;
use crate::particles::ParticlesMut;
use cullet_geometry::Vec3;
use cullet_simd::{Real, V};
use fearless_simd::{Select, Simd, SimdBase};
use std::ops::{Add, Mul};

/// Stress, in Pa, above any that is looked at without the law: three of them multiply to a number
/// that f32 still has.
pub(super) const WATCH: f64 = 1e12;

/// Greatest eigenvalue of C⁻¹ beyond which what may tear has torn: a sixth as thick as it was, and
/// few of its neighbours are still beside it \[1\].
const SHREDDED: f64 = 36.0;

/// What a kind of material does.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MaterialLaw {
    pub(crate) elastic: LameParameters,
    pub(crate) softening: Softening,
    /// Where it flows, in place of the softening.
    pub(crate) flow: Option<FlowLaw>,
}

/// What a point needs to know.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointLaw<'a> {
    /// At least one.
    pub(crate) kinds: &'a [MaterialLaw],
    /// Spacing of the grid \[m\].
    pub(crate) spacing: Vec3,
    /// At the end of the step \[s\].
    pub(crate) time: f64,
    /// The step \[s\].
    pub(crate) step: f64,
}

/// μ, λ/2 and μ + λ/2 in the precision of the pass.
pub(super) fn stiffness<R: Real>(elastic: &LameParameters) -> [R; 3] {
    let half = 0.5 * elastic.lame;
    [elastic.shear, half, elastic.shear + half].map(R::of)
}

/// Dot product of two columns.
#[inline(always)]
fn dot<T: Copy + Mul<Output = T> + Add<Output = T>>(h: &[[T; 3]; 3], i: usize, j: usize) -> T {
    h[0][i] * h[0][j] + h[1][i] * h[1][j] + h[2][i] * h[2][j]
}

/// E = (H + Hᵀ + HᵀH)/2 \[1\].
#[inline(always)]
fn green_strain<S: Simd, R: Real>(h: &[[V<S, R>; 3]; 3]) -> [V<S, R>; 6] {
    let half = R::of(0.5);
    [
        h[0][0] + dot(h, 0, 0) * half + R::FAINT,
        h[1][1] + dot(h, 1, 1) * half + R::FAINT,
        h[2][2] + dot(h, 2, 2) * half + R::FAINT,
        (h[0][1] + h[1][0] + dot(h, 0, 1)) * half + R::FAINT,
        (h[1][2] + h[2][1] + dot(h, 1, 2)) * half + R::FAINT,
        (h[2][0] + h[0][2] + dot(h, 2, 0)) * half + R::FAINT,
    ]
}

/// What the undamaged solid would bear.
pub(super) struct Effective<V> {
    /// Green's strain \[1\].
    pub(super) strain: [V; 6],
    /// Second Piola–Kirchhoff stress \[Pa\].
    pub(super) stress: [V; 6],
    /// J² = det C \[1\].
    pub(super) square: V,
}

/// As [`LameParameters::second_piola`].
#[inline(always)]
pub(super) fn second_piola<S: Simd, R: Real>(
    simd: S,
    h: &[[V<S, R>; 3]; 3],
    [shear, half_lame, sum]: &[V<S, R>; 3],
) -> Effective<V<S, R>> {
    let (two, four, eight) = (R::of(2.0), R::of(4.0), R::of(8.0));
    let one = V::<S, R>::splat(simd, R::of(1.0));
    let e = green_strain::<S, R>(h);
    let adjoint = adjugate::<S, R>(&e);
    let trace = e[0] + e[1] + e[2];
    let minors = adjoint[0] + adjoint[1] + adjoint[2];
    let det = e[0] * adjoint[0] + e[3] * adjoint[3] + e[5] * adjoint[5];
    let d = trace * two + minors * four + det * eight;
    let floor = V::<S, R>::splat(simd, R::of(CRUSHED * CRUSHED));
    let square = one + d;
    let share = one / square.simd_gt(floor).select(square, floor);
    // S = ((μ + λ/2) d I + (λ/2 d − μ) M)/J² with M = adj C − I
    let whole = d * *sum * share;
    let rest = (d * *half_lame - *shear) * share;
    let stress = [
        whole + rest * ((trace - e[0]) * two + adjoint[0] * four),
        whole + rest * ((trace - e[1]) * two + adjoint[1] * four),
        whole + rest * ((trace - e[2]) * two + adjoint[2] * four),
        rest * (adjoint[3] * four - e[3] * two),
        rest * (adjoint[4] * four - e[4] * two),
        rest * (adjoint[5] * four - e[5] * two),
    ];
    Effective { strain: e, stress, square }
}

/// Which points change nothing: no principal stress reaches `limit`, where damage grows, and the
/// point is not crushed.
#[inline(always)]
pub(super) fn idle<S: Simd, R: Real>(
    simd: S,
    effective: &Effective<V<S, R>>,
    limit: V<S, R>,
) -> <V<S, R> as SimdBase<S>>::Mask {
    let zero = V::<S, R>::splat(simd, R::of(0.0));
    let s = &effective.stress;
    let (a, b, c) = (limit - s[0], limit - s[1], limit - s[2]);
    let (d, e, f) = (s[3], s[4], s[5]);
    let minor = a * b - d * d;
    let det = c * minor - d * e * f * R::of(2.0) - a * e * e - b * f * f;
    let floor = V::<S, R>::splat(simd, R::of(CRUSHED * CRUSHED));
    a.simd_gt(zero) & minor.simd_gt(zero) & det.simd_gt(zero) & effective.square.simd_gt(floor)
}

/// Adds μ(C_p⁻¹ − I) to the stress; σ_eq² of Kirchhoff's stress \[Pa²\].
#[inline(always)]
pub(super) fn flowing<S: Simd, R: Real>(
    effective: &mut Effective<V<S, R>>,
    flowed: Option<&[V<S, R>; 6]>,
    shear: V<S, R>,
) -> V<S, R> {
    const AT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    let two = R::of(2.0);
    let e = &effective.strain;
    // C C_p⁻¹ − I = 2E + M + 2EM with M = C_p⁻¹ − I
    let mut d = AT.map(|row| row.map(|k| e[k] * two));
    if let Some(m) = flowed {
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let product =
                e[AT[i][0]] * m[AT[0][j]] + (e[AT[i][1]] * m[AT[1][j]] + e[AT[i][2]] * m[AT[2][j]]);
            d[i][j] = d[i][j] + m[AT[i][j]] + product * two;
        }
        for (stress, &m) in effective.stress.iter_mut().zip(m) {
            *stress += m * shear;
        }
    }
    let (third, half) = (R::of(1.0 / 3.0), R::of(1.5));
    let mean = (d[0][0] + d[1][1] + d[2][2]) * third;
    let [x, y, z] = [d[0][0] - mean, d[1][1] - mean, d[2][2] - mean];
    let off = d[0][1] * d[1][0] + (d[1][2] * d[2][1] + d[2][0] * d[0][2]);
    let square = x * x + (y * y + z * z) + off * two;
    square * (shear * shear) * half
}

/// Which points flow no further: σ_eq² is below that of `limit`, and the point is not crushed.
#[inline(always)]
pub(super) fn rests<S: Simd, R: Real>(
    simd: S,
    effective: &Effective<V<S, R>>,
    equivalent: V<S, R>,
    limit: V<S, R>,
) -> <V<S, R> as SimdBase<S>>::Mask {
    let floor = V::<S, R>::splat(simd, R::of(CRUSHED * CRUSHED));
    equivalent.simd_lt(limit * limit) & effective.square.simd_gt(floor)
}

impl PointLaw<'_> {
    /// Whether points flow: all kinds do, or none.
    pub(super) fn flows(&self) -> bool {
        self.kinds[0].flow.is_some()
    }

    fn softening(&self, view: &ParticlesMut<'_>, p: usize) -> &Softening {
        &self.kinds[view.kind[p] as usize].softening
    }

    /// Strength of a point now over the law's \[1\], and over what it is at cracks.
    fn strength(&self, view: &ParticlesMut<'_>, p: usize, time: f64) -> (f64, f64) {
        let lone = 1.0 / self.softening(view, p).strength_ratio;
        let lone = if time < view.front_time[p] { lone } else { 1.0 };
        (view.strength[p] * lone, lone)
    }

    /// Share of a pull that damage takes \[1\].
    pub(super) fn taken(&self, view: &ParticlesMut<'_>, p: usize) -> f64 {
        self.softening(view, p).taken(view.damage[p])
    }

    /// Principal stress \[Pa\] below which damage does not grow, until a crack comes near.
    pub(super) fn limit(&self, view: &ParticlesMut<'_>, p: usize) -> f64 {
        if let Some(flow) = &self.kinds[view.kind[p] as usize].flow {
            // What tears is looked at in every step until it has torn.
            let whole = view.damage[p] <= 0.0;
            if view.eroded[p] {
                return WATCH;
            }
            return if whole { flow.rule.slow_stress(&view.flow[p].history) } else { 0.0 };
        }
        if view.damage[p] >= 1.0 {
            return WATCH;
        }
        let time = if view.front_time[p] < f64::INFINITY { f64::INFINITY } else { self.time };
        let softening = self.softening(view, p);
        let damage = view.damage[p];
        let (strength, lone) = self.strength(view, p, time);
        let reached = softening.least_threshold(damage, lone) * softening.weakest();
        let reached = reached * softening.least_pull(damage);
        (softening.strength * strength * reached).min(WATCH)
    }

    /// Lets a point of Green's strain `strain` \[1\] flow and tear, and returns what it bears
    /// \[Pa\].
    pub(super) fn flow(
        &self,
        view: &mut ParticlesMut<'_>,
        p: usize,
        strain: &Sym3,
        tally: &mut DomainTally,
    ) -> Option<Sym3> {
        let law = self.kinds[view.kind[p] as usize].flow.as_ref()?;
        if view.eroded[p] {
            return Some([0.0; 6]);
        }
        let mut found = law.respond(strain, view.flow[p], self.step);
        if law.rule.failure.is_some() && found.thinnest > SHREDDED {
            // The grid follows it no further.
            found.damage = 1.0;
            found.thinnest = 1.0;
            tally.shredded += 1;
        }
        view.flow[p] = found.state;
        tally.thinnest = tally.thinnest.max(found.thinnest);
        tally.plastic += found.work * view.volume[p];
        tally.dissipated += found.torn * view.volume[p];
        if found.damage > view.damage[p] {
            tally.grown += 1;
            view.damage[p] = found.damage;
            view.normal[p] = Vec3::from(found.normal);
            if found.damage >= 1.0 {
                // What has torn lies in the tear: it holds nothing apart any more.
                tally.dissipated += law.energy(strain, &found.state) * view.volume[p];
                view.eroded[p] = true;
                view.damage_time[p] = self.time;
                tally.broken += 1;
                return Some([0.0; 6]);
            }
        }
        Some(found.stress)
    }

    /// Energy of a point of Green's strain `strain` \[J\].
    pub(super) fn held(&self, view: &ParticlesMut<'_>, p: usize, strain: &Sym3) -> f64 {
        if let Some(flow) = &self.kinds[view.kind[p] as usize].flow {
            return flow.energy(strain, &view.flow[p]) * view.volume[p];
        }
        self.softening(view, p).energy(strain, view.damage[p]) * view.volume[p]
    }

    /// Damages a point of Green's strain `strain` \[1\] and returns what it bears \[Pa\]; `rate` is
    /// asked for the strain rate \[1/s\] where damage begins.
    pub(super) fn weaken(
        &self,
        view: &mut ParticlesMut<'_>,
        p: usize,
        strain: &Sym3,
        tally: &mut DomainTally,
        rate: impl FnOnce() -> f64,
    ) -> Sym3 {
        let (strength, lone) = self.strength(view, p, self.time);
        let state =
            DamageState { damage: view.damage[p], strength, shielded: view.shielded[p], lone };
        let response = self.softening(view, p).respond(strain, state);
        if response.damage > state.damage {
            tally.grown += 1;
            tally.dissipated += response.dissipated * view.volume[p];
            view.damage[p] = response.damage;
            view.normal[p] = Vec3::from(response.normal);
            if state.damage <= 0.0 {
                view.onset_rate[p] = rate();
            }
            if response.damage >= 1.0 {
                view.damage_time[p] = self.time;
                tally.broken += 1;
            }
        }
        response.stress
    }
}
