//! What can be told of a sheet before its points are made: numbers out of bounds, too many points,
//! a state that is too large, a pace at which strains would be too large.

use crate::membrane::{
    MOST_QUANTITIES, MembraneLaw, MembranePace, MembraneSheet, SheetDiffusion, SheetSource,
    SheetSourceKind,
};
use crate::refusal::Refusal;

/// Most points of a sheet.
pub const MOST_SHEET_POINTS: f64 = 1e5;
/// Largest state of a body that is simulated in windows \[bytes\] (F96m).
pub const MAX_STATE: u64 = 64 << 20;
/// Greatest strain by what a sheet takes up: beyond it bonds would be half or one and a half times
/// as long \[1\].
pub const MOST_SWELLING: f64 = 0.5;
/// Greatest s_c of a softer sheet: above it strains are no longer those of paper or foil \[1\]
/// (F92m).
pub const MOST_CRITICAL: f64 = 0.1;
/// How far ν of rubber may be from the 1/3 that its bonds have by nature.
const RUBBER_POISSON: f64 = 0.05;
/// s_c of the bonds that are there over that of the continuum is above this \[1\].
const DISCRETE: f64 = 0.9;

/// Something in a sheet's numbers that does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetFault {
    /// The key of a scene that it is at, below the sheet: `pace.softer`, `diffusion.0.source.2`.
    pub key: String,
    /// What does not hold, with the bound.
    pub refusal: Refusal,
}

impl MembraneSheet {
    /// That its numbers hold, as far as that is known before its points are made.
    ///
    /// # Errors
    ///
    /// The first of [`MembraneSheet::faults`].
    pub fn check(&self) -> Result<(), Refusal> {
        match self.faults().into_iter().next() {
            Some(fault) => Err(fault.refusal),
            None => Ok(()),
        }
    }

    /// All that does not hold in its numbers.
    #[must_use]
    pub fn faults(&self) -> Vec<SheetFault> {
        let mut faults = Vec::new();
        self.check_bounds(&mut faults);
        // What follows is worked out from numbers that hold.
        if faults.is_empty() {
            self.check_sizes(&mut faults);
            self.check_pace(&mut faults);
            self.check_quantities(&mut faults);
        }
        faults
    }

    fn check_bounds(&self, faults: &mut Vec<SheetFault>) {
        let material = ["material"; 5].into_iter().chain(["scatter", "bending_floor", "damping"]);
        let bounds = material.zip(self.material.bounds());
        let ([gusts, rate], base) = (self.air.gusts, self.foundation.unwrap_or(0.0));
        let own = [
            ("thickness", ("thickness of a sheet [m]", self.thickness, 1e-9, 1.0)),
            ("spacing", ("spacing of a sheet's points [m]", self.spacing, 1e-6, 10.0)),
            ("foundation", ("stiffness of a sheet's base [Pa/m]", base, 0.0, 1e12)),
            ("air.density", ("density of the air [kg/m³]", self.air.density, 0.0, 1e4)),
            ("air.drag", ("drag of a sheet [1]", self.air.drag, 0.0, 1e3)),
            ("air.gusts", ("greatest gust over the wind [1]", gusts, 0.0, 1e3)),
            ("air.gust_rate", ("gusts in a second [1/s]", rate, 0.0, 1e6)),
        ];
        for (key, (what, value, low, high)) in bounds.chain(own) {
            if value.is_nan() || value < low || value > high {
                faults.push(fault(key, Refusal::OutOfRange { what, value, low, high }));
            }
        }
        let (nu, third) = (self.material.poisson, 1.0 / 3.0);
        if self.material.law == MembraneLaw::Rubber && (nu - third).abs() > RUBBER_POISSON {
            let refusal = Refusal::OutOfRange {
                what: "Poisson's ratio of a rubber sheet, whose bonds give 1/3 by nature",
                value: nu,
                low: third - RUBBER_POISSON,
                high: third + RUBBER_POISSON,
            };
            faults.push(fault("material", refusal));
        }
    }

    /// Points, and the bytes of a state in which every bond was touched.
    fn check_sizes(&self, faults: &mut Vec<SheetFault>) {
        let next = self.outline.iter().cycle().skip(1);
        let twice: f64 =
            self.outline.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
        let points = 0.5 * twice.abs() / (self.spacing * self.spacing);
        let limit = MOST_SHEET_POINTS;
        if points.is_nan() || points > limit {
            let what = "the points of a sheet";
            faults.push(fault("spacing", Refusal::TooLarge { what, value: points, limit }));
            return;
        }
        let (value, limit) = (points * self.bytes_by_point(), MAX_STATE as f64);
        if value > limit {
            let what = "the bytes of a sheet's state once each of its bonds has been touched";
            faults.push(fault("spacing", Refusal::TooLarge { what, value, limit }));
        }
    }

    /// Bytes of a state by point: place and velocity, piece, what it has taken up, and for each
    /// bond a mark and what it remembers.
    fn bytes_by_point(&self) -> f64 {
        let takes_up = 16.0 * self.diffusion.all.len() as f64;
        let memory = if self.material.law == MembraneLaw::Foil { 24.0 } else { 8.0 };
        let bonds = 0.5 * std::f64::consts::PI * self.horizon * self.horizon;
        52.0 + takes_up + bonds * (0.125 + memory)
    }

