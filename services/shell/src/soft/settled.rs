//! Pieces of a soft shell that have come to rest, as rigid bodies: closed walls of their present
//! shape. Those that go through themselves or through others stay soft.

use super::draw::PartedSurface;
use super::window::WallWindow;
use cullet_continuum::SettledOffer;
use cullet_continuum::crossings::crossings;
use std::collections::BTreeMap;

impl<const N: usize> WallWindow<N> {
    /// Pieces that are at rest now, by number, where they shall become rigid bodies.
    pub(super) fn settled(&self) -> SettledOffer {
        let (state, prepared) = (&self.run.state, &self.run.prepared);
        let mut pieces = self.pieces();
        pieces.retain(|piece| piece.frozen);
        if self.window.retired.is_none() || pieces.is_empty() {
            return SettledOffer::default();
        }
        let domain = &state.domain;
        let drawn = PartedSurface::new(&prepared.lattice, domain, prepared.thickness);
        let (places, owners) = (drawn.places(domain), drawn.owners(domain));
        let mut own: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
        let mut piece_at = vec![0; places.len()];
        // Beside cracks flaps overlap that no contact keeps apart.
        let mut whole = Vec::new();
        for (corners, &p) in drawn.surface.triangles.iter().zip(&owners) {
            let label = state.labels[p as usize];
            if pieces.binary_search_by_key(&label, |piece| piece.number).is_err() {
                continue;
            }
            own.entry(label).or_default().push(*corners);
            corners.iter().for_each(|&v| piece_at[v as usize] = label);
            if domain.is_whole(p as usize) {
                whole.push(*corners);
            }
        }
        for crossing in crossings(&whole, &places) {
            for v in crossing.edge.iter().chain(&crossing.triangle) {
                own.remove(&piece_at[*v as usize]);
            }
        }
        SettledOffer::of(&pieces, &own, &places, &drawn.thickness(domain))
    }
}

#[cfg(test)]
mod tests;
