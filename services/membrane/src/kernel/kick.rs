//! What forces do to the velocities of points, and what of it is booked.

use super::block::BlockForces;
use super::task::TaskRows;
use crate::forces::{ForceInput, StepSums};
use crate::grips::FREE;
use crate::vector::length;
use cullet_continuum::air;
use cullet_geometry::Vec3;
use cullet_simd::{LANES, Lanes};
use std::ops::Range;

/// The kicks of a task.
pub(super) struct KickPass<'a> {
    input: &'a ForceInput<'a>,
    /// Unit of forces of bending \[N\].
    unit: f64,
    /// Of points that something else acts on than the sheet, gravity and the air.
    sums: StepSums,
    /// Of others, side by side.
    plain: PlainSums,
}

/// Sums over points that only the sheet, gravity and the air act on, by lane.
struct PlainSums {
    /// Power of dashpots \[W\].
    damped: [f64; LANES],
    /// Σ mass times the mean velocity along each axis \[kg·m/s\].
    momentum: [[f64; LANES]; 3],
    mass: [f64; LANES],
    exchanged: [f64; LANES],
    /// Of the air.
    blown: [f64; LANES],
    impulse: [[f64; LANES]; 3],
}

/// Adds up lanes in one order.
fn total(lanes: &[f64; LANES]) -> f64 {
    lanes.iter().sum()
}

impl<'a> KickPass<'a> {
    pub(super) fn new(input: &'a ForceInput<'a>, unit: f64) -> Self {
        let zero = [0.0; LANES];
        let plain = PlainSums {
            damped: zero,
            momentum: [zero; 3],
            mass: zero,
            exchanged: zero,
            blown: zero,
            impulse: [zero; 3],
        };
        Self { input, unit, sums: StepSums::default(), plain }
    }

    /// What all kicks did.
    pub(super) fn sums(self) -> StepSums {
        let Self { input, mut sums, plain, .. } = self;
        sums.damped -= total(&plain.damped) * input.dt;
        let momentum = plain.momentum.map(|lanes| total(&lanes));
        sums.gravity += input.gravity.dot(&Vec3::from(momentum)) * input.dt;
        sums.air += total(&plain.blown);
        let blown = Vec3::from(plain.impulse.map(|lanes| total(&lanes)));
        sums.impulse += input.gravity * (total(&plain.mass) * input.dt) + blown;
        sums.exchanged += total(&plain.exchanged);
        sums
    }

    /// Kicks the points of a block of a task.
    #[inline(always)]
    pub(super) fn block(&mut self, k: usize, rows: &mut TaskRows<'_>) {
        let own = k * LANES..rows.after.len().min((k + 1) * LANES);
        let input = self.input;
        let first = rows.remembered.first * LANES + own.start;
        let points = first..first + own.len();
        let alone = input.lips.is_empty() && input.touch.is_empty();
        let plain = alone
            && own.len() == LANES
            && input.holders[points.clone()].iter().all(|&holder| holder == FREE)
            && !input.frozen[points.clone()].iter().any(|&frozen| frozen);
        if plain {
            self.plain.add(input, self.unit, first, &rows.forces[k], &mut rows.after[own]);
        } else {
            self.points(k, points, own.start, rows);
        }
    }

