//! Hertz: two elastic bodies that touch at a point and bounce.

/// Young's modulus and Poisson's ratio of one side of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// E \[Pa\].
    pub young: f64,
    /// ν \[1\].
    pub poisson: f64,
}

/// A Hertz impact from first touch to parting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz {
    /// Duration t_c \[s\].
    pub duration: f64,
    /// Greatest approach δ \[m\].
    pub indentation: f64,
    /// Greatest contact radius a \[m\].
    pub radius: f64,
    /// Greatest force F \[N\]; the force is F sin(πt/t_c) within a few per cent.
    pub force: f64,
    /// Greatest pressure p₀ \[Pa\].
    pub pressure: f64,
}

/// 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂ \[Pa\].
#[must_use]
pub fn effective_modulus(one: Elastic, two: Elastic) -> f64 {
    let compliance = |e: Elastic| (1.0 - e.poisson * e.poisson) / e.young;
    1.0 / (compliance(one) + compliance(two))
}

/// Duration of a Hertz impact over δ/v \[1\]: 2∫₀¹ dx/√(1 − x^{5/2}).
pub const DURATION_OVER_APPROACH: f64 = 2.943_3;

/// The impact of effective mass `mass` \[kg\], modulus `modulus` \[Pa\] and radius `radius` \[m\]
/// at closing speed `speed` \[m/s\].
#[must_use]
pub fn hertz(mass: f64, modulus: f64, radius: f64, speed: f64) -> Hertz {
    let root = radius.sqrt();
    // δ = (15 m* v² / (16 √R* E*))^{2/5}  [accuracy H1]
    let indentation = libm::pow(15.0 * mass * speed * speed / (16.0 * root * modulus), 0.4);
    let contact = (radius * indentation).sqrt();
    // F = 4/3 E* √R* δ^{3/2}
    let force = 4.0 / 3.0 * modulus * root * indentation * indentation.sqrt();
    Hertz {
        // t_c = 2.943 δ/v = 2.87 (m*²/(E*² R* v))^{1/5}
        duration: DURATION_OVER_APPROACH * indentation / speed,
        indentation,
        radius: contact,
        force,
        // p₀ = 3F / 2πa²
        pressure: 1.5 * force / (std::f64::consts::PI * contact * contact),
    }
}

impl Hertz {
    /// Tension at the rim of the contact \[Pa\]: σ_r = (1 − 2ν) p₀ / 3.
    #[must_use]
    pub fn tension(&self, poisson: f64) -> f64 {
        (1.0 - 2.0 * poisson) * self.pressure / 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The three rows of the accuracy catalogue, H1: E* [Pa], m* [kg], R* [m], v [m/s] and δ, F,
    /// t_c, a, p₀, σ_r.
    #[test]
    fn the_three_rows_of_h1_come_out() {
        let rows = [
            (
                [55.8e9, 32.7e-3, 10e-3, 1.0],
                [31.3e-6, 1304.0, 92.2e-6, 0.560e-3, 1.99e9, 371e6],
                0.22,
            ),
            (
                [36.8e9, 2.68e-3, 4e-3, 5.0],
                [59.2e-6, 1414.0, 34.9e-6, 0.487e-3, 2.85e9, 532e6],
                0.22,
            ),
            (
                [0.167e9, 0.976, 27.5e-3, 5.0],
                [3.69e-3, 8.26e3, 2.17e-3, 10.1e-3, 38.9e6, 7.8e6],
                0.2,
            ),
        ];
        for ([modulus, mass, radius, speed], want, poisson) in rows {
            let h = hertz(mass, modulus, radius, speed);
            let got =
                [h.indentation, h.force, h.duration, h.radius, h.pressure, h.tension(poisson)];
            for (got, want) in got.into_iter().zip(want) {
                assert!((got / want - 1.0).abs() < 0.01, "{got} is not {want}: {h:?}");
            }
            let direct = 2.87 * libm::pow(mass * mass / (modulus * modulus * radius * speed), 0.2);
            assert!((h.duration / direct - 1.0).abs() < 0.01, "{} is not {direct}", h.duration);
            // The half-sine of peak F over t_c carries close to 2 m* v: F = 1.839 I/t_c at e = 1.
            let ratio = h.force * h.duration / (2.0 * mass * speed);
            assert!((ratio / 1.839 - 1.0).abs() < 0.01, "peak over mean is {ratio}");
        }
    }

    #[test]
    fn the_energy_of_the_approach_is_the_work_of_the_spring() {
        let h = hertz(0.3, 7e10, 0.02, 3.0);
        let work = 0.4 * h.force * h.indentation;
        assert!((work / (0.5 * 0.3 * 9.0) - 1.0).abs() < 1e-12, "{work}");
    }
}
