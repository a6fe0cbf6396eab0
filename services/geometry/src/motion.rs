//! Motions against time: tracks of a place and a turn, and frames that hang on one another.
//!
//! A track is what a channel of a glTF animation is (glTF 2.0, section 3.11 and appendix C), and
//! has at every time the value that is written there.

use crate::math::{Pose, Quat, Vec3};
use nalgebra::{Quaternion, SVector, Translation3, Vector4};

/// How far the norm of a quaternion of a track may be from 1 \[1\]: one of whole numbers of 8 bits
/// is off by up to 0.008.
pub const QUATERNION_SLACK: f64 = 0.01;

/// Cosine of the turn between two keys above which they are mixed linearly \[1\]: the sine that
/// slerp divides by loses its digits, and the two differ by less than 1e-12.
const NEARLY_EQUAL: f64 = 1.0 - 1e-10;

/// Values against time: a place \[m\] with `N` = 3, a turn as the quaternion (x, y, z, w) with
/// `N` = 4. It has its first value before the first time, and its last one after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionTrack<const N: usize> {
    times: Vec<f64>,
    values: Vec<SVector<f64, N>>,
    /// Slopes with which the curve arrives at a value and leaves it \[1/s\]; of a straight track
    /// none.
    slopes: Vec<[SVector<f64, N>; 2]>,
}

/// Why a track is none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TrackError {
    /// Numbers of times, values and slopes do not go together.
    #[error("there are {times} times, but {values} values")]
    Count {
        /// How many times.
        times: usize,
        /// How many values.
        values: usize,
    },
    /// A time is not finite, or not after the one before.
    #[error("key {index} is at {time} s; it must be later than the one before, at {before} s")]
    Time {
        /// Which key, from 0.
        index: usize,
        /// Its time \[s\].
        time: f64,
        /// That of the one before \[s\]; of the first, the least time that is taken.
        before: f64,
    },
    /// A value is not finite.
    #[error("key {index} has a number that is not finite")]
    Value {
        /// Which key, from 0.
        index: usize,
    },
    /// A quaternion is no rotation.
    #[error("key {index} has a quaternion of norm {norm}; it must be 1 within {QUATERNION_SLACK}")]
    Norm {
        /// Which key, from 0.
        index: usize,
        /// Its norm \[1\].
        norm: f64,
    },
}

impl<const N: usize> MotionTrack<N> {
    /// One value at all times.
    #[must_use]
    pub fn constant(value: SVector<f64, N>) -> Self {
        Self { times: vec![0.0], values: vec![value], slopes: Vec::new() }
    }

    /// A track through values at times \[s\]: straight from one to the next (a turn goes the short
    /// way at an even rate), or, with the slopes with which it arrives and leaves \[1/s\], cubic.
    ///
    /// # Errors
    /// No time, or other numbers of values or slopes; times that are negative or do not rise; what
    /// is not finite; a quaternion that is not of norm 1 within [`QUATERNION_SLACK`].
    pub fn new(
        times: Vec<f64>,
        mut values: Vec<SVector<f64, N>>,
        cubic: Vec<[SVector<f64, N>; 2]>,
    ) -> Result<Self, TrackError> {
        let count = times.len();
        if count == 0 || values.len() != count || !(cubic.is_empty() || cubic.len() == count) {
            return Err(TrackError::Count { times: count, values: values.len() });
        }
        for (index, &time) in times.iter().enumerate() {
            let before = if index == 0 { 0.0 } else { times[index - 1] };
            let late = if index == 0 { time >= before } else { time > before };
            if !time.is_finite() || !late {
                return Err(TrackError::Time { index, time, before });
            }
        }
        let finite = |value: &SVector<f64, N>| value.iter().all(|x| x.is_finite());
        for (index, value) in values.iter_mut().enumerate() {
            if !finite(value) || !cubic.get(index).is_none_or(|pair| pair.iter().all(finite)) {
                return Err(TrackError::Value { index });
            }
            if N == 4 {
                let norm = value.norm();
                if (norm - 1.0).abs() > QUATERNION_SLACK {
                    return Err(TrackError::Norm { index, norm });
                }
                // A cubic curve goes through the numbers as they are written.
                if cubic.is_empty() {
                    *value /= norm;
                }
            }
        }
        Ok(Self { times, values, slopes: cubic })
    }