    /// Kicks points one by one.
    fn points(&mut self, k: usize, points: Range<usize>, own: usize, rows: &mut TaskRows<'_>) {
        let (input, unit, sums) = (self.input, self.unit, &mut self.sums);
        let forces = &rows.forces[k];
        for (lane, i) in points.enumerate() {
            let at = own + lane;
            if input.frozen[i] {
                rows.after[at] = Vec3::zeros();
                continue;
            }
            let narrow = |all: &[Lanes<f32>; 3]| {
                Vec3::new(all[0].0[lane].into(), all[1].0[lane].into(), all[2].0[lane].into())
            };
            let wide =
                |all: &[[f64; LANES]; 3]| Vec3::new(all[0][lane], all[1][lane], all[2][lane]);
            let damper = narrow(&forces.damper);
            let (lips, propped) = input.lips.force(i, input.places, input.frozen);
            let force = wide(&forces.pulled) + wide(&forces.bent) * unit + lips;
            let [weighs, mass] = input.masses[i];
            let weight = input.gravity * weighs;
            let touch = input.touch.get(i).copied().unwrap_or_default();
            let mut change = (force + weight + touch) * input.dt;
            let v = input.velocities[i];
            let mut blown = Vec3::zeros();
            if let Some((air, wind)) = input.air {
                // The drag of what the other forces leave.
                let relative = v + change / mass - wind;
                let area = narrow(&forces.area) * input.areas[i];
                blown = air::impulse(air, area, relative, mass, input.dt);
                change += blown;
            }
            let mut next = v + change / mass;
            let mut held = Vec3::zeros();
            if input.holders[i] != FREE {
                next = input.led[input.holders[i] as usize];
                held = (next - v) * mass - change;
                rows.held[at] = held;
            }
            let middle = 0.5 * (v + next);
            sums.damped -= damper.dot(&middle) * input.dt;
            sums.gravity += weight.dot(&middle) * input.dt;
            sums.bodies += touch.dot(&middle) * input.dt;
            sums.air += blown.dot(&middle);
            sums.grips += held.dot(&middle);
            sums.impulse += (weight + touch + propped) * input.dt + blown + held;
            sums.exchanged += length(&change) + length(&held);
            rows.after[at] = next;
        }
    }
}

impl PlainSums {
    /// Kicks sixteen points from `first` on, side by side.
    #[inline(always)]
    fn add(
        &mut self,
        input: &ForceInput<'_>,
        unit: f64,
        first: usize,
        forces: &BlockForces,
        after: &mut [Vec3],
    ) {
        let masses = &input.masses[first..first + LANES];
        let velocities = &input.velocities[first..first + LANES];
        let (mut weighs, mut mass, mut inverse) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            weighs[lane] = masses[lane][0];
            mass[lane] = masses[lane][1];
        }
        for lane in 0..LANES {
            inverse[lane] = 1.0 / mass[lane];
            self.mass[lane] += weighs[lane];
        }
        let (mut before, mut change) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for c in 0..3 {
            let gravity = input.gravity[c];
            for lane in 0..LANES {
                before[c][lane] = velocities[lane][c];
                let pulled = forces.pulled[c][lane];
                let bent = forces.bent[c][lane] * unit;
                change[c][lane] = (pulled + bent + gravity * weighs[lane]) * input.dt;
            }
        }
        if let Some((air, wind)) = input.air {
            let areas = &input.areas[first..first + LANES];
            let (mut area, mut relative) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
            for c in 0..3 {
                for lane in 0..LANES {
                    area[c][lane] = f64::from(forces.area[c].0[lane]) * areas[lane];
                    // The drag of what the other forces leave.
                    let next = before[c][lane] + change[c][lane] * inverse[lane];
                    relative[c][lane] = next - wind[c];
                }
            }
            let blown = air::impulses(air, &area, &relative, &mass, input.dt);
            for c in 0..3 {
                for lane in 0..LANES {
                    change[c][lane] += blown[c][lane];
                    let middle = before[c][lane] + 0.5 * (change[c][lane] * inverse[lane]);
                    self.blown[lane] += blown[c][lane] * middle;
                    self.impulse[c][lane] += blown[c][lane];
                }
            }
        }
        let mut square = [0.0; LANES];
        for c in 0..3 {
            for lane in 0..LANES {
                let v = before[c][lane];
                let next = v + change[c][lane] * inverse[lane];
                let middle = 0.5 * (v + next);
                square[lane] += change[c][lane] * change[c][lane];
                self.damped[lane] += f64::from(forces.damper[c].0[lane]) * middle;
                self.momentum[c][lane] += weighs[lane] * middle;
                after[lane][c] = next;
            }
        }
        for (exchanged, square) in self.exchanged.iter_mut().zip(square) {
            *exchanged += square.sqrt();
        }
    }
}
