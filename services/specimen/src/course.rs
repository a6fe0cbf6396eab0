//! How a load or a velocity goes with time.

/// A factor that depends on time, of a load or a given velocity.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Amplitude {
    /// Straight lines between points of time \[s\] and factor, constant before and after; times
    /// ascend, two equal ones are a jump.
    Table(Vec<(f64, f64)>),
    /// sin(π (t − start)/duration) while that lasts, else 0.
    HalfSine {
        /// When it begins \[s\].
        start: f64,
        /// How long it lasts \[s\].
        duration: f64,
    },
}

impl Amplitude {
    /// Always 1.
    #[must_use]
    pub fn constant() -> Self {
        Self::Table(vec![(0.0, 1.0)])
    }

    /// The factor at `time` \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::HalfSine { start, duration } => {
                let share = (time - start) / duration;
                let inside = (0.0..=1.0).contains(&share);
                if inside { libm::sin(core::f64::consts::PI * share) } else { 0.0 }
            }
            Self::Table(rows) => {
                let after = rows.partition_point(|row| row.0 <= time);
                match (after.checked_sub(1).map(|k| rows[k]), rows.get(after)) {
                    (None, None) => 0.0,
                    (None, Some(row)) => row.1,
                    (Some(row), None) => row.1,
                    (Some((t0, f0)), Some(&(t1, f1))) => f0 + (f1 - f0) * (time - t0) / (t1 - t0),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Amplitude;

    #[test]
    fn a_table_is_straight_between_its_rows_and_jumps_where_told() {
        let course = Amplitude::Table(vec![(1.0, 0.0), (2.0, 4.0), (2.0, 1.0), (3.0, 1.0)]);
        for (time, factor) in [(0.0, 0.0), (1.5, 2.0), (2.0, 1.0), (2.5, 1.0), (9.0, 1.0)] {
            assert_eq!(course.at(time), factor, "{time}");
        }
        assert_eq!(Amplitude::constant().at(-1.0), 1.0);
    }

    #[test]
    fn a_half_sine_is_one_in_the_middle_and_nothing_outside() {
        let course = Amplitude::HalfSine { start: 1.0, duration: 2.0 };
        assert!((course.at(2.0) - 1.0).abs() < 1e-15);
        assert!((course.at(1.5) - 0.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!((course.at(0.9), course.at(3.1)), (0.0, 0.0));
    }
}
