//! What a wall is made of, beside its elasticity and its strength.

use cullet_model::{BrittleProblem, Hardening, Law, Problem, Refusal, Treatment};

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
        if !matches!(problem.law, Law::Yielding { .. }) {
            let (problem, treatment) = BrittleProblem::treated(problem, solver)?;
            return Ok((problem, Self { treatment, hardening: None }));
        }
        let (problem, flow) = BrittleProblem::yielding(problem, solver)?;
        Ok((problem, Self { treatment: None, hardening: Some(flow.hardening) }))
    }
}
