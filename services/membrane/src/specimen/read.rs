//! What is read off a sheet: its points, on the middle plane.

use super::outline::AlignedSheet;
use crate::law::counted;
use crate::law::{generalised, generalised_slope};
use crate::steps::SheetRun;
use cullet_geometry::symmetric::Sym3;
use cullet_geometry::{Mat3, Vec3};
use cullet_specimen::{FieldValues, LocalVector, PointField, PointFields};
use nalgebra::{Matrix2, Matrix3x2};
use std::collections::BTreeMap;

/// Share of the bonds that a straight crack half a spacing away takes, in a continuum, at which a
/// point is broken: points lie anywhere.
const BROKEN: f64 = 0.8;
/// Intervals of the integral over those bonds.
const INTERVALS: u32 = 512;

/// What is read off the points, and what of it was there before anything moved.
#[derive(Clone, Debug)]
pub(super) struct ReadSheet {
    /// Where each was \[m\].
    rest: Vec<Vec3>,
    /// Directions of the plane, and its normal.
    axes: [Vec3; 3],
    /// Bonds that notches took.
    notched: Vec<bool>,
    /// Share of bonds that is gone of a point that is broken \[1\].
    broken: f64,
}

/// Share of Σk beyond a line at the share `off` of the horizon from a point, in a continuum:
/// (6/π) ∫ r(1 − r) acos(off/r) dr from `off` to 1, by Simpson's rule in r = off + (1 − off)u²
/// \[1\].
fn beyond(off: f64) -> f64 {
    let n = INTERVALS;
    let value = |k: u32| {
        let u = f64::from(k) / f64::from(n);
        let r = off + (1.0 - off) * u * u;
        let weight = match k {
            0 => 1.0,
            k if k == n => 1.0,
            k if k % 2 == 1 => 4.0,
            _ => 2.0,
        };
        weight * r * (1.0 - r) * libm::acos((off / r).min(1.0)) * 2.0 * u * (1.0 - off)
    };
    let sum: f64 = (0..=n).map(value).sum();
    6.0 / std::f64::consts::PI * sum / (3.0 * f64::from(n))
}

impl ReadSheet {
    /// Of a sheet as it starts.
    pub(super) fn new(run: &SheetRun, shape: &AlignedSheet, rest: Vec<Vec3>) -> Self {
        Self {
            rest,
            axes: shape.axes.map(|axis| Vec3::ith(axis, 1.0)),
            notched: run.state.damage.iter().map(|d| *d >= 1.0).collect(),
            broken: BROKEN * beyond(0.5 / run.prepared.sheet().horizon),
        }
    }

    /// What the points carry.
    pub(super) fn fields(&self, run: &SheetRun, fields: &[PointField]) -> PointFields {
        let count = self.rest.len();
        let thickness = run.prepared.sheet().thickness;
        let slopes = |i: usize| run.stencils.slopes(i, &run.state.places);
        let dilatations = match fields.contains(&PointField::Stress) {
            true => self.dilatations(run),
            false => Vec::new(),
        };
        let vectors =
            |of: &dyn Fn(usize) -> LocalVector| FieldValues::Vectors((0..count).map(of).collect());
        let tensors =
            |of: &dyn Fn(usize) -> Sym3| FieldValues::Tensors((0..count).map(of).collect());
        let value = |field: PointField| match field {
            PointField::Displacement => vectors(&|i| LocalVector {
                value: run.state.places[i] - self.rest[i],
                gradient: self.gradient(&slopes(i)),
            }),
            PointField::Velocity => vectors(&|i| LocalVector {
                value: run.state.velocities[i],
                gradient: self.rate(&run.stencils.slopes(i, &run.state.velocities)),
            }),
            PointField::Stress => tensors(&|i| self.stress(run, &dilatations, i)),
            PointField::Strain => tensors(&|i| self.strain(run, i)),
            PointField::Damage => {
                FieldValues::Numbers((0..count).map(|i| self.damage(run, i)).collect())
            }
            // No specimen of a sheet flows.
            PointField::PlasticStrain | PointField::VolumeRatio => {
                FieldValues::Numbers(vec![f64::NAN; count])
            }
        };
        PointFields {
            places: self.rest.clone(),
            numbers: (0..count as u32).collect(),
            volumes: run.prepared.points.areas.iter().map(|area| area * thickness).collect(),
            fields: fields.iter().map(|&field| (field, value(field))).collect(),
        }
    }

    /// ∂u/∂X of a place over the plane, whose normal goes along.
    fn gradient(&self, [x, y]: &[Vec3; 2]) -> Mat3 {
        let [a, b, c] = self.axes;
        let normal = x.cross(y);
        let size = normal.norm();
        let up = if size > 0.0 { normal / size } else { c };
        (x - a) * a.transpose() + (y - b) * b.transpose() + (up - c) * c.transpose()
    }

    fn rate(&self, [x, y]: &[Vec3; 2]) -> Mat3 {
        x * self.axes[0].transpose() + y * self.axes[1].transpose()
    }

