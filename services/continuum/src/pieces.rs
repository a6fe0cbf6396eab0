//! The parts that a body has come to, and their numbers.

use cullet_model::TornPiece;

/// How long a piece must be at rest \[s\].
const TIME: f64 = 0.5;
/// How long a piece is at rest that has become a rigid body: it is not here any more, for good.
pub const GONE: u32 = u32::MAX;

/// A part, as a state has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PieceRecord {
    /// Its number; 0 is the body at its start.
    pub number: u32,
    /// The piece that it came from.
    pub parent: u32,
    /// Steps of the world before it came to be.
    pub born: u64,
    /// Steps of the world in a row in which it was at rest; [`GONE`] where it has become a rigid
    /// body.
    pub still: u32,
}

impl PieceRecord {
    /// Whether it has become a rigid body.
    #[must_use]
    pub fn is_gone(&self) -> bool {
        self.still == GONE
    }
}

/// Steps of the world after which a piece at rest is frozen.
#[must_use]
pub fn patience(world_step: f64) -> u32 {
    (TIME / world_step).ceil().max(1.0) as u32
}

/// Marks the points of pieces that have become rigid bodies. `labels` has the number of the piece
/// of each point.
#[must_use]
pub fn gone_points(labels: &[u32], pieces: &[PieceRecord]) -> Vec<bool> {
    let most = pieces.iter().map(|piece| piece.number).max().unwrap_or(0);
    let mut gone = vec![false; most as usize + 1];
    pieces.iter().for_each(|piece| gone[piece.number as usize] = piece.is_gone());
    labels.iter().map(|&label| gone[label as usize]).collect()
}

/// Marks the points of pieces that have been at rest for long, or are gone.
#[must_use]
pub fn frozen_points(labels: &[u32], pieces: &[PieceRecord], world_step: f64) -> Vec<bool> {
    let patience = patience(world_step);
    let most = pieces.iter().map(|piece| piece.number).max().unwrap_or(0);
    let mut still = vec![false; most as usize + 1];
    pieces.iter().for_each(|piece| still[piece.number as usize] = piece.still >= patience);
    labels.iter().map(|&label| still[label as usize]).collect()
}

/// The pieces that are here, by number, as an outcome has them. `of` has the mass \[kg\] and the
/// area \[m²\] of each point.
#[must_use]
pub fn torn_pieces(
    labels: &[u32],
    pieces: &[PieceRecord],
    world_step: f64,
    of: impl Fn(usize) -> (f64, f64),
) -> Vec<TornPiece> {
    let patience = patience(world_step);
    let here = pieces.iter().filter(|piece| !piece.is_gone());
    let mut torn: Vec<TornPiece> = here
        .map(|piece| TornPiece {
            number: piece.number,
            parent: piece.parent,
            born: piece.born,
            mass: 0.0,
            area: 0.0,
            frozen: piece.still >= patience,
        })
        .collect();
    torn.sort_by_key(|piece| piece.number);
    for (point, label) in labels.iter().enumerate() {
        if let Ok(slot) = torn.binary_search_by_key(label, |piece| piece.number) {
            let (mass, area) = of(point);
            torn[slot].mass += mass;
            torn[slot].area += area;
        }
    }
    torn
}

/// Numbers the pieces anew after bonds have broken: of the components that a piece has come to, the
/// one of most area keeps its number, and the others take new ones, by their first points.
/// `components` has the number of the first point of its component for each point, `areas` the area
/// of each \[m²\], and `step` is the number of steps of the world so far.
pub fn renumber(
    components: &[u32],
    areas: &[f64],
    labels: &mut [u32],
    pieces: &mut Vec<PieceRecord>,
    step: u64,
) {
    let mut area = vec![0.0; components.len()];
    for (i, &c) in components.iter().enumerate() {
        area[c as usize] += areas[i];
    }
    let old = labels.to_vec();
    let mut next = pieces.iter().map(|piece| piece.number + 1).max().unwrap_or(0);
    // The component that keeps each number.
    let mut keeps: Vec<Option<u32>> = vec![None; next as usize];
    let first = |&i: &usize| components[i] as usize == i;
    for c in (0..components.len()).filter(first) {
        let best = &mut keeps[old[c] as usize];
        if best.is_none_or(|b| area[c] > area[b as usize]) {
            *best = Some(c as u32);
        }
    }
    let mut number = vec![0; components.len()];
    for c in (0..components.len()).filter(first) {
        number[c] = old[c];
        if keeps[old[c] as usize] != Some(c as u32) {
            number[c] = next;
            pieces.push(PieceRecord { number: next, parent: old[c], born: step, still: 0 });
            next += 1;
        }
    }
    for (label, &c) in labels.iter_mut().zip(components) {
        *label = number[c as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::{PieceRecord, renumber};

    #[test]
    fn the_largest_part_keeps_the_number_and_others_name_their_parent() {
        let (mut labels, mut pieces) = (vec![0; 6], vec![PieceRecord::default()]);
        renumber(&[0, 0, 2, 2, 2, 0], &[1.0; 6], &mut labels, &mut pieces, 3);
        assert_eq!(labels, [0, 0, 1, 1, 1, 0]);
        assert_eq!(pieces[1], PieceRecord { number: 1, parent: 0, born: 3, still: 0 });
        renumber(&[0, 1, 2, 2, 2, 1], &[1.0; 6], &mut labels, &mut pieces, 9);
        assert_eq!(labels, [2, 0, 1, 1, 1, 0]);
        assert_eq!(pieces[2], PieceRecord { number: 2, parent: 0, born: 9, still: 0 });
    }
}
