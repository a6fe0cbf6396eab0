//! Local damage: Rankine threshold, linear softening, a calibrated band, cracks across the
//! principal directions that are pulled.
//!
//! Strain is that of the solid between the cracks and, along each pulled principal direction, the
//! opening of cracks, c/(1 − c) σ/E: springs in a row. So the stress is the slope of a potential at
//! any damage and Poisson's ratio, a bar keeps (1 − c) E and what is broken bears no tension: no
//! cycle of strain gains or loses energy but by growing damage. Where several directions are
//! pulled their cracks open together, and damage grows as much faster that a point spends no more
//! than G_f/l (as far as it can without snapping back). Weakening the pulled part of the
//! undamaged stress, as is often done, has no potential where Poisson's ratio couples directions.

use crate::mpm::elastic::LameParameters;
use crate::mpm::symmetric::{Sym3, below, eigen};
use cullet_model::Material;

/// Width over which the grid smears a crack, in spacings, where the material breaks sharply: w_b/h,
/// Poisson-disk points, 8 a cell.
///
/// Spreading G_f over any other length dissipates the wrong energy (F03). With k = σ_f² h/(2EG_f),
/// how sharply a cell breaks, the width w = 2.39 k/(k + 0.0245), less along the grid, is the one
/// for which a crack that runs through the notched bar of
/// `services/fracture/tests/verification/bar.rs` (F-B) dissipates G_f per area in the mean over the
/// places and the turns of the grid. Softer cells (small k) part while many of their points are
/// only half broken. Measure again when the kernel, the sampling, the damage law or the parting of
/// nodes changes.
pub const BAND_WIDTH: f64 = 2.39;

/// The k at which the band is half as wide.
const HALF_WIDTH: f64 = 0.0245;

/// The k of the sharpest cell there is at a crack: σ_t = ½ √(EG_f/h). Sharper ones break ahead of
/// the crack, and where a crack costs so much goes by where the grid lies.
const SHARPEST: f64 = 0.125;

/// How much narrower the band is whose normal lies along an axis of the grid, and along the
/// diagonal of two \[1\]: an opening there slips between two planes of nodes, elsewhere it mixes
/// three.
const ALONG: [f64; 2] = [0.22, 0.13];

/// Share of the snap-back stress √(2EG_f/l) to which a strength is capped (F01). At 1 the softening
/// branch turns back; 0.927 keeps H ≤ 6.1, so full damage takes several steps.
pub const STRENGTH_CEILING: f64 = 0.927;

/// The greatest share H/(1 + H), that of the cap.
const SHARPEST_SHARE: f64 = STRENGTH_CEILING * STRENGTH_CEILING;

/// Most steps in which damage is found, and the error at which it is \[1\].
const GROWTH_STEPS: usize = 8;
const GROWTH_ERROR: f64 = 1e-12;

/// The softening law of one material on one grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softening {
    /// Threshold where a crack grows, σ_t = min(σ_f, ½ √(EG_f/h)) \[Pa\].
    pub strength: f64,
    /// Brittleness H = H̄l/(1 − H̄l) \[1\].
    pub brittleness: f64,
    /// Stress at which cracks grow over σ_f \[1\]; below 1 the body is toughness-controlled (F01).
    pub strength_ratio: f64,
    /// Planes across which the material is weaker, if there are any.
    pub weak_plane: Option<BodyWeakPlane>,
    /// How much narrower a band is that lies along the grid: [`ALONG`], or nothing where the width
    /// is none of the grid's \[1\].
    narrower: [f64; 2],
    young: f64,
    elastic: LameParameters,
}

/// Planes across which a material breaks sooner: cleavage, bedding, grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyWeakPlane {
    /// Unit normal in the frame before the hit.
    pub normal: [f64; 3],
    /// Strength across them over the strength in any other direction, in (0, 1].
    pub ratio: f64,
}

/// What the law makes of an effective stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Weakened stress \[Pa\].
    pub stress: Sym3,
    /// Damage after, never below damage before \[1\].
    pub damage: f64,
    /// Energy lost to new damage per volume \[J/m³\].
    pub dissipated: f64,
    /// Unit direction of the greatest principal stress where damage grew; else zero.
    pub normal: [f64; 3],
}

