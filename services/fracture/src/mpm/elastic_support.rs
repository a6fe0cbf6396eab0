//! What a body rests on: a disc that gives way as an elastic half-space, moves off as what it
//! belongs to does, and does not pull.

use super::domain::Domain;
use super::load_patch::{LEAST_RADIUS, LoadPatch};
use cullet_geometry::Vec3;
use cullet_model::{Material, Support};

/// One support, under the points that rest on it.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticSupport {
    patch: LoadPatch,
    /// Direction in which it can push.
    pub normal: Vec3,
    /// Where \[m\].
    pub point: Vec3,
    /// Force over depth \[N/m\].
    stiffness: f64,
    /// How fast it gives way over what it has given \[1/kg\].
    mobility: f64,
    /// How far the body has sunk into it \[m\].
    depth: f64,
    /// Impulse given to the body \[N·s\].
    pub delivered: f64,
    /// Work done on the body so far \[J\].
    pub work: f64,
    /// Impulse of the last step \[N·s\], and the speed of the body there before it \[m/s\].
    last: (f64, f64),
}

impl ElasticSupport {
    /// Puts `support` under the points near it. It is as stiff as a half-space of the body's own
    /// material under a flat punch, k = 2aE/(1 − ν²).
    #[must_use]
    pub fn new(support: &Support, domain: &Domain, material: &Material) -> Self {
        let radius = support.radius.max(LEAST_RADIUS * domain.grid.spacing.max());
        let modulus = material.young / (1.0 - material.poisson * material.poisson);
        Self {
            patch: LoadPatch::on_disc(domain, &support.point, &support.normal, support.radius),
            normal: support.normal,
            point: support.point,
            stiffness: 2.0 * radius * modulus,
            mobility: support.mobility,
            depth: 0.0,
            delivered: 0.0,
            work: 0.0,
            last: (0.0, 0.0),
        }
    }

    /// Pushes the body by what falls into the domain's next step.
    pub fn push(&mut self, domain: &mut Domain) {
        let impulse = self.stiffness * self.depth.max(0.0) * domain.step;
        let own = -self.mobility * self.delivered;
        let speed = self.patch.speed(domain, &self.normal);
        self.depth -= (speed - own) * domain.step;
        self.last = (impulse, speed);
        if impulse > 0.0 {
            self.delivered += impulse;
            self.patch.push(domain, self.normal * impulse);
        }
    }

    /// Books the work of the step that was just taken, as a striker's is.
    pub fn book(&mut self, domain: &Domain) {
        let (impulse, before) = self.last;
        if impulse > 0.0 {
            self.work += 0.5 * impulse * (before + self.patch.speed(domain, &self.normal));
        }
    }
}
