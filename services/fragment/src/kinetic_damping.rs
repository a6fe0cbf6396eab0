//! How a body comes to rest after its hits.

use cullet_geometry::{Mat3, Vec3};

/// Peaks of the motion that are let go by, until it is at rest.
const PEAKS: u32 = 12;

/// Energy of a peak over that of the first at which it is at rest  \[1\].
const REST: f64 = 1e-3;

/// Motion of the whole.
struct WholeMotion {
    centre: Vec3,
    velocity: Vec3,
    spin: Vec3,
}

/// How a body comes to rest: each time that its motion beside that of the whole is at a peak, it is
/// stopped \[kinetic damping: Barnes 1999\].
#[derive(Clone, Debug, Default)]
pub struct KineticDamping {
    last: f64,
    first: f64,
    peaks: u32,
    /// Energy that was taken \[J\].
    pub taken: f64,
}

impl WholeMotion {
    fn of(masses: &[f64], places: &[Vec3], velocities: &[Vec3]) -> Self {
        let all = || masses.iter().zip(places).zip(velocities).map(|((m, x), v)| (*m, x, v));
        let mass: f64 = masses.iter().sum();
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
    /// After a step, with the masses \[kg\], places \[m\] and velocities \[m/s\] of all nodes,
    /// which it changes: whether the body is at rest.
    pub fn look(&mut self, masses: &[f64], places: &[Vec3], velocities: &mut [Vec3]) -> bool {
        let motion = WholeMotion::of(masses, places, velocities);
        let beside = velocities.iter().zip(places).zip(masses);
        let energy: f64 =
            beside.map(|((v, x), m)| 0.5 * m * (v - motion.at(x)).norm_squared()).sum();
        if energy < self.last {
            self.first = self.first.max(self.last);
            self.peaks += 1;
            self.taken += energy;
            velocities.iter_mut().zip(places).for_each(|(v, x)| *v = motion.at(x));
            let was = std::mem::take(&mut self.last);
            return was <= REST * self.first || self.peaks >= PEAKS;
        }
        self.last = energy;
        false
    }
}
