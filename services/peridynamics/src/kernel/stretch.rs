//! The first pass: bonds soften, and the sums of each point are taken.

use super::{ABREAST, BondShape, lanes};
use crate::anisotropy::BondAnisotropy;
use crate::bonds::{BondGraph, BondSlot};
use crate::law::{BondBreaking, FlowedSums};
use cullet_geometry::Vec3;
use cullet_simd::{LANES, LaneRows, Lanes, PackedRecord, sum_lanes};
use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x16};

/// What the first pass reads.
pub(crate) struct StretchPass<'a> {
    pub(crate) bonds: &'a BondGraph,
    /// Place at rest, ductile damage, displacement and damage.
    pub(crate) records: &'a [PackedRecord],
    /// e_p of each bond, then the other end's; empty where nothing flows \[1\].
    pub(crate) flowed: [&'a [Lanes<f32>]; 2],
    /// How bonds soften, and s_c, where they do.
    pub(crate) breaking: Option<(BondBreaking, f64)>,
    /// In which direction they are stronger or weaker, where they are.
    pub(crate) strength: Option<BondAnisotropy>,
    /// Strength of each point over that of the law; empty where all have that \[1\].
    pub(crate) strengths: &'a [f32],
    /// The least of them, no more than 1 \[1\].
    pub(crate) weakest: f32,
    /// Whether they break by flow.
    pub(crate) ductile: bool,
    /// Whether sums over what has flowed are wanted.
    pub(crate) limited: bool,
}

/// Sums over a point's bonds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BondSums {
    /// Σwk over the mean volume.
    pub(crate) whole: f32,
    /// x̄ of x = q − e_p, over the bonds that are left \[1\].
    pub(crate) mean: f32,
    /// Σwk(x − x̄)²/Σwk \[1\].
    pub(crate) deviation: f32,
    /// Where wanted.
    pub(crate) flowed: FlowedSums,
}

/// Some groups of a point.
struct PointGroups {
    point: usize,
    /// The first of them.
    first: usize,
    /// The first of the point's.
    origin: usize,
    /// An extension near the point's mean.
    about: f32,
}

