//! The second pass: what has flowed, and the forces.

use super::{ABREAST, BondShape, PullModuli, lanes};
use crate::bonds::BondGraph;
use cullet_geometry::Vec3;
use cullet_simd::{LaneRows, Lanes, PackedRecord};
use fearless_simd::{Simd, SimdBase, SimdMask, f32x16, f64x8};

/// What the second pass reads.
pub(crate) struct PullPass<'a> {
    pub(crate) bonds: &'a BondGraph,
    /// Place at rest and mean extension, displacement and what yielding left of z.
    pub(crate) records: &'a [PackedRecord],
    pub(crate) moduli: PullModuli,
    /// k of each bond; empty where all are whole \[1\].
    pub(crate) left: &'a [Lanes<f32>],
}

/// What the second pass writes, for some points in a row.
pub(crate) struct PullBlock<'a> {
    /// The first of them.
    pub(crate) first: usize,
    /// Over the mean volume and times the horizon \[Pa\].
    pub(crate) forces: &'a mut [Vec3],
    /// e_p of each of their bonds, then the other end's; empty where nothing flows \[1\].
    pub(crate) flowed: [&'a mut [Lanes<f32>]; 2],
}

/// e_p of a point's bonds, and as the other ends have it; both empty where nothing flows.
struct FlowedBonds<'a> {
    own: &'a mut [Lanes<f32>],
    back: &'a mut [Lanes<f32>],
}

/// A force in f64, eight lanes twice.
pub(super) type WideForce<S> = [[f64x8<S>; 2]; 3];

impl PullPass<'_> {
    /// Forces on the points of a block.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(&self, simd: S, block: PullBlock<'_>) {
        let PullBlock { first, forces, flowed: [own, back] } = block;
        let origin = self.bonds.groups(first).start;
        for (k, force) in forces.iter_mut().enumerate() {
            let point = first + k;
            let mut sum = [[f64x8::splat(simd, 0.0); 2]; 3];
            let mut groups = self.bonds.groups(point);
            let mut flowed = match own.is_empty() {
                true => FlowedBonds { own: &mut [], back: &mut [] },
                false => FlowedBonds {
                    own: &mut own[groups.start - origin..groups.end - origin],
                    back: &mut back[groups.start - origin..groups.end - origin],
                },
            };
            while groups.len() >= ABREAST {
                self.groups::<S, ABREAST>(simd, point, groups.start, &mut flowed, &mut sum);
                groups.start += ABREAST;
            }
            while !groups.is_empty() {
                self.groups::<S, 1>(simd, point, groups.start, &mut flowed, &mut sum);
                groups.start += 1;
            }
            *force = Vec3::new(total(sum[0]), total(sum[1]), total(sum[2]));
        }
    }

    /// Adds the forces of `N` groups from the one at `first`.
    #[inline(always)]
    fn groups<S: Simd, const N: usize>(
        &self,
        simd: S,
        point: usize,
        first: usize,
        flowed: &mut FlowedBonds<'_>,
        sum: &mut WideForce<S>,
    ) {
        let own = &self.records[point];
        let shape = BondShape::<S, N>::of(simd, self.records, own, self.bonds, first);
        let (mean, left) = (LaneRows::splat(simd, own.0[3]), LaneRows::splat(simd, own.0[7]));
        let [other, other_left] = shape.other;
        let bulk = LaneRows::splat(simd, self.moduli.mean);
        let shear = LaneRows::splat(simd, self.moduli.deviatoric);
        let (mut z, mut far_z) = (shape.stretch - mean, shape.stretch - other);
        if !flowed.own.is_empty() {
            let at = first - self.bonds.groups(point).start;
            let (one, two) = (lanes(simd, flowed.own, at), lanes(simd, flowed.back, at));
            let (whole, far_whole) = (z - one, far_z - two);
            (z, far_z) = (whole * left, far_whole * other_left);
            if own.0[7] < 1.0 || below_one(simd, &other_left) {
                put(&(one + (whole - z)), flowed.own, at);
                put(&(two + (far_whole - far_z)), flowed.back, at);
            }
        }
        let near = z * shear + mean * bulk;
        let far = far_z * shear + other * bulk;
        let weight = lanes(simd, &self.bonds.weights, first);
        let back_weight = lanes(simd, &self.bonds.back_weights, first);
        let mut pull = (near * weight + far * back_weight) * shape.inverse;
        if !self.left.is_empty() {
            pull = pull * lanes(simd, self.left, first);
        }
        for (sum, along) in sum.iter_mut().zip(shape.along) {
            add(simd, sum, &(along * pull));
        }
    }
}

/// Whether any is below 1.
#[inline(always)]
fn below_one<S: Simd, const N: usize>(simd: S, rows: &LaneRows<S, N>) -> bool {
    let one = f32x16::splat(simd, 1.0);
    let mut any = false;
    for row in &rows.0 {
        any |= row.simd_lt(one).any_true();
    }
    any
}

/// Writes the numbers of `N` groups from the one at `first`.
#[inline(always)]
fn put<S: Simd, const N: usize>(rows: &LaneRows<S, N>, list: &mut [Lanes<f32>], first: usize) {
    for (row, lanes) in rows.0.iter().zip(&mut list[first..first + N]) {
        row.store_slice(&mut lanes.0);
    }
}

/// Adds in f64.
#[inline(always)]
pub(super) fn add<S: Simd, const N: usize>(
    simd: S,
    sum: &mut [f64x8<S>; 2],
    more: &LaneRows<S, N>,
) {
    for row in &more.0 {
        let (low, high) = simd.widen_f32x16(*row);
        sum[0] += low;
        sum[1] += high;
    }
}

/// The sum over all lanes, in one order.
#[inline(always)]
pub(super) fn total<S: Simd>([low, high]: [f64x8<S>; 2]) -> f64 {
    let mut lanes = [0.0; 8];
    (low + high).store_slice(&mut lanes);
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
