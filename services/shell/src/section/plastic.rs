//! Sections that yield: J2 plasticity in plane stress at each station through the thickness.
//!
//! The strain of a station is that of the convected frame less its plastic part, so that no turn of
//! the shell makes stress. The return is Simo & Hughes' \[1998, box 3.3\]: with p = S₁₁ + S₂₂ and
//! q² = ½(S₁₁ − S₂₂)² + 2S₁₂² of the trial stress,
//! φ²(γ) = (p²/6)/(1 + γE/3(1 − ν))² + q²/(1 + 2μγ)² = ⅔σ_y²(α + √⅔ γφ).

use super::{PointState, SectionLaw, SectionTally};
use crate::kernel::{PlaneStress, Resultants, SurfaceStrain};

/// Steps of Newton's method, and share of the yield stress at which it has ended.
const ROUNDS: usize = 40;
const ENOUGH: f64 = 1e-12;

/// Plastic strain below which a power of it is taken to rise in a straight line \[1\].
const LEAST_STRAIN: f64 = 1e-6;

/// The stress at which a metal yields, σ_y = A + Bαⁿ  \[Johnson & Cook 1983, Eq. 1, slow and cold\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hardening {
    /// A: that at which it yields first \[Pa\].
    pub yield_stress: f64,
    /// B \[Pa\].
    pub hardening: f64,
    /// n, in (0, 1\] \[1\].
    pub exponent: f64,
}

impl Hardening {
    /// σ_y at a plastic strain of `alpha` \[Pa\], and its slope \[Pa\].
    #[must_use]
    pub fn stress(&self, alpha: f64) -> (f64, f64) {
        let Self { yield_stress, hardening, exponent } = *self;
        if hardening <= 0.0 {
            return (yield_stress, 0.0);
        }
        if alpha < LEAST_STRAIN {
            let slope = hardening * libm::pow(LEAST_STRAIN, exponent - 1.0);
            return (yield_stress + slope * alpha, slope);
        }
        let more = hardening * libm::pow(alpha, exponent);
        (yield_stress + more, more * exponent / alpha)
    }
}

/// What has flowed at a station.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StationFlow {
    /// Ê_p: 11, 22, 12 \[1\].
    pub strain: [f64; 3],
    /// Equivalent plastic strain α \[1\].
    pub amount: f64,
}

/// S : E of a symmetric pair, 11, 22, 12.
fn times(s: &[f64; 3], e: &[f64; 3]) -> f64 {
    s[0] * e[0] + s[1] * e[1] + 2.0 * s[2] * e[2]
}

