//! The rigid motion that carries a part's momentum and angular momentum.

use crate::particles::{Particles, twist};
use crate::solver::{Fragment, Problem};
use cullet_geometry::{Mat3, Vec3};

/// Mass, momentum and angular momentum of a set of points about their own centroid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Velocity of the centroid \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity \[rad/s\].
    pub spin: Vec3,
    /// Points.
    pub points: usize,
    volume: f64,
}

impl Default for Motion {
    fn default() -> Self {
        Self { velocity: Vec3::zeros(), spin: Vec3::zeros(), points: 0, volume: 0.0 }
    }
}

/// Velocity along `n` that a unit impulse along `n` at `point` gives the whole body there:
/// 1/m + n·[I⁻¹(r×n)]×r \[1/kg\]  [Gate 0].
#[must_use]
pub fn mobility(problem: &Problem, point: &Vec3, n: &Vec3) -> f64 {
    let whole = problem.solid.mesh.mass_properties();
    let density = problem.material.density;
    let arm = (point - whole.centroid).cross(n);
    let turned = whole.inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * arm);
    (1.0 / whole.volume + turned.dot(&arm)) / density
}

/// Points below which a part is given no spin: its inertia is a guess.
const LEAST_POINTS: usize = 4;

/// The motion of each of `parts` parts; `part` tells the part of each point by id.
#[must_use]
pub fn of_parts(particles: &Particles, part: &[u32], parts: usize, spacing: f64) -> Vec<Motion> {
    let mut motions = vec![Motion::default(); parts];
    let mut centroids = vec![Vec3::zeros(); parts];
    let place = |p: usize| part[particles.id[p] as usize] as usize;
    for p in 0..particles.len() {
        let at = place(p);
        if at < parts {
            motions[at].points += 1;
            motions[at].volume += particles.volume[p];
            motions[at].velocity += particles.velocity[p] * particles.volume[p];
            centroids[at] += particles.position[p] * particles.volume[p];
        }
    }
    for (motion, centroid) in motions.iter_mut().zip(&mut centroids) {
        let share = if motion.points > 0 { 1.0 / motion.volume } else { 0.0 };
        motion.velocity *= share;
        *centroid *= share;
    }
    // A point is a cloud of second moment h²/4 per axis, so it has inertia and spin of its own.
    let own = 0.25 * spacing * spacing;
    let mut momenta = vec![Vec3::zeros(); parts];
    let mut inertias = vec![Mat3::zeros(); parts];
    for p in 0..particles.len() {
        let at = place(p);
        if at < parts {
            let r = particles.position[p] - centroids[at];
            let volume = particles.volume[p];
            let slip = particles.velocity[p] - motions[at].velocity;
            momenta[at] += (r.cross(&slip) + twist(&particles.affine[p]) * own) * volume;
            let square = r.norm_squared() + 2.0 * own;
            inertias[at] += (Mat3::identity() * square - r * r.transpose()) * volume;
        }
    }
    for (at, motion) in motions.iter_mut().enumerate() {
        let inverse = inertias[at].try_inverse().filter(|_| motion.points >= LEAST_POINTS);
        motion.spin = inverse.map_or(Vec3::zeros(), |inverse| inverse * momenta[at]);
    }
    motions
}

/// Makes fragments carry exactly the momentum and the angular momentum of `pushes`: points \[m\]
/// and impulses \[N·s\].
///
/// A fragment's mesh holds a little more or less mass than its points, and its velocity was taken
/// where it had come to, not where it was before the hit: one rigid motion of all makes up for
/// both.
pub(crate) fn balance(fragments: &mut [Fragment], pushes: &[(Vec3, Vec3)], density: f64) {
    let own: Vec<_> = fragments.iter().map(|f| f.solid.mesh.mass_properties()).collect();
    let volume: f64 = own.iter().map(|p| p.volume).sum();
    let centre = own.iter().map(|p| p.centroid * p.volume).sum::<Vec3>() / volume;
    let (mut linear, mut angular, mut inertia) = (Vec3::zeros(), Vec3::zeros(), Mat3::zeros());
    for (point, impulse) in pushes {
        linear += impulse / density;
        angular += (point - centre).cross(impulse) / density;
    }
    for (fragment, p) in fragments.iter().zip(&own) {
        let r = p.centroid - centre;
        linear -= fragment.velocity * p.volume;
        angular -= r.cross(&fragment.velocity) * p.volume + p.inertia * fragment.spin;
        let square = Mat3::identity() * r.norm_squared() - r * r.transpose();
        inertia += p.inertia + square * p.volume;
    }
    let shift = linear / volume;
    let turn = inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * angular);
    for (fragment, p) in fragments.iter_mut().zip(&own) {
        fragment.velocity += shift + turn.cross(&(p.centroid - centre));
        fragment.spin += turn;
    }
}

#[cfg(test)]
mod tests {
    use super::of_parts;
    use crate::particles::Particles;
    use cullet_geometry::{Mat3, Vec3, math::unit};

    #[test]
    fn a_rigid_motion_is_found_again() {
        let points: Vec<Vec3> = (0..200)
            .map(|i| Vec3::new(unit(3, 0, i), 2.0 * unit(3, 1, i), 0.5 * unit(3, 2, i)))
            .collect();
        let mut particles = Particles::at_rest(&points, 1.0, 1000.0);
        let (v, w) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.3, 0.7, -1.1));
        let cross = Mat3::new(0.0, -w.z, w.y, w.z, 0.0, -w.x, -w.y, w.x, 0.0);
        for (p, x) in points.iter().enumerate() {
            particles.velocity[p] = v + w.cross(x);
            particles.affine[p] = cross;
        }
        let part: Vec<u32> = (0..200).map(|i| u32::from(i >= 197)).collect();
        let motions = of_parts(&particles, &part, 2, 0.1);
        let centroid = points[..197].iter().sum::<Vec3>() / 197.0;
        assert!((motions[0].spin - w).norm() < 1e-12);
        assert!((motions[0].velocity - (v + w.cross(&centroid))).norm() < 1e-12);
        assert_eq!(motions[1].spin, Vec3::zeros());
    }
}