impl StretchPass<'_> {
    /// Softens the bonds of a point, `left` being theirs and empty where all are whole, and sums
    /// them up about the extension `about`, which should be near their mean. Of bonds that soften,
    /// what was left before goes to `before`.
    #[inline(always)]
    pub(crate) fn point<S: Simd>(
        &self,
        simd: S,
        point: usize,
        about: f32,
        left: &mut [Lanes<f32>],
        before: &mut Vec<(BondSlot, f32)>,
    ) -> BondSums {
        let zero = f32x16::splat(simd, 0.0);
        let mut sums = [zero; 6];
        let mut groups = self.bonds.groups(point);
        let mut at = PointGroups { point, first: groups.start, origin: groups.start, about };
        while groups.len() >= ABREAST {
            at.first = groups.start;
            self.groups::<S, ABREAST>(simd, &at, left, before, &mut sums);
            groups.start += ABREAST;
        }
        while !groups.is_empty() {
            at.first = groups.start;
            self.groups::<S, 1>(simd, &at, left, before, &mut sums);
            groups.start += 1;
        }
        let [whole, first, second, e, ex, ee] = sums;
        let (whole, first) = (sum_lanes(simd, whole), sum_lanes(simd, first));
        let second = sum_lanes(simd, second);
        if whole <= 0.0 {
            return BondSums::default();
        }
        let shift = first / whole;
        let deviation = (second / whole - shift * shift).max(0.0);
        let mut flowed = FlowedSums::default();
        if self.limited {
            let mean = |sum| f64::from(sum_lanes(simd, sum)) / f64::from(whole);
            let product = mean(ex) - mean(e) * f64::from(shift);
            flowed = FlowedSums { square: mean(ee), product };
        }
        BondSums { whole, mean: about + shift, deviation, flowed }
    }

    /// Adds up Σwk, Σwkx, Σwkx² of `N` groups, x from `about`, and where wanted Σwke, Σwkex, Σwke².
    #[inline(always)]
    fn groups<S: Simd, const N: usize>(
        &self,
        simd: S,
        at: &PointGroups,
        left: &mut [Lanes<f32>],
        before: &mut Vec<(BondSlot, f32)>,
        sums: &mut [f32x16<S>; 6],
    ) {
        let own = &self.records[at.point];
        let shape = BondShape::<S, N>::of(simd, self.records, own, self.bonds, at.first);
        let mut weight = lanes(simd, &self.bonds.weights, at.first);
        if !left.is_empty() {
            let left = &mut left[at.first - at.origin..];
            self.soften(simd, &shape, at, left, before);
            weight = weight * lanes(simd, left, 0);
        }
        let mut x = shape.stretch - LaneRows::splat(simd, at.about);
        if !self.flowed[0].is_empty() {
            x = x - lanes(simd, self.flowed[0], at.first);
        }
        let product = weight * x;
        let square = product * x;
        for k in 0..N {
            sums[0] += weight.0[k];
            sums[1] += product.0[k];
            sums[2] += square.0[k];
        }
        if self.limited && !self.flowed[0].is_empty() {
            let e = lanes(simd, self.flowed[0], at.first);
            let (own, cross, square) = (weight * e, product * e, weight * e * e);
            for k in 0..N {
                sums[3] += own.0[k];
                sums[4] += cross.0[k];
                sums[5] += square.0[k];
            }
        }
    }

    /// Softens bonds by their elastic stretch, the mean of both ends'.
    #[inline(always)]
    fn soften<S: Simd, const N: usize>(
        &self,
        simd: S,
        shape: &BondShape<S, N>,
        at: &PointGroups,
        left: &mut [Lanes<f32>],
        before: &mut Vec<(BondSlot, f32)>,
    ) {
        let half = LaneRows::splat(simd, 0.5);
        let mut elastic = shape.stretch;
        if !self.flowed[0].is_empty() {
            let own = lanes(simd, self.flowed[0], at.first);
            let back = lanes(simd, self.flowed[1], at.first);
            elastic = elastic - (own + back) * half;
        }
        let [flow, damage] = [3, 7].map(|c| LaneRows::splat(simd, self.records[at.point].0[c]));
        let mut critical = LaneRows::<S, N>::splat(simd, f32::MAX);
        if let Some((breaking, limit)) = &self.breaking {
            let dust = LaneRows::splat(simd, breaking.dust as f32);
            let rise = (shape.other[1] + damage) * half * dust + LaneRows::splat(simd, 1.0);
            critical = rise * LaneRows::splat(simd, *limit as f32);
        }
        if self.ductile {
            // What has flowed too far bears no stretch at all.
            let flow = (shape.other[0] + flow) * half;
            let (one, zero) = (f32x16::splat(simd, 1.0), f32x16::splat(simd, 0.0));
            for k in 0..N {
                critical.0[k] = flow.0[k].simd_ge(one).select(zero, critical.0[k]);
            }
        }
        let least = self.strength.map_or(1.0, |how| how.strength.min(1.0));
        let soft = critical * LaneRows::splat(simd, 0.5 * self.weakest * least as f32);
        for (k, left) in left.iter_mut().enumerate().take(N) {
            if elastic.0[k].simd_gt(soft.0[k]).any_true() {
                let (mut stretches, mut limits) = ([0.0; LANES], [0.0; LANES]);
                elastic.0[k].store_slice(&mut stretches);
                critical.0[k].store_slice(&mut limits);
                if let Some(how) = &self.strength {
                    self.turn_limits(&mut limits, at, at.first + k, how);
                }
                if !self.strengths.is_empty() {
                    self.scale_limits(&mut limits, at.point, at.first + k);
                }
                self.soften_some([&stretches, &limits], at.first + k, left, before);
            }
        }
    }

    /// Changes s_c of sixteen bonds by their directions at rest.
    #[inline(never)]
    fn turn_limits(
        &self,
        limits: &mut [f32; LANES],
        at: &PointGroups,
        group: usize,
        how: &BondAnisotropy,
    ) {
        let place = |point: usize| {
            let [x, y, z, ..] = self.records[point].0;
            Vec3::new(f64::from(x), f64::from(y), f64::from(z))
        };
        let (own, axis) = (place(at.point), how.axis.normalize());
        for (limit, end) in limits.iter_mut().zip(self.bonds.ends[group]) {
            let rest = place(self.bonds.bases[group] as usize + end as usize) - own;
            let along = rest.dot(&axis).powi(2) / rest.norm_squared();
            *limit *= (1.0 - (1.0 - how.strength) * along) as f32;
        }
    }

    /// Changes s_c of sixteen bonds by the strengths of their ends.
    #[inline(never)]
    fn scale_limits(&self, limits: &mut [f32; LANES], point: usize, group: usize) {
        let own = self.strengths[point];
        for (limit, end) in limits.iter_mut().zip(self.bonds.ends[group]) {
            *limit *= own.min(self.strengths[self.bonds.bases[group] as usize + end as usize]);
        }
    }

    /// Softens those of sixteen bonds that are drawn further than before.
    #[inline(never)]
    fn soften_some(
        &self,
        [elastic, critical]: [&[f32; LANES]; 2],
        group: usize,
        left: &mut Lanes<f32>,
        before: &mut Vec<(BondSlot, f32)>,
    ) {
        for lane in 0..LANES {
            let [stretch, limit] = [elastic[lane], critical[lane]].map(f64::from);
            let (now, old) = (BondBreaking::left(stretch, limit) as f32, left.0[lane]);
            if now < old {
                left.0[lane] = now;
                if self.bonds.weights[group].0[lane] > 0.0 {
                    let end = self.bonds.bases[group] as usize;
                    let end = end + self.bonds.ends[group][lane] as usize;
                    before.push((BondSlot { group, lane, end }, old));
                }
            }
        }
    }
}
