//! Model no more than a scene needs: can this hit crack anything, and does it need a solver?
//!
//! Gate 1 asks energy, gate 2 asks stress. Both err on the side of solving: only what cannot crack
//! is `Rigid`.

use crate::reason::RigidReason;
use cullet_geometry::Vec3;
use cullet_model::Material;
use cullet_world::{BodyMeasure, BodyView, DURATION_OVER_APPROACH, Hit};

/// What to do about a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gate {
    /// Nothing can crack: leave the body whole.
    Rigid(RigidReason),
    /// It may crack, but does not deserve a solver: geometric pieces will do.
    Geometric(RigidReason),
    /// Solve it.
    Solve,
}

/// Where the gates stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GateLimits {
    /// η: share of the approach energy that may become crack \[1\]; one is the hard upper bound.
    pub efficiency: f64,
    /// Below this share of σ_f nothing cracks \[1\]: a half, because radii and contact sizes are
    /// estimates.
    pub safety: f64,
    /// Bodies of a later generation get geometric pieces.
    pub solve_generation: u32,
    /// Bodies of a smaller share of the original get geometric pieces \[1\].
    pub solve_volume_ratio: f64,
}

/// η of scenes that ask for a fidelity \[1\]: the upper end of the catalogue's 0.05 to 0.3
/// [Gate 1]. Bricks of `scenes/wall` that broke had at least 8 times the energy of their smallest
/// section; other scenes were not counted.
const FITTED: f64 = 0.3;

impl GateLimits {
    /// Where a scene asks for a fidelity: η as it is found, not its hard bound. `share`: of the
    /// energy of all the hits that reach the body at once \[1\].
    #[must_use]
    pub fn fitted(share: f64) -> Self {
        Self { efficiency: (FITTED / share).min(1.0), ..Self::default() }
    }
}

impl Default for GateLimits {
    fn default() -> Self {
        Self { efficiency: 1.0, safety: 0.5, solve_generation: 1, solve_volume_ratio: 0.05 }
    }
}

/// Share of the strength below which the stress of a spin does not matter \[1\] (F12).
const STRESSING_SPIN: f64 = 0.05;

/// Estimates of the greatest tension that a hit makes \[Pa\].
struct Stress {
    contact: f64,
    bending: f64,
    wave: f64,
    spin: f64,
}

/// Hertz's greatest force of a hit \[N\] and approach \[m\]: δ = v t_c / 2.943;
/// ½ m* v² = (2/5) F δ.
pub(crate) fn hertz(hit: &Hit) -> (f64, f64) {
    let approach = hit.impact.closing_speed * hit.impact.duration / DURATION_OVER_APPROACH;
    (2.5 * hit.impact.energy / approach, approach)
}

/// Greatest stress \[Pa\] of a body that `force` \[N\] bends over a contact of `radius` \[m\].
pub(crate) fn bending(force: f64, radius: f64, poisson: f64, body: &BodyMeasure) -> f64 {
    let t = body.thickness;
    // Small loads act over r₀' = √(1.6 r² + t²) − 0.675 t on a plate  [Roark]
    let spread =
        if radius < 0.5 * t { (1.6 * radius * radius + t * t).sqrt() - 0.675 * t } else { radius };
    let reach = libm::log((body.length / spread).max(1.0));
    // σ = (3F / 2πt²) [(1 + ν) ln(2b/πr₀') + β], with L for 2b and 1 for β
    let pi = std::f64::consts::PI;
    let plate = 1.5 * force / (pi * t * t) * ((1.0 + poisson) * reach + 1.0);
    // σ = F L c / 4 I → 6 F L / 4 b t² for a beam of section b t
    let beam = 1.5 * force * body.length / (body.section.max(t * t) * t);
    plate.max(beam)
}

fn stress(hit: &Hit, material: &Material, body: &BodyMeasure) -> Stress {
    let (radius, speed) = (hit.impact.radius, hit.impact.closing_speed);
    let poisson = material.poisson;
    let (force, _) = hertz(hit);
    let pi = std::f64::consts::PI;
    // σ_r = (1 − 2ν) p₀ / 3, p₀ = 3F / 2πa²  [accuracy H1]
    let rim = (1.0 - 2.0 * poisson) * force / (2.0 * pi * radius * radius);
    // The field is only about a/10 deep: σ √(a/10) cannot beat √(E G_f), so a shallow one counts
    // for less [Gate 2].
    let depth = 0.1 * radius;
    let process = material.young * material.fracture_energy
        / (material.failure_stress * material.failure_stress);
    let contact = rim * (depth / process.max(depth)).sqrt();
    Stress {
        contact,
        bending: bending(force, radius, poisson, body),
        // σ = ρ c v with a rigid striker, the upper bound of ρ c v / (1 + Z₁/Z₂)
        wave: (material.young * material.density).sqrt() * speed,
        // σ = (3 + ν)/8 ρω²R² in the middle of a disc
        spin: 0.125
            * (3.0 + poisson)
            * material.density
            * (0.5 * hit.spin * body.length).norm_squared(),
    }
}

/// Can the hit crack the body, and does it need a solver?
#[must_use]
pub fn gate(hit: &Hit, material: &Material, body: &BodyMeasure, limits: &GateLimits) -> Gate {
    let Stress { contact, bending, wave, spin } = stress(hit, material, body);
    let strength = body.weakest * material.failure_stress;
    let least = limits.safety * strength;
    // A_max = η E_n / G_f  [Gate 1]; what a spin has stored comes on top.
    let affordable = limits.efficiency * hit.impact.energy / material.fracture_energy;
    if affordable < body.section && spin < least {
        let (efficiency, section) = (limits.efficiency, body.section);
        return Gate::Rigid(RigidReason::Energy { efficiency, affordable, section });
    }
    let greatest = contact.max(bending).max(wave) + spin;
    if greatest < least {
        return Gate::Rigid(RigidReason::Stress {
            stress: greatest,
            strength,
            safety: limits.safety,
        });
    }
    if body.generation > limits.solve_generation {
        let (generation, limit) = (body.generation, limits.solve_generation);
        return Gate::Geometric(RigidReason::Generation { generation, limit });
    }
    if body.volume_ratio < limits.solve_volume_ratio {
        let (ratio, limit) = (body.volume_ratio, limits.solve_volume_ratio);
        return Gate::Geometric(RigidReason::Size { ratio, limit });
    }
    Gate::Solve
}

/// The spin \[rad/s\] of a body when these hits began, in its own frame, if its stress ρω²R² is
/// more than a twentieth of the strength (F12); else zero.
#[must_use]
pub fn stressing_spin(body: &BodyView<'_>, hits: &[Hit]) -> Vec3 {
    let Some(hit) = hits.iter().min_by(|a, b| a.time.total_cmp(&b.time)) else {
        return Vec3::zeros();
    };
    let speeds = body.solid.mesh.vertices.iter().map(|x| hit.spin.cross(x).norm_squared());
    let stress = body.material.solid.density * speeds.fold(0.0, f64::max);
    let strength = body.weakest * body.material.solid.failure_stress;
    if stress > STRESSING_SPIN * strength { hit.spin } else { Vec3::zeros() }
}
