//! Paths by keyframes: where a driven body is at which time.

use crate::placed_motion::PlacedMotion;
use cullet_geometry::{Pose, Quat, Vec3};
use nalgebra::{Quaternion, Translation3};

/// A place on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// When \[s\].
    pub time: f64,
    /// Body frame, whose origin is the centre of mass, to world frame \[m\].
    pub pose: Pose,
}

/// How a path goes from one keyframe to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathInterpolation {
    /// Straight, at an even speed and an even turn (slerp); velocities jump at keyframes.
    Linear,
    /// Position and rotation are cubic (Hermite) with the velocities of Catmull and Rom at inner
    /// keyframes, and begin and end at rest: velocities are continuous at all times.
    Smooth,
    /// As a motion says, of which the keyframes are samples; straight where there is none.
    Motion,
}

/// Where a driven body is at which time. It stays at the first keyframe before, and at the last
/// one after it.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyframedPath {
    keys: Vec<Keyframe>,
    interpolation: PathInterpolation,
    /// What it does in place of going from one keyframe to the next.
    motion: Option<PlacedMotion>,
    /// Velocity \[m/s\] and angular velocity in the body's frame \[rad/s\] at each keyframe, of a
    /// smooth path.
    rates: Vec<(Vec3, Vec3)>,
}

/// Why a path is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PathError {
    /// It has no keyframe.
    #[error("a path needs at least one keyframe")]
    Empty,
    /// A time is not a number, or not after the one before.
    #[error("keyframe {index} is at {time:.6e} s; it must be finite and later than the one before")]
    Time {
        /// Which keyframe.
        index: usize,
        /// Its time \[s\].
        time: f64,
    },
    /// A place or a turn is out of range.
    #[error("keyframe {index}: {what} is {value:.6e}; it must lie in [{low:.3e}, {high:.3e}]")]
    Pose {
        /// Which keyframe.
        index: usize,
        /// What about it.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least accepted.
        low: f64,
        /// Greatest accepted.
        high: f64,
    },
    /// A motion leads out of range.
    #[error("at {time:.6e} s the {what} is {value:.6e}; it must be at most {high:.3e}")]
    Motion {
        /// When \[s\].
        time: f64,
        /// What about it.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Greatest accepted.
        high: f64,
    },
}

/// Farthest keyframe from the world's origin \[m\].
const FARTHEST: f64 = 1e9;
/// Fastest mean speed from one keyframe to the next \[m/s\].
const FASTEST: f64 = 1e6;

impl KeyframedPath {
    /// A path through these keyframes; their quaternions may have either sign.
    ///
    /// # Errors
    /// No keyframe; times that do not rise; a place farther than 1e9 m; a quaternion that is not of
    /// norm 1 within 1e-9; a way that takes more than 1e6 m/s.
    pub fn new(keys: Vec<Keyframe>, interpolation: PathInterpolation) -> Result<Self, PathError> {
        check(&keys)?;
        let rates = match interpolation {
            PathInterpolation::Linear | PathInterpolation::Motion => Vec::new(),
            PathInterpolation::Smooth => rates(&keys),
        };
        Ok(Self { keys, interpolation, rates, motion: None })
    }

    /// The path that a motion says: at every time, not only at keyframes.
    ///
    /// # Errors
    /// A motion without a time; a place farther than 1e9 m, and a mean speed of more than 1e6 m/s,
    /// at one of [`PlacedMotion::sample_times`].
    pub fn of_motion(motion: PlacedMotion) -> Result<Self, PathError> {
        let keys: Vec<Keyframe> = motion
            .sample_times()
            .into_iter()
            .map(|time| Keyframe { time, pose: motion.at(time) })
            .collect();
        check(&keys).map_err(|error| match error {
            PathError::Pose { index, what, value, high, .. } => {
                PathError::Motion { time: keys[index].time, what, value, high }
            }
            other => other,
        })?;
        let (interpolation, rates) = (PathInterpolation::Motion, Vec::new());
        Ok(Self { keys, interpolation, rates, motion: Some(motion) })
    }

    /// Its keyframes; of a motion where it is at [`PlacedMotion::sample_times`].
    #[must_use]
    pub fn keys(&self) -> &[Keyframe] {
        &self.keys
    }

    /// How it goes from one to the next.
    #[must_use]
    pub fn interpolation(&self) -> PathInterpolation {
        self.interpolation
    }