    /// s_c = √(2πGh/Mδ), with M = 3Eh or 8μh as bonds are fitted to, at the pace's E.
    fn check_pace(&self, faults: &mut Vec<SheetFault>) {
        let material = &self.material;
        let real = (material.young / material.density).sqrt();
        let (MembranePace::Softer(speed) | MembranePace::Heavier(speed)) = self.pace else {
            return;
        };
        let key = match self.pace {
            MembranePace::Softer(_) => "pace.softer",
            _ => "pace.heavier",
        };
        if speed.is_nan() || speed <= 0.0 {
            let what = "the working wave speed of a sheet [m/s]";
            let refusal = Refusal::OutOfRange { what, value: speed, low: 1e-3, high: real };
            faults.push(fault(key, refusal));
            return;
        }
        let softer = matches!(self.pace, MembranePace::Softer(_)) && speed < real;
        if !softer || material.law == MembraneLaw::Rubber {
            return;
        }
        let young = material.density * speed * speed;
        let modulus = 4.0 * young / (1.0 + material.poisson);
        let horizon = self.horizon * self.spacing;
        let work = 2.0 * std::f64::consts::PI * material.fracture_energy;
        let value = DISCRETE * (work / (modulus * horizon)).sqrt();
        if value > MOST_CRITICAL {
            let what = "the critical stretch of a sheet at this pace";
            let refusal = Refusal::OutOfRange { what, value, low: 0.0, high: MOST_CRITICAL };
            faults.push(fault(key, refusal));
        }
    }

    /// That there are not too many quantities, that one of them is shown, and of each what
    /// [`check_swelling`] holds; that the sheet does not begin with more than half its dry mass of
    /// them.
    fn check_quantities(&self, faults: &mut Vec<SheetFault>) {
        let quantities = &self.diffusion;
        let count = quantities.all.len();
        if count > MOST_QUANTITIES {
            let (what, limit) = ("the quantities that spread in a sheet", MOST_QUANTITIES as f64);
            let refusal = Refusal::TooLarge { what, value: count as f64, limit };
            faults.push(fault("diffusion", refusal));
        }
        let unfit = |lack: &str| Refusal::Unfit { solver: "membrane", lack: lack.to_owned() };
        if quantities.shown as usize >= count.max(1) {
            faults.push(fault("diffusion", unfit("the quantity that it shows is not there")));
        }
        let mut carried = 0.0;
        for (number, what) in quantities.all.iter().enumerate() {
            if (0..number).any(|before| quantities.name(before) == quantities.name(number)) {
                let refusal = unfit("two quantities that spread in it have the same name");
                faults.push(fault(&format!("diffusion.{number}.name"), refusal));
            }
            check_swelling(what, number, faults);
            let half = 0.5 * self.material.density;
            let before = carried;
            carried += what.weight * what.start;
            if carried > half && before <= half {
                let refusal = unfit("at its start it would hold more than half its dry mass");
                faults.push(fault(&format!("diffusion.{number}.start"), refusal));
            }
        }
    }
}

/// That nothing that is known to come in swells or shrinks a sheet too much by itself.
fn check_swelling(what: &SheetDiffusion, quantity: usize, faults: &mut Vec<SheetFault>) {
    let mut hold = |key: String, theta: f64| {
        let value = what.swelling(theta);
        if value.abs() > MOST_SWELLING {
            let what = "the strain by what a sheet takes up";
            let (low, high) = (-MOST_SWELLING, MOST_SWELLING);
            let refusal = Refusal::OutOfRange { what, value, low, high };
            faults.push(SheetFault { key, refusal });
        }
    };
    // What is beyond saturation runs off.
    let most = what.saturation.max(what.start);
    let held = |source: &SheetSource| match source.kind {
        SheetSourceKind::Held(value)
        | SheetSourceKind::Film(value, _)
        | SheetSourceKind::Contact { towards: value, .. } => Some(value.min(most)),
        SheetSourceKind::Flux(_) => None,
    };
    for (number, source) in what.sources.iter().enumerate() {
        if let Some(theta) = held(source) {
            hold(format!("diffusion.{quantity}.source.{number}"), theta);
        }
    }
    if what.loss > 0.0 {
        hold(format!("diffusion.{quantity}.ambient"), what.ambient);
    }
}

impl SheetDiffusion {
    /// The strain along x and y at a value of θ \[1\].
    #[must_use]
    pub fn strains(&self, theta: f64) -> [f64; 2] {
        self.expansion.map(|by| by * (theta - self.start))
    }

    /// The strain at a value of θ along the direction in which it is greater \[1\].
    #[must_use]
    pub fn swelling(&self, theta: f64) -> f64 {
        greater(self.strains(theta))
    }
}

/// The greater of two strains, whatever their signs \[1\].
#[must_use]
pub fn greater([along, across]: [f64; 2]) -> f64 {
    if along.abs() >= across.abs() { along } else { across }
}

fn fault(key: &str, refusal: Refusal) -> SheetFault {
    SheetFault { key: key.to_owned(), refusal }
}

#[cfg(test)]
mod tests;
