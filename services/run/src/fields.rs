//! What fields do to rigid bodies: their accelerations before a step, whom they remove after it.

use super::{Event, RunError, SceneRun, number};
use cullet_geometry::Vec3;
use cullet_geometry::math::{scramble, unit};
use cullet_scene::directions::{FieldLaw, SceneField};
use cullet_world::{BodyId, BodyView};
use std::f64::consts::PI;

/// Root mean square of the curl of three value noises with quintic blending and lattice values even
/// over [-1, 1) \[1\]: √6 · √(2/3 · 10/7) · 2∫f², where f = 6t⁵ − 15t⁴ + 10t³, ∫f'² = 10/7 and
/// ∫f² = 181/462.
const CURL_RMS: f64 = 1.873_038_6;

impl SceneRun<'_> {
    /// Accelerates all bodies that feel fields, for the step to come.
    pub(super) fn apply_fields(&mut self) {
        let fields = &self.scene.directions.fields;
        if fields.iter().all(|field| matches!(field.law, FieldLaw::Kill { .. })) {
            return;
        }
        let (time, step) = (self.world.time(), self.scene.world.step);
        let free = self.world.bodies().filter(|view| !view.fixed && !view.driven);
        let pull = |view: &BodyView<'_>| {
            let felt = fields.iter().filter(|field| self.feels(field, view.id));
            let sum: Vec3 = felt.map(|field| acceleration(&field.law, view, time, step)).sum();
            (view.id, sum)
        };
        let pulls: Vec<(BodyId, Vec3)> = free.map(|view| pull(&view)).collect();
        for (body, acceleration) in pulls {
            if acceleration != Vec3::zeros() {
                self.world.accelerate(body, acceleration);
            }
        }
    }

    fn feels(&self, field: &SceneField, body: BodyId) -> bool {
        field.bodies.as_ref().is_none_or(|bodies| {
            self.origins.get(&body).is_some_and(|origin| bodies.contains(&origin.object))
        })
    }

    /// Removes bodies that planes of fields or the bounds of the world do not let be. One whose job
    /// is not settled stays until it is.
    pub(super) fn remove_bodies(&mut self) -> Result<(), RunError> {
        let kills = |field: &&SceneField| matches!(field.law, FieldLaw::Kill { .. });
        let fields: Vec<&SceneField> = self.scene.directions.fields.iter().filter(kills).collect();
        let bounds = self.scene.world.bounds;
        if fields.is_empty() && bounds.is_none() {
            return Ok(());
        }
        let why = |view: &BodyView<'_>| {
            let at = view.pose.translation.vector;
            let behind = |field: &&&SceneField| match field.law {
                FieldLaw::Kill { point, normal } => {
                    (at - point).dot(&normal) < 0.0 && self.feels(field, view.id)
                }
                _ => false,
            };
            if fields.iter().any(|field| behind(&field)) {
                return Some("it is behind the plane of a field");
            }
            let out =
                bounds.is_some_and(|it| (0..3).any(|k| at[k] < it.min[k] || at[k] > it.max[k]));
            out.then_some("it is outside of the bounds of the world")
        };
        let free = self.world.bodies().filter(|view| !view.fixed && !view.driven);
        let idle = free.filter(|view| !self.pending.iter().any(|job| job.body == view.id));
        let gone: Vec<(BodyId, &str)> =
            idle.filter_map(|view| Some((view.id, why(&view)?))).collect();
        for (body, reason) in gone {
            if self.world.remove(body) {
                self.event(&Event::Removed { body: number(body), reason: reason.to_owned() })?;
                self.joints_changed = true;
            }
        }
        Ok(())
    }
}

/// What a field gives a body in a step that begins at `time` \[s\] and lasts `step` \[s\], as the
/// mean acceleration \[m/s²\].
fn acceleration(law: &FieldLaw, body: &BodyView<'_>, time: f64, step: f64) -> Vec3 {
    let at = body.pose.translation.vector;
    match *law {
        FieldLaw::Wind { velocity, drag, density } => {
            let radius = libm::cbrt(3.0 * body.volume / (4.0 * PI));
            let factor = 0.5 * density * drag * PI * radius * radius / body.mass;
            drawn_along(&(velocity - body.velocity), factor, step)
        }
        FieldLaw::Attractor { point, strength, falloff, size } => {
            let way = point - at;
            let distance = way.norm();
            if distance <= size {
                return way * (strength / size);
            }
            let fall = (0..falloff).fold(1.0, |all, _| all * (size / distance));
            way * (strength * fall / distance)
        }
        FieldLaw::Turbulence { strength, size, rate, seed } => {
            stirred(&(at / size), time * rate, seed) * strength
        }
        FieldLaw::Kill { .. } => Vec3::zeros(),
    }
}

/// The mean acceleration over a step of what quadratic drag slows down against air: du/dt = −k|u|u,
/// so u(t) = u₀ / (1 + k|u₀|t), however large the step. `against`: the air's velocity less its own.
fn drawn_along(against: &Vec3, factor: f64, step: f64) -> Vec3 {
    let rate = factor * against.norm();
    against * (rate / (1.0 + rate * step))
}

