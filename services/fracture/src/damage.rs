//! Local damage: Rankine threshold, linear softening, tension-only weakening, a calibrated band.

use crate::material::Material;
use crate::mpm::symmetric::{Sym3, below, eigen};

/// Width over which the grid smears a crack, in spacings, where the material breaks sharply: w_b/h,
/// Poisson-disk points, 8 a cell.
///
/// Spreading G_f over any other length dissipates the wrong energy (F03). With k = σ_f² h/(2EG_f),
/// how sharply a cell breaks, the width w = 2.3 k/(k + 0.0245) is the one for which a crack that
/// runs through the notched bar of `services/fracture/tests/bar.rs` (F-B) dissipates G_f per area
/// in the mean over seeds, at k = 0.05, 0.09, 0.19, 0.38 and where strength is capped. Softer cells
/// (small k) part while many of their points are only half broken. Measure again when the kernel,
/// the sampling, the damage law or the parting of nodes changes.
pub const BAND_WIDTH: f64 = 2.3;

/// The k at which the band is half as wide.
const HALF_WIDTH: f64 = 0.0245;

/// The k of the sharpest cell there is: where strength is capped.
const SHARPEST: f64 = 0.37;

/// Share of the snap-back stress √(2EG_f/l) to which the strength is capped (F01).
///
/// At 1 the softening branch turns back; 0.9 keeps H ≤ 4.3, so full damage takes several steps.
pub const STRENGTH_CEILING: f64 = 0.9;

/// The softening law of one material on one grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softening {
    /// Threshold where a crack grows, σ_eff = min(σ_f, 0.9 √(2EG_f/l)) \[Pa\].
    pub strength: f64,
    /// Brittleness H = H̄l/(1 − H̄l) \[1\].
    pub brittleness: f64,
    /// Stress at which cracks grow over σ_f \[1\]; below 1 the body is toughness-controlled (F01).
    pub strength_ratio: f64,
    /// Planes across which the material is weaker, if there are any.
    pub weak_plane: Option<WeakPlane>,
    young: f64,
    poisson: f64,
}

/// Planes across which a material breaks sooner: cleavage, bedding, grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakPlane {
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

/// State of a point before the law is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Damage so far \[1\].
    pub damage: f64,
    /// Local strength over the law's strength \[1\].
    pub strength: f64,
    /// Under the striker: no new damage while in compression (F11).
    pub shielded: bool,
    /// Stronger than the cap, so that it breaks at once: past its strength there is no softening.
    pub sudden: bool,
}

impl Softening {
    /// The law of `material` on a grid of `spacing` \[m\].
    #[must_use]
    pub fn on_grid(material: &Material, spacing: f64) -> Self {
        let stress = material.failure_stress;
        let k = stress * stress * spacing / (2.0 * material.young * material.fracture_energy);
        let k = k.min(SHARPEST);
        Self::new(material, BAND_WIDTH * k / (k + HALF_WIDTH) * spacing)
    }

    /// The law of `material` when a crack is spread over `length` \[m\].
    #[must_use]
    pub fn new(material: &Material, length: f64) -> Self {
        let snap_back = (2.0 * material.young * material.fracture_energy / length).sqrt();
        let strength = material.failure_stress.min(STRENGTH_CEILING * snap_back);
        // H̄ l = σ_f² l / (2 E G_f),  H = H̄l/(1 − H̄l)  [Fan24 Eq. 2.28, F01]
        let share = strength * strength / (snap_back * snap_back);
        Self {
            strength,
            brittleness: share / (1.0 - share),
            strength_ratio: strength / material.failure_stress,
            weak_plane: None,
            young: material.young,
            poisson: material.poisson,
        }
    }

    /// Strain at which a point in tension is broken through, σ_eff/E (1 + 1/H) \[1\].
    #[must_use]
    pub fn breaking_strain(&self) -> f64 {
        self.strength / self.young * (1.0 + 1.0 / self.brittleness)
    }

