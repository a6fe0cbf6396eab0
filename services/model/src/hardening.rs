//! How a metal yields and hardens.

/// Plastic strain below which a power of it is taken to rise in a straight line \[1\].
const LEAST_STRAIN: f64 = 1e-6;

/// The stress at which a metal yields, σ_y = A + Bαⁿ: Johnson & Cook's \[1983\], slow and cold.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Hardening {
    /// A: that at which it yields first \[Pa\].
    pub yield_stress: f64,
    /// B \[Pa\].
    pub hardening: f64,
    /// n, in (0, 1\] \[1\].
    pub exponent: f64,
}

impl Hardening {
    /// σ_y at a plastic strain of `alpha` \[Pa\], and its slope \[Pa\].
    #[must_use]
    pub fn stress(&self, alpha: f64) -> (f64, f64) {
        let Self { yield_stress, hardening, exponent } = *self;
        if hardening <= 0.0 {
            return (yield_stress, 0.0);
        }
        if alpha < LEAST_STRAIN {
            let slope = hardening * libm::pow(LEAST_STRAIN, exponent - 1.0);
            return (yield_stress + slope * alpha, slope);
        }
        let more = hardening * libm::pow(alpha, exponent);
        (yield_stress + more, more * exponent / alpha)
    }

    /// Its numbers: what each is, its value, the least and the greatest that holds.
    #[must_use]
    pub fn bounds(&self) -> [(&'static str, f64, f64, f64); 3] {
        [
            ("yield stress [Pa]", self.yield_stress, 1e3, 1e10),
            ("hardening [Pa]", self.hardening, 0.0, 1e11),
            ("exponent of hardening [1]", self.exponent, 0.05, 1.0),
        ]
    }
}
