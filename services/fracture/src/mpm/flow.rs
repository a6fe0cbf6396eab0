//! Flow at a point: J2 plasticity at any strain, for the compressible neo-Hookean solid.
//!
//! With C_p the part of C that has flowed,
//! Ψ = μ/2 (tr CC_p⁻¹ − 3) − μ ln J + λ/4 (J² − 1 − 2 ln J), so that
//! S = μ(C_p⁻¹ − C⁻¹) + λ/2 (J² − 1) C⁻¹: what is elastic adds μ(C_p⁻¹ − I).
//!
//! Kirchhoff's stress has the deviator μ dev b with b = F C_p⁻¹ Fᵀ; it returns along itself
//! \[Simo 1988\], and the trace of b is that which keeps det b, so that flow keeps the volume. In
//! the frame before the hit that is C_p⁻¹ ← r C_p⁻¹ + (t − r t₀) C⁻¹: no F, and no eigenvectors.

use super::elastic::{CRUSHED, LameParameters, adjugate, matrix};
use crate::mpm::symmetric::{Sym3, eigen};
use cullet_geometry::Mat3;
use cullet_model::{FlowHistory, JohnsonCook};

/// Newton's steps to the trace of b, of a cubic that is nearly a straight line there.
const ROUNDS: usize = 20;
const ENOUGH: f64 = 1e-15;

/// How a point of a material flows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowLaw {
    /// Its elasticity.
    pub elastic: LameParameters,
    /// Its flow stress, and how it tears.
    pub rule: JohnsonCook,
    /// Mass density ρ \[kg/m³\].
    pub density: f64,
    /// Plastic strain over which a point that has torn loses its strength: 2G_f/(σ_y h) \[1\].
    pub tearing_strain: f64,
}

/// What flow has left at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowState {
    /// C_p⁻¹ − I \[1\].
    pub flowed: Sym3,
    /// Strain and warming.
    pub history: FlowHistory,
    /// D = Σ Δε/ε_f; it tears from 1 on \[1\].
    pub spent: f64,
    /// Plastic strain since it began to tear \[1\].
    pub torn: f64,
}

/// What a step made of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowResponse {
    /// Second Piola–Kirchhoff stress \[Pa\].
    pub stress: Sym3,
    /// State after it.
    pub state: FlowState,
    /// Plastic work \[J/m³\].
    pub work: f64,
    /// Energy that tearing took beside that \[J/m³\].
    pub torn: f64,
    /// Share of its strength that it has lost \[1\].
    pub damage: f64,
    /// No less than the greatest eigenvalue of C⁻¹ \[1\].
    pub thinnest: f64,
    /// Unit direction of its greatest stress; zero where it did not tear.
    pub normal: [f64; 3],
}

/// A strain after what has flowed: invariants of b, and C⁻¹.
struct Trial {
    /// J².
    square: f64,
    /// C⁻¹.
    inverse: Mat3,
    /// tr b/3.
    mean: f64,
    /// ½ s:s and det s of s = dev b.
    invariants: (f64, f64),
}

impl Trial {
    fn new(strain: &Sym3, flowed: &Sym3) -> Self {
        let (e, m) = (matrix(strain), matrix(flowed));
        // C C_p⁻¹ − I, similar to b − I: no cancellation where nothing flowed.
        let d = e * 2.0 + m + e * m * 2.0;
        let rise = d.trace() / 3.0;
        let s = d - Mat3::identity() * rise;
        let c: Sym3 = std::array::from_fn(|k| 2.0 * strain[k] + if k < 3 { 1.0 } else { 0.0 });
        let minors = adjugate(&c);
        let square = c[0] * minors[0] + c[3] * minors[3] + c[5] * minors[5];
        Self {
            square,
            inverse: matrix(&minors) / square.max(CRUSHED * CRUSHED),
            mean: 1.0 + rise,
            invariants: (0.5 * (s * s).trace(), s.determinant()),
        }
    }

    /// A bound on the greatest eigenvalue of C⁻¹, met where two are equal \[1\].
    fn thinnest(&self) -> f64 {
        let mean = self.inverse.trace() / 3.0;
        let square = (self.inverse * self.inverse).trace() / 3.0 - mean * mean;
        mean + (2.0 * square.max(0.0)).sqrt()
    }

    /// tr s³/tr s² \[1\].
    fn skew(&self) -> f64 {
        let (j2, j3) = self.invariants;
        if j2 > 0.0 { 1.5 * j3 / j2 } else { 0.0 }
    }

    /// tr b/3 where dev b is `left` of what it was, and det b is the same.
    fn mean_after(&self, left: f64) -> f64 {
        let ((j2, j3), t) = (self.invariants, self.mean);
        let det = t * t * t - t * j2 + j3;
        let (j2, j3) = (left * left * j2, left * left * left * j3);
        let mut t = t;
        for _ in 0..ROUNDS {
            let step = (t * t * t - t * j2 + j3 - det) / (3.0 * t * t - j2);
            t -= step;
            if step.abs() <= ENOUGH {
                break;
            }
        }
        t
    }
}

