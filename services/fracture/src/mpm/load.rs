//! The striker's push: Hertz pressure on the contact disc, half a sine in time.

use super::domain::Domain;
use crate::material::Material;
use crate::solver::Impact;
use cullet_geometry::Vec3;

/// Least radius of the loaded disc, in spacings (F11): a smaller one is a point force on this grid,
/// whose stress grows as the grid shrinks.
pub const LEAST_RADIUS: f64 = 2.0;

/// Depth of the loaded layer, in spacings: one kernel's reach under the surface.
pub const DEPTH: f64 = 1.5;

/// Fewest points that may carry a load; the nearest ones are taken where the disc holds fewer.
pub const LEAST_POINTS: usize = 8;

/// Share of the striker's lost energy still in the contact below which the force fades to nothing:
/// a cut at zero would switch on and off from step to step.
const FADING: f64 = 0.1;

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
    /// Work done on the body so far \[J\].
    pub work: f64,
    closing_speed: f64,
    /// Of the striker along the push \[1/kg\].
    striker_mobility: f64,
}

impl Load {
    /// Spreads `impact` over the points of `domain` near it, over `duration` \[s\].
    ///
    /// `mobility` is the body's at the contact, 1/m + n·[I⁻¹(r×n)]×r \[1/kg\]; the striker's
    /// follows from ½ m* v² = E.
    #[must_use]
    pub fn new(impact: &Impact, domain: &Domain, duration: f64, mobility: f64) -> Self {
        let spacing = &domain.grid.spacing;
        let radius = impact.radius.max(LEAST_RADIUS * spacing.max());
        let depth = DEPTH * spacing.component_mul(&impact.normal).norm();
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
            work: 0.0,
            closing_speed: impact.closing_speed,
            // 1/m* = v²/2E is the sum of the two mobilities [Gate 0]
            striker_mobility: (impact.closing_speed * impact.closing_speed / (2.0 * impact.energy)
                - mobility)
                .max(0.0),
        }
    }

    /// Energy that the striker has lost by giving `impulse` \[N·s\], seen from the body at rest
    /// \[J\].
    fn lost(&self, impulse: f64) -> f64 {
        impulse * (self.closing_speed - 0.5 * self.striker_mobility * impulse)
    }

    /// Share of the force that the contact can still exert \[1\].
    ///
    /// What the striker has lost and the body has not received is stored in the contact; without
    /// it the two part, however much of the half-sine is to come (F12). So a corner that breaks off
    /// does not take the whole impulse, and no push does more work than the striker can pay.
    fn grip(&self) -> f64 {
        if self.delivered == 0.0 {
            return 1.0;
        }
        let lost = self.lost(self.delivered);
        if lost <= self.work {
            return 0.0;
        }
        ((1.0 - self.work / lost) / FADING).min(1.0)
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

    /// When the tension at the rim of the contact, too narrow for the grid, reaches `strength`
    /// \[Pa\], if it does \[s\].
    ///
    /// σ_r = (1 − 2ν) p₀/3 with p₀ = 3F/2πa² grows with F^⅓ (H1); a field only a/10 deep counts in
    /// proportion to √(a/10) where that is less than the material's EG_f/σ_f² [Gate 2].
    #[must_use]
    pub fn cracks_at(&self, radius: f64, material: &Material) -> Option<f64> {
        let pi = core::f64::consts::PI;
        let force = 0.5 * pi * self.impulse / self.duration;
        let rim = (1.0 - 2.0 * material.poisson) * force / (2.0 * pi * radius * radius);
        let strength = material.failure_stress;
        let process = material.young * material.fracture_energy / (strength * strength);
        let depth = 0.1 * radius;
        let tension = rim * (depth / process.max(depth)).sqrt();
        let ratio = strength / tension;
        (ratio <= 1.0).then(|| self.duration / pi * libm::asin(ratio * ratio * ratio))
    }

    /// Whether nothing more is to come at time `t` \[s\].
    #[must_use]
    pub fn is_over(&self, t: f64) -> bool {
        t >= self.duration
    }

    /// Pushes the body by what falls into the domain's next step; returns the work done \[J\].
    pub fn push(&mut self, domain: &mut Domain) -> f64 {
        let now = domain.time;
        let size = (self.by(now + domain.step) - self.by(now)) * self.grip();
        if size <= 0.0 {
            return 0.0;
        }
        self.delivered += size;
        let impulse = self.direction * size;
        let work: f64 =
            self.shares.iter().map(|&(id, share)| domain.push(id, impulse * share)).sum();
        self.work += work;
        work
    }
}