    /// Time of the last keyframe \[s\]: from then on it stands still.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.keys.last().map_or(0.0, |key| key.time)
    }

    /// The pose at a time \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> Pose {
        if let Some(motion) = &self.motion {
            return motion.at(time);
        }
        let after = self.keys.partition_point(|key| key.time <= time);
        let (Some(k), true) = (after.checked_sub(1), after < self.keys.len()) else {
            return self.keys[after.min(self.keys.len() - 1)].pose;
        };
        let (from, to) = (&self.keys[k], &self.keys[k + 1]);
        let span = to.time - from.time;
        let u = (time - from.time) / span;
        match self.interpolation {
            PathInterpolation::Linear | PathInterpolation::Motion => {
                let (a, b) = (from.pose.translation.vector, to.pose.translation.vector);
                let turn = exponential(&(between(&from.pose, &to.pose) * u));
                pose(&(a + (b - a) * u), from.pose.rotation * turn)
            }
            PathInterpolation::Smooth => {
                hermite((from, &self.rates[k]), (to, &self.rates[k + 1]), span, u)
            }
        }
    }

    /// Velocity \[m/s\] and angular velocity \[rad/s\], world frame, that take it from where it is
    /// at a time to where it is `dt` \[s\] later.
    #[must_use]
    pub fn velocity(&self, time: f64, dt: f64) -> (Vec3, Vec3) {
        let (from, to) = (self.at(time), self.at(time + dt));
        let way = to.translation.vector - from.translation.vector;
        (way / dt, logarithm(&(to.rotation * from.rotation.inverse())) / dt)
    }
}

fn check(keys: &[Keyframe]) -> Result<(), PathError> {
    if keys.is_empty() {
        return Err(PathError::Empty);
    }
    let mut last: Option<&Keyframe> = None;
    for (index, key) in keys.iter().enumerate() {
        let time = key.time;
        if !time.is_finite() || last.is_some_and(|last| time <= last.time) {
            return Err(PathError::Time { index, time });
        }
        let place = key.pose.translation.vector;
        let speed =
            last.map_or(0.0, |l| (place - l.pose.translation.vector).norm() / (time - l.time));
        let rows = [
            ("distance from the world's origin [m]", place.norm(), 0.0, FARTHEST),
            ("norm of the quaternion [1]", key.pose.rotation.coords.norm(), 1.0 - 1e-9, 1.0 + 1e-9),
            ("mean speed from the one before [m/s]", speed, 0.0, FASTEST),
        ];
        for (what, value, low, high) in rows {
            if !(low..=high).contains(&value) {
                return Err(PathError::Pose { index, what, value, low, high });
            }
        }
        last = Some(key);
    }
    Ok(())
}

/// Velocities at the keyframes: of the parabola through each and its neighbours; zero at the ends.
fn rates(keys: &[Keyframe]) -> Vec<(Vec3, Vec3)> {
    let still = (Vec3::zeros(), Vec3::zeros());
    let segments: Vec<(f64, Vec3, Vec3)> = keys
        .windows(2)
        .map(|pair| {
            let span = pair[1].time - pair[0].time;
            let way = pair[1].pose.translation.vector - pair[0].pose.translation.vector;
            (span, way / span, between(&pair[0].pose, &pair[1].pose) / span)
        })
        .collect();
    let mut rates = vec![still; keys.len()];
    for (k, pair) in segments.windows(2).enumerate() {
        let ((h, v, w), (i, x, y)) = (pair[0], pair[1]);
        // Both turns are about axes of the frame of the middle keyframe: each leaves its own axis.
        rates[k + 1] = ((v * i + x * h) / (h + i), (w * i + y * h) / (h + i));
    }
    rates
}

/// Cubic between two keyframes with given rates; the rotation is the product of three turns whose
/// shares are cumulative Bernstein polynomials [Kim, Kim, Shin 1995].
fn hermite(
    (from, rate): (&Keyframe, &(Vec3, Vec3)),
    (to, rate_after): (&Keyframe, &(Vec3, Vec3)),
    span: f64,
    u: f64,
) -> Pose {
    let (v, w) = (1.0 - u, u);
    let (a, b) = (from.pose.translation.vector, to.pose.translation.vector);
    let place = a * (v * v * (1.0 + 2.0 * w))
        + b * (w * w * (3.0 - 2.0 * w))
        + (rate.0 * (v * v * w) - rate_after.0 * (w * w * v)) * span;
    let (first, last) = (rate.1 * (span / 3.0), rate_after.1 * (span / 3.0));
    let whole = from.pose.rotation.inverse() * to.pose.rotation;
    let middle = logarithm(&(exponential(&-first) * whole * exponential(&-last)));
    let share = [1.0 - v * v * v, w * w * (3.0 - 2.0 * w), w * w * w];
    let turn = exponential(&(first * share[0]))
        * exponential(&(middle * share[1]))
        * exponential(&(last * share[2]));
    pose(&place, from.pose.rotation * turn)
}

fn pose(place: &Vec3, turn: Quat) -> Pose {
    Pose::from_parts(Translation3::from(*place), Quat::new_normalize(turn.into_inner()))
}

