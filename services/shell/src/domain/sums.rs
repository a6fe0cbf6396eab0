//! Sums over a shell: energies and momenta.

use super::state::ShellDomain;
use cullet_continuum::bytes::{held, held_lists};
use cullet_geometry::Vec3;
use cullet_simd::Real;

/// Sums over a whole shell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShellSums {
    /// Kinetic energy \[J\].
    pub kinetic: f64,
    /// Elastic energy \[J\].
    pub elastic: f64,
    /// Linear momentum \[kg·m/s\].
    pub momentum: Vec3,
    /// Angular momentum about the origin \[kg·m²/s\].
    pub angular_momentum: Vec3,
}

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// Memory that it takes, about \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let nodes = held(&self.displacement) + held(&self.mass) + held(&self.origin);
        let nodes = nodes + held(&self.velocity) + held(&self.external);
        let points = held(&self.setup) + held(&self.states) + held(&self.seats);
        let points = points + held(&self.point_at) + held(&self.elements);
        let splits = held_lists(&self.split.cells) + held(&self.split.mass);
        let parts = self.surface.bytes() + self.kernel.bytes() + self.links.bytes();
        nodes + points + splits + parts
    }

    /// Elastic energy of all points \[J\].
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        let strains = self.strains();
        let of = |(point, strain)| {
            let state = self.state(point);
            state.area * self.law.energy(state, strain)
        };
        self.live().zip(&strains).map(of).sum()
    }

    /// Sums as it is now.
    #[must_use]
    pub fn sums(&self) -> ShellSums {
        let (mut kinetic, mut momentum, mut angular) = (0.0, Vec3::zeros(), Vec3::zeros());
        for (node, (v, m)) in self.velocity.iter().zip(&self.mass).enumerate() {
            let place = self.surface.nodes[self.origin[node] as usize] + self.moved(node);
            kinetic += 0.5 * m * v.norm_squared();
            momentum += v * *m;
            angular += place.cross(v) * *m;
        }
        let elastic = self.elastic_energy();
        ShellSums { kinetic, elastic, momentum, angular_momentum: angular }
    }
}
