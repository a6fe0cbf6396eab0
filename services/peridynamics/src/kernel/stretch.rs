//! The first pass: bonds soften, and the sums of each point are taken.

use super::{ABREAST, BondShape, lanes};
use crate::bonds::{BondGraph, BondSlot};
use crate::law::BondBreaking;
use cullet_simd::{LANES, LaneRows, Lanes, PackedRecord, sum_lanes};
use fearless_simd::{Simd, SimdBase, SimdMask, f32x16};

/// What the first pass reads.
pub(crate) struct StretchPass<'a> {
    pub(crate) bonds: &'a BondGraph,
    /// Place at rest, nothing, displacement and damage.
    pub(crate) records: &'a [PackedRecord],
    /// e_p of each bond, then the other end's; empty where nothing flows \[1\].
    pub(crate) flowed: [&'a [Lanes<f32>]; 2],
    /// How bonds soften, and s_c, where they do.
    pub(crate) breaking: Option<(BondBreaking, f64)>,
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
}

/// How the bonds of a group soften.
struct BreakingGroup<'a> {
    breaking: &'a BondBreaking,
    group: usize,
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
        let mut sums = [zero; 3];
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
        let [whole, first, second] = sums;
        let (whole, first) = (sum_lanes(simd, whole), sum_lanes(simd, first));
        let second = sum_lanes(simd, second);
        if whole <= 0.0 {
            return BondSums::default();
        }
        let shift = first / whole;
        let deviation = (second / whole - shift * shift).max(0.0);
        BondSums { whole, mean: about + shift, deviation }
    }

    /// Adds up Σwk, Σwkx and Σwkx² of `N` groups, x from `about`.
    #[inline(always)]
    fn groups<S: Simd, const N: usize>(
        &self,
        simd: S,
        at: &PointGroups,
        left: &mut [Lanes<f32>],
        before: &mut Vec<(BondSlot, f32)>,
        sums: &mut [f32x16<S>; 3],
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
        let Some((breaking, critical)) = &self.breaking else { return };
        let half = LaneRows::splat(simd, 0.5);
        let mut elastic = shape.stretch;
        if !self.flowed[0].is_empty() {
            let own = lanes(simd, self.flowed[0], at.first);
            let back = lanes(simd, self.flowed[1], at.first);
            elastic = elastic - (own + back) * half;
        }
        let damage = LaneRows::splat(simd, self.records[at.point].0[7]);
        let dust = LaneRows::splat(simd, breaking.dust as f32);
        let rise = (shape.other[1] + damage) * half * dust + LaneRows::splat(simd, 1.0);
        let critical = rise * LaneRows::splat(simd, *critical as f32);
        let soft = critical * half;
        for (k, left) in left.iter_mut().enumerate().take(N) {
            if elastic.0[k].simd_gt(soft.0[k]).any_true() {
                let (mut stretches, mut limits) = ([0.0; LANES], [0.0; LANES]);
                elastic.0[k].store_slice(&mut stretches);
                critical.0[k].store_slice(&mut limits);
                let softens = BreakingGroup { breaking, group: at.first + k };
                self.soften_some([&stretches, &limits], &softens, left, before);
            }
        }
    }

    /// Softens those of sixteen bonds that are drawn further than before.
    #[inline(never)]
    fn soften_some(
        &self,
        [elastic, critical]: [&[f32; LANES]; 2],
        softens: &BreakingGroup<'_>,
        left: &mut Lanes<f32>,
        before: &mut Vec<(BondSlot, f32)>,
    ) {
        let group = softens.group;
        for lane in 0..LANES {
            let [stretch, limit] = [elastic[lane], critical[lane]].map(f64::from);
            let (now, old) = (softens.breaking.left(stretch, limit) as f32, left.0[lane]);
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
