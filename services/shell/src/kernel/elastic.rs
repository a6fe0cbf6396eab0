//! Elasticity in lanes: in plane stress, and of soft walls at any strain through the thickness.

use super::strain::{Vectors, three};
use crate::section::{LEAST_AREA, SectionLaw, SoftElasticity};
use cullet_simd::{Real, V};
use fearless_simd::{Simd, SimdBase};

/// Elasticity in plane stress.
pub(super) struct ElasticLanes<R> {
    modulus: R,
    poisson: R,
    /// 1 − ν.
    shear: R,
    /// Whether von Mises' stress counts, or else the greatest principal one.
    pub(super) yields: bool,
    /// Of a soft wall.
    pub(super) soft: Option<SoftLanes<R>>,
}

/// Most stations through the thickness.
const MOST_STATIONS: usize = 5;

/// What a soft wall is, as the lanes need it.
pub(super) struct SoftLanes<R> {
    neo_hookean: Option<NeoHookeanLanes<R>>,
    /// Place over the thickness and weight of each.
    stations: [(R, R); MOST_STATIONS],
    count: usize,
    /// Height of a face over the thickness.
    pub(super) outer: R,
    /// [`crate::section::SoftSection::viscosity`].
    pub(super) viscosity: R,
}

/// See [`crate::section::NeoHookean`].
struct NeoHookeanLanes<R> {
    lambda: R,
    mu: R,
    /// μ(λ + 2μ).
    both: R,
    /// Slope of what goes by the area below [`LEAST_AREA`].
    rises: R,
}

impl<R: Real> SoftLanes<R> {
    #[inline(always)]
    pub(super) fn of(law: &SectionLaw) -> Option<Self> {
        let soft = law.soft.as_ref()?;
        let neo_hookean = match &soft.elastic {
            SoftElasticity::Linear(_) => None,
            SoftElasticity::NeoHookean(neo) => Some(NeoHookeanLanes {
                lambda: R::of(neo.lambda),
                mu: R::of(neo.mu),
                both: R::of(neo.mu * (neo.lambda + 2.0 * neo.mu)),
                rises: R::of(neo.continued().1),
            }),
        };
        let mut stations = [(R::of(0.0), R::of(0.0)); MOST_STATIONS];
        let list = law.stations.list();
        for (to, &(z, w)) in stations.iter_mut().zip(list) {
            *to = (R::of(z * soft.bend), R::of(w));
        }
        Some(Self {
            neo_hookean,
            stations,
            count: list.len(),
            outer: R::of(0.5 * soft.bend),
            viscosity: R::of(soft.viscosity),
        })
    }

    /// n and m of a whole section of thickness `t`.
    #[inline(always)]
    pub(super) fn borne<S: Simd>(
        &self,
        simd: S,
        elastic: &ElasticLanes<R>,
        [membrane, bending]: [&Vectors<S, R>; 2],
        t: V<S, R>,
    ) -> [Vectors<S, R>; 2] {
        let zero = V::<S, R>::splat(simd, R::of(0.0));
        let (mut n, mut m) = ([zero; 3], [zero; 3]);
        for &(z, w) in &self.stations[..self.count] {
            let height = t * z;
            let e = three(|k| membrane[k] + bending[k] * height);
            let s = match &self.neo_hookean {
                Some(neo) => neo.stress::<S>(simd, &e),
                None => elastic.stress::<S>(&e),
            };
            let share = t * w;
            for k in 0..3 {
                let part = s[k] * share;
                n[k] += part;
                m[k] += part * height;
            }
        }
        [n, m]
    }
}

impl<R: Real> NeoHookeanLanes<R> {
    #[inline(always)]
    fn stress<S: Simd>(&self, simd: S, e: &Vectors<S, R>) -> Vectors<S, R> {
        let one = V::<S, R>::splat(simd, R::of(1.0));
        let least = V::<S, R>::splat(simd, R::of(LEAST_AREA));
        let mu = V::<S, R>::splat(simd, self.mu);
        let two = R::of(2.0);
        let (c11, c22, c12) = (one + e[0] * two, one + e[1] * two, e[2] * two);
        let d = c11 * c22 - c12 * c12;
        let at = d.max(least);
        let by_area = V::<S, R>::splat(simd, self.both) / ((at * self.lambda + mu + mu) * at)
            + (at - d) * self.rises;
        [mu - by_area * c22, mu - by_area * c11, by_area * c12]
    }
}

impl<R: Real> ElasticLanes<R> {
    pub(super) fn of(law: &SectionLaw) -> Self {
        let (poisson, yields) = (law.elastic.poisson, law.hardening.is_some());
        let (modulus, shear) = (R::of(law.elastic.modulus), R::of(1.0 - poisson));
        let soft = SoftLanes::of(law);
        Self { modulus, poisson: R::of(poisson), shear, yields, soft }
    }

    /// Height of a face over the thickness, as stations have it.
    #[inline(always)]
    pub(super) fn outer(&self) -> R {
        self.soft.as_ref().map_or(R::of(0.5), |soft| soft.outer)
    }

    #[inline(always)]
    pub(super) fn stress<S: Simd>(&self, e: &Vectors<S, R>) -> Vectors<S, R> {
        [
            (e[0] + e[1] * self.poisson) * self.modulus,
            (e[1] + e[0] * self.poisson) * self.modulus,
            e[2] * self.shear * self.modulus,
        ]
    }
}