/// The shorter turn from one pose to another, in the frame of the first \[rad\].
fn between(from: &Pose, to: &Pose) -> Vec3 {
    logarithm(&(from.rotation.inverse() * to.rotation))
}

/// The rotation about an axis by its length \[rad\].
fn exponential(turn: &Vec3) -> Quat {
    let half = 0.5 * turn.norm();
    // sin x / x
    let share = if half < 1e-4 { 1.0 - half * half / 6.0 } else { libm::sin(half) / half };
    let axis = turn * (0.5 * share);
    Quat::new_normalize(Quaternion::new(libm::cos(half), axis.x, axis.y, axis.z))
}

/// The axis of a rotation by at most π, times its angle \[rad\].
fn logarithm(turn: &Quat) -> Vec3 {
    let sign = if turn.w < 0.0 { -1.0 } else { 1.0 };
    let (axis, w) = (Vec3::new(turn.i, turn.j, turn.k) * sign, turn.w * sign);
    let sine = axis.norm();
    if sine < 1e-12 { axis * 2.0 } else { axis * (2.0 * libm::atan2(sine, w) / sine) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f64, place: Vec3, turn: Vec3) -> Keyframe {
        Keyframe { time, pose: pose(&place, exponential(&turn)) }
    }

    fn keys() -> Vec<Keyframe> {
        vec![
            key(0.5, Vec3::new(1.0, 0.0, 0.0), Vec3::zeros()),
            key(1.0, Vec3::new(1.0, 2.0, 0.0), Vec3::new(0.0, 0.0, 1.2)),
            key(2.5, Vec3::new(-1.0, 2.0, 3.0), Vec3::new(0.4, 0.3, 2.9)),
            key(3.0, Vec3::new(-1.0, 5.0, 3.0), Vec3::new(-1.0, 0.0, 0.0)),
        ]
    }

    #[test]
    fn a_path_goes_through_its_keyframes_and_stays_at_its_ends() {
        for interpolation in [PathInterpolation::Linear, PathInterpolation::Smooth] {
            let path = KeyframedPath::new(keys(), interpolation).unwrap();
            for key in path.keys() {
                let at = path.at(key.time);
                let off = (at.translation.vector - key.pose.translation.vector).norm();
                assert!(off < 1e-12, "{off}");
                assert!(at.rotation.angle_to(&key.pose.rotation) < 1e-7);
            }
            assert_eq!(path.at(-3.0), keys()[0].pose);
            assert_eq!(path.at(99.0), keys()[3].pose);
            assert_eq!(path.velocity(3.5, 0.01), (Vec3::zeros(), Vec3::zeros()));
        }
    }

    #[test]
    fn a_straight_path_is_even() {
        let path = KeyframedPath::new(keys(), PathInterpolation::Linear).unwrap();
        for time in [0.51, 0.7, 0.98] {
            let (v, w) = path.velocity(time, 0.01);
            assert!((v - Vec3::new(0.0, 4.0, 0.0)).norm() < 1e-9, "{v}");
            assert!((w - Vec3::new(0.0, 0.0, 2.4)).norm() < 1e-9, "{w}");
        }
    }

    /// Differences of the velocity over ever shorter times shrink with them, also at keyframes.
    #[test]
    fn a_smooth_path_has_no_kinks() {
        let path = KeyframedPath::new(keys(), PathInterpolation::Smooth).unwrap();
        let dt = 1e-5;
        for time in [0.5, 1.0, 2.5, 3.0] {
            let (before, after) = (path.velocity(time - dt, dt), path.velocity(time, dt));
            let jump = (before.0 - after.0).norm() + (before.1 - after.1).norm();
            assert!(jump < 1e-2, "{jump} at {time}");
        }
        let straight = KeyframedPath::new(keys(), PathInterpolation::Linear).unwrap();
        let (before, after) = (straight.velocity(1.0 - dt, dt), straight.velocity(1.0, dt));
        assert!((before.0 - after.0).norm() > 1.0);
    }

    #[test]
    fn what_is_no_path_is_refused() {
        let new = |keys| KeyframedPath::new(keys, PathInterpolation::Linear).unwrap_err();
        assert_eq!(new(Vec::new()), PathError::Empty);
        let mut late = keys();
        late[2].time = 1.0;
        assert_eq!(new(late), PathError::Time { index: 2, time: 1.0 });
        let mut lost = keys();
        lost[1].pose.translation.x = f64::NAN;
        assert!(matches!(new(lost), PathError::Pose { index: 1, .. }));
        let fast = vec![keys()[0], key(0.5 + 1e-9, Vec3::zeros(), Vec3::zeros())];
        let text = new(fast).to_string();
        assert!(text.contains("keyframe 1") && text.contains("speed"), "{text}");
    }
}