/// State of a point before the damage law is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DamageState {
    /// Damage so far \[1\].
    pub damage: f64,
    /// Local strength over the law's strength \[1\].
    pub strength: f64,
    /// Under the striker: no new damage while in compression (F11).
    pub shielded: bool,
    /// Strength over what it is where a crack grows, above 1 away from cracks: the greater, the
    /// more sharply it breaks \[1\].
    pub lone: f64,
}

impl Softening {
    /// The law of `material` on a grid of `spacing` \[m\].
    #[must_use]
    pub fn on_grid(material: &Material, spacing: f64) -> Self {
        let energy = material.young * material.fracture_energy;
        let strength = material.failure_stress.min((2.0 * SHARPEST * energy / spacing).sqrt());
        let k = strength * strength * spacing / (2.0 * energy);
        let length = BAND_WIDTH * k / (k + HALF_WIDTH) * spacing;
        Self { narrower: ALONG, ..Self::with_strength(material, length, strength) }
    }

    /// The law of `material` when a crack is spread over `length` \[m\].
    #[must_use]
    pub fn new(material: &Material, length: f64) -> Self {
        let snap_back = (2.0 * material.young * material.fracture_energy / length).sqrt();
        Self::with_strength(
            material,
            length,
            material.failure_stress.min(STRENGTH_CEILING * snap_back),
        )
    }

    fn with_strength(material: &Material, length: f64, strength: f64) -> Self {
        // H̄ l = σ_f² l / (2 E G_f),  H = H̄l/(1 − H̄l)  [Fan24 Eq. 2.28, F01]
        let energy = 2.0 * material.young * material.fracture_energy;
        let share = strength * strength * length / energy;
        Self {
            strength,
            brittleness: share / (1.0 - share),
            strength_ratio: strength / material.failure_stress,
            weak_plane: None,
            narrower: [0.0; 2],
            young: material.young,
            elastic: LameParameters::new(material),
        }
    }

    /// Width of a band across the unit vector `n` over that of one which lies along no axis of the
    /// grid \[1\].
    fn width(&self, n: &[f64; 3]) -> f64 {
        let parts = alignment(n).into_iter().zip(self.narrower);
        1.0 - parts.map(|(share, less)| less * share * share * share).sum::<f64>()
    }

    /// Strain at which a point in tension is broken through, σ_eff/E (1 + 1/H) \[1\].
    #[must_use]
    pub fn breaking_strain(&self) -> f64 {
        self.strength / self.young * (1.0 + 1.0 / self.brittleness)
    }

    /// Damage that a pull of `ratio` strengths asks for \[1\].
    #[must_use]
    pub fn damage(&self, ratio: f64) -> f64 {
        asked(self.brittleness, ratio).clamp(0.0, 1.0)
    }

    /// H where the energy that opening cracks release is `spread` times what one direction would
    /// at the strength of a crack's tip: each point spends G_f/l, however many directions are
    /// pulled and however strong it is, as far as it can without snapping back.
    fn brittleness_of(&self, spread: f64) -> f64 {
        let share = self.brittleness / (1.0 + self.brittleness);
        let share = (spread * share).min(SHARPEST_SHARE.max(share));
        share / (1.0 - share)
    }

    /// Share of a pull in [`LameParameters::pulls`] that damage takes: c/(1 + ν(1 − c)) \[1\].
    #[must_use]
    pub fn taken(&self, damage: f64) -> f64 {
        damage / (1.0 + self.elastic.poisson() * (1.0 - damage))
    }

    /// Stress between cracks that breaks further what is damaged, over the stress of the undamaged
    /// solid at the same strain: at most this \[1\].
    #[must_use]
    pub fn least_pull(&self, damage: f64) -> f64 {
        let poisson = self.elastic.poisson();
        if damage > 0.0 && poisson < 0.0 { 1.0 / (1.0 - 2.0 * poisson) } else { 1.0 }
    }

