//! The frame in which displacements are small.

use cullet_geometry::{Mat3, Vec3};
use nalgebra::Rotation3;
use rayon::prelude::*;

/// Points that are summed up together.
const CHUNK: usize = 4096;

/// Most rounds in which the nearest rotation is sought.
const ROUNDS: usize = 50;

/// Where a body is and how it is turned: displacements are counted from there, so that moving and
/// turning it as a whole costs no digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CorotatedFrame {
    /// Where the origin of the reference is \[m\].
    pub(crate) centre: Vec3,
    /// From the reference.
    pub(crate) turn: Rotation3<f64>,
}

impl CorotatedFrame {
    /// Of places \[m\], for points with the `reference` \[m\]: the rotation nearest to
    /// Σ(x − x̄)(X − X̄)^T, or that of the last step where there is none.
    pub(crate) fn of(places: &[Vec3], reference: &[Vec3], last: &Rotation3<f64>) -> Self {
        let (Some(&origin), Some(&rest)) = (places.first(), reference.first()) else {
            return Self { centre: Vec3::zeros(), turn: *last };
        };
        type FrameSums = (Vec3, Vec3, Mat3);
        let add = |a: FrameSums, b: FrameSums| (a.0 + b.0, a.1 + b.1, a.2 + b.2);
        let sums: Vec<FrameSums> = places
            .par_chunks(CHUNK)
            .zip(reference.par_chunks(CHUNK))
            .map(|(places, reference)| {
                let pairs = places.iter().zip(reference).map(|(x, at)| (x - origin, at - rest));
                pairs.fold(FrameSums::default(), |sum, (x, at)| {
                    add(sum, (x, at, x * at.transpose()))
                })
            })
            .collect();
        let (sum, own, product) = sums.into_iter().fold(FrameSums::default(), add);
        let (mean, own) = (sum / places.len() as f64, own / places.len() as f64);
        let turn = nearest_rotation(&(product - sum * own.transpose())).unwrap_or(*last);
        Self { centre: origin + mean - turn * (rest + own), turn }
    }
}

/// The rotation nearest to a matrix, if it is no reflection: its polar factor by Newton's method
/// (Higham 1986).
fn nearest_rotation(matrix: &Mat3) -> Option<Rotation3<f64>> {
    let mut turn = matrix * (3.0_f64.sqrt() / matrix.norm());
    // Scaling by the determinant makes it fast where a body is thin.
    for _ in 0..ROUNDS {
        let determinant = turn.determinant();
        if !(determinant > 1e-12 && determinant.is_finite()) {
            return None;
        }
        turn /= libm::cbrt(determinant);
        let next = 0.5 * (turn + turn.try_inverse()?.transpose());
        let change = (next - turn).norm();
        turn = next;
        if change < 1e-15 {
            break;
        }
    }
    Some(Rotation3::from_matrix_unchecked(turn))
}

#[cfg(test)]
mod tests {
    use super::CorotatedFrame;
    use cullet_geometry::Vec3;
    use nalgebra::Rotation3;

    #[test]
    fn a_body_that_was_moved_and_turned_is_found() {
        let at = |k: usize| {
            let [x, y, z] = [k % 5, k / 5 % 4, k / 20].map(|c| c as f64);
            Vec3::new(x - 2.0, 0.3 * (y - 1.5), z - 1.0)
        };
        let reference: Vec<Vec3> = (0..60).map(at).collect();
        for angle in [1e-9, 0.4, 3.1] {
            let turn = Rotation3::new(Vec3::new(0.48, -0.6, 0.64) * angle);
            let away = Vec3::new(1e3, -2e3, 5.0);
            let places: Vec<Vec3> = reference.iter().map(|x| turn * x + away).collect();
            let frame = CorotatedFrame::of(&places, &reference, &Rotation3::identity());
            assert!((frame.centre - away).norm() < 1e-9, "{angle}: {frame:?}");
            assert!(frame.turn.angle_to(&turn) < 1e-9, "{angle}: {frame:?}");
        }
    }
}
