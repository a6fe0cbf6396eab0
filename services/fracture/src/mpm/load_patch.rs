//! Where something presses on a body: points with their shares of the force, and what these are
//! on the grid.

use super::domain::Domain;
use super::stencil::{packed, vector};
use cullet_geometry::Vec3;
use std::ops::{AddAssign, Mul};

/// Least radius of the loaded disc, in spacings (F11): a smaller one is a point force on this grid,
/// whose stress grows as the grid shrinks.
pub const LEAST_RADIUS: f64 = 2.0;

/// Depth of the loaded layer, in spacings: one kernel's reach under the surface.
pub const DEPTH: f64 = 1.5;

/// Fewest points that may carry a load; the nearest ones are taken where the disc holds fewer.
pub const LEAST_POINTS: usize = 8;

/// Points with their shares of a push, numbers or vectors, and the nodes that carry them.
#[derive(Clone, Debug, Default, PartialEq)]
struct CarriedPush<T> {
    /// By id.
    shares: Vec<(u32, T)>,
    /// The nodes', as long as no node is split.
    nodes: Vec<(u32, T)>,
    /// Splits that the domain had seen when those were found.
    seen: Option<u64>,
}

impl<T> CarriedPush<T>
where
    T: Copy + Default + PartialEq + Mul<f64, Output = T> + AddAssign,
{
    fn new(shares: Vec<(u32, T)>) -> Self {
        Self { shares, nodes: Vec::new(), seen: None }
    }

    /// Finds the nodes as they are now: weights stay, a crack makes copies.
    fn find(&mut self, domain: &Domain) {
        if self.seen != Some(domain.splits()) {
            self.nodes = domain.carriers(&self.shares);
            self.seen = Some(domain.splits());
        }
    }

    /// Gives each node the impulse that is made of its share \[N·s\].
    fn push(&mut self, domain: &mut Domain, impulse: impl Fn(T) -> Vec3) {
        self.find(domain);
        let nodes = &mut domain.grid.nodes;
        for &(n, share) in &self.nodes {
            let n = n as usize;
            nodes.velocity[n] += packed(impulse(share) / nodes.mass[n]);
        }
    }
}

/// Points under a contact, with shares that sum to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadPatch(CarriedPush<f64>);

impl LoadPatch {
    /// Under these points.
    #[must_use]
    pub fn new(shares: Vec<(u32, f64)>) -> Self {
        Self(CarriedPush::new(shares))
    }

    /// Under the points near a contact: Hertz's pressure over a disc of `radius` \[m\] across
    /// `normal`, no narrower than the grid can tell.
    #[must_use]
    pub fn on_disc(domain: &Domain, point: &Vec3, normal: &Vec3, radius: f64) -> Self {
        Self::new(disc(domain, point, normal, radius))
    }

    /// Point ids and their shares.
    #[must_use]
    pub fn shares(&self) -> &[(u32, f64)] {
        &self.0.shares
    }

    /// Velocity along `direction` in the mean \[m/s\].
    pub fn speed(&mut self, domain: &Domain, direction: &Vec3) -> f64 {
        self.0.find(domain);
        let velocity = &domain.grid.nodes.velocity;
        self.0.nodes.iter().map(|&(n, s)| s * vector(velocity[n as usize]).dot(direction)).sum()
    }

    /// Pushes the points with `impulse` \[N·s\] in all.
    pub fn push(&mut self, domain: &mut Domain, impulse: Vec3) {
        self.0.push(domain, |share| impulse * share);
    }
}

/// Points that are pushed apart from the axis of a contact: a generalised force S whose coordinate
/// is how far they have moved outward in the mean. Their shares are the push of each at S = 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpreadPatch(CarriedPush<Vec3>);

impl SpreadPatch {
    /// The points of a patch about the axis along `normal` through `point` \[m\]: outward, less
    /// the mean.
    #[must_use]
    pub fn new(patch: &LoadPatch, domain: &Domain, point: &Vec3, normal: &Vec3) -> Self {
        let outward = |&(id, share): &(u32, f64)| {
            let arm = domain.particles.reference[domain.slot(id)] - point;
            let aside = arm - normal * arm.dot(normal);
            (id, share, aside.try_normalize(0.0).unwrap_or_default())
        };
        let all: Vec<(u32, f64, Vec3)> = patch.shares().iter().map(outward).collect();
        let mean: Vec3 = all.iter().map(|(_, share, out)| out * *share).sum();
        let shares = all.into_iter().map(|(id, share, out)| (id, (out - mean) * share)).collect();
        Self(CarriedPush::new(shares))
    }

    /// How far the points have moved outward \[m\], and how fast they do \[m/s\].
    pub fn motion(&mut self, domain: &Domain) -> (f64, f64) {
        self.0.find(domain);
        let nodes = &domain.grid.nodes;
        let along = |of: &[wide::f64x4]| -> f64 {
            self.0.nodes.iter().map(|(n, out)| vector(of[*n as usize]).dot(out)).sum()
        };
        (along(&nodes.displacement), along(&nodes.velocity))
    }

    /// Pushes the points outward with `impulse` \[N·s\].
    pub fn push(&mut self, domain: &mut Domain, impulse: f64) {
        self.0.push(domain, |out| out * impulse);
    }
}

/// The points near a contact and their shares of its force, which sum to 1.
fn disc(domain: &Domain, point: &Vec3, normal: &Vec3, radius: f64) -> Vec<(u32, f64)> {
    let spacing = &domain.grid.spacing;
    let radius = radius.max(LEAST_RADIUS * spacing.max());
    let depth = DEPTH * spacing.component_mul(normal).norm();
    let particles = &domain.particles;
    let mut shares: Vec<(u32, f64)> = Vec::new();
    let mut near: Vec<(f64, u32)> = Vec::new();
    for (x, &id) in particles.reference.iter().zip(&particles.id) {
        let arm = x - point;
        let along = arm.dot(normal);
        let aside = (arm.norm_squared() - along * along).max(0.0) / (radius * radius);
        near.push((arm.norm_squared(), id));
        // The disc of a curved surface sinks by up to its radius.
        if aside < 1.0 && along.abs() < depth.max(0.5 * radius) {
            // p = p₀ √(1 − r²/a²)  [H1]
            shares.push((id, (1.0 - aside).sqrt()));
        }
    }
    if shares.len() < LEAST_POINTS {
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        shares = near.iter().take(LEAST_POINTS).map(|&(_, id)| (id, 1.0)).collect();
    }
    shares.sort_unstable_by_key(|share| share.0);
    let sum: f64 = shares.iter().map(|share| share.1).sum();
    for share in &mut shares {
        share.1 /= sum;
    }
    shares
}
