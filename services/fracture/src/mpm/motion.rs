//! The rigid motion that carries a part's momentum and angular momentum.

use super::domain::Domain;
use cullet_geometry::{Mat3, Vec3};
use cullet_model::BrittleProblem;

/// Mass, momentum and angular momentum of a set of points about their own centroid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    /// Velocity of the centroid \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity \[rad/s\].
    pub spin: Vec3,
    /// Points.
    pub points: usize,
    volume: f64,
}

impl Default for RigidMotion {
    fn default() -> Self {
        Self { velocity: Vec3::zeros(), spin: Vec3::zeros(), points: 0, volume: 0.0 }
    }
}

/// Velocity along `n` that a unit impulse along `n` at `point` gives the whole body there:
/// 1/m + n·[I⁻¹(r×n)]×r \[1/kg\]  [Gate 0].
#[must_use]
pub fn mobility(problem: &BrittleProblem, point: &Vec3, n: &Vec3) -> f64 {
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
pub fn of_parts(domain: &Domain, part: &[u32], parts: usize) -> Vec<RigidMotion> {
    let particles = &domain.particles;
    let points = domain.motions();
    let position = |p: usize| particles.reference[p] + points[p].displacement;
    let mut motions = vec![RigidMotion::default(); parts];
    let mut centroids = vec![Vec3::zeros(); parts];
    let place = |p: usize| part[particles.id[p] as usize] as usize;
    for (p, point) in points.iter().enumerate().filter(|&(p, _)| place(p) < parts) {
        let at = place(p);
        motions[at].points += 1;
        motions[at].volume += particles.volume[p];
        motions[at].velocity += point.velocity * particles.volume[p];
        centroids[at] += position(p) * particles.volume[p];
    }
    for (motion, centroid) in motions.iter_mut().zip(&mut centroids) {
        let share = if motion.points > 0 { 1.0 / motion.volume } else { 0.0 };
        motion.velocity *= share;
        *centroid *= share;
    }
    // A point is a cloud of second moment h²/4 per axis, so it has inertia and spin of its own.
    let own = domain.grid.spacing.map(|h| 0.25 * h * h);
    let mut momenta = vec![Vec3::zeros(); parts];
    let mut inertias = vec![Mat3::zeros(); parts];
    for (p, point) in points.iter().enumerate().filter(|&(p, _)| place(p) < parts) {
        let at = place(p);
        let r = position(p) - centroids[at];
        let volume = particles.volume[p];
        let slip = point.velocity - motions[at].velocity;
        let twist = (0..3).fold(Vec3::zeros(), |sum, a| {
            sum + Vec3::ith(a, own[a]).cross(&point.velocity_gradient.column(a))
        });
        momenta[at] += (r.cross(&slip) + twist) * volume;
        let square = Mat3::identity() * (r.norm_squared() + own.sum());
        inertias[at] += (square - r * r.transpose() - Mat3::from_diagonal(&own)) * volume;
    }
    for (at, motion) in motions.iter_mut().enumerate() {
        let inverse = inertias[at].try_inverse().filter(|_| motion.points >= LEAST_POINTS);
        motion.spin = inverse.map_or(Vec3::zeros(), |inverse| inverse * momenta[at]);
    }
    motions
}

#[cfg(test)]
mod tests {
    use super::of_parts;
    use crate::damage::Softening;
    use crate::mpm::Domain;
    use crate::mpm::stencil::packed;
    use crate::particles::Particles;
    use cullet_geometry::{Vec3, math::unit};
    use cullet_model::Material;

    const STONE: Material = Material {
        density: 2450.0,
        young: 32e9,
        poisson: 0.2,
        failure_stress: 3e6,
        fracture_energy: 3.0,
    };

    #[test]
    fn a_rigid_motion_is_found_again() {
        let points: Vec<Vec3> = (0..2000)
            .map(|i| Vec3::new(unit(3, 0, i), 2.0 * unit(3, 1, i), 0.5 * unit(3, 2, i)))
            .collect();
        let particles = Particles::at_rest(&points, 1.0, STONE.density);
        let law = Softening::new(&STONE, 0.1);
        let mut domain = Domain::new(particles, &STONE, law, Vec3::new(0.1, 0.1, 0.05));
        let (v, w) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.3, 0.7, -1.1));
        for n in 0..domain.grid.nodes.len() {
            domain.grid.nodes.velocity[n] = packed(v + w.cross(&domain.grid.place(n)));
        }
        let part: Vec<u32> = (0..2000).map(|i| u32::from(i >= 1997)).collect();
        let motions = of_parts(&domain, &part, 2);
        let centroid = points[..1997].iter().sum::<Vec3>() / 1997.0;
        assert!((motions[0].spin - w).norm() < 1e-12);
        assert!((motions[0].velocity - (v + w.cross(&centroid))).norm() < 1e-12);
        assert_eq!(motions[1].spin, Vec3::zeros());
    }
}
