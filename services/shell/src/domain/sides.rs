//! The sides of a crack meet: by the gap between them at both faces, so that pieces bear on one
//! another when they are pressed or bent shut.

use super::functional::Functional;
use super::side_pairs::SidePair;
use super::state::ShellDomain;
use cullet_geometry::Vec3;
use cullet_simd::Real;

/// Coefficient of friction between the sides of a crack \[1\]: fresh faces of glass on glass have
/// 0.9 to 1.
const FRICTION: f64 = 0.9;

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// Stops the sides of cracks that would go on into one another; the energy that this takes
    /// \[J\]. One pair after the other: each impulse is inelastic, so that none makes energy.
    /// `before` are the velocities before the forces of this step: an impulse works at the mean of
    /// those before and after.
    pub(super) fn meet(&mut self, before: &[Vec3]) -> f64 {
        let mut given = Vec::new();
        for k in 0..self.sides.pairs.len() {
            let SidePair { own, other, apart } = self.sides.pairs[k];
            let (own, other) = (own as usize, other as usize);
            if self.element_of(own) == self.element_of(other) {
                continue;
            }
            let half = 0.5 * self.setup[self.seats[own]].thickness;
            let [a, b] = [own, other].map(|p| self.present(p));
            let length = apart.norm();
            let direction = apart / length;
            let opened = b.moved - a.moved;
            let leaned = b.turned - a.turned;
            // One has left the other: it has gone through the wall, or along the crack.
            if opened.norm() > length + 2.0 * half {
                continue;
            }
            for z in [half, -half] {
                if (opened + leaned * z).dot(&direction) >= 0.0 {
                    continue;
                }
                let places = [other, own].map(|p| self.functional(p, z, &direction));
                let gap = places[0].minus(&places[1]);
                let (speed, mobility) = (gap.speed(&self.velocity), gap.mobility(&self.mass));
                if speed >= 0.0 || mobility <= 0.0 {
                    continue;
                }
                let impulse = -speed / mobility;
                gap.push(impulse, &mut self.velocity, &self.mass);
                given.push((gap, -impulse));
                // Friction, across the shell and along the crack.
                let up = self.setup[self.seats[own]].surface.normal;
                for along in [up, up.cross(&direction)] {
                    let places = [other, own].map(|p| self.functional(p, z, &along));
                    let slip = places[0].minus(&places[1]);
                    let (speed, mobility) = (slip.speed(&self.velocity), slip.mobility(&self.mass));
                    if mobility > 0.0 {
                        let most = FRICTION * impulse;
                        // Not `clamp`: what is no number is found by the energy.
                        let held = (-speed / mobility).max(-most).min(most);
                        slip.push(held, &mut self.velocity, &self.mass);
                        given.push((slip, -held));
                    }
                }
            }
        }
        let work = |(gap, impulse): &(Functional, f64)| {
            0.5 * impulse * (gap.speed(before) + gap.speed(&self.velocity))
        };
        given.iter().map(work).sum()
    }
}
