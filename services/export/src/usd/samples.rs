//! Time samples and arrays as text.

use cullet_geometry::{Quat, Vec3};
use std::fmt::{Display, Write};

/// How long before a body appears it still has a scale of zero \[frames\]: numbers are interpolated
/// between samples, and visibility is not read by all programs.
const JUMP: f64 = 0.001;

/// Three numbers, as a double each.
pub(super) fn triple(v: &Vec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}

/// Three numbers, as a float each.
pub(super) fn single(v: &Vec3) -> String {
    format!("({}, {}, {})", v.x as f32, v.y as f32, v.z as f32)
}

/// A quaternion, the real part first. USD takes the angle from the real part alone: as a float, a
/// small rotation would be none.
pub(super) fn quaternion(q: &Quat) -> String {
    format!("({}, {}, {}, {})", q.w, q.i as f32, q.j as f32, q.k as f32)
}

/// An array.
pub(super) fn list<T: Display>(values: impl IntoIterator<Item = T>) -> String {
    let mut text = String::from("[");
    for (k, value) in values.into_iter().enumerate() {
        let _ = write!(text, "{}{value}", if k > 0 { ", " } else { "" });
    }
    text.push(']');
    text
}

/// Samples of an attribute, in order of time \[frames\].
pub(super) fn samples<T: Display>(
    text: &mut String,
    indent: &str,
    attribute: &str,
    samples: impl IntoIterator<Item = (f64, T)>,
) {
    let _ = writeln!(text, "{indent}{attribute}.timeSamples = {{");
    for (time, value) in samples {
        let _ = writeln!(text, "{indent}    {time}: {value},");
    }
    let _ = writeln!(text, "{indent}}}");
}

/// When something is there and when not, from the first frame on: time \[frames\] and whether.
pub(super) fn visibility(birth: f64, death: f64, last: f64) -> Vec<(f64, bool)> {
    let mut samples = vec![(0.0, birth <= 0.0)];
    samples.extend((birth > 0.0).then_some((birth, true)));
    samples.extend((death <= last).then_some((death, false)));
    samples
}

/// The same as scales that jump.
pub(super) fn scales(visibility: &[(f64, bool)]) -> Vec<(f64, &'static str)> {
    let size = |there: bool| if there { "(1, 1, 1)" } else { "(0, 0, 0)" };
    let mut samples = Vec::new();
    for (k, &(time, there)) in visibility.iter().enumerate() {
        if let Some(&(before, was)) = k.checked_sub(1).map(|k| &visibility[k])
            && time - JUMP > before
        {
            samples.push((time - JUMP, size(was)));
        }
        samples.push((time, size(there)));
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_jumps_where_visibility_does() {
        let seen = visibility(12.5, 30.0, 48.0);
        assert_eq!(seen, [(0.0, false), (12.5, true), (30.0, false)]);
        let (none, one) = ("(0, 0, 0)", "(1, 1, 1)");
        let wanted =
            [(0.0, none), (12.5 - JUMP, none), (12.5, one), (30.0 - JUMP, one), (30.0, none)];
        assert_eq!(scales(&seen), wanted);
        assert_eq!(visibility(0.0, f64::INFINITY, 48.0), [(0.0, true)]);
    }
}
