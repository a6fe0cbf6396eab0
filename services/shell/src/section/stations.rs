//! Stations through the thickness.

/// Places and weights through a thickness of 1: ∫f dz = t Σ w f(t z).
#[derive(Clone, Debug, PartialEq)]
pub struct Stations(Vec<(f64, f64)>);

impl Stations {
    /// Place over t in [−½, ½] and weight of each.
    #[must_use]
    pub fn list(&self) -> &[(f64, f64)] {
        &self.0
    }
}

/// Gauss–Lobatto stations, which have both faces: three, five or seven; other numbers give five.
#[must_use]
pub fn lobatto(count: usize) -> Stations {
    let half: Vec<(f64, f64)> = match count {
        3 => vec![(0.0, 4.0 / 6.0), (0.5, 1.0 / 6.0)],
        7 => {
            let root = 2.0 * (5.0_f64 / 3.0).sqrt();
            let inner = 0.5 * ((5.0 - root) / 11.0).sqrt();
            let outer = 0.5 * ((5.0 + root) / 11.0).sqrt();
            let more = 7.0 * 15.0_f64.sqrt();
            let (near, far) = ((124.0 + more) / 700.0, (124.0 - more) / 700.0);
            vec![(0.0, 128.0 / 525.0), (inner, near), (outer, far), (0.5, 1.0 / 42.0)]
        }
        _ => {
            let inner = 0.5 * (3.0_f64 / 7.0).sqrt();
            vec![(0.0, 16.0 / 45.0), (inner, 49.0 / 180.0), (0.5, 0.05)]
        }
    };
    let below = half.iter().rev().filter(|s| s.0 > 0.0).map(|&(z, w)| (-z, w));
    Stations(below.chain(half.iter().copied()).collect())
}

#[cfg(test)]
mod tests {
    use super::lobatto;

    /// S12: Σ w = 1 and Σ w z² = 1/12, so that D is Et³/12(1 − ν²); and the next even moment.
    #[test]
    fn stations_give_the_bending_stiffness() {
        for count in [3, 5, 7] {
            let stations = lobatto(count);
            assert_eq!(stations.list().len(), count);
            let moment =
                |n: i32| -> f64 { stations.list().iter().map(|(z, w)| w * z.powi(n)).sum() };
            assert!((moment(0) - 1.0).abs() < 1e-12 && moment(1).abs() < 1e-16);
            assert!((moment(2) * 12.0 - 1.0).abs() < 1e-12, "{count}: {}", moment(2));
            assert_eq!((moment(4) * 80.0 - 1.0).abs() < 1e-12, count > 3);
        }
    }
}
