//! Pieces of a soft solid that have come to rest, as rigid bodies.

use super::super::surface::{HeldBonds, TornSolid};
use super::SoftSolidWindow;
use cullet_continuum::rest::POINTS;
use cullet_continuum::settled::{MOST_SETTLED, settled};
use cullet_model::{SettledPiece, TornPiece};
use std::collections::BTreeMap;

impl SoftSolidWindow {
    /// Pieces that are at rest now, by number, where they shall become rigid bodies.
    pub(super) fn settled(&self) -> Vec<SettledPiece> {
        let (state, prepared) = (&self.run.state, &self.run.prepared);
        let mut pieces = self.pieces();
        let points = |number: u32| state.labels.iter().filter(|label| **label == number).count();
        pieces.retain(|piece| piece.frozen && points(piece.number) >= POINTS as usize);
        if self.window.retired.is_none() || pieces.is_empty() {
            return Vec::new();
        }
        let held = HeldBonds::of(&state.domain, prepared.body().spacing);
        let drawn = TornSolid::surface(&prepared.surface, &held);
        let places = drawn.places(&state.domain, &prepared.rest);
        let mut own: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
        for corners in &drawn.surface.triangles {
            let label = state.labels[drawn.carrier(corners[0]) as usize];
            own.entry(label).or_default().push(*corners);
        }
        let body = |piece: &TornPiece| {
            settled(piece.number, own.get(&piece.number)?, &places, 0.0, piece.mass)
        };
        pieces.iter().filter_map(body).take(MOST_SETTLED).collect()
    }
}
