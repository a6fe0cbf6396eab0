//! Sections that yield: what flows at the stations through the thickness, and what it takes.

use super::yielding::{StationFlow, less, times};
use super::{NEAR_YIELD, PointState, SectionLaw, SectionTally};
use crate::kernel::{Resultants, SurfaceStrain};
use cullet_model::Hardening;

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
        let (mut borne, mut slack) = (Resultants::default(), f64::INFINITY);
        for (&(z, w), flow) in stations.iter().zip(&mut state.flow) {
            let then = *flow;
            let stress = flow.flow(&self.elastic, hardening, &strain.at(z * t));
            if *flow != then {
                let first = |before: SurfaceStrain| {
                    self.elastic.stress(&less(&before.at(z * t), &then.strain))
                };
                let first = state.last.map_or(stress, first);
                let mean = [0, 1, 2].map(|k| 0.5 * (first[k] + stress[k]));
                let work = times(&mean, &less(&flow.strain, &then.strain));
                tally.dissipated += state.area * t * w * work;
            }
            slack = slack.min(flow.slack(hardening, &stress));
            borne.add(t, (z, w), &stress);
        }
        state.slack = slack;
        let is_near = slack <= NEAR_YIELD * hardening.yield_stress;
        state.last = is_near.then_some(*strain);
        borne
    }
}

#[cfg(test)]
mod tests {
    use crate::kernel::{Resultants, SurfaceStrain};
    use crate::section::yielding::times;
    use crate::section::{PointState, SectionLaw, SectionTally, gauss};
    use cullet_model::{Hardening, Material};

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
            let again = law.borne(&state, &strain);
            (0..3).for_each(|k| assert!((again.force[k] - borne.force[k]).abs() < 1e-3));
            (0..3).for_each(|k| assert!((again.moment[k] - borne.moment[k]).abs() < 1e-6));
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
