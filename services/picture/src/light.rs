//! The key light, and which points of the scene it reaches.

use super::change::ChangedTiles;
use super::occlusion::turned;
use super::raster::{Buffers, ScreenCorner};
use cullet_geometry::Vec3;
use std::ops::Range;

/// The key light and what stands in its way.
pub(super) struct Light {
    /// Unit direction towards the light.
    pub(super) towards: Vec3,
    right: Vec3,
    above: Vec3,
    target: Vec3,
    half: f64,
    /// Pixels along each side of its picture.
    side: usize,
    pub(super) seen: Buffers,
}

impl Light {
    pub(super) fn new(towards: Vec3, up: Vec3, target: Vec3, half: f64, side: usize) -> Self {
        let right = towards.cross(&up).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        let seen = Buffers::depth(side, side);
        Self { towards, right, above: towards.cross(&right), target, half, side, seen }
    }

    /// A point in the light's picture; `near` is the way towards the light \[m\].
    pub(super) fn project(&self, point: Vec3) -> ScreenCorner {
        let d = point - self.target;
        let scale = self.side as f64 / 2.0 / self.half;
        ScreenCorner {
            x: self.side as f64 / 2.0 + d.dot(&self.right) * scale,
            y: self.side as f64 / 2.0 - d.dot(&self.above) * scale,
            near: d.dot(&self.towards),
        }
    }

    /// Share of the light that reaches a point with that normal \[1\], and the tile of the light's
    /// picture that decided it, if one did. `turns`: of the disc that is asked, by quarters.
    pub(super) fn reaches(
        &self,
        point: Vec3,
        normal: Vec3,
        turns: Range<usize>,
    ) -> (f32, Option<u32>) {
        let texel = 2.0 * self.half / self.side as f64;
        let at = self.project(point + normal * (1.6 * texel));
        // What leans away from the light must not shade itself where the disc asks beside it.
        let facing = normal.dot(&self.towards).max(0.05);
        let slant = (1.0 - facing * facing).max(0.0).sqrt() / facing;
        let slack = (0.6 + DISC * slant).min(MOST_SLACK) * texel;
        let (size, reach) = (self.side as f64, TAP_REACH as f64);
        let near = |c: f64| c > -reach && c < size + reach;
        if !(near(at.x) && near(at.y)) {
            return (1.0, None);
        }
        let open = |(dx, dy): (f64, f64)| {
            let (x, y) = (at.x + dx, at.y + dy);
            let inside = x >= 0.0 && y >= 0.0 && x < size && y < size;
            !inside || {
                let near = self.seen.near[y as usize * self.side + x as usize];
                f64::from(near) <= at.near + slack
            }
        };
        let lit = |ring: &[[(f64, f64); 2]]| {
            let mut lit = 0;
            for &[one, two] in ring {
                lit += u16::from(open(one)) + u16::from(open(two));
            }
            lit
        };
        let outer = lit(&OUTER[turns.clone()]);
        let count = 2 * turns.len() as u16;
        // Where a whole ring is of one mind, what lies inside it is too.
        let agreed = turns.len() > 1 && (outer == 0 || outer == count);
        let inner = if agreed { outer } else { lit(&INNER[turns]) };
        // A cast takes what is below zero to zero.
        let (x, y) = ((at.x as usize).min(self.side - 1), (at.y as usize).min(self.side - 1));
        let tile = ChangedTiles::tile(self.side, x, y) as u32;
        (f32::from(outer + inner) / f32::from(2 * count), Some(tile))
    }
}

/// Where the light's picture is asked, in its pixels: a small disc, in its four turns.
const INNER: [[(f64, f64); 2]; 4] = in_turns([(0.5, 0.3), (-1.3, 0.9)]);
const OUTER: [[(f64, f64); 2]; 4] = in_turns([(0.7, -2.0), (2.3, 1.4)]);

const fn in_turns(taps: [(f32, f32); 2]) -> [[(f64, f64); 2]; 4] {
    let mut all = [[(0.0, 0.0); 2]; 4];
    let mut k = 0;
    while k < 8 {
        let (dx, dy) = turned(taps[k % 2].0, taps[k % 2].1, k / 2);
        all[k / 2][k % 2] = (dx as f64, dy as f64);
        k += 1;
    }
    all
}

/// Radius of the disc \[pixels\].
const DISC: f64 = 2.4;
/// How far what casts a shadow must be before a surface at most, in the light's pixels.
const MOST_SLACK: f64 = 10.0;

/// How far that is from the middle, at most \[pixels\].
pub(super) const TAP_REACH: usize = 3;