    /// When its values are \[s\].
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The two keys around a time, and the way between them; or the one that it stays at.
    fn around(&self, time: f64) -> Result<Segment, usize> {
        let after = self.times.partition_point(|key| *key <= time);
        match after.checked_sub(1) {
            Some(from) if after < self.times.len() => {
                let span = self.times[after] - self.times[from];
                Ok(Segment { from, span, share: (time - self.times[from]) / span })
            }
            _ => Err(after.min(self.times.len() - 1)),
        }
    }

    /// The cubic curve between two keys (glTF 2.0, appendix C.5).
    fn cubic(&self, Segment { from, span, share: u }: Segment) -> SVector<f64, N> {
        let v = 1.0 - u;
        let [_, leaving] = self.slopes[from];
        let [arriving, _] = self.slopes[from + 1];
        self.values[from] * (v * v * (1.0 + 2.0 * u))
            + self.values[from + 1] * (u * u * (3.0 - 2.0 * u))
            + (leaving * (v * v * u) - arriving * (u * u * v)) * span
    }
}

/// A part of a track, from one key to the next.
#[derive(Clone, Copy)]
struct Segment {
    from: usize,
    /// How long it takes \[s\].
    span: f64,
    /// How much of it is over \[1\].
    share: f64,
}

impl MotionTrack<3> {
    /// The place at a time \[m\].
    #[must_use]
    pub fn place(&self, time: f64) -> Vec3 {
        match self.around(time) {
            Err(key) => self.values[key],
            Ok(segment) if !self.slopes.is_empty() => self.cubic(segment),
            Ok(Segment { from, share, .. }) => {
                let (a, b) = (self.values[from], self.values[from + 1]);
                a + (b - a) * share
            }
        }
    }
}

impl MotionTrack<4> {
    /// The turn at a time.
    #[must_use]
    pub fn turn(&self, time: f64) -> Quat {
        let value = match self.around(time) {
            Err(key) => self.values[key],
            Ok(segment) if !self.slopes.is_empty() => {
                let mixed = self.cubic(segment);
                // A curve through nothing has no direction: the nearer key has.
                let near = self.values[segment.from + usize::from(segment.share > 0.5)];
                if mixed.norm() > 1e-9 { mixed } else { near }
            }
            Ok(Segment { from, share, .. }) => {
                slerp(&self.values[from], &self.values[from + 1], share)
            }
        };
        Quat::new_normalize(Quaternion::from(value))
    }
}

/// Spherical interpolation of unit quaternions, the short way (glTF 2.0, appendix C.4).
fn slerp(a: &Vector4<f64>, b: &Vector4<f64>, share: f64) -> Vector4<f64> {
    let cosine = a.dot(b);
    let b = if cosine < 0.0 { -b } else { *b };
    let cosine = cosine.abs();
    if cosine > NEARLY_EQUAL {
        return a + (b - a) * share;
    }
    let sine = (1.0 - cosine * cosine).sqrt();
    let angle = libm::atan2(sine, cosine);
    (a * libm::sin(angle * (1.0 - share)) + b * libm::sin(angle * share)) / sine
}

/// A frame in the frame that it hangs on.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLink {
    /// Where its origin is \[m\].
    pub place: MotionTrack<3>,
    /// How it is turned.
    pub turn: MotionTrack<4>,
    /// How much larger all is that hangs on it \[1\].
    pub scale: f64,
}

/// The motion of a frame that hangs on others, the outermost first.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameMotion {
    /// The frames, down to the one whose motion it is.
    pub links: Vec<MotionLink>,
    /// Where the frame is when nothing moves it.
    pub rest: Pose,
}

impl FrameMotion {
    /// Where the frame is at a time \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> Pose {
        let (mut place, mut turn, mut scale) = (Vec3::zeros(), Quat::identity(), 1.0);
        for link in &self.links {
            place += turn * link.place.place(time) * scale;
            turn *= link.turn.turn(time);
            scale *= link.scale;
        }
        let turn = Quat::new_normalize(turn.into_inner());
        Pose::from_parts(Translation3::from(place), turn)
    }

    /// All times of its tracks \[s\], rising, each once.
    #[must_use]
    pub fn times(&self) -> Vec<f64> {
        let of = |link: &MotionLink| [link.place.times.clone(), link.turn.times.clone()].concat();
        let mut times: Vec<f64> = self.links.iter().flat_map(of).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }
}

#[cfg(test)]
mod tests {
    use super::{FrameMotion, MotionLink, MotionTrack, TrackError};
    use crate::math::{Pose, Quat, Vec3};
    use nalgebra::{Vector3, Vector4};

