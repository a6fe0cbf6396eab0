//! A step of a shell: central differences.

use super::state::ShellDomain;
use crate::section::SectionTally;
use cullet_geometry::Vec3;
use cullet_simd::Real;
use rayon::prelude::*;

/// Control points of a chunk of the pass that moves them.
const CHUNK: usize = 512;

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShellTally {
    /// To points.
    pub points: SectionTally,
    /// Energy lost where sides of cracks met \[J\].
    pub met: f64,
}

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// Takes a step: cracks go on, points are strained, control points move. `hold` may change the
    /// velocity of a control point by its number.
    pub fn advance(&mut self, hold: impl Fn(usize, Vec3) -> Vec3 + Sync) -> ShellTally {
        self.go_on();
        let points = self.strain();
        if points.broken > 0 {
            self.note_broken();
        }
        let before = self.velocity.clone();
        self.accelerate(hold);
        let met = self.meet(&before);
        self.drift();
        ShellTally { points, met }
    }

    fn accelerate(&mut self, hold: impl Fn(usize, Vec3) -> Vec3 + Sync) {
        let (dt, kernel, mass, external) = (self.step, &self.kernel, &self.mass, &self.external);
        self.velocity.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, velocities)| {
            for (k, v) in velocities.iter_mut().enumerate() {
                let node = chunk * CHUNK + k;
                let force = Vec3::from(kernel.force(node)) + external[node];
                *v = hold(node, *v + force * (dt / mass[node]));
            }
        });
        self.external.fill(Vec3::zeros());
    }

    fn drift(&mut self) {
        let dt = self.step;
        for (u, v) in self.displacement.iter_mut().zip(&self.velocity) {
            (0..3).for_each(|c| u[c] += dt * v[c]);
        }
    }
}
