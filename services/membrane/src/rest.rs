//! Pieces at rest: after half a second they are not simulated any more, until something that moves
//! comes near.

use crate::pieces::PieceRecord;
use crate::proxies::RigidProxy;
use cullet_geometry::Vec3;

/// How long a piece must be at rest \[s\].
const TIME: f64 = 0.5;
/// Greatest speed of a point of a piece at rest \[m/s\]: half of what free fall gives in one step
/// of a world of 1/240 s.
const SPEED: f64 = 0.02;
/// Fewest points of a piece that is frozen or wakes others.
const POINTS: u32 = 6;

/// Steps of the world after which a piece at rest is frozen.
pub(crate) fn patience(world_step: f64) -> u32 {
    (TIME / world_step).ceil().max(1.0) as u32
}

/// Where a piece is and how it moves.
#[derive(Clone, Copy, Debug, Default)]
struct PieceMotion {
    points: u32,
    centre: Vec3,
    radius: f64,
    speed: f64,
    /// Whether a grip holds some of it.
    held: bool,
}

/// What is looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RestCheck<'a> {
    pub(crate) labels: &'a [u32],
    pub(crate) places: &'a [Vec3],
    pub(crate) velocities: &'a [Vec3],
    /// Whether a grip holds each point.
    pub(crate) held: &'a [bool],
    pub(crate) proxies: &'a [RigidProxy],
    pub(crate) spacing: f64,
    pub(crate) world_step: f64,
}

impl RestCheck<'_> {
    /// Counts for how long each piece has been at rest; those that something comes near to begin
    /// anew.
    pub(crate) fn count(&self, pieces: &mut [PieceRecord]) {
        let patience = patience(self.world_step);
        let motions = self.motions(pieces);
        let margin = 2.0 * self.spacing;
        let moves = |m: &PieceMotion| m.points >= POINTS && m.speed > SPEED;
        for (k, piece) in pieces.iter_mut().enumerate() {
            let own = &motions[k];
            let near = |other: &PieceMotion| {
                let reach = own.radius + other.radius + margin + other.speed * self.world_step;
                (own.centre - other.centre).norm() < reach
            };
            let touched = motions.iter().enumerate().any(|(n, m)| n != k && moves(m) && near(m));
            let reached = |proxy: &RigidProxy| {
                proxy.may_reach(own.centre, own.radius + margin, 2.0 * self.world_step)
            };
            let rests = own.points >= POINTS
                && own.speed <= SPEED
                && !own.held
                && !touched
                && !self.proxies.iter().any(reached);
            piece.still = if rests { (piece.still + 1).min(patience) } else { 0 };
        }
    }

    fn motions(&self, pieces: &[PieceRecord]) -> Vec<PieceMotion> {
        let most = pieces.iter().map(|piece| piece.number).max().unwrap_or(0);
        let mut slots = vec![0; most as usize + 1];
        pieces.iter().enumerate().for_each(|(k, piece)| slots[piece.number as usize] = k);
        let slot = |i: usize| slots[self.labels[i] as usize];
        let mut motions = vec![PieceMotion::default(); pieces.len()];
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
