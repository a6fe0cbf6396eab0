//! Damage, spread to the nodes of a lattice.

use super::lattice::{Lattice, weights};
use crate::field::DamageField;
use cullet_geometry::Vec3;

/// A particle is broken from this damage on (thesis Sec. 3.3 takes fully damaged ones; the last
/// tenth is asymptotic in explicit time stepping).
pub const BROKEN: f64 = 0.9;

/// What the nodes know of material and damage.
#[derive(Debug)]
pub(super) struct NodeDamage {
    /// Weight of the particles around.
    pub(super) weight: Vec<f64>,
    /// Share of broken weight, where there is any weight.
    pub(super) broken: Vec<f64>,
    /// When the nearest damage was complete \[s\].
    pub(super) time: Vec<f64>,
    /// Whether that was at the node itself.
    pub(super) known: Vec<bool>,
    /// The mean place of the damage that the time is the mean of \[m\].
    pub(super) centroid: Vec<Vec3>,
    /// Whether there is damage within two units along every axis.
    pub(super) near: Vec<bool>,
}

impl NodeDamage {
    pub(super) fn spread(lattice: &Lattice, field: &DamageField<'_>) -> Self {
        let n = lattice.len();
        let (mut weight, mut broken) = (vec![0.0; n], vec![0.0; n]);
        let (mut timed, mut time) = (vec![0.0; n], vec![0.0; n]);
        let mut centroid = vec![Vec3::zeros(); n];
        for ((&p, &damage), &when) in
            field.positions.iter().zip(field.damage).zip(field.damage_time)
        {
            let (base, w) = weights(lattice.steps_to(p));
            for z in 0..3 {
                for y in 0..3 {
                    let row = lattice.index([base[0], base[1] + y, base[2] + z]);
                    for x in 0..3 {
                        let share = w[0][x] * w[1][y] * w[2][z];
                        weight[row + x] += share;
                        if damage >= BROKEN {
                            broken[row + x] += share;
                            if when.is_finite() {
                                timed[row + x] += share;
                                time[row + x] += share * when;
                                centroid[row + x] += share * p;
                            }
                        }
                    }
                }
            }
        }
        for i in 0..n {
            broken[i] = if weight[i] > 0.0 { broken[i] / weight[i] } else { 0.0 };
            centroid[i] /= timed[i];
            time[i] = if timed[i] > 0.0 { time[i] / timed[i] } else { f64::INFINITY };
        }
        let known = time.iter().map(|t| t.is_finite()).collect();
        Self { weight, broken, time, known, centroid, near: Vec::new() }
    }

    /// Carries times outward to the nodes that have none.
    pub(super) fn carry_times(&mut self, lattice: &Lattice) {
        let mut queue: Vec<usize> =
            (0..lattice.len()).filter(|&i| self.time[i].is_finite()).collect();
        let mut head = 0;
        while head < queue.len() {
            let i = queue[head];
            head += 1;
            for j in lattice.beside(i) {
                if !self.time[j].is_finite() {
                    self.time[j] = self.time[i];
                    queue.push(j);
                }
            }
        }
    }
}
