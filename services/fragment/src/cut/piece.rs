//! Pieces of a body under the cut, and which of them belong together.

use crate::region::agglomerate;
use cullet_geometry::Solid;
use cullet_geometry::boolean::Exact;
use std::collections::BTreeMap;

/// A piece of the body: a connected part of one region's share.
#[derive(Debug)]
pub(super) struct CutPiece {
    pub(super) label: u32,
    /// Labels of pieces that joined it.
    pub(super) also: Vec<u32>,
    /// With faces named by facet.
    pub(super) exact: Exact,
    /// With the true damage times.
    pub(super) solid: Solid,
    pub(super) volume: f64,
    /// The facets it ends at, and the area \[m²\] of each that is inside the body.
    pub(super) contacts: Vec<(u32, f64)>,
    /// Area of those \[m²\], and of those with damage near by.
    pub(super) crack: f64,
    pub(super) damaged: f64,
    /// Whether all its faces are new.
    pub(super) buried: bool,
}

/// Which pieces belong together, each group named by its largest.
pub(super) fn groups(pieces: &[CutPiece], floor: f64, max: usize) -> Vec<u32> {
    let mut ends: Vec<(u32, u32, f64)> = Vec::new();
    for (p, piece) in pieces.iter().enumerate() {
        ends.extend(piece.contacts.iter().map(|&(facet, area)| (facet, p as u32, area)));
    }
    ends.sort_unstable_by_key(|&(facet, piece, _)| (facet, piece));
    let mut shared: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    for group in ends.chunk_by(|a, b| a.0 == b.0) {
        for (k, &(_, p, mine)) in group.iter().enumerate() {
            for &(_, q, other) in &group[k + 1..] {
                if pieces[p as usize].label != pieces[q as usize].label {
                    *shared.entry((p, q)).or_insert(0.0) += mine.min(other);
                }
            }
        }
    }
    let volumes: Vec<f64> = pieces.iter().map(|piece| piece.volume).collect();
    // A crack of which less than half has damage behind it is an artefact (F27).
    let forced: Vec<bool> = pieces.iter().map(|piece| piece.damaged < 0.5 * piece.crack).collect();
    agglomerate(&volumes, &forced, &shared, floor, max)
}
