//! What is checked while a solve runs beside its energy: numbers, momentum and damage.

use super::domain::Domain;
use cullet_geometry::Vec3;
use cullet_model::Failure;

/// Steps between checks.
pub const CHECK_PERIOD: u64 = 64;

/// Momentum that nothing gave, over what the nodes carry, above which it is reported \[1\]:
/// rounding in f32 comes to 10⁻⁵.
const DRIFT: f64 = 1e-3;

/// Rounding of a sum of damage \[1\].
const ROUNDING: f64 = 1e-9;

/// Points that broke before the wave had come so near are ahead of sound (F06): times its way.
const AHEAD: f64 = 1.1;

/// And cells more, by which a contact is wider than its disc.
const REACH: f64 = 3.0;

/// What the checks have found so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    damage: f64,
    drift: f64,
    healed: u32,
}

impl Diagnostics {
    /// Checks a body that was given that momentum \[N·s\]; `None` in a turning frame, whose own
    /// forces give some.
    ///
    /// # Errors
    /// A number that is none (F76).
    pub fn check(&mut self, domain: &Domain, given: Option<Vec3>) -> Result<(), Failure> {
        if !domain.is_finite() {
            let step = domain.steps;
            return Err(Failure::NotFinite { what: "position or velocity", step });
        }
        if let Some(momentum) = given {
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
