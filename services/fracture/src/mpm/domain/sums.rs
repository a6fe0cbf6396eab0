//! Sums over the whole body: energies and momenta.

use super::Domain;
use crate::mpm::elastic::green_strain;
use crate::mpm::stencil::vector;
use cullet_geometry::{Mat3, Vec3};
use cullet_model::EnergyAccount;
use rayon::prelude::*;

/// Points of a piece of work.
const CHUNK: usize = 1024;

impl Domain {
    /// Elastic energy \[J\].
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        self.elastic_energy_back(0.0)
    }

    /// Energy of motion and of strain, both in the middle of the step that was just taken, where
    /// the velocities are; the rest of the account is left to fill in.
    #[must_use]
    pub fn energy(&self) -> EnergyAccount {
        EnergyAccount {
            kinetic: self.kinetic_energy(),
            elastic: self.elastic_energy_back(0.5 * self.step),
            ..EnergyAccount::default()
        }
    }

    /// Elastic energy `time` \[s\], half a step, ago: ½u·Ku′ of the places u before and u′ after
    /// the step, which with the energy of motion is what steps of this kind keep \[J\]. That is the
    /// energy in the middle less that of the strain v Δt/2 by itself.
    fn elastic_energy_back(&self, time: f64) -> f64 {
        let (motions, particles) = (self.motions(), &self.particles);
        let energy = |p: usize| {
            let (h, rate) = (&motions[p].displacement_gradient, &motions[p].velocity_gradient);
            let middle = h - rate * time;
            let strain = green_strain(&middle);
            let law = &self.response.laws[particles.kind[p] as usize];
            let damage = particles.damage[p];
            let held = match &law.flow {
                Some(flow) => flow.energy(&strain, &particles.flow[p]),
                None if damage > 0.0 => law.softening.energy(&strain, damage),
                None => law.elastic.energy_density(&strain),
            };
            if time == 0.0 {
                return particles.volume[p] * held;
            }
            let drawn = (Mat3::identity() + middle).transpose() * rate * time;
            let half = (drawn + drawn.transpose()) * 0.5;
            let (trace, square) = (half.trace(), half.norm_squared());
            let own = 0.5 * law.elastic.lame * trace * trace + law.elastic.shear * square;
            particles.volume[p] * (held - (1.0 - damage) * own)
        };
        let points: Vec<usize> = (0..motions.len()).filter(|&p| !particles.eroded[p]).collect();
        let sums: Vec<f64> =
            points.par_chunks(CHUNK).map(|chunk| chunk.iter().map(|&p| energy(p)).sum()).collect();
        sums.into_iter().sum()
    }

    /// Kinetic energy \[J\].
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        let nodes = &self.grid.nodes;
        let pairs = nodes.velocity.iter().zip(&nodes.mass);
        0.5 * pairs.map(|(v, mass)| (*v * *v).reduce_add() * mass).sum::<f64>()
    }

    /// Linear momentum \[kg·m/s\].
    #[must_use]
    pub fn momentum(&self) -> Vec3 {
        let nodes = &self.grid.nodes;
        let pairs = nodes.velocity.iter().zip(&nodes.mass);
        pairs.fold(Vec3::zeros(), |sum, (v, mass)| sum + vector(*v) * *mass)
    }

    /// Σ m |v|: what the nodes carry, whichever way \[kg·m/s\].
    #[must_use]
    pub fn traffic(&self) -> f64 {
        let nodes = &self.grid.nodes;
        let pairs = nodes.velocity.iter().zip(&nodes.mass);
        pairs.map(|(v, mass)| (*v * *v).reduce_add().sqrt() * mass).sum()
    }

    /// Angular momentum about the origin \[kg·m²/s\].
    #[must_use]
    pub fn angular_momentum(&self) -> Vec3 {
        let nodes = &self.grid.nodes;
        (0..nodes.len()).fold(Vec3::zeros(), |sum, n| {
            let x = self.grid.place(n) + vector(nodes.displacement[n]);
            sum + x.cross(&vector(nodes.velocity[n])) * nodes.mass[n]
        })
    }
}
