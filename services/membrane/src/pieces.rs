//! The parts that a sheet has come to.

use crate::bonds::MembraneBonds;

/// Bonds up to this length, in spacings, hold a piece together. Longer ones that still cross a line
/// which has parted are ties, and bear nothing a continuum would.
const HOLDING: f64 = 1.6;

/// A part, as a state has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PieceRecord {
    pub(crate) number: u32,
    /// The piece that it came from.
    pub(crate) parent: u32,
    /// Steps of the world before it came to be.
    pub(crate) born: u64,
    /// Steps of the world in a row in which it was at rest.
    pub(crate) still: u32,
}

/// Component of each point by live bonds that hold: the number of its first point.
pub(crate) fn components(bonds: &MembraneBonds, damage: &[f64], spacing: f64) -> Vec<u32> {
    let count = bonds.starts.len() - 1;
    let mut label = vec![u32::MAX; count];
    let mut queue = Vec::new();
    for first in 0..count {
        if label[first] != u32::MAX {
            continue;
        }
        label[first] = first as u32;
        queue.push(first);
        while let Some(i) = queue.pop() {
            for b in bonds.of(i) {
                let j = bonds.ends[b] as usize;
                let holds = damage[b] < 1.0 && bonds.lengths[b] <= HOLDING * spacing;
                if holds && label[j] == u32::MAX {
                    label[j] = first as u32;
                    queue.push(j);
                }
            }
        }
    }
    label
}

/// Numbers the pieces anew after bonds have broken: of the components that a piece has come to, the
/// one of most area keeps its number, and the others take new ones, by their first points.
pub(crate) fn renumber(
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
    let next = pieces.iter().map(|piece| piece.number + 1).max().unwrap_or(0);
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
            number[c] = pieces.iter().map(|piece| piece.number + 1).max().unwrap_or(0);
            let (number, parent) = (number[c], old[c]);
            pieces.push(PieceRecord { number, parent, born: step, still: 0 });
        }
    }
    for (label, &c) in labels.iter_mut().zip(components) {
        *label = number[c as usize];
    }
}
