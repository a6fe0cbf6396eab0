//! How a grip is led.

use cullet_geometry::{Quat, Vec3};
use cullet_model::{BodyGrip, Refusal};

/// Where a grip is and how it is turned, by the time.
#[derive(Clone, Debug, PartialEq)]
pub struct GripPath {
    /// From the first time on.
    rows: Vec<(f64, Vec3)>,
    /// \[rad/s\].
    turn: Vec3,
    /// When it lets go \[s\]; infinite where it never does.
    until: f64,
}

impl GripPath {
    /// The path of a grip with these rows: how far \[m\] it has moved at which time \[s\].
    ///
    /// # Errors
    ///
    /// If its times do not rise or a number is none; `number` says which grip, `family` of what.
    pub fn new(
        rows: &[(f64, Vec3)],
        until: Option<f64>,
        number: usize,
        family: &'static str,
    ) -> Result<Self, Refusal> {
        let finite = rows.iter().all(|(t, x)| t.is_finite() && x.iter().all(|c| c.is_finite()));
        if !finite || !rows.windows(2).all(|two| two[0].0 < two[1].0) {
            let lack = format!("the times of grip {number}'s path must rise and be finite");
            return Err(Refusal::Unfit { solver: family, lack });
        }
        let mut rows = rows.to_vec();
        if rows.first().is_none_or(|(t, _)| *t > 0.0) {
            rows.insert(0, (0.0, Vec3::zeros()));
        }
        Ok(Self { rows, turn: Vec3::zeros(), until: until.unwrap_or(f64::INFINITY) })
    }

    /// The path of a body's grip, which may turn.
    ///
    /// # Errors
    ///
    /// As [`GripPath::new`].
    pub fn of(grip: &BodyGrip, number: usize, family: &'static str) -> Result<Self, Refusal> {
        if !grip.turn.iter().all(|c| c.is_finite()) {
            let lack = format!("the turn of grip {number} must be finite");
            return Err(Refusal::Unfit { solver: family, lack });
        }
        let path = Self::new(&grip.path, grip.until, number, family)?;
        Ok(Self { turn: grip.turn, ..path })
    }

    /// Whether it holds in a step of the world that begins at this time \[s\].
    #[must_use]
    pub fn holds(&self, time: f64) -> bool {
        time < self.until
    }

    /// How far \[m\] it has moved at a time \[s\], and how fast it moves just after that \[m/s\].
    #[must_use]
    pub fn at(&self, time: f64) -> (Vec3, Vec3) {
        let after = self.rows.partition_point(|(t, _)| *t <= time).max(1);
        let (t0, from) = self.rows[after - 1];
        match self.rows.get(after) {
            Some(&(t1, to)) => {
                let velocity = (to - from) / (t1 - t0);
                (from + velocity * (time - t0), velocity)
            }
            None => (from, Vec3::zeros()),
        }
    }

    /// How it is turned at a time \[s\], and how fast it turns just after that \[rad/s\].
    #[must_use]
    pub fn turned(&self, time: f64) -> (Quat, Vec3) {
        let last = match self.rows.len() {
            1 => f64::INFINITY,
            rows => self.rows[rows - 1].0,
        };
        let spin = if time < last { self.turn } else { Vec3::zeros() };
        (Quat::from_scaled_axis(self.turn * time.min(last)), spin)
    }

    /// Where a place \[m\] that it holds is at a time \[s\], and how fast it moves \[m/s\]; it
    /// turns about `middle` \[m\].
    #[must_use]
    pub fn leads(&self, place: &Vec3, middle: &Vec3, time: f64) -> (Vec3, Vec3) {
        let ((moved, velocity), (turned, spin)) = (self.at(time), self.turned(time));
        let arm = turned * (place - middle);
        (middle + arm + moved, velocity + spin.cross(&arm))
    }
}

#[cfg(test)]
mod tests {
    use super::GripPath;
    use cullet_geometry::Vec3;
    use cullet_model::{BodyGrip, BodyRegion};

    fn grip(path: Vec<(f64, Vec3)>, turn: Vec3) -> BodyGrip {
        let region = BodyRegion::Ball { centre: Vec3::zeros(), radius: 1.0 };
        BodyGrip { region, path, turn, until: Some(3.0) }
    }

    #[test]
    fn a_grip_goes_straight_between_its_rows_and_stays_at_the_last() {
        let rows = vec![(1.0, Vec3::x()), (2.0, 3.0 * Vec3::x())];
        let path = GripPath::of(&grip(rows, Vec3::zeros()), 1, "family").unwrap();
        assert_eq!(path.at(0.5), (0.5 * Vec3::x(), Vec3::x()));
        assert_eq!(path.at(1.5), (2.0 * Vec3::x(), 2.0 * Vec3::x()));
        assert_eq!(path.at(9.0), (3.0 * Vec3::x(), Vec3::zeros()));
        assert!(path.holds(2.9) && !path.holds(3.0));
        let back = vec![(1.0, Vec3::x()), (1.0, Vec3::zeros())];
        let why = GripPath::of(&grip(back, Vec3::zeros()), 4, "family").unwrap_err().to_string();
        assert!(why.contains("grip 4"), "{why}");
    }

    #[test]
    fn a_grip_turns_what_it_holds_about_its_middle() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let path = GripPath::of(&grip(vec![], quarter * Vec3::z()), 1, "family").unwrap();
        let (place, velocity) = path.leads(&(2.0 * Vec3::x()), &Vec3::x(), 1.0);
        assert!((place - Vec3::new(1.0, 1.0, 0.0)).norm() < 1e-14, "{place}");
        assert!((velocity - -quarter * Vec3::x()).norm() < 1e-14, "{velocity}");
        let rows = vec![(1.0, Vec3::zeros())];
        let path = GripPath::of(&grip(rows, quarter * Vec3::z()), 1, "family").unwrap();
        let (place, velocity) = path.leads(&(2.0 * Vec3::x()), &Vec3::x(), 5.0);
        assert!((place - Vec3::new(1.0, 1.0, 0.0)).norm() < 1e-14, "{place}");
        assert_eq!(velocity, Vec3::zeros());
    }
}
