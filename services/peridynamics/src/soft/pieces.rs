//! The parts that a soft solid has come to, and which of them are at rest: after half a second they
//! are not moved any more, until something that moves comes near.

use crate::PeridynamicDomain;
use crate::bonds::BondSlot;
use cullet_continuum::rest::patience;
use cullet_continuum::{PieceRecord, RigidProxy};
use cullet_geometry::Vec3;

/// Bonds up to this length, in spacings, hold a piece together. Longer ones that still cross a
/// face which has parted are ties, and bear nothing a continuum would.
pub(super) const HOLDING: f64 = 1.6;
/// What must be left of a bond for it to hold \[1\].
pub(super) const HOLDS: f64 = 0.1;
/// Greatest speed of a point of a piece at rest \[m/s\]: half of what free fall gives in one step
/// of a world of 1/240 s.
const SPEED: f64 = 0.02;
/// Fewest points of a piece that wakes others, or becomes a rigid body.
pub(super) const POINTS: u32 = 6;

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

/// Numbers the pieces anew after bonds have broken: of the components that a piece has come to, the
/// one of most points keeps its number, and the others take new ones, by their first points.
pub(super) fn renumber(
    components: &[u32],
    labels: &mut [u32],
    pieces: &mut Vec<PieceRecord>,
    step: u64,
) {
    let mut sizes = vec![0_u32; components.len()];
    components.iter().for_each(|&c| sizes[c as usize] += 1);
    let old = labels.to_vec();
    let mut next = pieces.iter().map(|piece| piece.number + 1).max().unwrap_or(0);
    // The component that keeps each number.
    let mut keeps: Vec<Option<u32>> = vec![None; next as usize];
    let first = |&i: &usize| components[i] as usize == i;
    for c in (0..components.len()).filter(first) {
        let best = &mut keeps[old[c] as usize];
        if best.is_none_or(|b| sizes[c] > sizes[b as usize]) {
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

/// Marks the points of pieces at rest.
pub(super) fn frozen_points(labels: &[u32], pieces: &[PieceRecord], world_step: f64) -> Vec<bool> {
    let patience = patience(world_step);
    let most = pieces.iter().map(|piece| piece.number).max().unwrap_or(0);
    let mut still = vec![false; most as usize + 1];
    for piece in pieces {
        still[piece.number as usize] = piece.still >= patience;
    }
    labels.iter().map(|&label| still[label as usize]).collect()
}

/// Where a piece is and how it moves.
#[derive(Clone, Copy, Debug, Default)]
struct SolidMotion {
    points: u32,
    centre: Vec3,
    radius: f64,
    speed: f64,
    /// Whether a grip holds some of it.
    held: bool,
}

/// What tells whether pieces are at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct SolidRest<'a> {
    pub(super) labels: &'a [u32],
    pub(super) places: &'a [Vec3],
    pub(super) velocities: &'a [Vec3],
    /// Whether a grip holds each point.
    pub(super) held: &'a [bool],
    pub(super) proxies: &'a [RigidProxy],
    pub(super) spacing: f64,
    pub(super) world_step: f64,
}

impl SolidRest<'_> {
    /// Counts for how long each piece has been at rest; those that something comes near to begin
    /// anew.
    pub(super) fn count(&self, pieces: &mut [PieceRecord]) {
        let patience = patience(self.world_step);
        let motions = self.motions(pieces);
        let margin = 2.0 * self.spacing;
        let moves = |m: &SolidMotion| m.points >= POINTS && m.speed > SPEED;
        let moving: Vec<usize> = (0..motions.len()).filter(|&k| moves(&motions[k])).collect();
        for (k, piece) in pieces.iter_mut().enumerate().filter(|(_, piece)| !piece.is_gone()) {
            let own = &motions[k];
            let near = |other: &SolidMotion| {
                let reach = own.radius + other.radius + margin + other.speed * self.world_step;
                (own.centre - other.centre).norm() < reach
            };
            let reached = |proxy: &RigidProxy| {
                proxy.may_reach(own.centre, own.radius + margin, 2.0 * self.world_step)
            };
            let rests = own.speed <= SPEED
                && !own.held
                && !moving.iter().any(|&n| n != k && near(&motions[n]))
                && !self.proxies.iter().any(reached);
            piece.still = if rests { (piece.still + 1).min(patience) } else { 0 };
        }
    }

    fn motions(&self, pieces: &[PieceRecord]) -> Vec<SolidMotion> {
        let most = pieces.iter().map(|piece| piece.number).max().unwrap_or(0);
        let mut slots = vec![0; most as usize + 1];
        pieces.iter().enumerate().for_each(|(k, piece)| slots[piece.number as usize] = k);
        let slot = |i: usize| slots[self.labels[i] as usize];
        let mut motions = vec![SolidMotion::default(); pieces.len()];
        for i in 0..self.places.len() {
            let own = &mut motions[slot(i)];
            own.points += 1;
            own.centre += self.places[i];
            own.speed = own.speed.max(self.velocities[i].norm());
            own.held |= self.held[i];
        }
        motions.iter_mut().for_each(|own| own.centre /= f64::from(own.points.max(1)));
        for (i, place) in self.places.iter().enumerate() {
            let own = &mut motions[slot(i)];
            own.radius = own.radius.max((place - own.centre).norm());
        }
        motions
    }
}

#[cfg(test)]
mod tests {
    use super::renumber;
    use cullet_continuum::PieceRecord;

    #[test]
    fn the_largest_part_keeps_the_number_and_others_name_their_parent() {
        let (mut labels, mut pieces) = (vec![0; 6], vec![PieceRecord::default()]);
        renumber(&[0, 0, 2, 2, 2, 0], &mut labels, &mut pieces, 3);
        assert_eq!(labels, [0, 0, 1, 1, 1, 0]);
        assert_eq!(pieces[1], PieceRecord { number: 1, parent: 0, born: 3, still: 0 });
        renumber(&[0, 1, 2, 2, 2, 1], &mut labels, &mut pieces, 9);
        assert_eq!(labels, [2, 0, 1, 1, 1, 0]);
        assert_eq!(pieces[2], PieceRecord { number: 2, parent: 0, born: 9, still: 0 });
    }
}