    /// The least strength of any direction over the strength \[1\].
    #[must_use]
    pub fn weakest(&self) -> f64 {
        self.weak_plane.map_or(1.0, |plane| plane.ratio)
    }

    /// Stress, in strengths, at which a point of that damage breaks further where one direction is
    /// pulled \[1\].
    #[must_use]
    pub fn threshold(&self, damage: f64) -> f64 {
        threshold(self.brittleness, damage)
    }

    /// The same where all are, of a point that is `lone` times as strong as at a crack.
    #[must_use]
    pub fn least_threshold(&self, damage: f64, lone: f64) -> f64 {
        threshold(self.brittleness_of(3.0 * lone * lone), damage)
    }

    /// Damages and weakens a point of Green's strain `strain` \[1\].
    #[must_use]
    #[inline]
    pub fn respond(&self, strain: &Sym3, state: DamageState) -> Response {
        let (sound, _) = self.elastic.stress(strain);
        let strength = self.strength * state.strength;
        if state.damage <= 0.0 && below(&sound, strength * self.weakest()) {
            return Response::held(&sound, state.damage);
        }
        self.respond_damaged(strain, &sound, state, strength)
    }

    fn respond_damaged(
        &self,
        strain: &Sym3,
        sound: &Sym3,
        state: DamageState,
        strength: f64,
    ) -> Response {
        let held = Response::held(sound, state.damage);
        let least = self.least_threshold(state.damage, state.lone) * strength;
        let trace = sound[0] + sound[1] + sound[2];
        let fixed = state.damage >= 1.0 || (state.shielded && trace < 0.0);
        let least = least * self.weakest() * self.least_pull(state.damage);
        let near = !fixed && !below(sound, least);
        if !near && (state.damage <= 0.0 || below(sound, 0.0)) {
            return held;
        }
        let (strains, axes) = eigen(strain);
        let cracked = |damage| Cracked::new(self, strains, axes, damage);
        let before = cracked(state.damage);
        let (first, normal) = before.pull(self);
        let sharper = state.lone * state.lone * self.width(&normal);
        let reached = threshold(before.brittleness(self, sharper), state.damage) * strength;
        let grows = near && first > reached;
        let after = match grows {
            true => cracked(grown(state.damage, |damage| {
                let cracked = cracked(damage);
                asked(cracked.brittleness(self, sharper), cracked.pull(self).0 / strength)
            })),
            false => before,
        };
        // ∫ Y dc along the softening branch, on which c follows from the pull κ, is Y₁ (c₁ − c₀)
        // κ₀/κ₁.
        let dissipated = match grows {
            true => {
                let last = after.pull(self).0.max(reached);
                after.release(self) * (after.damage - state.damage) * reached / last
            }
            false => 0.0,
        };
        let normal = if grows { normal } else { [0.0; 3] };
        Response { stress: after.stress(), damage: after.damage, dissipated, normal }
    }

    /// What a point of Green's strain `strain` and that damage holds \[J/m³\].
    #[must_use]
    pub fn energy(&self, strain: &Sym3, damage: f64) -> f64 {
        self.elastic.energy(eigen(strain).0, self.taken(damage))
    }
}

/// How far the unit vector `n` lies along one axis of the grid, and along the diagonal of two
/// \[1\]: eighth powers.
fn alignment(n: &[f64; 3]) -> [f64; 2] {
    let [x, y, z] = n.map(|c| c * c);
    let fourth = |a: f64| a * a * a * a;
    let pairs = (x * y) * (x * y) + (y * z) * (y * z) + (z * x) * (z * x);
    [fourth(x) + fourth(y) + fourth(z), 16.0 * pairs]
}

/// c = (1+H)(1 − σ_f/σ̄), which is damage for σ_f ≤ σ̄ ≤ σ_f(1+1/H)  [Fan24 Eq. 2.28] \[1\].
fn asked(brittleness: f64, ratio: f64) -> f64 {
    (1.0 + brittleness) * (1.0 - 1.0 / ratio.max(f64::MIN_POSITIVE))
}

/// Stress, in strengths, at which it asks for that damage \[1\].
fn threshold(brittleness: f64, damage: f64) -> f64 {
    1.0 / (1.0 - damage / (1.0 + brittleness))
}

