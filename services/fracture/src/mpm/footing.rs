//! Where something presses on a body: points with their shares of the force, and what these are
//! on the grid.

use super::domain::Domain;
use super::kernel::{packed, vector};
use cullet_geometry::Vec3;

/// Points with shares that sum to 1, and the nodes that carry them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Footing {
    /// Point ids and their shares.
    pub shares: Vec<(u32, f64)>,
    /// Nodes and their shares, as long as no node is parted.
    nodes: Vec<(u32, f64)>,
    /// Partings that the domain had seen when those were found.
    seen: Option<u64>,
}

impl Footing {
    /// Under these points.
    #[must_use]
    pub fn new(shares: Vec<(u32, f64)>) -> Self {
        Self { shares, ..Self::default() }
    }

    /// The nodes as they are now: weights stay, a crack makes copies.
    fn find(&mut self, domain: &Domain) {
        if self.seen != Some(domain.partings()) {
            self.nodes = domain.carriers(&self.shares);
            self.seen = Some(domain.partings());
        }
    }

    /// Velocity along `direction` in the mean \[m/s\].
    pub fn speed(&mut self, domain: &Domain, direction: &Vec3) -> f64 {
        self.find(domain);
        let velocity = &domain.grid.nodes.velocity;
        self.nodes.iter().map(|&(n, s)| s * vector(velocity[n as usize]).dot(direction)).sum()
    }

    /// Pushes the points with `impulse` \[N·s\] in all.
    pub fn push(&mut self, domain: &mut Domain, impulse: Vec3) {
        self.find(domain);
        let nodes = &mut domain.grid.nodes;
        for &(n, share) in &self.nodes {
            let n = n as usize;
            nodes.velocity[n] += packed(impulse * (share / nodes.mass[n]));
        }
    }
}
