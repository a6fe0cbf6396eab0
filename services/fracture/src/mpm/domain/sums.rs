//! Sums over the whole body: energies and momenta.

use super::Domain;
use crate::mpm::elastic::green_strain;
use crate::mpm::stencil::vector;
use cullet_geometry::Vec3;

impl Domain {
    /// Elastic energy \[J\].
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        let (motions, particles) = (self.motions(), &self.particles);
        let points = motions.iter().enumerate().filter(|(p, _)| !particles.eroded[*p]);
        points
            .map(|(p, motion)| {
                let strain = green_strain(&motion.displacement_gradient);
                let law = &self.response.laws[particles.kind[p] as usize];
                let energy = match &law.flow {
                    Some(flow) => flow.energy(&strain, &particles.flow[p]),
                    None => law.softening.energy(&strain, particles.damage[p]),
                };
                particles.volume[p] * energy
            })
            .sum()
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