/// Damage after a strain at which a point of damage c asks for `asked(c)`: where both are one.
/// Cracks that open relieve the pull; where one direction is pulled, the right side is linear in c,
/// and the first step finds it.
fn grown(damage: f64, asked: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut short) = (damage, asked(damage) - damage);
    let (mut high, mut over) = (1.0, 1.0 - asked(1.0));
    if over <= 0.0 {
        return 1.0;
    }
    let mut found = low;
    for _ in 0..GROWTH_STEPS {
        found = low + (high - low) * short / (short + over);
        let more = asked(found) - found;
        if more.abs() < GROWTH_ERROR {
            break;
        }
        if more > 0.0 {
            (low, short, over) = (found, more, 0.5 * over);
        } else {
            (high, over, short) = (found, -more, 0.5 * short);
        }
    }
    found.clamp(damage, 1.0)
}

/// A strain at some damage, in its principal directions.
#[derive(Clone, Copy)]
struct Cracked {
    axes: [[f64; 3]; 3],
    damage: f64,
    /// Stress \[Pa\].
    bears: [f64; 3],
    /// Stress over what damage leaves of it where cracks open \[Pa\].
    pulls: [f64; 3],
}

impl Cracked {
    fn new(law: &Softening, strains: [f64; 3], axes: [[f64; 3]; 3], damage: f64) -> Self {
        let (poisson, taken) = (law.elastic.poisson(), law.taken(damage));
        let pulls = law.elastic.pulls(strains, taken);
        let bears = pulls.map(|pull| if pull > 0.0 { (1.0 - taken) * pull } else { pull });
        // (1 − taken)/(1 − c)
        let ease = (1.0 + poisson) / (1.0 + poisson * (1.0 - damage));
        Self { axes, damage, bears, pulls: pulls.map(|pull| ease * pull) }
    }

    /// The greatest pull \[Pa\] over what its direction bears in strengths, and that direction: a
    /// principal one, or across weak planes where that is nearer to its strength.
    fn pull(&self, law: &Softening) -> (f64, [f64; 3]) {
        let pulls = &self.pulls;
        let first = (0..3).fold(0, |m, k| if pulls[k] > pulls[m] { k } else { m });
        let (most, axis) = (pulls[first], self.axes[first]);
        let Some(BodyWeakPlane { normal: n, ratio }) = law.weak_plane else {
            return (most, axis);
        };
        let onto = |a: &[f64; 3]| a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
        let across: f64 = pulls.iter().zip(&self.axes).map(|(s, a)| s * onto(a) * onto(a)).sum();
        if across > ratio * most { (across / ratio, n) } else { (most, axis) }
    }

    /// H for what pulls, Σ⟨pull⟩² over the greatest of them, of a point that breaks `sharper` times
    /// as sharply as the law's.
    fn brittleness(&self, law: &Softening, sharper: f64) -> f64 {
        let most = self.pulls.iter().fold(0.0_f64, |m, pull| m.max(*pull));
        let squares = self.pulls.iter().map(|pull| pull.max(0.0) * pull.max(0.0));
        let spread = if most > 0.0 { squares.sum::<f64>() / (most * most) } else { 1.0 };
        law.brittleness_of(spread * sharper)
    }

    /// −∂ψ/∂c = Σ⟨pull⟩²/2E \[J/m³\].
    fn release(&self, law: &Softening) -> f64 {
        let squares = self.pulls.iter().map(|pull| pull.max(0.0) * pull.max(0.0));
        0.5 * squares.sum::<f64>() / law.young
    }

    fn stress(&self) -> Sym3 {
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
        let all = self.bears.iter().zip(&self.axes);
        pairs.map(|(i, j)| all.clone().map(|(s, a)| s * a[i] * a[j]).sum())
    }
}

impl Response {
    /// Nothing changes.
    #[inline]
    fn held(stress: &Sym3, damage: f64) -> Self {
        Self { stress: *stress, damage, dissipated: 0.0, normal: [0.0; 3] }
    }
}

#[cfg(test)]
mod tests;
