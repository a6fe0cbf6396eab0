//! Bonds of a sheet: each point is bonded to those within the horizon δ.
//!
//! A bond of the stretch g has the energy ½k g². With the kernel W = 1 − ξ/δ its stiffness is
//! k = c W A_i A_j, then fitted so that at each point ½A⁻¹Σk n⊗n⊗n⊗n is that of an isotropic sheet:
//! Han and others' Eq. 24 is for solids, and one constant for all points leaves edges soft.

use crate::cells::PlaneGrid;
use crate::fit::{BondRows, FactorBounds, MomentTarget, fit};
use crate::outline::{SheetOutline, meet};
use crate::points::SheetPoints;
use cullet_continuum::bytes::held;
use cullet_model::{Refusal, SheetPlace};

/// Least and greatest horizon over the spacing. Below two the moments cannot be fitted; above six a
/// point has more than a hundred bonds.
const HORIZONS: [f64; 2] = [2.0, 6.0];
/// Bonds stay positive, and none is more than this of the mean of its point.
const FACTORS: FactorBounds = FactorBounds { low: 0.4, high: 4.0 };

/// The bonds of all points, each from both of its ends.
#[derive(Clone, Debug)]
pub struct MembraneBonds {
    /// First bond of each point, then their number.
    pub starts: Vec<u32>,
    /// Other ends, rising for each point.
    pub ends: Vec<u32>,
    /// Each bond as its other end has it.
    pub twins: Vec<u32>,
    /// ξ \[m\].
    pub lengths: Vec<f64>,
    /// n, from the point to the other end \[1\].
    pub directions: Vec<[f64; 2]>,
    /// k \[J\].
    pub stiffness: Vec<f64>,
    /// Whether a notch cuts it.
    pub cut: Vec<bool>,
}

