//! The spacings at which one hit is solved, coarsest first: the finer one only where the coarser
//! two still differ by more than the scene allows.

use cullet_proto::BrokenBody;
use cullet_world::fidelity::{Figures, Plan, estimate};
use std::collections::VecDeque;

/// Spacings fall by this from one solve to the next: each costs sixteen times the one before.
const STEP: f64 = 2.0;

/// Spacings over the plan's below which a coarser solve is not worth its while.
const NEAR: f64 = 1.5;

/// What is left to solve of a hit, and what the last solve came to.
#[derive(Clone, Debug, Default)]
pub(super) struct Ladder {
    left: VecDeque<f64>,
    last: Option<Figures>,
    error: f64,
}

impl Ladder {
    /// From the coarsest that the body bears to the plan's spacing; without an error that is good
    /// enough the plan's alone. A single coarser one would have nothing to be compared with.
    pub(super) fn new(plan: &Plan, error: Option<f64>) -> Self {
        let coarser = std::iter::successors(Some(plan.coarsest), |h| Some(h / STEP));
        let coarser = coarser.take_while(|&h| error.is_some() && h > NEAR * plan.spacing);
        let mut left: VecDeque<f64> = coarser.collect();
        if left.len() < 2 {
            left.clear();
        }
        left.push_back(plan.spacing);
        Self { left, last: None, error: error.unwrap_or(0.0) }
    }

    /// The next spacing \[m\]; none where no plan was made or all are done.
    pub(super) fn climb(&mut self) -> Option<f64> {
        self.left.pop_front()
    }

    /// Whether finer solves could follow the one at hand.
    pub(super) fn goes_on(&self) -> bool {
        !self.left.is_empty()
    }

    /// Why the outcome is not good enough yet, if so; nothing after the last.
    pub(super) fn wants_more(&mut self, outcome: Option<&BrokenBody>) -> Option<String> {
        if !self.goes_on() {
            return None;
        }
        let Some(now) = outcome.map(figures) else {
            self.last = None;
            return Some("it did not come to an end on this grid".to_owned());
        };
        let Some(last) = self.last.replace(now) else {
            return Some("nothing to compare it with".to_owned());
        };
        let (error, limit) = (estimate(&last, &now), self.error);
        (error > limit).then(|| format!("its error is about {error:.2}, over {limit}"))
    }
}

fn figures(broken: &BrokenBody) -> Figures {
    let volumes = broken.fragments.iter().map(|part| part.solid.mesh.signed_volume());
    let whole: f64 = volumes.clone().sum();
    let largest = volumes.fold(0.0, f64::max);
    let report = &broken.report;
    Figures { spacing: report.spacing, crack_area: report.crack_area, largest: largest / whole }
}

#[cfg(test)]
mod tests {
    use super::Ladder;
    use cullet_world::fidelity::{Bound, Plan, Regime};

    fn plan(coarsest: f64) -> Plan {
        Plan {
            regime: Regime::Dynamic,
            ratio: 1.0,
            duration: 1e-4,
            rate: 1e3,
            size: 5e-3,
            count: 100.0,
            spacing: 1e-3,
            coarsest,
            bound: Bound::Error,
            points: 1e4,
            steps: 500.0,
            cost: 1.0,
            error: 0.1,
        }
    }

    #[test]
    fn coarser_solves_come_first_where_the_body_has_room_for_them() {
        let all = |mut ladder: Ladder| {
            let mut spacings = Vec::new();
            while let Some(h) = ladder.climb() {
                spacings.push(h);
            }
            spacings
        };
        assert_eq!(all(Ladder::new(&plan(8e-3), Some(0.1))), [8e-3, 4e-3, 2e-3, 1e-3]);
        assert_eq!(all(Ladder::new(&plan(5e-3), Some(0.1))), [5e-3, 2.5e-3, 1e-3]);
        assert_eq!(all(Ladder::new(&plan(2.9e-3), Some(0.1))), [1e-3]);
        assert_eq!(all(Ladder::new(&plan(1.0), None)), [1e-3]);
        assert!(all(Ladder::default()).is_empty());
    }

    #[test]
    fn a_solve_that_failed_is_followed_by_a_finer_one_and_the_last_is_final() {
        let mut ladder = Ladder::new(&plan(5e-3), Some(0.1));
        ladder.climb();
        assert!(ladder.wants_more(None).is_some_and(|why| why.contains("did not come to an end")));
        ladder.climb();
        assert!(ladder.wants_more(None).is_some());
        ladder.climb();
        assert_eq!(ladder.wants_more(None), None);
    }
}
