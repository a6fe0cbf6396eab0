//! Pieces of a sheet that have come to rest, as rigid bodies.

use super::MembraneWindow;
use crate::crossings::live_pairs;
use crate::steps::SheetRun;
use crate::surface::TornSurface;
use cullet_continuum::SettledOffer;
use cullet_geometry::Vec3;
use std::collections::BTreeMap;

impl SheetRun {
    /// The drawn surface of the pieces that are here. `alive` says which pairs of points hold.
    pub(super) fn torn_surface(&self, alive: &[bool]) -> TornSurface {
        let prepared = &self.prepared;
        let thickness = prepared.sheet().thickness as f32;
        let torn = TornSurface::new(&prepared.triangles, alive, thickness);
        match self.gone.contains(&true) {
            true => torn.without(&self.gone),
            false => torn,
        }
    }

    /// Slopes at each point \[1\].
    pub(super) fn slopes(&self) -> Vec<[Vec3; 2]> {
        let places = &self.state.places;
        (0..places.len()).map(|i| self.stencils.slopes(i, places)).collect()
    }
}

impl MembraneWindow {
    /// Pieces that are at rest now, by number, where they shall become rigid bodies.
    pub(super) fn settled(&self) -> SettledOffer {
        let mut pieces = self.pieces();
        pieces.retain(|piece| piece.frozen);
        if self.window.retired.is_none() || pieces.is_empty() {
            return SettledOffer::default();
        }
        let state = &self.run.state;
        let torn = self.run.torn_surface(&live_pairs(&self.run.prepared, &state.damage));
        let places = torn.places(&state.places, &self.run.slopes());
        let mut own: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
        for corners in &torn.surface.triangles {
            let label = state.labels[torn.ties(corners[0])[0].point as usize];
            own.entry(label).or_default().push(*corners);
        }
        let thickness = vec![self.run.prepared.sheet().thickness; places.len()];
        SettledOffer::of(&pieces, &own, &places, &thickness)
    }
}

#[cfg(test)]
mod tests;
