//! Which samples of a motion are needed: the others lie between their neighbours.

use cullet_geometry::{Quat, Vec3};
use nalgebra::Quaternion;

/// How far a key that is left out may be from the line between its neighbours, over the diagonal
/// of its body \[1\]; and at most so far \[m\].
pub const PLACE_SHARE: f64 = 1e-6;
/// See [`PLACE_SHARE`].
pub const PLACE_MOST: f64 = 1e-6;
/// How far a rotation that is left out may be from that between its neighbours \[rad\].
pub const TURN_MOST: f64 = 1e-6;

/// One less the product of two unit quaternions above which USD interpolates on the sphere
/// (`GfSlerp`) \[1\].
const USD_SLERPS: f64 = 1e-5;

/// The samples that are kept, in order: the first, the last, and those without which another would
/// be further than `bound` from what is interpolated. `error(low, high, k)`: how far sample k is
/// from what is interpolated between two others (Ramer, Douglas and Peucker, over time).
fn kept(count: usize, bound: f64, error: impl Fn(usize, usize, usize) -> f64) -> Vec<usize> {
    if count < 2 {
        return (0..count).collect();
    }
    let mut keep = vec![false; count];
    (keep[0], keep[count - 1]) = (true, true);
    let mut spans = vec![(0, count - 1)];
    while let Some((low, high)) = spans.pop() {
        let errors = (low + 1..high).map(|k| (k, error(low, high, k)));
        let worst = errors.max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((k, _)) = worst.filter(|(_, error)| *error > bound) {
            keep[k] = true;
            spans.extend([(low, k), (k, high)]);
        }
    }
    (0..count).filter(|&k| keep[k]).collect()
}

/// Share of the way from one time to another \[1\].
fn share(times: &[f64], low: usize, high: usize, k: usize) -> f64 {
    let span = times[high] - times[low];
    if span > 0.0 { (times[k] - times[low]) / span } else { 0.0 }
}

/// The samples of a vector that are needed; one if it never changes.
pub(crate) fn of_vectors(times: &[f64], values: &[Vec3], bound: f64) -> Vec<usize> {
    let kept = kept(times.len(), bound, |low, high, k| {
        let line = values[low].lerp(&values[high], share(times, low, high, k));
        (values[k] - line).norm()
    });
    match kept[..] {
        [first, last] if values[first] == values[last] => vec![first],
        _ => kept,
    }
}

/// A rotation between two as USD reads it: where they are near one another, each number by itself;
/// the angle is then that of the first number, although the four are no unit any more.
fn as_usd_reads(low: &Quat, high: &Quat, share: f64) -> Quat {
    if 1.0 - low.coords.dot(&high.coords) > USD_SLERPS {
        return low.slerp(high, share);
    }
    let line = low.lerp(high, share);
    let first = line.w.clamp(-1.0, 1.0);
    let rest = line.imag().try_normalize(0.0).unwrap_or_default() * (1.0 - first * first).sqrt();
    Quat::new_unchecked(Quaternion::from_parts(first, rest))
}

/// The samples of a rotation that are needed; one if it never changes. Some programs interpolate on
/// the sphere, as glTF asks, others each number by itself, as Blender, or as USD does: all must do.
pub(crate) fn of_turns(times: &[f64], values: &[Quat], bound: f64) -> Vec<usize> {
    let kept = kept(times.len(), bound, |low, high, k| {
        let share = share(times, low, high, k);
        let (low, high) = (&values[low], &values[high]);
        let read = [low.slerp(high, share), low.nlerp(high, share), as_usd_reads(low, high, share)];
        read.iter().map(|turn| turn.angle_to(&values[k])).fold(0.0, f64::max)
    });
    match kept[..] {
        [first, last] if values[first] == values[last] => vec![first],
        _ => kept,
    }
}

/// Turns signs so that each quaternion is the nearer of the two to the one before: programs that
/// interpolate the four numbers then take the short way.
pub(crate) fn continuous(values: &mut [Quat]) {
    for k in 1..values.len() {
        if values[k].coords.dot(&values[k - 1].coords) < 0.0 {
            values[k] = Quat::new_unchecked(-values[k].into_inner());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_lies_between_its_neighbours() {
        let times: Vec<f64> = (0..60).map(|k| f64::from(k) / 24.0).collect();
        // It rests, falls, slides evenly.
        let place = |t: f64| match t {
            t if t < 1.0 => Vec3::zeros(),
            t if t < 1.5 => Vec3::z() * (-0.5 * 9.81 * (t - 1.0) * (t - 1.0)),
            t => Vec3::new(0.3 * (t - 1.5), 0.0, -0.5 * 9.81 * 0.25),
        };
        let values: Vec<Vec3> = times.iter().map(|&t| place(t)).collect();
        let kept = of_vectors(&times, &values, 1e-6);
        assert!(kept.len() < 20 && kept.contains(&24), "{kept:?}");
        for k in 0..times.len() {
            let next = kept.partition_point(|&key| key < k).max(1);
            let (low, high) = (kept[next - 1], kept[next]);
            let line = values[low].lerp(&values[high], share(&times, low, high, k));
            assert!((line - values[k]).norm() <= 1e-6, "{k}");
        }
        assert_eq!(of_vectors(&times, &vec![Vec3::x(); 60], 1e-6), [0]);
    }

    #[test]
    fn an_even_spin_needs_its_ends_and_signs_do_not_jump() {
        let times: Vec<f64> = (0..20).map(f64::from).collect();
        let turn = |t: f64| Quat::from_scaled_axis(Vec3::new(0.0, 1e-3 * t, 0.0));
        let mut values: Vec<Quat> = times.iter().map(|&t| turn(t)).collect();
        assert_eq!(of_turns(&times, &values, TURN_MOST), [0, 19]);
        let fast: Vec<Quat> = times.iter().map(|&t| turn(300.0 * t)).collect();
        assert!(of_turns(&times, &fast, TURN_MOST).len() > 13, "Blender would not turn it evenly");
        values[7] = Quat::new_unchecked(-values[7].into_inner());
        continuous(&mut values);
        assert!(values.windows(2).all(|pair| pair[0].coords.dot(&pair[1].coords) > 0.0));
        values[9] = turn(9.1);
        assert!(of_turns(&times, &values, TURN_MOST).contains(&9));
    }
    /// What hardly turns: linear between far keys on the sphere, and yet not as USD reads it.
    #[test]
    fn small_turns_keep_what_usd_reads_wrong() {
        let times: Vec<f64> = (0..6).map(f64::from).collect();
        let turn = |t: f64| Quat::from_scaled_axis(Vec3::z() * (4e-4 + 8e-4 * t));
        let values: Vec<Quat> = times.iter().map(|&t| turn(t)).collect();
        let read = as_usd_reads(&values[0], &values[5], 0.2);
        assert!(read.angle_to(&values[1]) > 1e-4, "{}", read.angle_to(&values[1]));
        assert!(of_turns(&times, &values, TURN_MOST).len() > 2);
    }
}
