//! How fast the waves of a body are. A film's real waves take ten million steps for a few seconds;
//! a declared pace takes fewer, and what it costs is reported.

use cullet_model::sheet_check::MOST_CRITICAL;
use cullet_model::{MembraneLaw, MembranePace, Refusal};

/// What a pace makes of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkingPace {
    /// E that is worked with \[Pa\].
    pub young: f64,
    /// Inertia over mass \[1\].
    pub inertia: f64,
    /// √(E/ρ) that is worked with \[m/s\].
    pub speed: f64,
    /// Factor on all stretches at which something happens: √(E real / E worked with) \[1\].
    pub stretches: f64,
}

impl WorkingPace {
    /// Of a material with this Young's modulus \[Pa\] and density \[kg/m³\].
    ///
    /// # Errors
    ///
    /// If the speed is no positive number.
    pub fn new(young: f64, density: f64, pace: MembranePace) -> Result<Self, Refusal> {
        let real = (young / density).sqrt();
        let whole = Self { young, inertia: 1.0, speed: real, stretches: 1.0 };
        let (MembranePace::Softer(speed) | MembranePace::Heavier(speed)) = pace else {
            return Ok(whole);
        };
        if speed.is_nan() || speed <= 0.0 {
            let what = "the working wave speed [m/s]";
            return Err(Refusal::OutOfRange { what, value: speed, low: 1e-3, high: real });
        }
        // A body that is slower already stays as it is.
        if speed >= real {
            return Ok(whole);
        }
        Ok(match pace {
            MembranePace::Heavier(_) => {
                Self { inertia: real * real / (speed * speed), speed, ..whole }
            }
            _ => Self { young: density * speed * speed, speed, stretches: real / speed, ..whole },
        })
    }

    /// That a softer sheet breaks at strains that its law holds for.
    ///
    /// # Errors
    ///
    /// If paper or foil would be stretched by more than a tenth.
    pub fn admits(&self, law: MembraneLaw, critical: f64) -> Result<(), Refusal> {
        let soft = self.stretches > 1.0 && law != MembraneLaw::Rubber;
        if soft && critical > MOST_CRITICAL {
            let what = "the critical stretch of a sheet at this pace";
            return Err(Refusal::OutOfRange {
                what,
                value: critical,
                low: 0.0,
                high: MOST_CRITICAL,
            });
        }
        Ok(())
    }
}