fn less(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

/// |dev S| in plane stress.
fn deviator(s: &[f64; 3]) -> f64 {
    let (p, d) = (s[0] + s[1], s[0] - s[1]);
    (p * p / 6.0 + 0.5 * d * d + 2.0 * s[2] * s[2]).sqrt()
}

impl StationFlow {
    /// Stress under a strain, after what of it flows.
    pub fn flow(
        &mut self,
        elastic: &PlaneStress,
        hardening: &Hardening,
        strain: &[f64; 3],
    ) -> [f64; 3] {
        let trial = elastic.stress(&less(strain, &self.strain));
        let root = (2.0_f64 / 3.0).sqrt();
        if deviator(&trial) <= root * hardening.stress(self.amount).0 {
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
        for _ in 0..ROUNDS {
            let (over, slope, _, yields) = left(gamma);
            if over.abs() <= ENOUGH * yields {
                break;
            }
            *(if over > 0.0 { &mut low } else { &mut high }) = gamma;
            let next = gamma - over / slope;
            let middle =
                if high.is_finite() { 0.5 * (low + high) } else { 2.0 * gamma + 1.0 / shear };
            gamma = if next > low && next < high { next } else { middle };
        }
        let (a, b, phi) = (1.0 + bulk * gamma, 1.0 + shear * gamma, left(gamma).2);
        let (p, d, s12) = (p / a, d / b, trial[2] / b);
        let stress = [0.5 * p + d, 0.5 * p - d, s12];
        let direction =
            [(2.0 * stress[0] - stress[1]) / 3.0, (2.0 * stress[1] - stress[0]) / 3.0, s12];
        (0..3).for_each(|k| self.strain[k] += gamma * direction[k]);
        self.amount += root * gamma * phi;
        stress
    }
}

impl SectionLaw {
    /// What the section of a point bears under `strain`, after what of it flows. What that takes is
    /// the work of the mean of the stresses before and after.
    pub(super) fn flow(
        &self,
        hardening: &Hardening,
        state: &mut PointState,
        strain: &SurfaceStrain,
        tally: &mut SectionTally,
    ) -> Resultants {
        let (t, stations) = (state.thickness, self.stations.list());
        state.flow.resize(stations.len(), StationFlow::default());
        let before = state.last.unwrap_or_default();
        let mut borne = Resultants::default();
        for (&(z, w), flow) in stations.iter().zip(&mut state.flow) {
            let then = *flow;
            let stress = flow.flow(&self.elastic, hardening, &strain.at(z * t));
            if *flow != then {
                let first = self.elastic.stress(&less(&before.at(z * t), &then.strain));
                let mean = [0, 1, 2].map(|k| 0.5 * (first[k] + stress[k]));
                let work = times(&mean, &less(&flow.strain, &then.strain));
                tally.dissipated += state.area * t * w * work;
            }
            borne.add(t, (z, w), &stress);
        }
        state.last = Some(*strain);
        borne
    }

    /// Elastic energy of a point that has flowed, over its area \[J/m²\].
    pub(super) fn energy_of_flowed(&self, state: &PointState, strain: &SurfaceStrain) -> f64 {
        let t = state.thickness;
        let at = |(&(z, w), flow): (&(f64, f64), &StationFlow)| {
            w * t * self.elastic.energy(&less(&strain.at(z * t), &flow.strain))
        };
        self.stations.list().iter().zip(&state.flow).map(at).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::{Hardening, StationFlow, deviator, times};
    use crate::kernel::{PlaneStress, Resultants, SurfaceStrain};
    use crate::section::{PointState, SectionLaw, SectionTally, gauss};
    use cullet_model::Material;

    const STEEL: PlaneStress = PlaneStress { modulus: 210e9 / (1.0 - 0.09), poisson: 0.3 };

    fn steel(hardening: Hardening) -> SectionLaw {
        let material = Material {
            density: 7850.0,
            young: 210e9,
            poisson: 0.3,
            failure_stress: f64::INFINITY,
            fracture_energy: f64::INFINITY,
        };
        SectionLaw::new(&material).yielding(hardening)
    }

    fn whole(t: f64) -> PointState {
        PointState::new(f64::INFINITY, [1e-6, 1e-6, 0.0], t, 1.0)
    }

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

    /// Moment that bends a section with nothing across, over σ_y t²/4.
    fn plastic_moment(stations: usize) -> f64 {
        let law = steel(Hardening { yield_stress: 250e6, hardening: 0.0, exponent: 1.0 });
        let law = SectionLaw { stations: gauss(stations), ..law };
        let mut state = whole(1e-3);
        let (mut tally, mut borne) = (SectionTally::default(), Resultants::default());
        for step in 1..=400 {
            let bending = f64::from(step) * 0.5;
            let (mut low, mut high) = (-bending, 0.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let strain = SurfaceStrain { membrane: [0.0; 3], bending: [bending, middle, 0.0] };
                let found = law.step(&mut state.clone(), &strain, &mut tally);
                *(if found.moment[1] > 0.0 { &mut high } else { &mut low }) = middle;
            }
            let strain = SurfaceStrain { membrane: [0.0; 3], bending: [bending, low, 0.0] };
            borne = law.step(&mut state, &strain, &mut tally);
        }
        borne.moment[0] / (250e6 * 1e-6 / 4.0)
    }

    /// A section that flows through and through bears σ_y t²/4: within 6 % with five stations and
    /// within 3 % with seven.
    #[test]
    fn a_section_bears_its_plastic_moment() {
        for (stations, bar) in [(5, 0.06), (7, 0.03)] {
            let moment = plastic_moment(stations);
            println!("plastic moment, {stations} stations: {moment:.4}");
            assert!((moment - 1.0).abs() < bar, "{stations}: {moment}");
        }
    }

    /// What is put in is stored or dissipated, to rounding, on any path there and back; and a
    /// section that is let go keeps its bend.
    #[test]
    fn work_is_stored_or_dissipated_and_a_bend_stays() {
        let law = steel(Hardening { yield_stress: 250e6, hardening: 300e6, exponent: 0.5 });
        let (mut state, mut tally) = (whole(1e-3), SectionTally::default());
        let (mut last, mut before) = (SurfaceStrain::default(), Resultants::default());
        let mut work = 0.0;
        for step in 0..=600 {
            let phase = f64::from(step) * 0.02;
            let strain = SurfaceStrain {
                membrane: [2e-3 * phase.sin(), -1e-3 * (2.0 * phase).sin(), 1e-3 * phase.sin()],
                bending: [12.0 * (1.3 * phase).sin(), 4.0 * phase.sin(), -3.0 * phase.sin()],
            };
            let borne = law.step(&mut state, &strain, &mut tally);
            let change = |now: &[f64; 3], then: &[f64; 3]| [0, 1, 2].map(|k| now[k] - then[k]);
            let mean = |a: &[f64; 3], b: &[f64; 3]| [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
            work += times(
                &mean(&borne.force, &before.force),
                &change(&strain.membrane, &last.membrane),
            ) + times(
                &mean(&borne.moment, &before.moment),
                &change(&strain.bending, &last.bending),
            );
            (last, before) = (strain, borne);
        }
        let stored = law.energy(&state, &last);
        assert!(tally.dissipated > 20.0 * stored, "{} and {stored}", tally.dissipated);
        let off = (stored + tally.dissipated) / work - 1.0;
        assert!(off.abs() < 1e-12, "{off}");
        let flat = law.step(&mut state.clone(), &SurfaceStrain::default(), &mut tally);
        assert!(flat.moment[0].abs() > 1.0, "{flat:?}");
    }
}