impl MembraneBonds {
    /// Memory that it takes \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let ends = [&self.starts, &self.ends, &self.twins].map(|list| held(list));
        let lengths = held(&self.lengths) + held(&self.directions);
        ends.iter().sum::<u64>() + lengths + held(&self.stiffness) + held(&self.cut)
    }

    /// Bonds points within `horizon` spacings; none crosses the outline.
    ///
    /// # Errors
    ///
    /// If the horizon is not within \[2, 6\] spacings.
    pub(crate) fn new(
        points: &SheetPoints,
        outline: &SheetOutline,
        spacing: f64,
        horizon: f64,
    ) -> Result<Self, Refusal> {
        let [low, high] = HORIZONS;
        if horizon.is_nan() || horizon < low || horizon > high {
            let what = "the horizon of a sheet over its spacing";
            return Err(Refusal::OutOfRange { what, value: horizon, low, high });
        }
        let reach = horizon * spacing;
        let places = &points.places;
        let grid = PlaneGrid::new(places, reach);
        let near_edge: Vec<bool> = places.iter().map(|&p| outline.distance(p) < reach).collect();
        let (mut starts, mut ends) = (vec![0u32], Vec::new());
        for (i, &p) in places.iter().enumerate() {
            let first = ends.len();
            grid.around(p, reach, |j| {
                let q = places[j as usize];
                let squared = (q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1]);
                let crosses = || {
                    near_edge[i] && near_edge[j as usize] && {
                        let (a, b) = if (j as usize) < i { (q, p) } else { (p, q) };
                        outline.is_met_by(a, b)
                    }
                };
                if j as usize != i && squared < reach * reach && squared > 0.0 && !crosses() {
                    ends.push(j);
                }
            });
            ends[first..].sort_unstable();
            starts.push(ends.len() as u32);
        }
        let mut bonds = Self {
            twins: vec![0; ends.len()],
            lengths: vec![0.0; ends.len()],
            directions: vec![[0.0; 2]; ends.len()],
            stiffness: vec![0.0; ends.len()],
            cut: vec![false; ends.len()],
            starts,
            ends,
        };
        bonds.measure(points, reach);
        Ok(bonds)
    }

    fn measure(&mut self, points: &SheetPoints, reach: f64) {
        for i in 0..points.places.len() {
            let [x, y] = points.places[i];
            for b in self.of(i) {
                let j = self.ends[b] as usize;
                let back = &self.ends[self.of(j)];
                let slot = back.binary_search(&(i as u32)).unwrap_or(0);
                self.twins[b] = self.starts[j] + slot as u32;
                let (dx, dy) = (points.places[j][0] - x, points.places[j][1] - y);
                let length = (dx * dx + dy * dy).sqrt();
                self.lengths[b] = length;
                self.directions[b] = [dx / length, dy / length];
                self.stiffness[b] = (1.0 - length / reach) * (points.areas[i] * points.areas[j]);
            }
        }
    }

    /// The bonds of a point.
    #[must_use]
    pub fn of(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    /// Fits k so that ½A⁻¹Σk is `modulus` \[N/m\] at each point and the fourth moments are those
    /// of an isotropic sheet, ⟨n_x⁴⟩ = 3/8, ⟨n_x²n_y²⟩ = 1/8. That is 3Eh where ν = 1/3.
    pub(crate) fn fit(&mut self, areas: &[f64], modulus: f64) {
        let rows = BondRows { starts: &self.starts, twins: &self.twins };
        let directions = &self.directions;
        let basis = |b: usize| {
            let [x, y] = directions[b];
            let (xx, xy, yy) = (x * x, x * y, y * y);
            [xx * xx, xx * xy, xx * yy, xy * yy, yy * yy]
        };
        let target = |i: usize| {
            let sum = 2.0 * areas[i] * modulus;
            MomentTarget { moments: [0.375 * sum, 0.0, 0.125 * sum, 0.0, 0.375 * sum], sum }
        };
        fit(rows, &mut self.stiffness, basis, target, FACTORS);
    }

    /// The stretch at which bonds have cost `work` \[N\] by length of a crack, the mean over all
    /// directions: ½s_c²·(2/π)·½A⁻¹Σkξ, from the bonds that are there. The continuum's
    /// √(2πG/3Eδ) is 5 % more with a horizon of three spacings.
    pub(crate) fn critical_stretch(&self, areas: &[f64], work: f64) -> f64 {
        let own = |i: usize| {
            let sum: f64 = self.of(i).map(|b| self.stiffness[b] * self.lengths[b]).sum();
            0.5 * sum / areas[i]
        };
        let mean = (0..areas.len()).map(own).sum::<f64>() / areas.len() as f64;
        (work * std::f64::consts::PI / mean).sqrt()
    }

    /// Cuts bonds along lines. After the fit, so that the lips of a notch are as soft as those of a
    /// crack that has grown.
    pub(crate) fn cut_along(&mut self, lines: &[Vec<SheetPlace>], places: &[SheetPlace]) {
        for line in lines {
            for pair in line.windows(2) {
                for i in 0..places.len() {
                    for b in self.of(i) {
                        let j = self.ends[b] as usize;
                        if i < j && meet(places[i], places[j], pair[0], pair[1]) {
                            self.cut[b] = true;
                            self.cut[self.twins[b] as usize] = true;
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::MembraneBonds;
    use crate::outline::SheetOutline;
    use crate::points::relaxed;

    fn sheet() -> (crate::points::SheetPoints, MembraneBonds) {
        let outline = SheetOutline::new(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).unwrap();
        let points = relaxed(&outline, 0.02, 7).unwrap();
        let bonds = MembraneBonds::new(&points, &outline, 0.02, 3.015).unwrap();
        (points, bonds)
    }

    /// C1111 and C1122 of a point, turned by an angle, over ½A⁻¹Σk of an isotropic sheet.
    fn moduli(areas: &[f64], bonds: &MembraneBonds, i: usize) -> [f64; 2] {
        let sum = |f: &dyn Fn([f64; 2]) -> f64| {
            let all = bonds.of(i).map(|b| bonds.stiffness[b] * f(bonds.directions[b]));
            0.5 * all.sum::<f64>() / areas[i]
        };
        [sum(&|[x, _]| x * x * x * x), sum(&|[x, y]| x * x * y * y)]
    }

    fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
        (mean, (square / values.len() as f64).sqrt())
    }

    /// T1: moduli over their targets inside and at edges, E in two directions, G by the angle of a
    /// plane.
    #[test]
    fn fitted_bonds_are_isotropic_inside_and_at_edges() {
        let (points, mut bonds) = sheet();
        bonds.fit(&points.areas, 1.0);
        let inside = |i: &usize| points.places[*i].iter().all(|c| (0.06..=0.94).contains(c));
        let (inner, edge): (Vec<usize>, Vec<usize>) =
            (0..points.places.len()).partition(|i| inside(i));
        for (k, target) in [(0, 0.375), (1, 0.125)] {
            let over = |all: &[usize]| -> Vec<f64> {
                all.iter().map(|&i| moduli(&points.areas, &bonds, i)[k] / target).collect()
            };
            let (mean, deviation) = mean_and_deviation(&over(&inner));
            assert!((mean - 1.0).abs() < 2e-3 && deviation < 0.01, "{k}: {mean} {deviation}");
            let (mean, deviation) = mean_and_deviation(&over(&edge));
            assert!((mean - 1.0).abs() < 0.02 && deviation < 0.08, "{k}: {mean} {deviation}");
        }
        // E along an axis is C11 − C12²/C11; at 45° it has C11' = (C11 + C12)/2 + C12.
        let sums = inner.iter().fold([0.0; 2], |[a, b], &i| {
            let [c, d] = moduli(&points.areas, &bonds, i);
            [a + c, b + d]
        });
        let [c11, c12] = sums.map(|s| s / inner.len() as f64);
        let (along, across) = (0.5 * (c11 + c12) + c12, 0.5 * (c11 + c12) - c12);
        let ratio = (c11 - c12 * c12 / c11) / (along - across * across / along);
        assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
        let [mut least, mut most] = [f64::INFINITY, 0.0_f64];
        for k in 0..12 {
            let angle = std::f64::consts::PI * f64::from(k) / 12.0;
            let (sin, cos) = angle.sin_cos();
            let cost = inner.iter().flat_map(|&i| bonds.of(i)).map(|b| {
                let [x, y] = bonds.directions[b];
                bonds.stiffness[b] * bonds.lengths[b] * (x * cos + y * sin).abs()
            });
            let cost = cost.sum::<f64>();
            [least, most] = [least.min(cost), most.max(cost)];
        }
        assert!(most / least < 1.03, "{}", most / least);
    }

    #[test]
    fn each_bond_has_a_twin_of_the_same_stiffness_and_short_horizons_are_refused() {
        let (points, mut bonds) = sheet();
        bonds.fit(&points.areas, 1.0);
        for i in 0..points.places.len() {
            for b in bonds.of(i) {
                let twin = bonds.twins[b] as usize;
                assert_eq!(bonds.ends[twin] as usize, i);
                assert_eq!(bonds.twins[twin] as usize, b);
                assert_eq!(bonds.stiffness[twin], bonds.stiffness[b]);
                assert_eq!(bonds.lengths[twin], bonds.lengths[b]);
                assert!(bonds.stiffness[b] > 0.0);
            }
        }
        let outline = SheetOutline::new(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).unwrap();
        assert!(MembraneBonds::new(&points, &outline, 0.02, 1.9).is_err());
        // s_c of the bonds over that of a continuum.
        let ratio = bonds.critical_stretch(&points.areas, 1.0)
            / (2.0 * std::f64::consts::PI / (1.0 * 3.015 * 0.02)).sqrt();
        assert!((ratio - 0.955).abs() < 0.01, "{ratio}");
    }
}
