//! What has gone in and out of a specimen.

use crate::discretisation::{BodySums, StepTally};
use crate::problem::SpecimenProblem;
use cullet_geometry::Vec3;

/// What has gone in and out.
#[derive(Clone, Debug, Default)]
pub(crate) struct EnergyBooks {
    /// Energy at the start \[J\].
    first: f64,
    /// Energy that is rounding \[J\]: of a body all of which is strained by what its precision
    /// cannot tell from nothing.
    noise: f64,
    /// By loads and supports \[J\].
    pub(crate) work: f64,
    /// Sum of the sizes of all works \[J\].
    traffic: f64,
    /// By damage \[J\].
    pub(crate) dissipated: f64,
    /// By damping \[J\].
    pub(crate) damped: f64,
    /// Where sides met \[J\].
    pub(crate) met: f64,
    /// Force of each support on the body in the specimen's frame \[N\], mean since the last sample.
    pub(crate) reactions: Vec<Vec3>,
    /// Force of each load now, likewise \[N\].
    pub(crate) applied: Vec<Vec3>,
}

impl EnergyBooks {
    pub(crate) fn new(problem: &SpecimenProblem, sums: &BodySums) -> Self {
        Self { first: sums.kinetic + sums.elastic, noise: noise(problem), ..Self::default() }
    }

    pub(crate) fn add(&mut self, tally: &StepTally) {
        self.damped += tally.damped;
        self.dissipated += tally.dissipated;
        self.met += tally.met;
        self.work += tally.pushed + tally.held;
        self.traffic += tally.pushed.abs() + tally.held.abs();
    }

    /// Energy that is there or was lost in a known way, less what was put in \[J\].
    pub(crate) fn balance(&self, sums: &BodySums) -> f64 {
        let there = sums.kinetic + sums.elastic;
        there + self.dissipated + self.damped + self.met - self.first - self.work
    }

    /// Energy that is there over what was there and was put in \[1\].
    pub(crate) fn growth(&self, sums: &BodySums) -> f64 {
        (sums.kinetic + sums.elastic) / self.most()
    }

    /// Whether more energy is there than `growth` times what was there and was put in.
    pub(crate) fn exceeds(&self, sums: &BodySums, growth: f64) -> bool {
        sums.kinetic + sums.elastic > growth * self.most()
    }

    fn most(&self) -> f64 {
        self.first + self.traffic + self.noise
    }
}

fn noise(problem: &SpecimenProblem) -> f64 {
    let young = problem.matter.materials().map(|material| material.young).fold(0.0, f64::max);
    let strain = problem.settings.precision.epsilon();
    0.5 * young * strain * strain * problem.body.mesh.signed_volume()
}
