//! Damping: dashpots of bonds, and the air.

use super::PeridynamicDomain;
use super::parts::PartFrames;
use crate::kernel::DashpotPass;
use cullet_geometry::Vec3;
use cullet_simd::PackedRecord;
use fearless_simd::dispatch;
use rayon::prelude::*;

impl PeridynamicDomain {
    /// Greatest ω of the body, or more \[1/s\].
    pub(super) fn fastest(&self) -> f64 {
        (2.0 * self.law.stiffness() * self.steepest / self.law.density).sqrt()
    }

    /// Adds the dashpots' 15wηλ̇ to the pulls of bonds after a step of `dt` \[s\]; what they
    /// take in such a step \[J\].
    ///
    /// η is such that no mode has more than the share of critical damping that the law says. The
    /// forces are not scaled and turned yet.
    pub(super) fn drag(&mut self, frames: &PartFrames<'_>, dt: f64) -> f64 {
        let viscosity = 2.0 * self.law.damping.bonds * self.law.stiffness() / self.fastest();
        let points = self.places.len();
        let mean = self.velocities.iter().sum::<Vec3>() / points as f64;
        let mut velocities = vec![PackedRecord::default(); self.records.len()];
        velocities[..points].par_iter_mut().enumerate().for_each(|(p, record)| {
            if !self.is_debris(p) {
                let back = frames.of(p).turn.inverse();
                let v = back * (self.velocities[p] - mean) / self.horizon;
                record.0[..3].copy_from_slice(&[v.x as f32, v.y as f32, v.z as f32]);
            }
        });
        let pass = DashpotPass {
            bonds: &self.bonds,
            records: &self.records,
            velocities: &velocities,
            left: &self.left,
            viscosity: viscosity as f32,
        };
        let level = self.level.level();
        let found: Vec<(Vec3, f32)> = (0..points)
            .into_par_iter()
            .map(|p| dispatch!(level, simd => pass.point(simd, p)))
            .collect();
        let mut power = 0.0;
        self.drags.clear();
        for (force, (more, taken)) in self.forces.iter_mut().zip(found) {
            *force += more;
            self.drags.push(more);
            power += f64::from(taken);
        }
        power * self.mean_volume * dt
    }

    /// Slows all points as air does in a step of `dt` \[s\]: by exp(−λ dt), so that it does not
    /// depend on the step. What it took \[J\].
    pub(super) fn slow(&mut self, dt: f64) -> f64 {
        let keep = libm::exp(-self.law.damping.air * dt);
        let lost = 0.5 * self.law.density * (1.0 - keep * keep);
        let mut taken = 0.0;
        for (v, volume) in self.velocities.iter_mut().zip(&self.volumes) {
            taken += lost * volume * v.norm_squared();
            *v *= keep;
        }
        taken
    }
}
