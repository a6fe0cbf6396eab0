//! One quadrature point of each of sixteen cells: its section, as far as that is elastic.

use super::elastic::ElasticLanes;
use super::strain::{SurfaceLanes, Vectors, take, three};
use super::{PointSetup, SurfaceStrain};
use cullet_simd::{LANES, Lanes, Real, V, load};
use fearless_simd::{Simd, SimdBase, SimdMask};

/// A point of each of sixteen cells.
#[derive(Clone, Debug)]
pub(super) struct PointSlot<R> {
    pub(super) geometry: SurfaceLanes<R>,
    /// Area \[m²\]; none where there is no point.
    pub(super) area: Lanes<R>,
    /// t \[m\].
    pub(super) thickness: Lanes<R>,
    /// [`crate::section::SectionLaw::elastic_limit`] \[Pa\].
    limit: Lanes<R>,
    /// Lanes that are special whatever their stress.
    special: u16,
    /// Of what yields.
    flowed: Option<Box<FlowedLanes<R>>>,
    /// Of what is damped.
    pub(super) strained: Option<Box<StrainedLanes<R>>>,
}

/// Strains of the last step: of the midsurface, then of bending.
#[derive(Clone, Debug)]
pub(super) struct StrainedLanes<R> {
    pub(super) strain: [[Lanes<R>; 3]; 2],
    /// 1 where they are those of the last step, 0 where there was none.
    pub(super) known: Lanes<R>,
}

/// What points that yield bear less than if they had not, and the strain at which that was found:
/// of the midsurface, then of bending.
#[derive(Clone, Debug)]
struct FlowedLanes<R> {
    less: [[Lanes<R>; 3]; 2],
    strain: [[Lanes<R>; 3]; 2],
}

/// What the sections of a register's points bear: n̂ and m̂, 11, 22, 12.
pub(super) struct Section<S: Simd, R: Real> {
    /// Had nothing flowed.
    pub(super) whole: [Vectors<S, R>; 2],
    /// As far as they are elastic.
    pub(super) borne: [Vectors<S, R>; 2],
    /// Which of them may not be, a bit each.
    pub(super) stirred: u32,
}

#[inline(always)]
pub(super) fn strain_of<S: Simd, R: Real>(
    membrane: &Vectors<S, R>,
    bending: &Vectors<S, R>,
    lane: usize,
) -> SurfaceStrain {
    SurfaceStrain {
        membrane: three(|c| membrane[c][lane].wide()),
        bending: three(|c| bending[c][lane].wide()),
    }
}

impl<R: Real> PointSlot<R> {
    pub(super) fn empty() -> Self {
        let (zero, one) = (Lanes([R::of(0.0); LANES]), Lanes([R::of(1.0); LANES]));
        // A surface that is one, so that lanes without a cell make no infinities.
        let mut vectors = [[zero; 3]; 6];
        (vectors[0][0], vectors[1][1], vectors[5][2]) = (one, one, one);
        let geometry = SurfaceLanes { vectors, stretch: one, to_local: [one, zero, one] };
        let limit = Lanes([R::of(f64::from(f32::MAX)); LANES]);
        Self {
            geometry,
            area: zero,
            thickness: one,
            limit,
            special: 0,
            flowed: None,
            strained: None,
        }
    }

    pub(super) fn put(&mut self, lane: usize, setup: &PointSetup, live: bool) {
        let s = &setup.surface;
        let [a1, a2] = s.tangents;
        let [x11, x22, x12] = s.curvatures;
        for (lanes, vector) in
            self.geometry.vectors.iter_mut().zip([a1, a2, x11, x22, x12, s.normal])
        {
            (0..3).for_each(|c| lanes[c].0[lane] = R::of(vector[c]));
        }
        self.geometry.stretch.0[lane] = R::of(s.stretch);
        for (lanes, t) in self.geometry.to_local.iter_mut().zip(s.to_local) {
            lanes.0[lane] = R::of(t);
        }
        self.area.0[lane] = R::of(if live { s.area } else { 0.0 });
        self.thickness.0[lane] = R::of(setup.thickness);
        if let Some(strained) = &mut self.strained {
            strained.known.0[lane] = R::of(0.0);
        }
    }

