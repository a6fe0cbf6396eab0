//! How a wall comes to rest after its hits.

use crate::domain::ShellDomain;
use cullet_geometry::{Mat3, Vec3};
use cullet_simd::Real;

/// Peaks of the motion that are let go by, until it is at rest.
const PEAKS: u32 = 12;

/// Energy of a peak over that of the first at which it is at rest  \[1\].
const REST: f64 = 1e-3;

/// Motion of the whole.
pub(super) struct WholeMotion {
    centre: Vec3,
    velocity: Vec3,
    spin: Vec3,
}

/// How a wall comes to rest: each time that its motion beside that of the whole is at a peak, it is
/// stopped \[kinetic damping: Barnes 1999\].
#[derive(Clone, Debug, Default)]
pub(super) struct KineticDamping {
    last: f64,
    first: f64,
    peaks: u32,
    /// Energy that was taken \[J\].
    pub(super) taken: f64,
}

impl WholeMotion {
    pub(super) fn of<R: Real, const N: usize>(domain: &ShellDomain<R, N>) -> Self {
        let place = |n: usize| domain.surface.nodes[domain.origin[n] as usize] + domain.moved(n);
        let all = || (0..domain.mass.len()).map(|n| (domain.mass[n], place(n), domain.velocity[n]));
        let mass: f64 = domain.mass.iter().sum();
        let centre = all().map(|(m, x, _)| x * m).sum::<Vec3>() / mass;
        let velocity = all().map(|(m, _, v)| v * m).sum::<Vec3>() / mass;
        let (mut momentum, mut inertia) = (Vec3::zeros(), Mat3::zeros());
        for (m, x, v) in all() {
            let r = x - centre;
            momentum += r.cross(&(v - velocity)) * m;
            inertia += (Mat3::identity() * r.norm_squared() - r * r.transpose()) * m;
        }
        let spin = inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * momentum);
        Self { centre, velocity, spin }
    }

    fn at(&self, place: &Vec3) -> Vec3 {
        self.velocity + self.spin.cross(&(place - self.centre))
    }
}

impl KineticDamping {
    /// After a step: whether it is at rest.
    pub(super) fn look<R: Real, const N: usize>(&mut self, domain: &mut ShellDomain<R, N>) -> bool {
        let motion = WholeMotion::of(domain);
        let own: Vec<Vec3> = (0..domain.mass.len())
            .map(|n| {
                motion.at(&(domain.surface.nodes[domain.origin[n] as usize] + domain.moved(n)))
            })
            .collect();
        let beside = domain.velocity.iter().zip(&own).zip(&domain.mass);
        let energy: f64 = beside.map(|((v, own), m)| 0.5 * m * (v - own).norm_squared()).sum();
        if energy < self.last {
            self.first = self.first.max(self.last);
            self.peaks += 1;
            self.taken += energy;
            domain.velocity = own;
            let was = std::mem::take(&mut self.last);
            return was <= REST * self.first || self.peaks >= PEAKS;
        }
        self.last = energy;
        false
    }
}
