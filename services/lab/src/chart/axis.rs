//! An axis of logarithms.

/// Decades from which on only powers of ten have labels \[1\].
const MANY: f64 = 2.4;

/// A logarithmic axis of a chart: from values to pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogAxis {
    /// Logarithms of its ends.
    ends: (f64, f64),
    /// The pixels there.
    pixels: (i32, i32),
}

impl LogAxis {
    /// From `low` to `high`, both above 0, at those pixels.
    pub(super) fn new(low: f64, high: f64, from: i32, to: i32) -> Self {
        Self { ends: (libm::log10(low), libm::log10(high)), pixels: (from, to) }
    }

    /// The pixel of a value; what lies outside is put on the end.
    pub(super) fn at(&self, value: f64) -> i32 {
        let (low, high) = self.ends;
        let log = if value > 0.0 { libm::log10(value) } else { low };
        let share = ((log - low) / (high - low)).clamp(0.0, 1.0);
        let (from, to) = (f64::from(self.pixels.0), f64::from(self.pixels.1));
        (from + share * (to - from)).round() as i32
    }

    /// Values with a line, and whether they have a label.
    pub(super) fn lines(&self) -> Vec<(f64, bool)> {
        let (low, high) = self.ends;
        let mut lines = Vec::new();
        for decade in low.floor() as i32..=high.floor() as i32 {
            for digit in 1..10 {
                // As written, so that 0.3 is not 0.30000000000000004.
                let value: f64 = format!("{digit}e{decade}").parse().unwrap_or(f64::NAN);
                let log = libm::log10(value);
                let labelled = match digit {
                    1 => true,
                    2 | 5 => high - low < MANY,
                    _ => false,
                };
                if log >= low - 1e-9 && log <= high + 1e-9 {
                    lines.push((value, labelled));
                }
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::LogAxis;

    #[test]
    fn equal_ratios_are_equal_ways() {
        let axis = LogAxis::new(0.01, 100.0, 500, 100);
        assert_eq!([0.01, 0.1, 1.0, 100.0].map(|v| axis.at(v)), [500, 400, 300, 100]);
        assert_eq!((axis.at(0.0), axis.at(1e9)), (500, 100));
        let labelled = |axis: &LogAxis| -> Vec<f64> {
            axis.lines().into_iter().filter(|line| line.1).map(|line| line.0).collect()
        };
        assert_eq!(labelled(&axis), [0.01, 0.1, 1.0, 10.0, 100.0]);
        let short = LogAxis::new(0.3, 4.0, 0, 100);
        assert_eq!(labelled(&short), [0.5, 1.0, 2.0]);
        assert_eq!(short.lines().len(), 11, "0.3 to 0.9, 1 to 4");
    }
}
