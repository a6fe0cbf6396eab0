//! How the solve of treated glass ends.

use super::preconditions::ThinBody;
use super::{ShellSolve, laminated, toughened};
use cullet_model::{Failure, Fragmentation, Refusal, Treatment};
use cullet_simd::Real;

impl<R: Real, const N: usize> ShellSolve<R, N> {
    /// What comes of it, by what was done to the glass.
    pub(super) fn finish_treated(&mut self) -> Result<Fragmentation, Failure> {
        match self.nature.treatment {
            Some(Treatment::Toughened { surface_stress }) if self.is_dicing() => {
                toughened::finish(self, surface_stress)
            }
            Some(Treatment::Laminated { interlayer }) => laminated::finish(self, &interlayer),
            _ => self.finish(),
        }
    }
}

/// Refuses a treatment that is none, or that the family does not know.
pub(super) fn check(treatment: Option<&Treatment>, body: &ThinBody) -> Result<(), Refusal> {
    if let (Some(Treatment::Toughened { .. }), ThinBody::Wall(_)) = (treatment, body) {
        let lack = "toughened glass dices as flat plates only".to_owned();
        return Err(Refusal::Unfit { solver: "shell", lack });
    }
    for (what, value, low, high) in treatment.iter().flat_map(|treatment| treatment.bounds()) {
        if !(low..=high).contains(&value) {
            return Err(Refusal::OutOfRange { what, value, low, high });
        }
    }
    match treatment {
        None
        | Some(
            Treatment::HeatStrengthened { .. }
            | Treatment::Toughened { .. }
            | Treatment::Laminated { .. },
        ) => Ok(()),
        Some(other) => Err(Refusal::Unknown { solver: "shell", what: "a law", kind: other.kind() }),
    }
}
