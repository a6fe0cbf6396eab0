//! Pieces at rest: after half a second on something that carries them they are not simulated any
//! more, until something that moves comes near.

use crate::pieces::{PieceRecord, patience};
use crate::rigid::RigidProxy;
use crate::tree::{BoxTree, SpaceBox};
use cullet_geometry::Vec3;

/// Greatest speed of a point of a piece at rest \[m/s\]: half of what free fall gives in one step
/// of a world of 1/240 s.
const SPEED: f64 = 0.02;
/// Fewest points of a piece that is frozen or wakes others.
pub const POINTS: u32 = 6;

/// Where a piece is and how it moves.
#[derive(Clone, Copy, Debug, Default)]
struct PieceMotion {
    points: u32,
    centre: Vec3,
    radius: f64,
    speed: f64,
    /// Whether a grip holds some of it.
    held: bool,
    /// Whether a rigid body pushes it.
    touched: bool,
}

impl PieceMotion {
    /// Whether others near it are not at rest.
    fn moves(&self) -> bool {
        self.points >= POINTS && self.speed > SPEED
    }

    /// A box around all places within `margin` \[m\] of it.
    fn around(&self, margin: f64) -> SpaceBox {
        let reach = Vec3::from([self.radius + margin; 3]);
        [self.centre - reach, self.centre + reach]
    }
}

/// What is looked at.
#[derive(Clone, Copy, Debug)]
pub struct RestCheck<'a> {
    /// Number of the piece that each point belongs to.
    pub labels: &'a [u32],
    /// Of each point \[m\].
    pub places: &'a [Vec3],
    /// Of each point \[m/s\].
    pub velocities: &'a [Vec3],
    /// Whether a grip holds each point.
    pub held: &'a [bool],
    /// Whether a rigid body pushed each point in the last step of the world.
    pub touched: &'a [bool],
    /// Pairs of points that press on each other.
    pub pressed: &'a [[u32; 2]],
    /// Bodies that may come near.
    pub proxies: &'a [RigidProxy],
    /// Distance of points \[m\].
    pub spacing: f64,
    /// Step of the world \[s\].
    pub world_step: f64,
}

impl RestCheck<'_> {
    /// Counts for how long each piece has been at rest; those that something comes near to begin
    /// anew, and so do those that nothing carries: at the top of its way a piece in flight is slow
    /// too. Whether one is now to be frozen that was not.
    pub fn count(&self, pieces: &mut [PieceRecord]) -> bool {
        let patience = patience(self.world_step);
        let slots = slots(pieces);
        let motions = self.motions(&slots, pieces.len());
        let carried = self.carried(pieces, &slots, &motions);
        let margin = 2.0 * self.spacing;
        let movers: Vec<&PieceMotion> = motions.iter().filter(|m| m.moves()).collect();
        let tree = BoxTree::new(movers.iter().map(|m| m.around(m.speed * self.world_step)));
        let mut new = false;
        for (k, piece) in pieces.iter_mut().enumerate().filter(|(_, piece)| !piece.is_gone()) {
            let own = &motions[k];
            let near = |n: u32| {
                let other = movers[n as usize];
                let reach = own.radius + other.radius + margin + other.speed * self.world_step;
                (own.centre - other.centre).norm() < reach
            };
            let reached = |proxy: &RigidProxy| {
                proxy.may_reach(own.centre, own.radius + margin, 2.0 * self.world_step)
            };
            let rests = carried[k]
                && own.points >= POINTS
                && own.speed <= SPEED
                && !own.held
                && !tree.find(&own.around(margin), near)
                && !self.proxies.iter().any(reached);
            new |= rests && piece.still + 1 == patience;
            piece.still = if rests { (piece.still + 1).min(patience) } else { 0 };
        }
        new
    }

    fn motions(&self, slots: &[usize], count: usize) -> Vec<PieceMotion> {
        let slot = |i: usize| slots[self.labels[i] as usize];
        let mut motions = vec![PieceMotion::default(); count];
        for i in 0..self.places.len() {
            let own = &mut motions[slot(i)];
            own.points += 1;
            own.centre += self.places[i];
            own.speed = own.speed.max(self.velocities[i].norm());
            own.held |= self.held[i];
            own.touched |= self.touched[i];
        }
        motions.iter_mut().for_each(|own| own.centre /= f64::from(own.points.max(1)));
        for (i, place) in self.places.iter().enumerate() {
            let own = &mut motions[slot(i)];
            own.radius = own.radius.max((place - own.centre).norm());
        }
        motions
    }

    /// Which pieces a grip or a rigid body carries, by themselves or by others that press on them.
    /// What is frozen was carried when it was, and pushes nothing since.
    fn carried(
        &self,
        pieces: &[PieceRecord],
        slots: &[usize],
        motions: &[PieceMotion],
    ) -> Vec<bool> {
        let patience = patience(self.world_step);
        let slot = |i: u32| slots[self.labels[i as usize] as usize];
        let both = |&[i, j]: &[u32; 2]| [[slot(i), slot(j)], [slot(j), slot(i)]];
        let mut pairs: Vec<[usize; 2]> = self.pressed.iter().flat_map(both).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let by_itself = |(piece, own): (&PieceRecord, &PieceMotion)| {
            !piece.is_gone() && (own.held || own.touched || piece.still >= patience)
        };
        let mut carried: Vec<bool> = pieces.iter().zip(motions).map(by_itself).collect();
        let mut queue: Vec<usize> = (0..pieces.len()).filter(|&k| carried[k]).collect();
        while let Some(k) = queue.pop() {
            let first = pairs.partition_point(|pair| pair[0] < k);
            for [_, other] in pairs[first..].iter().take_while(|pair| pair[0] == k) {
                if !std::mem::replace(&mut carried[*other], true) {
                    queue.push(*other);
                }
            }
        }
        carried
    }
}

/// Where the piece of each number is.
fn slots(pieces: &[PieceRecord]) -> Vec<usize> {
    let most = pieces.iter().map(|piece| piece.number).max().unwrap_or(0);
    let mut slots = vec![0; most as usize + 1];
    pieces.iter().enumerate().for_each(|(k, piece)| slots[piece.number as usize] = k);
    slots
}

#[cfg(test)]
mod tests;
