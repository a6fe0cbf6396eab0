//! Dashpots of bonds.

use super::pull::{WideForce, add, total};
use super::{ABREAST, BondShape, lanes, window};
use crate::bonds::BondGraph;
use cullet_geometry::Vec3;
use cullet_simd::{LaneRows, Lanes, PackedRecord, gather_records, sum_lanes};
use fearless_simd::{Simd, SimdBase, f32x16, f64x8};

/// What the pass of the dashpots reads.
pub(crate) struct DashpotPass<'a> {
    pub(crate) bonds: &'a BondGraph,
    /// Place at rest and displacement.
    pub(crate) records: &'a [PackedRecord],
    /// Velocities in the body's frame over the horizon \[1/s\].
    pub(crate) velocities: &'a [PackedRecord],
    /// k of each bond; empty where all are whole \[1\].
    pub(crate) left: &'a [Lanes<f32>],
    /// 15η \[Pa s\].
    pub(crate) viscosity: f32,
}

impl DashpotPass<'_> {
    /// The force on a point over the mean volume and times the horizon \[Pa\], and what its bonds
    /// take over the mean volume \[W/m³\].
    #[inline(always)]
    pub(crate) fn point<S: Simd>(&self, simd: S, point: usize) -> (Vec3, f32) {
        let mut sum = [[f64x8::splat(simd, 0.0); 2]; 3];
        let mut power = f32x16::splat(simd, 0.0);
        let mut groups = self.bonds.groups(point);
        while groups.len() >= ABREAST {
            self.groups::<S, ABREAST>(simd, point, groups.start, &mut sum, &mut power);
            groups.start += ABREAST;
        }
        while !groups.is_empty() {
            self.groups::<S, 1>(simd, point, groups.start, &mut sum, &mut power);
            groups.start += 1;
        }
        (Vec3::new(total(sum[0]), total(sum[1]), total(sum[2])), sum_lanes(simd, power))
    }

    #[inline(always)]
    fn groups<S: Simd, const N: usize>(
        &self,
        simd: S,
        point: usize,
        first: usize,
        sum: &mut WideForce<S>,
        power: &mut f32x16<S>,
    ) {
        let own = &self.records[point];
        let shape = BondShape::<S, N>::of(simd, self.records, own, self.bonds, first);
        let own = &self.velocities[point].0;
        let mut speeds = [LaneRows::<S, N>::splat(simd, 0.0); 3];
        for k in 0..N {
            let (base, ends) = (self.bonds.bases[first + k], &self.bonds.ends[first + k]);
            let found = gather_records(simd, window(self.velocities, base), ends);
            for (c, speed) in speeds.iter_mut().enumerate() {
                speed.0[k] = found[c] - own[c];
            }
        }
        let [x, y, z] = shape.along;
        let rate = (x * speeds[0] + y * speeds[1] + z * speeds[2]) * shape.inverse;
        let mut drag = rate * LaneRows::splat(simd, self.viscosity);
        if !self.left.is_empty() {
            drag = drag * lanes(simd, self.left, first);
        }
        let weight = lanes(simd, &self.bonds.weights, first);
        let both = weight + lanes(simd, &self.bonds.back_weights, first);
        let pull = both * drag * shape.inverse;
        for (sum, along) in sum.iter_mut().zip(shape.along) {
            add(simd, sum, &(along * pull));
        }
        for row in (weight * drag * rate).0 {
            *power += row;
        }
    }
}