impl FlowLaw {
    /// What a point bears and how it flows at Green's strain `strain`, at the end of a step of
    /// `time` \[s\].
    #[must_use]
    pub fn respond(&self, strain: &Sym3, mut state: FlowState, time: f64) -> FlowResponse {
        let LameParameters { lame, shear } = self.elastic;
        let trial = Trial::new(strain, &state.flowed);
        let size = shear * (3.0 * trial.invariants.0.max(0.0)).sqrt();
        // dev b gives way to flow by 2 (n² : b)/(n : n), n = dev b: halfway, at the second look.
        let mut stiffness = 3.0 * shear * trial.mean;
        let mut more = self.rule.flow(size, stiffness, &state.history, time);
        if more > 0.0 {
            let half = 1.0 - 0.5 * (stiffness * more / size).min(1.0);
            stiffness = 3.0 * shear * (trial.mean + trial.skew() * half);
            more = self.rule.flow(size, stiffness, &state.history, time);
        }
        let (mut mean, mut work) = (trial.mean, 0.0);
        let mut normal = [0.0; 3];
        let mut flowed = matrix(&state.flowed);
        let mut bears = size;
        if more > 0.0 {
            bears = size - stiffness * more;
            let left = bears / size;
            mean = trial.mean_after(left);
            let share = mean - left * trial.mean;
            // r C_p⁻¹ + (t − r t₀) C⁻¹ − I
            flowed = flowed * left + trial.inverse * share - Mat3::identity() * (1.0 - left);
            // What the step's motion paid: it strained at the stress after flow.
            work = bears * more;
            state.history.strain += more;
            state.history.warming += self.rule.warming(work, self.density);
            state.flowed = components(&flowed);
        }
        let rest = 0.5 * lame * (trial.square - 1.0);
        let whole = (flowed + Mat3::identity()) * shear + trial.inverse * (rest - shear);
        let mut stress = components(&whole);
        let pressure = rest + shear * (mean - 1.0);
        let before = self.damage(&state);
        if more > 0.0 && self.rule.failure.is_some() {
            let triaxiality = if bears > 0.0 { pressure / bears } else { 0.0 };
            let rate = more / time;
            state.spent += self.rule.spent(more, rate, triaxiality, state.history.warming);
            if state.spent >= 1.0 {
                state.torn += more;
                normal = greatest(&stress);
            }
        }
        let damage = self.damage(&state);
        work *= 1.0 - before;
        let held = self.energy_between(&trial, mean, pressure);
        if damage > 0.0 {
            // What is torn bears pressure still.
            let kept = damage * pressure.min(0.0);
            let inverse = components(&trial.inverse);
            stress = std::array::from_fn(|k| (1.0 - damage) * stress[k] + kept * inverse[k]);
        }
        let torn = (damage - before) * held;
        FlowResponse { stress, state, work, torn, damage, thinnest: trial.thinnest(), normal }
    }

    /// Share of its strength that a point has lost \[1\].
    #[must_use]
    pub fn damage(&self, state: &FlowState) -> f64 {
        if state.torn > 0.0 { (state.torn / self.tearing_strain).min(1.0) } else { 0.0 }
    }

    /// What a whole point would hold that damage takes a share of: all but what pressure does.
    fn energy_between(&self, trial: &Trial, mean: f64, pressure: f64) -> f64 {
        let all = self.stored(trial.square, mean);
        if pressure >= 0.0 { all } else { all - self.stored(trial.square, root(trial.square)) }
    }

    /// Ψ of J² and tr b/3 \[J/m³\].
    fn stored(&self, square: f64, mean: f64) -> f64 {
        let LameParameters { lame, shear } = self.elastic;
        let log = 0.5 * libm::log(square.max(CRUSHED * CRUSHED));
        1.5 * shear * (mean - 1.0) - shear * log + 0.25 * lame * (square - 1.0 - 2.0 * log)
    }

    /// What a point holds at Green's strain `strain` \[J/m³\].
    #[must_use]
    pub fn energy(&self, strain: &Sym3, state: &FlowState) -> f64 {
        let trial = Trial::new(strain, &state.flowed);
        let pressure = 0.5 * self.elastic.lame * (trial.square - 1.0)
            + self.elastic.shear * (trial.mean - 1.0);
        let taken = self.damage(state) * self.energy_between(&trial, trial.mean, pressure);
        self.stored(trial.square, trial.mean) - taken
    }
}

/// t of b = t I with det b = J²: its cube root.
fn root(square: f64) -> f64 {
    libm::cbrt(square.max(0.0))
}

fn components(m: &Mat3) -> Sym3 {
    let mean = |i: usize, j: usize| 0.5 * (m[(i, j)] + m[(j, i)]);
    [m[(0, 0)], m[(1, 1)], m[(2, 2)], mean(0, 1), mean(1, 2), mean(2, 0)]
}

/// The eigenvector of the greatest eigenvalue.
fn greatest(s: &Sym3) -> [f64; 3] {
    let (values, axes) = eigen(s);
    axes[(0..3).fold(0, |m, k| if values[k] > values[m] { k } else { m })]
}

#[cfg(test)]
mod tests;
