//! How long a brittle solve goes on, and what happens when.

use crate::mpm::spin::Spin;
use cullet_geometry::Vec3;
use cullet_model::BrittleProblem;
use cullet_model::brittle::{AFTER_TRANSITS, PUSH_TRANSITS};
use cullet_model::hertz_contact;
use std::collections::VecDeque;

/// Transits without growth, after the push, that end the solve (F24).
const QUIET_TRANSITS: f64 = 2.5;

/// Transits over which the stress of a body's spin is put on, smoothly: two or three periods of its
/// slowest stretching, so that it does not swing (`spin_pulls_a_bar_apart_in_the_middle`).
const SPIN_TRANSITS: f64 = 4.0;

/// Share of the points that must break to count as growth: less is the opening of old cracks.
const GROWTH_SHARE: f64 = 2e-3;

/// Share of the points that must be broken for a solve to end because little breaks: where a body
/// is crushed a crack more or less matters little, elsewhere a single one that runs on may part it,
/// however few points it breaks.
const CRUSHED: f64 = 0.25;

/// How long a solve goes on, in transits L/c_s \[1\]: the levers that `benches/levers.rs` measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerminationCriteria {
    /// A longer push is shortened to this.
    pub push: f64,
    /// Without growth after the push, until the end.
    pub quiet: f64,
    /// After the push, until the end in any case.
    pub after: f64,
}

impl Default for TerminationCriteria {
    fn default() -> Self {
        Self { push: PUSH_TRANSITS, quiet: QUIET_TRANSITS, after: AFTER_TRANSITS }
    }
}

/// When the push ends and when the solve does \[s\]; the push begins at 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Schedule {
    pub(super) transit: f64,
    /// How long the stress of the spin is put on before the push.
    pub(super) spin_up: f64,
    pub(super) push: f64,
    pub(super) end: f64,
}

impl Schedule {
    pub(super) fn new(problem: &BrittleProblem, criteria: &TerminationCriteria) -> Self {
        let transit = problem.solid.mesh.diagonal() / problem.material.shear_speed();
        let longest =
            problem.impacts.iter().fold(0.0_f64, |m, i| m.max(hertz_contact::duration(i)));
        let push = longest.min(criteria.push * transit);
        let spins = problem.spin != Vec3::zeros();
        let spin_up = if spins { SPIN_TRANSITS * transit } else { 0.0 };
        Self { transit, spin_up, push, end: push + criteria.after * transit }
    }

    /// The turning frame at `time` \[s\]: before the push its forces grow as 3s² − 2s³, and motion
    /// is damped within a transit.
    pub(super) fn spin(&self, rate: Vec3, time: f64) -> Spin {
        let s = 1.0 + time / self.spin_up;
        let onset = (time < 0.0).then(|| (s * s * (3.0 - 2.0 * s), 1.0 / self.transit));
        Spin { rate, onset }
    }
}

/// How cracks grow, by the points that have broken.
#[derive(Debug, Default)]
pub(super) struct CrackActivity {
    /// When there was some last \[s\].
    pub(super) last: f64,
    /// How many were broken then.
    then: u32,
    /// How many were broken at each step of the last transit, and at the one before those \[s\].
    past: VecDeque<(f64, u32)>,
    /// Whether `past` goes back a transit.
    is_long: bool,
}

impl CrackActivity {
    /// Notes that `broken` of `points` are by a time \[s\]; `transit` \[s\] is L/c_s.
    pub(super) fn note(&mut self, time: f64, broken: u32, points: f64, transit: f64) {
        if f64::from(broken - self.then) > GROWTH_SHARE * points {
            self.last = time;
            self.then = broken;
        }
        self.past.push_back((time, broken));
        while self.past.get(1).is_some_and(|step| step.0 <= time - transit) {
            self.past.pop_front();
            self.is_long = true;
        }
    }

    /// Whether the body is crushed, and what broke within the last transit is at most this share of
    /// all that has broken.
    pub(super) fn is_small(&self, share: f64, points: f64) -> bool {
        let (Some(&(_, then)), Some(&(_, now))) = (self.past.front(), self.past.back()) else {
            return false;
        };
        let crushed = f64::from(now) >= CRUSHED * points;
        self.is_long && crushed && f64::from(now - then) <= share * f64::from(now)
    }
}
