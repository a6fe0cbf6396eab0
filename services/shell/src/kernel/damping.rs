//! What inner damping adds to a section, by the strains of the last step.

use super::elastic::ElasticLanes;
use super::slot::{PointSlot, StrainedLanes};
use super::strain::{Vectors, take, three};
use cullet_simd::{LANES, Lanes, Real, V, load, store};
use fearless_simd::{Simd, SimdBase};

/// What damping adds to n and m, and what it takes \[J\].
pub(super) struct Damped<S: Simd, R: Real> {
    pub(super) borne: [Vectors<S, R>; 2],
    pub(super) taken: V<S, R>,
}

impl<R: Real> PointSlot<R> {
    /// Takes strains as those of the last step.
    #[inline(always)]
    pub(super) fn remember<S: Simd>(
        &mut self,
        simd: S,
        [membrane, bending]: [&Vectors<S, R>; 2],
        lane: usize,
    ) {
        let zero = || [[Lanes([R::of(0.0); LANES]); 3]; 2];
        let fresh =
            || Box::new(StrainedLanes { strain: zero(), known: Lanes([R::of(0.0); LANES]) });
        let strained = self.strained.get_or_insert_with(fresh);
        for k in 0..3 {
            store(simd, membrane[k], &mut strained.strain[0][k], lane);
            store(simd, bending[k], &mut strained.strain[1][k], lane);
        }
        store(simd, V::<S, R>::splat(simd, R::of(1.0)), &mut strained.known, lane);
    }

    /// What damping adds; nothing where there is none.
    #[inline(always)]
    pub(super) fn damped<S: Simd>(
        &mut self,
        simd: S,
        elastic: &ElasticLanes<R>,
        strain: [&Vectors<S, R>; 2],
        lane: usize,
    ) -> Option<Damped<S, R>> {
        let soft = elastic.soft.as_ref()?;
        let (none, viscosity) = (R::of(0.0), soft.viscosity);
        if viscosity == none {
            return None;
        }
        let t = load(simd, &self.thickness, lane);
        let height = t * (soft.outer * R::of(2.0));
        let zero = V::<S, R>::splat(simd, none);
        let Some(strained) = &self.strained else {
            self.remember(simd, strain, lane);
            return Some(Damped { borne: [[zero; 3]; 2], taken: zero });
        };
        let known = load(simd, &strained.known, lane);
        let change = |j: usize| {
            let before = take(simd, &strained.strain[j], lane);
            three(|k| (strain[j][k] - before[k]) * known)
        };
        let (de, dk) = (change(0), change(1));
        let (s, c) = (elastic.stress::<S>(&de), elastic.stress::<S>(&dk));
        let (share, cubed) = (t * viscosity, t * height * height * (viscosity * R::of(1.0 / 12.0)));
        let (n, m) = (three(|k| s[k] * share), three(|k| c[k] * cubed));
        let twice = R::of(2.0);
        let taken = n[0] * de[0]
            + n[1] * de[1]
            + n[2] * de[2] * twice
            + m[0] * dk[0]
            + m[1] * dk[1]
            + m[2] * dk[2] * twice;
        let area = load(simd, &self.area, lane);
        self.remember(simd, strain, lane);
        Some(Damped { borne: [n, m], taken: taken * area })
    }
}
