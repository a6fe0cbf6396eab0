//! A station that yields: J2 plasticity in plane stress.
//!
//! Its strain is that of the convected frame less its plastic part, so that no turn of the shell
//! makes stress. The return is Simo & Hughes' \[1998, box 3.3\]: with p = S₁₁ + S₂₂ and
//! q² = ½(S₁₁ − S₂₂)² + 2S₁₂² of the trial stress,
//! φ²(γ) = (p²/6)/(1 + γE/3(1 − ν))² + q²/(1 + 2μγ)² = ⅔σ_y²(α + √⅔ γφ).

use crate::kernel::PlaneStress;
use cullet_model::Hardening;

/// Steps of Newton's method, and share of the yield stress at which it has ended.
const ROUNDS: usize = 40;
const ENOUGH: f64 = 1e-12;

/// What has flowed at a station.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StationFlow {
    /// Ê_p: 11, 22, 12 \[1\].
    pub strain: [f64; 3],
    /// Equivalent plastic strain α \[1\].
    pub amount: f64,
    /// σ_y(α) as far as it has risen over σ_y(0) \[Pa\].
    pub hardened: f64,
}

/// S : E of a symmetric pair, 11, 22, 12.
pub(super) fn times(s: &[f64; 3], e: &[f64; 3]) -> f64 {
    s[0] * e[0] + s[1] * e[1] + 2.0 * s[2] * e[2]
}

