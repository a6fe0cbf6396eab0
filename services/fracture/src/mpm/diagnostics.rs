//! What is checked while a solve runs: numbers, energy, momentum and damage.

use super::domain::Domain;
use cullet_geometry::Vec3;
use cullet_model::Failure;

/// Steps between checks.
pub const CHECK_PERIOD: u64 = 64;

/// Energy over what the strikers have lost that counts as instability (F04).
pub const GROWTH: f64 = 1.1;

/// Momentum that nothing gave, over what the nodes carry, above which it is reported \[1\]:
/// rounding in f32 comes to 10⁻⁵.
const DRIFT: f64 = 1e-3;

/// Rounding of a sum of damage \[1\].
const ROUNDING: f64 = 1e-9;

/// Points that broke before the wave had come so near are ahead of sound (F06): times its way.
const AHEAD: f64 = 1.1;

/// And cells more, by which a contact is wider than its disc.
const REACH: f64 = 3.0;

/// What a body was given from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Given {
    /// Energy that what pushes it has lost \[J\].
    pub energy: f64,
    /// Momentum; `None` in a turning frame, whose own forces give some \[N·s\].
    pub momentum: Option<Vec3>,
}

/// What the checks have found so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    damage: f64,
    drift: f64,
    healed: u32,
}

impl Diagnostics {
    /// Checks a body that was given so much.
    ///
    /// # Errors
    /// A number that is none (F76); more energy than was given, [`GROWTH`] times (F04).
    pub fn check(&mut self, domain: &Domain, given: &Given) -> Result<(), Failure> {
        let step = domain.steps;
        if !domain.is_finite() {
            return Err(Failure::NotFinite { what: "position or velocity", step });
        }
        let energy = domain.kinetic_energy() + domain.elastic_energy();
        if !energy.is_finite() {
            return Err(Failure::NotFinite { what: "energy", step });
        }
        if energy > GROWTH * given.energy {
            return Err(Failure::Unstable { ratio: energy / given.energy - 1.0, step });
        }
        if let Some(momentum) = given.momentum {
            let carried = domain.traffic().max(momentum.norm());
            let error = (domain.momentum() - momentum).norm();
            self.drift = self.drift.max(if carried > 0.0 { error / carried } else { 0.0 });
        }
        let damage: f64 = domain.particles.damage.iter().sum();
        self.healed += u32::from(damage < self.damage * (1.0 - ROUNDING));
        self.damage = damage;
        Ok(())
    }

    /// What was noticed and let pass, a sentence each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.drift > DRIFT {
            warnings.push(format!(
                "momentum that nothing gave: {:.3} of what the body's parts carry (F10)",
                self.drift
            ));
        }
        if self.healed > 0 {
            warnings.push(format!("damage fell between {} looks (F09)", self.healed));
        }
        warnings
    }
}

/// How many points broke farther from every contact, discs given by middle and radius \[m\], than
/// 1.1 times the way of sound since nought and three cells more, and by how much at most \[m\]
/// (F06).
#[must_use]
pub fn ahead(domain: &Domain, discs: &[(Vec3, f64)], speed: f64) -> (u32, f64) {
    let (particles, reach) = (&domain.particles, REACH * domain.grid.spacing.max());
    let mut found = (0, 0.0_f64);
    for (p, x) in particles.reference.iter().enumerate() {
        if particles.damage[p] < 1.0 {
            continue;
        }
        let of = |(middle, radius): &(Vec3, f64)| (x - middle).norm() - radius;
        let away = discs.iter().map(of).fold(f64::INFINITY, f64::min);
        let lead = away - AHEAD * speed * particles.damage_time[p] - reach;
        if lead > 0.0 {
            found = (found.0 + 1, found.1.max(lead));
        }
    }
    found
}
