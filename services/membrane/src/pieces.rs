//! The parts that a sheet has come to.

use crate::bonds::MembraneBonds;

/// Bonds up to this length, in spacings, hold a piece together. Longer ones that still cross a line
/// which has parted are ties, and bear nothing a continuum would.
const HOLDING: f64 = 1.6;

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
