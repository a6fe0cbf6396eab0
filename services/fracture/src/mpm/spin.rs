//! A body that spins: what its nodes feel in a frame that turns as the body did before the hit.

use super::grid::BackgroundGrid;
use super::stencil::{packed, vector};
use cullet_geometry::Vec3;
use rayon::prelude::*;

/// Nodes of a piece of work.
const NODES: usize = 512;

/// A frame that turns about its origin at a constant rate. Displacements in it stay small, and a
/// load that is fixed to the body has a fixed direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// Angular velocity ω of the frame \[rad/s\].
    pub rate: Vec3,
    /// While the stress of the spin is put on: share of it that is there \[1\], and the rate at
    /// which motion is damped meanwhile \[1/s\]. Afterwards the frame turns, undamped.
    pub onset: Option<(f64, f64)>,
}

impl Spin {
    /// Velocities after a step \[s\] of a = −ω×(ω×x) − 2ω×v: half of the first, the turn by −2ω of
    /// the second, the other half, so that neither does work that the other should.
    pub(super) fn push(&self, grid: &mut BackgroundGrid, step: f64) {
        let (spacing, nodes) = (grid.spacing, &mut grid.nodes);
        let (place, moved) = (&nodes.place, &nodes.displacement);
        let share = self.onset.map_or(1.0, |onset| onset.0);
        let damping = self.onset.map_or(1.0, |onset| 1.0 / (1.0 + onset.1 * step));
        let coriolis = if self.onset.is_some() { Vec3::zeros() } else { self.rate * step };
        nodes.velocity.par_chunks_mut(NODES).enumerate().for_each(|(chunk, velocities)| {
            for (i, velocity) in velocities.iter_mut().enumerate() {
                let n = chunk * NODES + i;
                let x = Vec3::from(place[n].map(f64::from)).component_mul(&spacing);
                let half = self.outward(&(x + vector(moved[n]))) * (0.5 * share * step);
                // Cayley's turn: v' − v = −t×(v' + v), which keeps |v|.
                let v = vector(*velocity) * damping + half;
                let t = coriolis;
                let w = v - t.cross(&v);
                let turned = (w - t.cross(&w) + t * t.dot(&w)) / (1.0 + t.norm_squared());
                *velocity = packed(turned + half);
            }
        });
    }

    /// Centrifugal acceleration at `x` \[m\]: −ω×(ω×x) \[m/s²\].
    fn outward(&self, x: &Vec3) -> Vec3 {
        -self.rate.cross(&self.rate.cross(x))
    }

    /// Work of the centrifugal forces since the nodes were in place, as far as half the last step
    /// \[s\] before now, where the velocities are: ½ Σ m (|ω×x|² − |ω×X|²), which is
    /// ½ Σ m (ω×u)·(ω×(2X + u)) \[J\].
    #[must_use]
    pub fn work(&self, grid: &BackgroundGrid, step: f64) -> f64 {
        let nodes = &grid.nodes;
        let one = |n: usize| {
            let back = vector(nodes.velocity[n]) * (0.5 * step);
            let (x, u) = (grid.place(n), vector(nodes.displacement[n]) - back);
            let twice = self.rate.cross(&u).dot(&self.rate.cross(&(x * 2.0 + u)));
            0.5 * nodes.mass[n] * twice
        };
        (0..nodes.len()).map(one).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::Spin;
    use crate::damage::Softening;
    use crate::mpm::Domain;
    use crate::mpm::stencil::{packed, vector};
    use crate::particles::Particles;
    use cullet_geometry::{Quat, Vec3};
    use cullet_model::Material;

    const HARD: Material = Material {
        density: 2450.0,
        young: 32e9,
        poisson: 0.0,
        failure_stress: 3e8,
        fracture_energy: 1e6,
    };
    /// Spacing \[m\].
    const H: f64 = 0.01;

    /// A bar of `cells` about the origin, eight points a cell.
    fn bar(cells: [usize; 3]) -> Domain {
        let [nx, ny, nz] = cells.map(|n| 2 * n);
        let half = Vec3::from(cells.map(|n| n as f64)) * (0.5 * H);
        let at =
            |i: usize| Vec3::new((i / (ny * nz)) as f64, (i / nz % ny) as f64, (i % nz) as f64);
        let points: Vec<Vec3> =
            (0..nx * ny * nz).map(|i| (at(i) + Vec3::repeat(0.5)) * (0.5 * H) - half).collect();
        let volume = 8.0 * half.product();
        let particles = Particles::at_rest(&points, volume, HARD.density);
        Domain::new(particles, &HARD, Softening::on_grid(&HARD, H), Vec3::repeat(H))
    }

    /// A body at rest in space, seen from a frame that turns, goes round and comes back.
    #[test]
    fn what_rests_in_space_goes_round_in_the_frame() {
        let mut domain = bar([6, 4, 4]);
        let rate = Vec3::new(120.0, -310.0, 200.0);
        domain.spin = Some(Spin { rate, onset: None });
        for n in 0..domain.grid.nodes.len() {
            domain.grid.nodes.velocity[n] = packed(-rate.cross(&domain.grid.place(n)));
        }
        let energy = domain.kinetic_energy();
        while domain.time * rate.norm() < 1.0 {
            domain.advance();
        }
        let turn = Quat::from_scaled_axis(-rate * domain.time);
        let far = 0.03 * (domain.time * rate.norm());
        for n in 0..domain.grid.nodes.len() {
            let x = domain.grid.place(n);
            let moved = vector(domain.grid.nodes.displacement[n]);
            assert!((x + moved - turn * x).norm() < 2e-3 * far, "{x:?} by {moved:?}");
        }
        assert!((domain.kinetic_energy() / energy - 1.0).abs() < 1e-3);
    }

    /// σ(x) = ½ρω²(L² − x²) along a bar of half-length L that turns about its middle.
    #[test]
    fn a_turning_bar_is_pulled_most_in_the_middle() {
        let mut domain = bar([20, 3, 3]);
        let (length, rate) = (10.0 * H, 400.0);
        let transit = 2.0 * length / HARD.shear_speed();
        let end = 4.0 * transit;
        while domain.time < end {
            let s = domain.time / end;
            let onset = Some((s * s * (3.0 - 2.0 * s), 1.0 / transit));
            domain.spin = Some(Spin { rate: Vec3::z() * rate, onset });
            domain.advance();
        }
        let stresses = domain.stresses();
        let most = 0.5 * HARD.density * rate * rate * length * length;
        for slab in 0..10 {
            let x = (slab as f64 - 4.5) * 2.0 * H;
            let inside =
                (0..stresses.len()).filter(|&p| (domain.particles.reference[p].x - x).abs() < H);
            let pulls: Vec<f64> = inside.map(|p| stresses[p][0]).collect();
            let mean = pulls.iter().sum::<f64>() / pulls.len() as f64;
            let wanted = most * (1.0 - x * x / (length * length));
            assert!((mean - wanted).abs() < 0.05 * most, "{mean} at {x}, not {wanted}");
        }
        let work = domain.spin.expect("it turns").work(&domain.grid, 0.0);
        // ½ Σ σ ε V of that stress is half of what the forces would do at full strength.
        assert!((2.0 * domain.elastic_energy() / work - 1.0).abs() < 0.1);
    }
}
