//! What takes the places of a body that was bent back by the motion of the whole.

use cullet_geometry::{Mat3, Vec3};

/// The turn and the shift that leave least of the displacements, mass by mass \[Kabsch 1976\].
#[derive(Clone, Copy, Debug)]
pub struct Straightened {
    from: Vec3,
    to: Vec3,
    turn: Mat3,
}

impl Straightened {
    /// Of nodes with masses \[kg\], where they were first and where they are now \[m\].
    #[must_use]
    pub fn of(masses: &[f64], first: &[Vec3], now: &[Vec3]) -> Self {
        let mass: f64 = masses.iter().sum();
        let middle =
            |places: &[Vec3]| places.iter().zip(masses).map(|(x, m)| x * *m).sum::<Vec3>() / mass;
        let (to, from) = (middle(first), middle(now));
        let mut spread = Mat3::zeros();
        for ((x, y), m) in first.iter().zip(now).zip(masses) {
            spread += (x - to) * (y - from).transpose() * *m;
        }
        let parts = spread.svd(true, true);
        let turn = match (parts.u, parts.v_t) {
            (Some(u), Some(v_t)) => {
                let handed = Vec3::new(1.0, 1.0, (u * v_t).determinant().signum());
                u * Mat3::from_diagonal(&handed) * v_t
            }
            _ => Mat3::identity(),
        };
        Self { from, to, turn }
    }

    /// What a motion would be.
    #[must_use]
    pub fn motion(&self, motion: &Vec3) -> Vec3 {
        self.turn * motion
    }

    /// Where a place that is now at `now` \[m\] would be.
    #[must_use]
    pub fn place(&self, now: &Vec3) -> Vec3 {
        self.to + self.turn * (now - self.from)
    }
}

#[cfg(test)]
mod tests {
    use super::Straightened;
    use cullet_geometry::{Quat, Vec3};

    #[test]
    fn a_rigid_motion_is_taken_back() {
        let first: Vec<Vec3> = (0..20)
            .map(|k| Vec3::new(f64::from(k % 3), f64::from(k % 5), 0.3 * f64::from(k % 7)))
            .collect();
        let masses: Vec<f64> = (0..20).map(|k| 1.0 + f64::from(k)).collect();
        let turn = Quat::from_scaled_axis(Vec3::new(1.0, -2.0, 0.5));
        let now: Vec<Vec3> = first.iter().map(|x| turn * x + Vec3::new(3.0, 0.0, -1.0)).collect();
        let straight = Straightened::of(&masses, &first, &now);
        for (x, y) in first.iter().zip(&now) {
            assert!((straight.place(y) - x).norm() < 1e-12);
        }
    }
}