    /// Takes how far a point is elastic ([`crate::section::SectionLaw::elastic_limit`]) \[Pa\].
    pub(super) fn watch(&mut self, lane: usize, limit: Option<f64>) {
        let most = f64::from(f32::MAX);
        self.limit.0[lane] = R::of(limit.unwrap_or(most).min(most));
        let bit = 1 << lane;
        self.special = if limit.is_none() { self.special | bit } else { self.special & !bit };
    }

    /// Takes what a point bears less than if nothing had flowed, and its strain.
    pub(super) fn note_flow(&mut self, lane: usize, less: &[[R; 3]; 2], strain: &SurfaceStrain) {
        let zero = || [[Lanes([R::of(0.0); LANES]); 3]; 2];
        let fresh = || Box::new(FlowedLanes { less: zero(), strain: zero() });
        let flowed = self.flowed.get_or_insert_with(fresh);
        for (j, strain) in [strain.membrane, strain.bending].into_iter().enumerate() {
            for i in 0..3 {
                flowed.less[j][i].0[lane] = less[j][i];
                flowed.strain[j][i].0[lane] = R::of(strain[i]);
            }
        }
    }

    /// What the points of a register bear at strains of the midsurface and of bending.
    #[inline(always)]
    pub(super) fn section<S: Simd>(
        &self,
        simd: S,
        elastic: &ElasticLanes<R>,
        [membrane, bending]: [&Vectors<S, R>; 2],
        lane: usize,
    ) -> Section<S, R> {
        let zero = V::<S, R>::splat(simd, R::of(0.0));
        let t = load(simd, &self.thickness, lane);
        let (mut s, mut c) = (elastic.stress::<S>(membrane), elastic.stress::<S>(bending));
        let whole = match &elastic.soft {
            Some(soft) => soft.borne(simd, elastic, [membrane, bending], t),
            None => {
                let cubed = t * t * t * R::of(1.0 / 12.0);
                [three(|k| s[k] * t), three(|k| c[k] * cubed)]
            }
        };
        let [mut n, mut m] = whole;
        if let Some(flowed) = &self.flowed {
            let ds = elastic.stress::<S>(&take(simd, &flowed.strain[0], lane));
            let dc = elastic.stress::<S>(&take(simd, &flowed.strain[1], lane));
            for k in 0..3 {
                (s[k], c[k]) = (s[k] - ds[k], c[k] - dc[k]);
                n[k] -= load(simd, &flowed.less[0][k], lane);
                m[k] -= load(simd, &flowed.less[1][k], lane);
            }
        }
        // The greatest stress, or the greatest change of one, is on one of the two faces.
        let (limit, outer) = (load(simd, &self.limit, lane), t * elastic.outer());
        let mut calm = limit.simd_gt(zero);
        for side in [outer, zero - outer] {
            let [s11, s22, s12] = three(|k| s[k] + c[k] * side);
            if elastic.yields {
                let mises = s11 * s11 + s22 * (s22 - s11) + s12 * s12 * R::of(3.0);
                calm &= (limit * limit).simd_gt(mises);
            } else {
                let below = limit - (s11 + s22) * R::of(0.5);
                let half = (s11 - s22) * R::of(0.5);
                calm &= below.simd_gt(zero) & (below * below).simd_gt(half * half + s12 * s12);
            }
        }
        let width = V::<S, R>::LEN;
        let mut stirred = u32::from(self.special >> lane) & ((1 << width) - 1);
        if !calm.all_true() {
            (0..width).filter(|&k| !calm.test(k)).for_each(|k| stirred |= 1 << k);
        }
        Section { whole, borne: [n, m], stirred }
    }
}
