//! Relief of crack faces: every corner of the mosaic moves once, for all cells at once, along the
//! mean normal of its face; where faces cross after that, it moves back. So both sides of a crack
//! fit as before, and volumes still sum to the body's (F34).

use super::flow::Flow;
use super::sheet::CellSheet;
use super::terms::{FrontSample, ReliefTerms};
use super::{Mosaic, overlap};
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use rayon::prelude::*;

/// Corners move by no more than this share of their distance to where faces meet.
const NEAR_SEAM: f64 = 0.35;
/// Steepest relief \[1\].
const STEEPEST: f64 = 1.2;
/// Passes that take away what is steeper.
const PASSES: usize = 4;
/// Rounds in which corners whose faces cross are pulled half-way back; after them, all the way.
const RETREATS: usize = 7;
/// Most triangles that edges are divided for; beyond, they stay longer.
const MOST: usize = 1_500_000;

impl Mosaic {
    /// Divides faces that are `wanted` and gives them relief. `front` tells of the crack front.
    pub(crate) fn engrave(
        &mut self,
        terms: &ReliefTerms,
        front: impl Fn(Vec3) -> Option<FrontSample> + Sync,
        wanted: impl Fn([Vec3; 3]) -> bool + Sync,
    ) {
        if terms.detail.is_none() {
            return;
        }
        let mut fronts: Vec<Option<FrontSample>> =
            self.places.par_iter().map(|&p| front(p)).collect();
        let edge = terms.detail.edge * terms.spacing;
        for [a, b] in self.refine(edge, MOST, wanted) {
            let pair = (fronts[a as usize], fronts[b as usize]);
            fronts.push(match pair {
                (Some(a), Some(b)) => Some(FrontSample {
                    time: 0.5 * (a.time + b.time),
                    slope: 0.5 * (a.slope + b.slope),
                }),
                _ => None,
            });
        }
        let sheet = CellSheet::new(self);
        let heights = heights(&sheet, &fronts, terms);
        let warp = |v: usize| warp(sheet.places[v], terms);
        let moves: Vec<Vec3> =
            (0..self.places.len())
                .into_par_iter()
                .map(|v| {
                    if sheet.wall[v] {
                        Vec3::zeros()
                    } else {
                        sheet.normal[v] * heights[v] + warp(v)
                    }
                })
                .collect();
        self.displace(&sheet.places, &moves);
    }

    /// Moves corners, those least whose faces would cross others.
    fn displace(&mut self, from: &[Vec3], moves: &[Vec3]) {
        let mut kept = vec![1.0; from.len()];
        let mut moved: Vec<bool> = moves.iter().map(|by| *by != Vec3::zeros()).collect();
        for round in 1.. {
            for (v, place) in self.places.iter_mut().enumerate() {
                *place = from[v] + kept[v] * moves[v];
            }
            let crossing =
                overlap::crossing_of(&self.places, &self.triangles, |v| moved[v as usize]);
            let corners = crossing.iter().flat_map(|&t| self.triangles[t as usize]);
            let back = |&v: &u32| kept[v as usize] > 0.0 && moves[v as usize] != Vec3::zeros();
            let mut corners: Vec<u32> = corners.filter(back).collect();
            if corners.is_empty() {
                return;
            }
            corners.sort_unstable();
            corners.dedup();
            moved.fill(false);
            for v in corners {
                moved[v as usize] = true;
                kept[v as usize] *= if round < RETREATS { 0.5 } else { 0.0 };
            }
        }
    }
}

/// The height of each corner along its normal \[m\].
fn heights(sheet: &CellSheet, fronts: &[Option<FrontSample>], terms: &ReliefTerms) -> Vec<f64> {
    let (detail, h) = (&terms.detail, terms.spacing);
    let mut heights = vec![0.0; fronts.len()];
    if detail.height > 0.0 || detail.ribs > 0.0 {
        let flow = Flow::new(sheet, fronts, terms);
        let speed = flow.speed();
        heights = (0..fronts.len())
            .into_par_iter()
            .map(|v| {
                let ribs = fronts[v].map_or(0.0, |front| {
                    let way = front.time * speed / (detail.rib_spacing * h);
                    rib(way) * f64::from(u8::from(flow.runs(v)))
                });
                h * (detail.height * flow.height(v) + detail.ribs * ribs)
            })
            .collect();
    }
    let room = sheet.to_seam(2.0 * h.max(detail.grid * h));
    for (height, room) in heights.iter_mut().zip(&room) {
        let most = NEAR_SEAM * room;
        *height = height.clamp(-most, most);
    }
    for _ in 0..PASSES {
        sheet.flatten(&mut heights, STEEPEST);
    }
    heights
}

/// A rib's profile over its way, of period 1: a rounded back and a sharper trough.
fn rib(way: f64) -> f64 {
    let turn = std::f64::consts::TAU * (way - way.floor());
    0.8 * libm::sin(turn) - 0.2 * libm::cos(2.0 * turn)
}

/// Grain: moves space itself, seams included, so nothing that was apart meets \[m\].
fn warp(place: Vec3, terms: &ReliefTerms) -> Vec3 {
    let (detail, h) = (&terms.detail, terms.spacing);
    let mut sum = Vec3::zeros();
    let (mut height, mut size) = (detail.grain * h, detail.grain_size * h);
    let mut octave = 0;
    while height > 0.0 && size > 2.0 * detail.edge * h && octave < 6 {
        let at = place / size;
        let along = |k: u64| noise(at, terms.seed.wrapping_add(3 * octave + k));
        sum += height * Vec3::new(along(0), along(1), along(2));
        (height, size, octave) = (0.5 * height, 0.5 * size, octave + 1);
    }
    sum
}

/// Value noise in [−1, 1], with two continuous derivatives.
fn noise(at: Vec3, seed: u64) -> f64 {
    let low = at.map(f64::floor);
    let ease = |x: f64| x * x * x * (x * (6.0 * x - 15.0) + 10.0);
    let share = (at - low).map(ease);
    let corner = |i: usize| {
        let bit = |k: usize| (i >> k & 1) as f64;
        let node = low + Vec3::new(bit(0), bit(1), bit(2));
        let key = node.iter().fold(0u64, |key, &x| {
            key.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(x as i64 as u64)
        });
        let weight = (0..3).map(|k| if bit(k) > 0.0 { share[k] } else { 1.0 - share[k] });
        weight.product::<f64>() * (2.0 * unit(seed, 77, key) - 1.0)
    };
    (0..8).map(corner).sum()
}
