//! Energies that a sheet stores.

use crate::bending::{BendingStencils, curvature_form};
use crate::bonds::MembraneBonds;
use crate::law::{counted, generalised};
use crate::state::SheetState;
use crate::table::BondTable;
use cullet_model::MembraneLaw;

/// What elastic energies depend on beside the state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnergyInput<'a> {
    pub(crate) law: MembraneLaw,
    pub(crate) bonds: &'a MembraneBonds,
    pub(crate) table: &'a BondTable,
    pub(crate) stencils: &'a BendingStencils,
    pub(crate) areas: &'a [f64],
    /// Points that do not count.
    pub(crate) gone: &'a [bool],
    /// Λ \[N/m\].
    pub(crate) dilatation: f64,
    /// B \[J\] and ν \[1\].
    pub(crate) bending: [f64; 2],
}

impl EnergyInput<'_> {
    /// Of stretched bonds and dilated points \[J\].
    pub(crate) fn stretching(&self, state: &SheetState) -> f64 {
        let mut sum = 0.0;
        for i in self.points() {
            let (mut own, mut dilated) = (0.0, 0.0);
            for b in self.bonds.of(i) {
                let memory = state.memory(b);
                if memory.damage >= 1.0 {
                    continue;
                }
                let j = self.bonds.ends[b] as usize;
                let length = (state.places[j] - state.places[i]).norm();
                let g = generalised(self.law, length * self.table.rest[b]);
                let elastic = g - memory.plastic;
                let left = if g > 0.0 { 1.0 - memory.damage } else { 1.0 };
                own += self.table.stiffness[b] * left * elastic * elastic;
                dilated += self.table.stiffness[b] * counted(g, memory);
            }
            // Each bond is met from both ends.
            sum += 0.25 * own;
            if self.dilatation != 0.0 {
                let theta = 2.0 * dilated / self.table.sums[i];
                let lambda = self.dilatation * self.table.softness[i];
                sum += 0.5 * self.areas[i] * lambda * theta * theta;
            }
        }
        sum
    }

    /// Of bending \[J\].
    pub(crate) fn bending(&self, state: &SheetState) -> f64 {
        self.points().map(|i| self.bending_at(state, i)).sum()
    }

    fn points(&self) -> impl Iterator<Item = usize> {
        (0..self.areas.len()).filter(|&i| !self.gone[i])
    }

    /// The same of one point.
    pub(crate) fn bending_at(&self, state: &SheetState, i: usize) -> f64 {
        let [stiffness, poisson] = self.bending;
        let kappa = self.stencils.curvature(i, &state.places);
        let scale = self.areas[i] * stiffness * self.table.softness[i];
        0.5 * scale * curvature_form(&kappa, poisson).0
    }
}
