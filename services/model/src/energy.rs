//! The account of a solve's energy: what it was given against what it holds and what it has spent.

use crate::Failure;

/// Energy that nothing gave, over that of the hits, at which a solve has failed \[1\].
pub const ENERGY_MADE: f64 = 0.02;

/// Energy that is not accounted for, over that of the hits, which is worth a word \[1\].
pub const ENERGY_NOTED: f64 = 0.05;

/// Where the energy of a body that is hit came from and where it is \[J\]: each joule once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyAccount {
    /// Work of strikers, supports and fields on the body, and what it held at first.
    pub given: f64,
    /// Motion.
    pub kinetic: f64,
    /// Elastic strain.
    pub elastic: f64,
    /// Damage and tears.
    pub broken: f64,
    /// Plastic flow.
    pub flowed: f64,
    /// Sides of cracks that met, and rubbed.
    pub met: f64,
    /// Motion that was damped on purpose.
    pub damped: f64,
}

impl EnergyAccount {
    /// What can be told where it is \[J\].
    #[must_use]
    pub fn known_energy(&self) -> f64 {
        self.kinetic + self.elastic + self.broken + self.flowed + self.met + self.damped
    }

    /// What can be told where it is and nothing gave; negative where some is missing \[J\].
    #[must_use]
    pub fn off(&self) -> f64 {
        self.known_energy() - self.given
    }
}

/// How far the account of a solve has been off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Where it was off most, over the energy of the hits \[1\].
    pub off: f64,
}

impl EnergyBalance {
    /// Looks at the account at a step, on the scale of the energy of the hits \[J\].
    ///
    /// # Errors
    /// A sum that is no number (F76); [`ENERGY_MADE`] of the scale that nothing gave.
    pub fn look(&mut self, account: &EnergyAccount, scale: f64, step: u64) -> Result<(), Failure> {
        let off = account.off() / scale;
        if off.is_nan() || !account.known_energy().is_finite() {
            return Err(Failure::NotFinite { what: "energy", step });
        }
        if off.abs() > self.off.abs() {
            self.off = off;
        }
        if off > ENERGY_MADE {
            return Err(Failure::Unstable { ratio: off, step });
        }
        Ok(())
    }

    /// A sentence where the account does not close.
    #[must_use]
    pub fn tell(&self) -> Option<String> {
        let told = self.off.abs() > ENERGY_NOTED;
        told.then(|| format!("energy is off by {:+.3} of what the hits had", self.off))
    }
}

#[cfg(test)]
mod tests {
    use super::{EnergyAccount, EnergyBalance};
    use crate::Failure;

    #[test]
    fn what_is_made_fails_and_what_is_missing_is_told() {
        let account = |kinetic| EnergyAccount {
            given: 10.0,
            kinetic,
            broken: 1.0,
            met: 0.5,
            ..EnergyAccount::default()
        };
        let mut balance = EnergyBalance::default();
        assert_eq!(balance.look(&account(8.69), 10.0, 1), Ok(()));
        assert_eq!(balance.look(&account(8.5), 10.0, 2), Ok(()));
        assert!((balance.off - 0.019).abs() < 1e-12 && balance.tell().is_none());
        let made = balance.look(&account(8.71), 10.0, 3);
        assert!(matches!(made, Err(Failure::Unstable { step: 3, .. })), "{made:?}");
        assert_eq!(balance.look(&account(7.9), 10.0, 4), Ok(()));
        let told = balance.tell().expect("a sentence");
        assert!(told.contains("-0.060"), "{told}");
        let none = balance.look(&account(f64::NAN), 10.0, 5);
        assert!(matches!(none, Err(Failure::NotFinite { step: 5, .. })), "{none:?}");
    }
}