    /// Damage that a greatest principal stress of `ratio` strengths asks for \[1\].
    #[must_use]
    pub fn damage(&self, ratio: f64) -> f64 {
        if ratio <= 1.0 {
            return 0.0;
        }
        // c = (1+H)(1 − σ_f/σ̄)  for  σ_f ≤ σ̄ ≤ σ_f(1+1/H), 1 beyond  [Fan24 Eq. 2.28]
        ((1.0 + self.brittleness) * (1.0 - 1.0 / ratio)).min(1.0)
    }

    /// The least strength of any direction over the strength \[1\].
    #[must_use]
    pub fn weakest(&self) -> f64 {
        self.weak_plane.map_or(1.0, |plane| plane.ratio)
    }

    /// The greatest pull \[Pa\] over what its direction bears in strengths, and that direction:
    /// the greatest principal stress, or the pull across weak planes where that is nearer to its
    /// strength.
    fn pull(&self, s: &Sym3, value: f64, vector: [f64; 3]) -> (f64, [f64; 3]) {
        let Some(WeakPlane { normal: n, ratio }) = self.weak_plane else {
            return (value, vector);
        };
        let across = n[0] * (s[0] * n[0] + 2.0 * s[3] * n[1])
            + n[1] * (s[1] * n[1] + 2.0 * s[4] * n[2])
            + n[2] * (s[2] * n[2] + 2.0 * s[5] * n[0]);
        if across > ratio * value { (across / ratio, n) } else { (value, vector) }
    }

    /// Stress, in strengths, at which a point of that damage breaks further \[1\].
    #[must_use]
    pub fn threshold(&self, damage: f64) -> f64 {
        1.0 / (1.0 - damage / (1.0 + self.brittleness))
    }

    /// Damages and weakens. `effective` is the stress of the undamaged solid \[Pa\].
    #[must_use]
    #[inline]
    pub fn respond(&self, effective: &Sym3, state: State) -> Response {
        let strength = self.strength * state.strength;
        if state.damage <= 0.0 && below(effective, strength * self.weakest()) {
            return Response::held(effective, state.damage);
        }
        self.respond_damaged(effective, state, strength)
    }

