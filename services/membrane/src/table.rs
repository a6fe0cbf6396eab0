//! The working numbers of bonds: what steps read, worked out anew whenever the quantity that
//! diffuses has changed.

use crate::bonds::MembraneBonds;
use crate::diffusion::share_at;
use crate::law::{LeftShares, StretchLimits};
use cullet_continuum::bytes::held;
use cullet_model::{MembraneLaw, SheetDiffusion};

/// Numbers by bond.
#[derive(Clone, Debug)]
pub(crate) struct BondTable {
    /// k \[J\].
    pub(crate) stiffness: Vec<f64>,
    /// 1/(ξ(1 + ε*)) \[1/m\].
    pub(crate) rest: Vec<f64>,
    /// s₀ or s_y, and s_c.
    pub(crate) limits: Vec<StretchLimits>,
    /// Σk of each point \[J\].
    pub(crate) sums: Vec<f64>,
    /// q_E of each point \[1\].
    pub(crate) softness: Vec<f64>,
    /// Factors on s_c by point, where it scatters.
    scatter: Option<Vec<f64>>,
    critical: f64,
    strength: f64,
    law: MembraneLaw,
}

impl BondTable {
    /// Memory that it takes \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let lists = [&self.stiffness, &self.rest, &self.sums, &self.softness];
        let scatter = self.scatter.as_ref().map_or(0, |list| held(list));
        lists.map(|list| held(list)).iter().sum::<u64>() + held(&self.limits) + scatter
    }

    /// Numbers of bonds that nothing has changed.
    pub(crate) fn new(
        bonds: &MembraneBonds,
        scatter: Option<Vec<f64>>,
        critical: f64,
        strength: f64,
        law: MembraneLaw,
    ) -> Self {
        let count = bonds.starts.len() - 1;
        let none = StretchLimits::new(law, strength, critical, LeftShares::WHOLE);
        let mut table = Self {
            stiffness: bonds.stiffness.clone(),
            rest: bonds.lengths.iter().map(|xi| 1.0 / xi).collect(),
            limits: vec![none; bonds.ends.len()],
            sums: Vec::new(),
            softness: vec![1.0; count],
            scatter,
            critical,
            strength,
            law,
        };
        table.sums = (0..count).map(|i| table.stiffness[bonds.of(i)].iter().sum()).collect();
        for i in 0..count {
            for b in bonds.of(i) {
                table.limits[b] = table.limit(i, bonds.ends[b] as usize, LeftShares::WHOLE);
            }
        }
        table
    }

    fn limit(&self, i: usize, j: usize, left: LeftShares) -> StretchLimits {
        let factor = self.scatter.as_ref().map_or(1.0, |all| 0.5 * (all[i] + all[j]));
        StretchLimits::new(self.law, self.strength, factor * self.critical, left)
    }

    /// Works all out anew for θ and the exposure of each point, one quantity after the other. What
    /// bonds remember stays. Shares that quantities leave multiply, and their strains add.
    pub(crate) fn update(
        &mut self,
        bonds: &MembraneBonds,
        quantities: &[SheetDiffusion],
        theta: &[f64],
        exposure: &[f64],
    ) {
        let count = bonds.starts.len() - 1;
        let each = || quantities.iter().enumerate().map(|(k, what)| (k * count, what));
        for i in 0..count {
            for b in bonds.of(i) {
                let j = bonds.ends[b] as usize;
                let [x, y] = bonds.directions[b];
                let (mut left, mut swollen) = (LeftShares::WHOLE, 0.0);
                for (first, what) in each() {
                    let (i, j) = (first + i, first + j);
                    let mean = 0.5 * (theta[i] + theta[j]);
                    let eaten = libm::exp(-0.5 * (exposure[i] + exposure[j]));
                    left.stiffness *= share_at(&what.stiffness, mean);
                    left.toughness *= share_at(&what.toughness, mean) * eaten;
                    left.strength *= share_at(&what.strength, mean);
                    let [along, across] = what.expansion;
                    swollen += (along * x * x + across * y * y) * (mean - what.start);
                }
                self.stiffness[b] = bonds.stiffness[b] * left.stiffness;
                self.rest[b] = 1.0 / (bonds.lengths[b] * (1.0 + swollen));
                self.limits[b] = self.limit(i, j, left);
            }
            self.sums[i] = self.stiffness[bonds.of(i)].iter().sum();
            let own = each().map(|(first, what)| share_at(&what.stiffness, theta[first + i]));
            self.softness[i] = own.product();
        }
    }
}
