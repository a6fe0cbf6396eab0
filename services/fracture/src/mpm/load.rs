//! The striker's push: Hertz pressure on the contact disc, half a sine in time.

use super::domain::Domain;
use crate::solver::Impact;
use cullet_geometry::Vec3;

/// Least radius of the loaded disc, in spacings (F11): a smaller one is a point force on this grid,
/// whose stress grows as the grid shrinks.
pub const LEAST_RADIUS: f64 = 2.0;

/// Depth of the loaded layer, in spacings: one kernel's reach under the surface.
pub const DEPTH: f64 = 1.5;

/// Fewest points that may carry a load; the nearest ones are taken where the disc holds fewer.
pub const LEAST_POINTS: usize = 8;

/// One impact, spread over points.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Point ids and their shares, which sum to 1.
    pub shares: Vec<(u32, f64)>,
    /// Direction of the push.
    pub direction: Vec3,
    /// ∫F dt \[N·s\].
    pub impulse: f64,
    /// How long it takes \[s\].
    pub duration: f64,
    /// How far it has come \[N·s\].
    pub delivered: f64,
    /// Speed of the loaded points along the push at which the striker loses touch \[m/s\].
    pub release: f64,
    /// Whether it has.
    pub released: bool,
}

impl Load {
    /// Spreads `impact` over the points of `domain` near it, over `duration` \[s\].
    #[must_use]
    pub fn new(impact: &Impact, domain: &Domain, duration: f64) -> Self {
        let radius = impact.radius.max(LEAST_RADIUS * domain.spacing);
        let depth = DEPTH * domain.spacing;
        let particles = &domain.particles;
        let mut shares: Vec<(u32, f64)> = Vec::new();
        let mut near: Vec<(f64, u32)> = Vec::new();
        for (x, &id) in particles.reference.iter().zip(&particles.id) {
            let arm = x - impact.point;
            let along = arm.dot(&impact.normal);
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
        Self {
            shares,
            direction: impact.normal,
            impulse: impact.impulse,
            duration,
            delivered: 0.0,
            release: f64::INFINITY,
            released: false,
        }
    }

    /// Mean speed of the loaded points along the push \[m/s\].
    fn speed(&self, domain: &Domain) -> f64 {
        let along = |id| domain.particles.velocity[domain.slot(id)].dot(&self.direction);
        self.shares.iter().map(|&(id, share)| share * along(id)).sum()
    }

    /// Impulse delivered by time `t` \[N·s\]: the integral of F = (π/2)(I/t_c) sin(πt/t_c).
    #[must_use]
    pub fn by(&self, t: f64) -> f64 {
        if t >= self.duration {
            return self.impulse;
        }
        // sin² keeps the small start exact: (1 − cos πt/t_c)/2 = sin²(πt/2t_c)
        let s = libm::sin(0.5 * core::f64::consts::PI * t / self.duration);
        self.impulse * s * s
    }

    /// Whether nothing more is to come at time `t` \[s\].
    #[must_use]
    pub fn is_over(&self, t: f64) -> bool {
        self.released || t >= self.duration
    }

    /// Pushes the body by what falls into the domain's next step; returns the work done \[J\].
    pub fn push(&mut self, domain: &mut Domain) -> f64 {
        self.released |= self.speed(domain) > self.release;
        if self.released {
            return 0.0;
        }
        let until = self.by(domain.time + domain.step);
        let impulse = self.direction * (until - self.delivered);
        self.delivered = until;
        if impulse == Vec3::zeros() {
            return 0.0;
        }
        self.shares.iter().map(|&(id, share)| domain.push(id, impulse * share)).sum()
    }
}