    fn about_z(angle: f64) -> Vector4<f64> {
        Vector4::new(0.0, 0.0, libm::sin(angle / 2.0), libm::cos(angle / 2.0))
    }

    #[test]
    fn a_straight_track_is_even_and_stays_at_its_ends() {
        let values = vec![Vector3::zeros(), Vector3::new(2.0, 0.0, -4.0)];
        let track = MotionTrack::<3>::new(vec![1.0, 3.0], values, Vec::new()).expect("a track");
        assert_eq!(track.place(1.5), Vec3::new(0.5, 0.0, -1.0));
        assert_eq!((track.place(0.0), track.place(9.0).x), (Vec3::zeros(), 2.0));
        // The second quaternion is the same turn with the other sign: the way is still short.
        let values = vec![about_z(0.2), -about_z(1.4)];
        let track = MotionTrack::<4>::new(vec![0.0, 2.0], values, Vec::new()).expect("a track");
        for (time, angle) in [(0.0, 0.2), (0.5, 0.5), (1.0, 0.8), (5.0, 1.4)] {
            let off = track.turn(time).angle_to(&Quat::from_axis_angle(&Vec3::z_axis(), angle));
            assert!(off < 1e-7, "{off} at {time} s");
        }
    }

    /// A cubic through the values and slopes of t³ - t is t³ - t.
    #[test]
    fn a_cubic_track_is_the_cubic_of_its_slopes() {
        let value = |t: f64| Vector3::new(t * t * t - t, 0.0, 2.0 * t);
        let slope = |t: f64| Vector3::new(3.0 * t * t - 1.0, 0.0, 2.0);
        let times = vec![0.0, 0.7, 2.0];
        let values = times.iter().map(|&t| value(t)).collect();
        let slopes = times.iter().map(|&t| [slope(t); 2]).collect();
        let track = MotionTrack::<3>::new(times, values, slopes).expect("a track");
        for time in [0.1, 0.35, 0.7, 1.1, 1.9] {
            assert!((track.place(time) - value(time)).norm() < 1e-12, "{time}");
        }
    }

    #[test]
    fn frames_hang_on_one_another() {
        let turn = MotionTrack::new(vec![0.0, 1.0], vec![about_z(0.0), about_z(1.0)], Vec::new());
        let base = MotionLink {
            place: MotionTrack::constant(Vector3::new(0.0, 0.0, 5.0)),
            turn: turn.expect("a track"),
            scale: 2.0,
        };
        let tip = MotionLink {
            place: MotionTrack::constant(Vector3::new(1.5, 0.0, 0.0)),
            turn: MotionTrack::constant(about_z(0.25)),
            scale: 1.0,
        };
        let motion = FrameMotion { links: vec![base, tip], rest: Pose::identity() };
        for time in [0.0, 0.3, 1.0] {
            let pose = motion.at(time);
            let place = Vec3::new(3.0 * libm::cos(time), 3.0 * libm::sin(time), 5.0);
            assert!((pose.translation.vector - place).norm() < 1e-12, "{pose} at {time}");
            let turn = Quat::from_axis_angle(&Vec3::z_axis(), time + 0.25);
            assert!(pose.rotation.angle_to(&turn) < 1e-7);
        }
        assert_eq!(motion.times(), [0.0, 1.0]);
    }

    #[test]
    fn what_is_no_track_is_refused() {
        let new = |times: &[f64], values: &[Vector4<f64>]| {
            let made = MotionTrack::<4>::new(times.to_vec(), values.to_vec(), Vec::new());
            made.expect_err("it is none").to_string()
        };
        let one = about_z(0.0);
        assert_eq!(new(&[], &[]), "there are 0 times, but 0 values");
        assert_eq!(new(&[0.0, 1.0], &[one]), "there are 2 times, but 1 values");
        let said = new(&[0.5, 0.5], &[one, one]);
        assert_eq!(said, "key 1 is at 0.5 s; it must be later than the one before, at 0.5 s");
        assert!(new(&[-1.0], &[one]).starts_with("key 0 is at -1 s"));
        assert!(new(&[0.0], &[one * f64::NAN]).contains("key 0 has a number"));
        assert!(new(&[0.0], &[one * 2.0]).contains("norm 2; it must be 1 within 0.01"));
        let slope = [Vector3::new(f64::INFINITY, 0.0, 0.0), Vector3::zeros()];
        let made = MotionTrack::<3>::new(vec![0.0], vec![Vector3::zeros()], vec![slope]);
        assert_eq!(made, Err(TrackError::Value { index: 0 }));
    }
}
