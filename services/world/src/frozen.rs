//! Do places follow velocities (F42)?

use crate::motion::{Motion, least_speed};
use cullet_geometry::Vec3;
use std::collections::BTreeMap;

/// Bodies slower than this are not looked at: what rests may jitter \[m/s\].
const FAST: f64 = 1.0;
/// A body that moves less than this share of what its velocity says has not followed it \[1\].
const SHARE: f64 = 0.2;
/// One that has not for so many steps on end is frozen. A hit takes one step, in which the place is
/// that of the first touch, and a second one in which the engine changes the velocity.
const STEPS: u32 = 5;

/// What a body moved over the steps in which it did not follow its velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Halt {
    steps: u32,
    moved: Vec3,
    /// What it should have moved \[m\].
    due: Vec3,
}

/// The bodies that do not follow their velocities just now.
#[derive(Debug, Default)]
pub(crate) struct Frozen(BTreeMap<u32, Halt>);

impl Frozen {
    /// Looks at one body over a step of that many \[s\]. If it is frozen: what it moved over the
    /// last [`STEPS`] steps or more, and what it should have \[m\].
    ///
    /// Over the steps the velocities must agree in sum, too: a body that is shaken does not count.
    pub(crate) fn look(
        &mut self,
        id: u32,
        before: &Motion,
        after: &Motion,
        step: f64,
    ) -> Option<(f64, f64)> {
        let mean = (before.velocity + after.velocity) / 2.0;
        let speed = least_speed(before, after);
        let moved = after.centre() - before.centre();
        // Also where something is not a number.
        if !(speed > FAST && moved.norm() < SHARE * speed * step) {
            self.0.remove(&id);
            return None;
        }
        let halt = self.0.entry(id).or_default();
        halt.steps += 1;
        halt.moved += moved;
        halt.due += mean * step;
        let (moved, due) = (halt.moved.norm(), halt.due.norm());
        let fast = due > FAST * step * f64::from(halt.steps);
        (halt.steps >= STEPS && fast && moved < SHARE * due).then_some((moved, due))
    }

    /// Forgets all but these.
    pub(crate) fn keep(&mut self, stays: impl Fn(u32) -> bool) {
        self.0.retain(|&id, _| stays(id));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_geometry::Pose;

    const STEP: f64 = 1.0 / 240.0;

    fn motion(x: f64, v: f64) -> Motion {
        let pose = Pose::translation(x, 0.0, 0.0);
        Motion { pose, velocity: Vec3::x() * v, spin: Vec3::zeros() }
    }

    /// At which of the steps a body is frozen that moves so far \[m\] with such velocities.
    fn frozen(steps: &[(f64, f64)]) -> Option<usize> {
        let mut found = Frozen::default();
        let (mut x, mut v) = (0.0, steps.first()?.1);
        steps.iter().position(|&(moved, after)| {
            let before = motion(x, v);
            (x, v) = (x + moved, after);
            found.look(3, &before, &motion(x, v), STEP).is_some()
        })
    }

    #[test]
    fn a_body_that_stays_while_its_velocity_runs_on_is_frozen_at_the_fifth_step() {
        assert_eq!(frozen(&[(0.0, 14.0); 9]), Some(4));
        assert_eq!(frozen(&[(0.19 * 1.2 * STEP, 1.2); 9]), Some(4));
    }

    #[test]
    fn what_follows_is_shaken_slow_or_bounces_is_not_frozen() {
        assert_eq!(frozen(&[(14.0 * STEP, 14.0); 9]), None);
        assert_eq!(frozen(&[(0.21 * 14.0 * STEP, 14.0); 9]), None, "it lags");
        assert_eq!(frozen(&[(0.0, 0.9); 9]), None, "slow");
        let shaken: Vec<(f64, f64)> = (0..40).map(|k| (0.0, [5.0, -5.0][k % 2])).collect();
        assert_eq!(frozen(&shaken), None);
        let hits: Vec<(f64, f64)> =
            (0..40).map(|k| if k % 5 == 4 { (5.0 * STEP, 5.0) } else { (0.0, 5.0) }).collect();
        assert_eq!(frozen(&hits), None, "four steps on end are none");
    }

    #[test]
    fn a_motion_that_is_no_number_is_not_this_fault() {
        assert_eq!(frozen(&[(f64::NAN, 14.0), (0.0, f64::NAN), (0.0, 14.0), (0.0, 14.0)]), None);
    }
}
