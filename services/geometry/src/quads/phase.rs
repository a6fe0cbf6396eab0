//! A first guess of the lattices, from waves along the crosses: the crests of a wave are the rows
//! of a lattice, and where waves cannot fit each other they fade.

use super::hierarchy::FieldLevel;
use crate::math::{Vec3, unit};
use nalgebra::Complex;
use std::f64::consts::TAU;

/// Gauss–Seidel sweeps on each level.
const SWEEPS: usize = 40;
/// The stream of the seed's numbers that the first guess takes.
const STREAM: u64 = 0x0517;

/// The two waves at a vertex, one along each axis of its cross: the argument is the way to the next
/// crest in parts of a turn.
type Waves = [Complex<f64>; 2];

/// A vertex with its cross.
#[derive(Clone, Copy, Debug)]
struct WaveFrame {
    at: Vec3,
    axes: [Vec3; 2],
}

/// How the waves at one vertex look from another.
#[derive(Clone, Copy, Debug)]
struct WaveLink {
    from: u32,
    weight: f64,
    /// Quarter turns between the crosses.
    quarters: usize,
    shift: Waves,
}

impl WaveFrame {
    fn of(level: &FieldLevel, v: usize, arm: Vec3) -> Self {
        Self { at: level.points[v], axes: [arm, level.normals[v].cross(&arm)] }
    }

    /// How waves of this `side` \[m\] at `other` look from here.
    fn link(&self, other: &Self, side: f64) -> (usize, Waves) {
        let [x, y] = other.axes;
        let turned = |quarters: usize| [[x, y], [y, -x], [-x, -y], [-y, x]][quarters];
        let fit = |q: usize| self.axes[0].dot(&turned(q)[0]) + self.axes[1].dot(&turned(q)[1]);
        let quarters = (1..4).fold(0, |best, q| if fit(q) > fit(best) { q } else { best });
        let (theirs, way) = (turned(quarters), other.at - self.at);
        let shift = [0, 1].map(|k| {
            let turns = 0.5 * way.dot(&(self.axes[k] + theirs[k])) / side;
            wave(turns - turns.floor())
        });
        (quarters, shift)
    }

    /// The turns of the two waves if a crest goes through `p`.
    fn turns(&self, p: Vec3, side: f64) -> [f64; 2] {
        self.axes.map(|axis| axis.dot(&(p - self.at)) / side)
    }
}

fn wave(turns: f64) -> Complex<f64> {
    Complex::new(libm::cos(TAU * turns), libm::sin(TAU * turns))
}

/// The waves of a cross as those of one turned by some quarters.
fn turned([x, y]: Waves, quarters: usize) -> Waves {
    [[x, y], [y, x.conj()], [x.conj(), y.conj()], [y.conj(), x]][quarters]
}

fn seen(waves: Waves, quarters: usize, shift: Waves) -> Waves {
    let [x, y] = turned(waves, quarters);
    [x * shift[0], y * shift[1]]
}

/// For each vertex of the finest level the point of its lattice of this `side` \[m\] that is
/// nearest to it. The waves are made to fit as \[Knöppel et al. 2015, *Stripe patterns on
/// surfaces*\] do.
pub(super) fn lattice_points(
    levels: &[FieldLevel],
    directions: &[Vec<Vec3>],
    side: f64,
    seed: u64,
) -> Vec<Vec3> {
    let mut waves: Vec<Waves> = Vec::new();
    let mut coarse: Vec<WaveFrame> = Vec::new();
    for (level, arms) in levels.iter().zip(directions).rev() {
        let frames: Vec<WaveFrame> =
            (0..arms.len()).map(|v| WaveFrame::of(level, v, arms[v])).collect();
        let start = |v: usize| match level.parents.get(v) {
            Some(&parent) => {
                let (quarters, shift) = frames[v].link(&coarse[parent as usize], side);
                seen(waves[parent as usize], quarters, shift)
            }
            None => [0, 1].map(|k| wave(unit(seed, STREAM, 2 * v as u64 + k))),
        };
        waves = (0..arms.len()).map(start).collect();
        relax(level, &frames, side, &mut waves);
        coarse = frames;
    }
    let point = |(frame, waves): (&WaveFrame, &Waves)| {
        let steps = waves.map(|w| libm::atan2(w.im, w.re) / TAU * side);
        frame.at + frame.axes[0] * steps[0] + frame.axes[1] * steps[1]
    };
    coarse.iter().zip(&waves).map(point).collect()
}

/// Replaces the waves at each vertex by the mean of those around it, in sweeps.
fn relax(level: &FieldLevel, frames: &[WaveFrame], side: f64, waves: &mut [Waves]) {
    let links = |v: usize| {
        let link = |&(from, weight): &(u32, f64)| {
            let (quarters, shift) = frames[v].link(&frames[from as usize], side);
            WaveLink { from, weight, quarters, shift }
        };
        level.neighbours(v).iter().map(link).collect::<Vec<WaveLink>>()
    };
    let links: Vec<Vec<WaveLink>> = (0..frames.len()).map(links).collect();
    for _ in 0..SWEEPS {
        for v in 0..frames.len() {
            let mut sum = [Complex::new(0.0, 0.0); 2];
            let mut whole = 0.0;
            for link in &links[v] {
                let [x, y] = seen(waves[link.from as usize], link.quarters, link.shift);
                sum = [sum[0] + x * link.weight, sum[1] + y * link.weight];
                whole += link.weight;
            }
            if whole > 0.0 {
                waves[v] = sum.map(|z| lifted(z / whole));
            }
            hold(level, v, &frames[v], side, &mut waves[v]);
        }
    }
}

/// A faded wave grows again, but slowly: by the fourth root. So rows begin and end only where they
/// have to.
fn lifted(z: Complex<f64>) -> Complex<f64> {
    let length = z.norm_sqr().sqrt();
    if length > 1e-30 { z / length.sqrt().sqrt() } else { z }
}

/// Puts a crest on the rim at a rim vertex, and both on its corner.
fn hold(level: &FieldLevel, v: usize, frame: &WaveFrame, side: f64, waves: &mut Waves) {
    if let Some(hold) = level.holds[v] {
        let turns = frame.turns(hold.at, side);
        let along = frame.axes.map(|axis| axis.dot(&hold.along).abs());
        for k in 0..2 {
            if hold.is_corner || along[k] < along[1 - k] {
                waves[k] = wave(turns[k]);
            }
        }
    }
}
