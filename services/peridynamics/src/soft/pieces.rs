//! The parts that a soft solid has come to.

use crate::PeridynamicDomain;
use crate::bonds::BondSlot;

/// Bonds up to this length, in spacings, hold a piece together. Longer ones that still cross a
/// face which has parted are ties, and bear nothing a continuum would.
pub(super) const HOLDING: f64 = 1.6;
/// What must be left of a bond for it to hold \[1\].
pub(super) const HOLDS: f64 = 0.1;

/// Whether a bond holds two points together.
pub(super) fn holds(
    domain: &PeridynamicDomain,
    point: usize,
    bond: BondSlot,
    spacing: f64,
) -> bool {
    domain.left(bond) > HOLDS && domain.rest(point, bond) <= HOLDING * spacing
}

/// Component of each point by bonds that hold: the number of its first point.
pub(super) fn components(domain: &PeridynamicDomain, spacing: f64) -> Vec<u32> {
    let count = domain.places.len();
    let mut label = vec![u32::MAX; count];
    let mut queue = Vec::new();
    for first in 0..count {
        if label[first] != u32::MAX {
            continue;
        }
        label[first] = first as u32;
        queue.push(first);
        while let Some(i) = queue.pop() {
            for bond in domain.bonds.of(i) {
                if label[bond.end] == u32::MAX && holds(domain, i, bond, spacing) {
                    label[bond.end] = first as u32;
                    queue.push(bond.end);
                }
            }
        }
    }
    label
}
