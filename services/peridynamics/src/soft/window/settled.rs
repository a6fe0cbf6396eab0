//! Pieces of a soft solid that have come to rest, as rigid bodies.

use super::super::surface::{HeldBonds, TornSolid};
use super::SoftSolidWindow;
use cullet_continuum::SettledOffer;
use cullet_continuum::rest::POINTS;
use std::collections::BTreeMap;

impl SoftSolidWindow {
    /// Pieces that are at rest now, by number, where they shall become rigid bodies.
    pub(super) fn settled(&self) -> SettledOffer {
        let (state, prepared) = (&self.run.state, &self.run.prepared);
        let mut pieces = self.pieces();
        let points = |number: u32| state.labels.iter().filter(|label| **label == number).count();
        pieces.retain(|piece| piece.frozen && points(piece.number) >= POINTS as usize);
        if self.window.retired.is_none() || pieces.is_empty() {
            return SettledOffer::default();
        }
        let held = HeldBonds::of(&state.domain, prepared.body().spacing);
        let drawn = TornSolid::surface(&prepared.surface, &held);
        let places = drawn.places(&state.domain, &prepared.rest);
        let mut own: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
        for corners in &drawn.surface.triangles {
            let label = state.labels[drawn.carrier(corners[0]) as usize];
            own.entry(label).or_default().push(*corners);
        }
        SettledOffer::of(&pieces, &own, &places, &[])
    }
}
