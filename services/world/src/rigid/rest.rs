//! Which bodies rest, so that the engine may let them sleep.
//!
//! A body rests where what touches it carries all that pulls at it. Then it is slow, and it does
//! not become faster: over a quarter of a window it moves as far as over the quarter before, but
//! for a small share of what its load alone would make of the difference. A body in free flight,
//! at its apex, on a slope that it slides down or past its balance fails that however slow it is,
//! and one that nothing pulls at rests only if it does not move at all.

use super::convert::{pose, vec3};
use crate::motion::Motion;
use cullet_geometry::{Pose, Vec3};
use rapier3d_f64::prelude::RigidBody;
use std::collections::VecDeque;

/// How long a body must have rested before it may sleep \[s\].
const WINDOW: f64 = 0.5;
/// Parts of it over which motions are compared.
const QUARTERS: usize = 4;
/// Greatest speed of a point of a body that rests, as a share of that which it would have fallen
/// over its own reach \[1\]: v² against a·r.
const SPEED_SHARE: f64 = 0.02;
/// The same of its mean over a quarter of a window: a heap creeps, and what moves on goes on \[1\].
const CREEP_SHARE: f64 = 2e-3;
/// Greatest acceleration of a point of a body that rests, as a share of that of its load \[1\].
const LOAD_SHARE: f64 = 2e-4;

/// Where a body has been since it is slow.
#[derive(Clone, Debug, Default)]
pub(super) struct Stillness {
    /// Steps on end in which it was slow.
    slow: u64,
    /// Its places at the ends of the last quarters of a window.
    places: VecDeque<Pose>,
    /// Whether it rests.
    pub(super) rests: bool,
}

/// What there is to know of a body that may rest.
pub(super) struct StillBody {
    /// Farthest point from its centre \[m\].
    pub(super) reach: f64,
    /// \[kg\]
    pub(super) mass: f64,
    /// \[m/s²\]
    pub(super) gravity: Vec3,
    /// \[s\]
    pub(super) step: f64,
}

/// What a body carries, and how it moved in a step.
struct LoadedMotion {
    /// Acceleration of its load \[m/s²\].
    load: f64,
    /// Farthest point from its centre \[m\].
    reach: f64,
    now: Pose,
    /// How far its farthest point moved over the step \[m\].
    moved: f64,
    step: f64,
}

impl Stillness {
    /// Looks at one step.
    fn look(&mut self, at: &LoadedMotion) {
        let fastest = SPEED_SHARE * (at.load * at.reach).sqrt();
        // Without a load only what does not move at all rests.
        if at.moved > fastest * at.step {
            *self = Self::default();
            return;
        }
        let quarter = (WINDOW / QUARTERS as f64 / at.step).round().max(1.0);
        if self.slow.is_multiple_of(quarter as u64) {
            self.places.push_back(at.now);
            while self.places.len() > QUARTERS + 1 {
                self.places.pop_front();
            }
            let time = quarter * at.step;
            let moves = self.moves();
            let creeps = CREEP_SHARE * (at.load * at.reach).sqrt() * time;
            let gained = LOAD_SHARE * at.load * time.powi(2);
            self.rests = moves.len() == QUARTERS
                && moves.iter().all(|(way, turn)| way.norm() + at.reach * turn.norm() <= creeps)
                && gain(&moves, at.reach) <= gained;
        }
        self.slow += 1;
    }

    /// How far it came over each quarter \[m\], and how far it turned \[rad\].
    fn moves(&self) -> Vec<(Vec3, Vec3)> {
        let moves = self.places.iter().zip(self.places.iter().skip(1)).map(|(from, to)| {
            let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
            (to.translation.vector - from.translation.vector, turn)
        });
        moves.collect()
    }
}

/// The greatest difference between how far a body's points moved over a quarter and over the one
/// before \[m\].
fn gain(moves: &[(Vec3, Vec3)], reach: f64) -> f64 {
    let gains = moves.windows(2).map(|pair| {
        let [(from, before), (to, after)] = [pair[0], pair[1]];
        (to - from).norm() + reach * (after - before).norm()
    });
    gains.fold(0.0, f64::max)
}

impl Stillness {
    /// Looks whether a body rests after a step, and lets it sleep, or not.
    ///
    /// The engine lets a group of bodies that touch sleep when each of them has been still for
    /// half a second, as it counts. Here it is told.
    pub(super) fn let_sleep(&mut self, body: &mut RigidBody, before: &Motion, of: &StillBody) {
        if !body.is_dynamic() || body.is_sleeping() {
            // What wakes it begins anew.
            *self = Self::default();
            return;
        }
        let now = pose(body.position());
        let turned = vec3(body.angvel()).norm() * of.reach * of.step;
        let moved = (now.translation.vector - before.centre()).norm() + turned;
        let load = (of.gravity + vec3(body.user_force()) / of.mass).norm();
        self.look(&LoadedMotion { load, reach: of.reach, now, moved, step: of.step });
        let activation = body.activation_mut();
        activation.time_since_can_sleep =
            if self.rests { activation.time_until_sleep } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1.0 / 240.0;

    /// Whether a body rests in the end that is at `x(t)` \[m\] for so long \[s\] under a load.
    fn rests(load: f64, time: f64, x: impl Fn(f64) -> f64) -> bool {
        let mut rest = Stillness::default();
        for k in 1..=(time / STEP) as u32 {
            let [before, after] = [k - 1, k].map(|k| x(f64::from(k) * STEP));
            let now = Pose::translation(after, 0.0, 0.0);
            let moved = (after - before).abs();
            rest.look(&LoadedMotion { load, reach: 0.1, now, moved, step: STEP });
        }
        rest.rests
    }

    #[test]
    fn what_lies_still_or_jitters_rests() {
        assert!(rests(9.81, 0.6, |_| 0.0));
        assert!(!rests(9.81, 0.4, |_| 0.0), "too short");
        assert!(rests(9.81, 0.6, |t| 1e-5 * (700.0 * t).sin()), "jitter");
        assert!(rests(9.81, 0.6, |t| 1e-3 * t), "the slow creep of a heap");
        assert!(rests(0.0, 0.6, |_| 0.2), "nothing pulls and nothing moves");
    }

    #[test]
    fn what_flies_swings_slides_or_tips_does_not() {
        assert!(!rests(9.81, 0.6, |t| 0.5 * 9.81 * (t - 0.3) * (t - 0.3)), "at its apex");
        assert!(!rests(0.0, 5.0, |t| 1e-6 * t), "it drifts where nothing pulls");
        assert!(!rests(9.81, 5.0, |t| 5e-3 * t), "it rolls on");
        let slope = 0.01 * 9.81;
        assert!(!rests(9.81, 0.55, |t| 0.5 * slope * t * t), "it slides from rest");
        // Past its balance by a tenth of a degree: it falls at the rate √(3g/4r).
        let (rate, first) = ((0.75 * 9.81 / 0.1_f64).sqrt(), 0.1 * 0.1_f64.to_radians());
        assert!(!rests(9.81, 0.6, |t| first * (rate * t).cosh()), "it tips");
        let swing = |t: f64| 1e-3 * (3.13 * t).cos();
        assert!((0..9).all(|k| !rests(9.81, 0.6 + 0.2 * f64::from(k), swing)), "it swings");
    }
}