pub(super) fn less(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

/// |dev S| in plane stress.
fn deviator(s: &[f64; 3]) -> f64 {
    let (p, d) = (s[0] + s[1], s[0] - s[1]);
    (p * p / 6.0 + 0.5 * d * d + 2.0 * s[2] * s[2]).sqrt()
}

impl StationFlow {
    /// How far von Mises' stress is below that at which it yields \[Pa\].
    pub(super) fn slack(&self, hardening: &Hardening, stress: &[f64; 3]) -> f64 {
        hardening.yield_stress + self.hardened - 1.5_f64.sqrt() * deviator(stress)
    }

    /// Stress under a strain, after what of it flows.
    pub fn flow(
        &mut self,
        elastic: &PlaneStress,
        hardening: &Hardening,
        strain: &[f64; 3],
    ) -> [f64; 3] {
        let trial = elastic.stress(&less(strain, &self.strain));
        let root = (2.0_f64 / 3.0).sqrt();
        if deviator(&trial) <= root * (hardening.yield_stress + self.hardened) {
            return trial;
        }
        let PlaneStress { modulus, poisson } = *elastic;
        // E/3(1 − ν) and 2μ.
        let (bulk, shear) = (modulus * (1.0 + poisson) / 3.0, modulus * (1.0 - poisson));
        let (p, d) = (trial[0] + trial[1], 0.5 * (trial[0] - trial[1]));
        let (p2, q2) = (p * p / 6.0, 2.0 * (d * d + trial[2] * trial[2]));
        // What is left of φ over the yield stress, and its slope. It falls: Newton's steps from the
        // left stay there where it is convex, and are halved back where it is not.
        let left = |gamma: f64| {
            let (a, b) = (1.0 + bulk * gamma, 1.0 + shear * gamma);
            let phi = (p2 / (a * a) + q2 / (b * b)).sqrt();
            let slope = -(p2 * bulk / (a * a * a) + q2 * shear / (b * b * b)) / phi;
            let (yields, rises) = hardening.stress(self.amount + root * gamma * phi);
            let grows = root * (phi + gamma * slope);
            (phi - root * yields, slope - root * rises * grows, phi, yields)
        };
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut gamma = 0.0;
        let mut found = left(gamma);
        for _ in 0..ROUNDS {
            let (over, slope, _, yields) = found;
            if over.abs() <= ENOUGH * yields {
                break;
            }
            *(if over > 0.0 { &mut low } else { &mut high }) = gamma;
            let next = gamma - over / slope;
            let middle =
                if high.is_finite() { 0.5 * (low + high) } else { 2.0 * gamma + 1.0 / shear };
            gamma = if next > low && next < high { next } else { middle };
            found = left(gamma);
        }
        let (_, _, phi, yields) = found;
        let (a, b) = (1.0 + bulk * gamma, 1.0 + shear * gamma);
        let (p, d, s12) = (p / a, d / b, trial[2] / b);
        let stress = [0.5 * p + d, 0.5 * p - d, s12];
        let direction =
            [(2.0 * stress[0] - stress[1]) / 3.0, (2.0 * stress[1] - stress[0]) / 3.0, s12];
        (0..3).for_each(|k| self.strain[k] += gamma * direction[k]);
        self.amount += root * gamma * phi;
        self.hardened = yields - hardening.yield_stress;
        stress
    }
}

#[cfg(test)]
mod tests {
    use super::{StationFlow, deviator};
    use crate::kernel::PlaneStress;
    use cullet_model::Hardening;

    const STEEL: PlaneStress = PlaneStress { modulus: 210e9 / (1.0 - 0.09), poisson: 0.3 };

    /// Pulled in one direction a station bears A + Bαⁿ, and its plastic strain is what is not
    /// elastic.
    #[test]
    fn a_pull_in_one_direction_follows_the_curve() {
        for exponent in [0.2, 0.6, 1.0] {
            let law = Hardening { yield_stress: 250e6, hardening: 400e6, exponent };
            let mut station = StationFlow::default();
            for step in 1..=200 {
                let along = f64::from(step) * 5e-4;
                // The width that leaves nothing across, by bisection.
                let (mut low, mut high) = (-along, 0.0);
                for _ in 0..80 {
                    let middle = 0.5 * (low + high);
                    let pulls = station.clone().flow(&STEEL, &law, &[along, middle, 0.0])[1] > 0.0;
                    *(if pulls { &mut high } else { &mut low }) = middle;
                }
                let stress = station.flow(&STEEL, &law, &[along, low, 0.0]);
                let wanted = law.stress(station.amount).0;
                let off = (stress[0] / wanted - 1.0).abs();
                assert!(step < 4 || off < 1e-9, "{exponent}, {step}: {stress:?}, {wanted}");
                let elastic = along - stress[0] / 210e9;
                assert!((station.amount - elastic).abs() < 1e-9, "{exponent}, {step}: {station:?}");
            }
        }
    }

    /// Wherever it is pulled, a station ends on its yield surface; turned strains give turned
    /// stresses; shear yields at A/√3.
    #[test]
    fn stresses_end_on_the_yield_surface_whatever_the_frame() {
        let law = Hardening { yield_stress: 250e6, hardening: 300e6, exponent: 0.4 };
        let turn = |e: &[f64; 3], angle: f64| {
            let (c, s) = (angle.cos(), angle.sin());
            [
                e[0] * c * c + e[1] * s * s + 2.0 * e[2] * c * s,
                e[0] * s * s + e[1] * c * c - 2.0 * e[2] * c * s,
                (e[1] - e[0]) * c * s + e[2] * (c * c - s * s),
            ]
        };
        for strain in [[0.02, -0.03, 0.01], [-0.05, -0.04, 0.0], [0.0, 0.0, 0.2], [1e-2, 0.4, 0.1]]
        {
            let mut station = StationFlow::default();
            let stress = station.flow(&STEEL, &law, &strain);
            let bears = deviator(&stress) * (1.5_f64).sqrt();
            assert!((bears / law.stress(station.amount).0 - 1.0).abs() < 1e-9, "{strain:?}");
            let mut turned = StationFlow::default();
            let there = turned.flow(&STEEL, &law, &turn(&strain, 0.7));
            let wanted = turn(&stress, 0.7);
            (0..3).for_each(|k| assert!((there[k] - wanted[k]).abs() < 1e-3, "{strain:?}"));
        }
        let even = Hardening { hardening: 0.0, ..law };
        let stress = StationFlow::default().flow(&STEEL, &even, &[0.0, 0.0, 0.01]);
        assert!((stress[2] * 3.0_f64.sqrt() / 250e6 - 1.0).abs() < 1e-9, "{stress:?}");
    }
}
