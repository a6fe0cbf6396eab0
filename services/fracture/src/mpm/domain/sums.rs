//! Sums over the whole body: energies and momenta.

use super::Domain;
use crate::mpm::elastic::green_strain;
use crate::mpm::kernel::vector;
use cullet_geometry::Vec3;

impl Domain {
    /// Elastic energy \[J\], to second order in the strain.
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        let motions = self.motions();
        let points = motions.iter().enumerate();
        points
            .map(|(p, motion)| {
                let (s, e) = (
                    self.stress(p, &motion.displacement_gradient),
                    green_strain(&motion.displacement_gradient),
                );
                let normal = s[0] * e[0] + s[1] * e[1] + s[2] * e[2];
                let shear = s[3] * e[3] + s[4] * e[4] + s[5] * e[5];
                0.5 * self.particles.volume[p] * (normal + 2.0 * shear)
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
