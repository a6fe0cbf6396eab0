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

/// Gauss's stations, which have neither face: five or seven; other numbers give seven.
#[must_use]
pub fn gauss(count: usize) -> Stations {
    let half: &[(f64, f64)] = match count {
        5 => &[
            (0.0, 64.0 / 225.0),
            (0.269_234_655_052_841_55, 0.239_314_335_249_683_23),
            (0.453_089_922_969_332, 0.118_463_442_528_094_54),
        ],
        _ => &[
            (0.0, 0.208_979_591_836_734_7),
            (0.202_922_575_688_698_6, 0.190_915_025_252_559_47),
            (0.370_765_592_799_697_2, 0.139_852_695_744_638_34),
            (0.474_553_956_171_379_26, 0.064_742_483_084_434_85),
        ],
    };
    let below = half.iter().rev().filter(|s| s.0 > 0.0).map(|&(z, w)| (-z, w));
    Stations(below.chain(half.iter().copied()).collect())
}

#[cfg(test)]
mod tests {
    use super::{gauss, lobatto};

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

    /// Gauss's too, up to z⁸ with five and z¹² with seven.
    #[test]
    fn gauss_stations_take_powers_exactly() {
        for (count, most) in [(5, 8), (7, 12)] {
            let stations = gauss(count);
            assert_eq!(stations.list().len(), count);
            for n in (0..=most).step_by(2) {
                let moment: f64 = stations.list().iter().map(|(z, w)| w * z.powi(n)).sum();
                let wanted = 0.5_f64.powi(n) / f64::from(n + 1);
                assert!((moment / wanted - 1.0).abs() < 1e-12, "{count}, {n}: {moment}");
            }
        }
    }
}