    /// A tensor of the plane, and across it, by the specimen's axes.
    fn tensor(&self, plane: &Matrix2<f64>, across: f64) -> Sym3 {
        let [a, b, c] = self.axes;
        let m = a * a.transpose() * plane[(0, 0)]
            + b * b.transpose() * plane[(1, 1)]
            + (a * b.transpose() + b * a.transpose()) * plane[(0, 1)]
            + c * c.transpose() * across;
        [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(1, 2)], m[(2, 0)]]
    }

    /// Green's strain of the middle plane.
    fn strain(&self, run: &SheetRun, i: usize) -> Sym3 {
        let f = Matrix3x2::from_columns(&run.stencils.slopes(i, &run.state.places));
        let plane = (f.transpose() * f - Matrix2::identity()) * 0.5;
        let poisson = run.prepared.sheet().material.poisson;
        self.tensor(&plane, -poisson / (1.0 - poisson) * plane.trace())
    }

    /// 2ΛAθ/Σk of each point \[1\]; nothing where bonds alone bear.
    fn dilatations(&self, run: &SheetRun) -> Vec<f64> {
        let prepared = &run.prepared;
        if prepared.dilatation == 0.0 {
            return vec![0.0; self.rest.len()];
        }
        let of = |i: usize| {
            let bond = |b: usize| {
                let g = self.stretch(run, i, b).0 - 1.0;
                run.table.stiffness[b] * counted(g, run.state.memory(b))
            };
            let theta = 2.0 * prepared.bonds.of(i).map(bond).sum::<f64>() / run.table.sums[i];
            2.0 * prepared.dilatation * prepared.points.areas[i] * theta / run.table.sums[i]
        };
        (0..self.rest.len()).map(of).collect()
    }

    /// s and the direction of a bond now.
    fn stretch(&self, run: &SheetRun, i: usize, b: usize) -> (f64, Vec3) {
        let j = run.prepared.bonds.ends[b] as usize;
        let off = run.state.places[j] - run.state.places[i];
        let length = off.norm();
        (length * run.table.rest[b], off / length)
    }

    /// The second Piola-Kirchhoff stress of the middle plane by the virial of the bonds \[Pa\].
    fn stress(&self, run: &SheetRun, dilatations: &[f64], i: usize) -> Sym3 {
        let (prepared, table) = (&run.prepared, &run.table);
        let law = prepared.sheet().material.law;
        let mut first = Matrix3x2::zeros();
        for b in prepared.bonds.of(i) {
            let memory = run.state.memory(b);
            if memory.damage >= 1.0 {
                continue;
            }
            let (stretch, along) = self.stretch(run, i, b);
            let g = generalised(law, stretch);
            let left = if g > 0.0 { 1.0 - memory.damage } else { 1.0 };
            let both = dilatations[i] + dilatations[prepared.bonds.ends[b] as usize];
            let tension = left * (g - memory.plastic) + (1.0 - memory.damage) * both;
            let force =
                table.stiffness[b] * tension * generalised_slope(law, stretch) * table.rest[b];
            let [x, y] = prepared.bonds.directions[b];
            let rest = nalgebra::RowVector2::new(x, y) * prepared.bonds.lengths[b];
            first += along * force * rest;
        }
        first *= 0.5 / (prepared.points.areas[i] * prepared.sheet().thickness);
        let f = Matrix3x2::from_columns(&run.stencils.slopes(i, &run.state.places));
        let second = match (f.transpose() * f).try_inverse() {
            Some(back) => back * f.transpose() * first,
            None => Matrix2::zeros(),
        };
        self.tensor(&((second + second.transpose()) * 0.5), 0.0)
    }

    /// Share of a point's bonds that is gone since, over that of a broken one \[1\].
    fn damage(&self, run: &SheetRun, i: usize) -> f64 {
        let (mut gone, mut all) = (0.0, 0.0);
        for b in run.prepared.bonds.of(i).filter(|&b| !self.notched[b]) {
            let k = run.prepared.bonds.stiffness[b];
            all += k;
            gone += if run.state.damage[b] >= 1.0 { k } else { 0.0 };
        }
        if all > 0.0 { (gone / (all * self.broken)).min(1.0) } else { 0.0 }
    }

    /// Shares of the sheet's mass that its pieces have, the largest first.
    pub(super) fn shares(&self, run: &SheetRun) -> Vec<f64> {
        let mut sizes: BTreeMap<u32, f64> = BTreeMap::new();
        for (label, mass) in run.state.labels.iter().zip(&run.masses) {
            *sizes.entry(*label).or_default() += mass[0];
        }
        let whole: f64 = sizes.values().sum();
        let mut shares: Vec<f64> = sizes.into_values().map(|size| size / whole).collect();
        shares.sort_unstable_by(|a, b| b.total_cmp(a));
        shares
    }
}

#[cfg(test)]
mod tests {
    use super::beyond;

    #[test]
    fn a_line_through_a_point_takes_half_of_its_bonds() {
        assert!((beyond(0.0) - 0.5).abs() < 1e-6, "{}", beyond(0.0));
        assert!(beyond(1.0) == 0.0 && beyond(0.2) < 0.5 * (1.0 - 0.2));
    }
}