    fn respond_damaged(&self, effective: &Sym3, state: State, strength: f64) -> Response {
        let held = Response::held(effective, state.damage);
        let reached = self.threshold(state.damage);
        let trace = effective[0] + effective[1] + effective[2];
        let fixed = state.damage >= 1.0 || (state.shielded && trace < 0.0);
        let near = !fixed && !below(effective, strength * reached * self.weakest());
        if !near && (state.damage <= 0.0 || below(effective, 0.0)) {
            return held;
        }
        if !near && below(&effective.map(|s| -s), 0.0) {
            return Response { stress: effective.map(|s| s * (1.0 - state.damage)), ..held };
        }
        let (values, vectors) = eigen(effective);
        let first = (0..3).fold(0, |m, k| if values[k] > values[m] { k } else { m });
        let (largest, normal) = self.pull(effective, values[first], vectors[first]);
        let grows = near && largest > strength * reached;
        let asked = match (grows, state.sudden) {
            (true, true) => 1.0,
            (true, false) => self.damage(largest / strength),
            (false, _) => 0.0,
        };
        let damage = asked.max(state.damage);
        let mut stress = *effective;
        let mut energy = 0.0;
        for (value, n) in values.iter().zip(&vectors) {
            let pulled = value.max(0.0);
            // ε_i = ((1+ν)σ_i − ν tr σ)/E
            energy +=
                0.5 * pulled * ((1.0 + self.poisson) * value - self.poisson * trace) / self.young;
            let cut = damage * pulled;
            stress[0] -= cut * n[0] * n[0];
            stress[1] -= cut * n[1] * n[1];
            stress[2] -= cut * n[2] * n[2];
            stress[3] -= cut * n[0] * n[1];
            stress[4] -= cut * n[1] * n[2];
            stress[5] -= cut * n[2] * n[0];
        }
        // ∫ ½σ̄²/E dc from threshold κ₀ to κ₁ is ½σ̄₁²/E (c₁−c₀) κ₀/κ₁ in uniaxial tension.
        let mean = if grows { reached * strength / largest } else { 0.0 };
        let dissipated = energy.max(0.0) * (damage - state.damage) * mean;
        let normal = if grows { normal } else { [0.0; 3] };
        Response { stress, damage, dissipated, normal }
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
mod tests {
    use super::{Response, Softening, State, WeakPlane};
    use crate::material::Material;

    const STONE: Material = Material {
        density: 2450.0,
        young: 32e9,
        poisson: 0.2,
        failure_stress: 3e6,
        fracture_energy: 3.0,
    };

    fn pull(law: &Softening, stress: f64, damage: f64) -> Response {
        let state = State { damage, strength: 1.0, shielded: false, sudden: false };
        law.respond(&[stress, 0.0, 0.0, 0.0, 0.0, 0.0], state)
    }

    /// F-U: the area under σ–ε is G_f/l.
    #[test]
    fn the_point_law_spends_the_fracture_energy() {
        let length = 0.008;
        let law = Softening::new(&STONE, length);
        let last = law.strength * (1.0 + 1.0 / law.brittleness);
        assert_eq!(law.strength, 3e6);
        assert!((last / law.strength - law.threshold(1.0)).abs() < 1e-12);
        let (mut damage, mut area, mut dissipated) = (0.0, 0.0, 0.0);
        let (mut strain, mut before) = (0.0, 0.0);
        // σ(ε) is piecewise linear, so a trapezium over steps that include both kinks is exact.
        let mut ramp: Vec<f64> = (0..=400).map(|i| last * f64::from(i) / 400.0).collect();
        ramp.push(law.strength);
        ramp.sort_by(f64::total_cmp);
        for effective in ramp {
            let response = pull(&law, effective, damage);
            let stress = response.stress[0];
            if effective <= law.strength {
                assert_eq!(response.damage, 0.0);
            }
            area += 0.5 * (stress + before) * (effective / STONE.young - strain);
            dissipated += response.dissipated;
            (strain, before, damage) = (effective / STONE.young, stress, response.damage);
        }
        let wanted = STONE.fracture_energy / length;
        assert!((damage - 1.0).abs() < 1e-12, "damage {damage}");
        assert!((area / wanted - 1.0).abs() < 1e-10, "area {area} of {wanted}");
        assert!((dissipated / wanted - 1.0).abs() < 1e-10, "dissipated {dissipated} of {wanted}");
    }

    /// A pull across weak planes breaks them first; along them the strength is the material's.
    #[test]
    fn weak_planes_break_first() {
        let plane = WeakPlane { normal: [0.6, 0.8, 0.0], ratio: 0.5 };
        let law = Softening { weak_plane: Some(plane), ..Softening::new(&STONE, 0.008) };
        let state = State { damage: 0.0, strength: 1.0, shielded: false, sudden: false };
        let pull = |n: [f64; 3], size: f64| {
            let s = size * law.strength;
            let stress = [n[0] * n[0], n[1] * n[1], n[2] * n[2], n[0] * n[1], n[1] * n[2], 0.0];
            law.respond(&stress.map(|x| s * x), state)
        };
        assert_eq!(pull(plane.normal, 0.49).damage, 0.0);
        let across = pull(plane.normal, 0.51);
        assert!(across.damage > 0.0);
        assert_eq!(across.normal, plane.normal);
        assert_eq!(pull([0.8, -0.6, 0.0], 0.99).damage, 0.0);
        assert!(pull([0.8, -0.6, 0.0], 1.01).damage > 0.0);
        // At 60 degrees the weak planes feel a quarter of the pull, and their strength is half.
        assert_eq!(pull([0.0, 0.0, 1.0], 0.99).damage, 0.0);
    }

    /// Pure shear: only the pulled principal direction weakens.
    #[test]
    fn weakening_is_one_sided_in_shear() {
        let law = Softening::new(&STONE, 0.008);
        let s = 10.0 * law.strength;
        let state = State { damage: 0.0, strength: 1.0, shielded: false, sudden: false };
        let response = law.respond(&[0.0, 0.0, 0.0, s, 0.0, 0.0], state);
        assert_eq!(response.damage, 1.0);
        // −s n⊗n with n = (1,−1,0)/√2
        let wanted = [-0.5 * s, -0.5 * s, 0.0, 0.5 * s, 0.0, 0.0];
        for (a, b) in response.stress.iter().zip(&wanted) {
            assert!((a - b).abs() < 1e-9 * s, "{:?}", response.stress);
        }
    }
}
