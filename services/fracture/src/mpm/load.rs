//! The striker's push: Hertz pressure on the contact disc, through the contact's spring.

use super::domain::Domain;
use super::footing::Footing;
use super::spring::{self, Spring};
use cullet_geometry::Vec3;
use cullet_model::{Impact, Material};

/// Least radius of the loaded disc, in spacings (F11): a smaller one is a point force on this grid,
/// whose stress grows as the grid shrinks.
pub const LEAST_RADIUS: f64 = 2.0;

/// Depth of the loaded layer, in spacings: one kernel's reach under the surface.
pub const DEPTH: f64 = 1.5;

/// Fewest points that may carry a load; the nearest ones are taken where the disc holds fewer.
pub const LEAST_POINTS: usize = 8;

/// Radius of the widest contact over the reach of the body from its centre: beyond, what is pressed
/// is no half-space.
const WIDEST: f64 = 0.5;

/// Durations of the contact after which it is over in any case.
const LONGEST: f64 = 3.0;

/// Durations apart after which the two have parted for good.
const APART: f64 = 0.5;

/// One impact: a striker that presses on points near the contact through a [`Spring`].
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// The points that it presses on.
    pub footing: Footing,
    /// Where \[m\].
    pub point: Vec3,
    /// Radius of the loaded disc \[m\].
    pub radius: f64,
    /// Direction of the push.
    pub direction: Vec3,
    /// Most that the striker gives \[N·s\].
    pub impulse: f64,
    /// How long the contact of a rigid body would take \[s\].
    pub duration: f64,
    /// How far it has come \[N·s\].
    pub delivered: f64,
    /// Work done on the body so far \[J\].
    pub work: f64,
    /// Force now \[N\].
    pub force: f64,
    spring: Spring,
    /// Speed of the striker along the push at first, seen from the body at rest \[m/s\].
    closing_speed: f64,
    /// The same now \[m/s\].
    speed: f64,
    /// Of the striker along the push \[1/kg\].
    mobility: f64,
    /// Approach of striker and body since they touched, δ \[m\].
    approach: f64,
    /// Given in the last step \[N·s\].
    last: f64,
    /// When they last touched \[s\].
    touched: f64,
    over: bool,
}

impl Load {
    /// Spreads `impact` over the points of `domain` near it, for a contact of `duration` \[s\].
    ///
    /// `mobility` is the body's at the contact, 1/m + n·[I⁻¹(r×n)]×r \[1/kg\]; the striker's
    /// follows from ½ m* v² = E. A `duration` shorter by s is that of a striker of the same energy
    /// with m* s² and v/s: same spring, same peak force, s times the impulse.
    #[must_use]
    pub fn new(impact: &Impact, domain: &Domain, duration: f64, mobility: f64) -> Self {
        let spring = Spring::new(impact);
        let reach = domain.particles.reference.iter().map(Vec3::norm).fold(0.0, f64::max);
        let widest = impact.radius.max(WIDEST * reach);
        let radius = spring.contact(spring.depth(impact.energy)).min(widest);
        let shares = disc(domain, &impact.point, &impact.normal, radius);
        let share = duration / spring::duration(impact);
        let reduced = 2.0 * impact.energy / (impact.closing_speed * impact.closing_speed);
        Self {
            footing: Footing::new(shares),
            point: impact.point,
            radius: radius.max(LEAST_RADIUS * domain.grid.spacing.max()),
            direction: impact.normal,
            impulse: share * impact.impulse,
            duration,
            delivered: 0.0,
            work: 0.0,
            force: 0.0,
            spring,
            closing_speed: impact.closing_speed / share,
            speed: impact.closing_speed / share,
            // 1/m* is the sum of the two mobilities [Gate 0]
            mobility: (1.0 / (reduced * share * share) - mobility).max(0.0),
            approach: 0.0,
            last: 0.0,
            touched: 0.0,
            over: false,
        }
    }

    /// Whether the tension at the rim of a contact that is too narrow for the grid has reached the
    /// strength.
    ///
    /// σ_r = (1 − 2ν) p₀/3 with p₀ = 3F/2πa² (H1); a field only a/10 deep counts in proportion to
    /// √(a/10) where that is less than the material's EG_f/σ_f² [Gate 2].
    #[must_use]
    pub fn cracks(&self, material: &Material) -> bool {
        let radius = self.spring.widest();
        let area = 2.0 * core::f64::consts::PI * radius * radius;
        let rim = (1.0 - 2.0 * material.poisson) * self.force / area;
        let strength = material.failure_stress;
        let process = material.young * material.fracture_energy / (strength * strength);
        let depth = 0.1 * radius;
        self.force > 0.0 && rim * (depth / process.max(depth)).sqrt() >= strength
    }

    /// Greatest radius of the contact so far, were it not widened \[m\].
    #[must_use]
    pub fn contact(&self) -> f64 {
        self.spring.widest()
    }

    /// Greatest force so far \[N\].
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.spring.greatest()
    }

    /// Energy that the striker has lost \[J\]: what the body has got, and what the spring holds.
    #[must_use]
    pub fn lost(&self) -> f64 {
        0.5 * self.delivered * (self.closing_speed + self.speed)
    }

    /// Whether nothing more is to come.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// Pushes the body by what falls into the domain's next step.
    ///
    /// The force is the spring's: it ends when the body gives way or the two part, so no push does
    /// more work than the striker loses (F12), nor gives more than `impulse`.
    pub fn push(&mut self, domain: &mut Domain) {
        if self.over {
            return;
        }
        // What the force of the last step did, and how near that brought the two.
        let surface = self.footing.speed(domain, &self.direction);
        self.work += self.last * surface;
        self.approach += (self.speed - surface) * domain.step;
        self.force = self.spring.force(self.approach.max(0.0));
        let left = self.impulse - self.delivered;
        let size = (self.force * domain.step).min(left);
        if size > 0.0 {
            self.touched = domain.time;
        }
        self.over = size == left
            || domain.time > LONGEST * self.duration
            || domain.time - self.touched > APART * self.duration;
        self.last = size;
        if size > 0.0 {
            self.delivered += size;
            self.speed -= size * self.mobility;
            self.footing.push(domain, self.direction * size);
        }
    }
}

/// The points near a contact and their shares of its force, which sum to 1: Hertz's pressure over a
/// disc of `radius` \[m\], no narrower than the grid can tell.
pub(super) fn disc(domain: &Domain, point: &Vec3, normal: &Vec3, radius: f64) -> Vec<(u32, f64)> {
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