/// A vector field without divergence and of root mean square 1: the curl of three noises, in eddies
/// of size 1 that turn into others once in a unit of time.
fn stirred(at: &Vec3, time: f64, seed: u64) -> Vec3 {
    let epoch = time.floor();
    let share = fade(time - epoch).0;
    let curl = |epoch: f64| {
        let of = |axis: u64| noise_slope(at, seed, (epoch as u64).wrapping_mul(4) + axis);
        let (x, y, z) = (of(0), of(1), of(2));
        Vec3::new(z.y - y.z, x.z - z.x, y.x - x.y)
    };
    let now = curl(epoch);
    if share == 0.0 {
        return now / CURL_RMS;
    }
    // Two that know nothing of each other: their variances add.
    let size = (share * share + (1.0 - share) * (1.0 - share)).sqrt();
    (now * (1.0 - share) + curl(epoch + 1.0) * share) / (CURL_RMS * size)
}

/// The quintic of Perlin's noise and its slope  [Perlin 2002].
fn fade(t: f64) -> (f64, f64) {
    let value = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    (value, 30.0 * t * t * (1.0 - t) * (1.0 - t))
}

/// The gradient of value noise: numbers in [-1, 1) at the corners of cubes of edge 1, blended.
fn noise_slope(at: &Vec3, seed: u64, stream: u64) -> Vec3 {
    let base = at.map(f64::floor);
    let (x, y, z) = (fade(at.x - base.x), fade(at.y - base.y), fade(at.z - base.z));
    let corner = |i: i64, j: i64, k: i64| {
        let key = |axis: usize, more: i64| (base[axis] as i64).wrapping_add(more) as u64;
        let index = scramble(scramble(scramble(key(0, i)) ^ key(1, j)) ^ key(2, k));
        2.0 * unit(seed, stream, index) - 1.0
    };
    let mut slope = Vec3::zeros();
    for (i, j, k) in (0..8).map(|n| (n & 1, n >> 1 & 1, n >> 2)) {
        let part = |(value, slope): (f64, f64), one: i64| match one {
            0 => (1.0 - value, -slope),
            _ => (value, slope),
        };
        let (a, b, c) = (part(x, i), part(y, j), part(z, k));
        slope += Vec3::new(a.1 * b.0 * c.0, a.0 * b.1 * c.0, a.0 * b.0 * c.1) * corner(i, j, k);
    }
    slope
}

#[cfg(test)]
mod tests {
    use super::{Vec3, drawn_along, stirred, unit};

    fn places() -> impl Iterator<Item = Vec3> {
        (0..40_000_u64).map(|n| {
            let number = |axis| 200.0 * unit(5, axis, n) - 100.0;
            Vec3::new(number(0), number(1), number(2))
        })
    }

    #[test]
    fn turbulence_has_the_strength_that_it_is_given_at_any_time() {
        for time in [0.0, 0.5, 7.25] {
            let squares = places().map(|at| stirred(&at, time, 3).norm_squared());
            let rms = (squares.sum::<f64>() / 40_000.0).sqrt();
            assert!((rms - 1.0).abs() < 0.02, "{rms} at {time}");
            let mean = places().map(|at| stirred(&at, time, 3)).sum::<Vec3>() / 40_000.0;
            assert!(mean.norm() < 0.02, "{mean}");
        }
    }

    #[test]
    fn turbulence_has_no_divergence_and_no_jumps() {
        let h = 1e-5;
        for at in places().take(200).chain([Vec3::new(2.0, -3.0, 0.0)]) {
            let along = |axis: usize| {
                let mut step = Vec3::zeros();
                step[axis] = h;
                let (low, high) = (stirred(&(at - step), 0.4, 9), stirred(&(at + step), 0.4, 9));
                assert!((high - low).norm() < 1e-3, "a jump at {at}");
                (high - low)[axis] / (2.0 * h)
            };
            let divergence: f64 = (0..3).map(along).sum();
            assert!(divergence.abs() < 1e-5, "{divergence} at {at}");
        }
        let at = Vec3::new(0.3, 0.4, 0.5);
        let jump = stirred(&at, 3.0 - 1e-7, 9) - stirred(&at, 3.0 + 1e-7, 9);
        assert!(jump.norm() < 1e-9, "{jump}");
        assert_ne!(stirred(&at, 0.0, 9), stirred(&at, 0.0, 10));
    }

    /// Half the speed against the air is left after 1/(k u) \[s\], in one step or in many.
    #[test]
    fn drag_takes_half_of_the_speed_in_its_time_in_steps_of_any_length() {
        let (factor, speed) = (0.01, 20.0);
        let end = 1.0 / (factor * speed);
        for steps in [1, 7, 100] {
            let step = end / f64::from(steps);
            let mut velocity = Vec3::zeros();
            for _ in 0..steps {
                let against = Vec3::x() * speed - velocity;
                velocity += drawn_along(&against, factor, step) * step;
            }
            assert!((velocity.x - 0.5 * speed).abs() < 1e-9, "{} in {steps}", velocity.x);
        }
    }
}
