//! What a wall is made of, beside its elasticity and its strength.

use cullet_model::{BrittleProblem, Hardening, Law, Problem, Refusal};
use cullet_model::{StrengthField, Treatment};

/// What was done to its glass, or how its metal yields.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WallNature {
    pub(super) treatment: Option<Treatment>,
    pub(super) hardening: Option<Hardening>,
}

impl WallNature {
    /// The problem, for the family `solver`, and what its law has beside a material and a strength.
    ///
    /// # Errors
    /// A law or a body that the family does not know, or the bound that a number breaks.
    pub(super) fn of(
        problem: Problem,
        solver: &'static str,
    ) -> Result<(BrittleProblem, Self), Refusal> {
        let Law::Yielding { material, hardening } = problem.law else {
            let (problem, treatment) = BrittleProblem::treated(problem, solver)?;
            return Ok((problem, Self { treatment, hardening: None }));
        };
        for (what, value, low, high) in hardening.bounds() {
            if !(low..=high).contains(&value) {
                return Err(Refusal::OutOfRange { what, value, low, high });
            }
        }
        // It does not crack.
        let law = Law::Brittle { material, strength: StrengthField::even() };
        let problem = BrittleProblem::of(Problem { law, ..problem }, solver)?;
        Ok((problem, Self { treatment: None, hardening: Some(hardening) }))
    }
}
