//! The contact between striker and body as a spring: Hertz's, that yields where the pressure
//! reaches what either of the two bears (F13).

use crate::Impact;

/// Duration of a Hertz contact over δ_max/v.
const HERTZ_TIME: f64 = 2.943_3;

/// Force over approach δ of two round bodies.
///
/// Up to δ_y, F = k δ^{3/2} (H1). There the middle of the contact has reached the pressure p_c at
/// which it crushes; beyond, F = F_y + πR p_c (δ − δ_y), and the way back is Hertz's for the
/// flatter contact that the crushing left  [Thornton 1997, Eq. 1–12].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzContact {
    /// k \[N/m^{3/2}\].
    stiffness: f64,
    /// δ_y \[m\].
    yields: f64,
    /// Greatest approach so far \[m\].
    deepest: f64,
    /// R, the radius of the contact being a = √(Rδ) \[m\].
    radius: f64,
}

impl HertzContact {
    /// The spring of an impact: the one whose Hertz contact takes its duration, δ_max = v t_c/2.943
    /// and ½ m* v² = ⅖ k δ_max^{5/2}  (H1).
    #[must_use]
    pub fn new(impact: &Impact) -> Self {
        let hertz = impact.closing_speed * impact.duration / HERTZ_TIME;
        let stiffness = 2.5 * impact.energy / power(hertz, 5);
        // p₀ = 3F/2πa²  [H1], and p₀ ∝ √δ
        let area = core::f64::consts::PI * impact.radius * impact.radius;
        let peak = 1.5 * stiffness * power(hertz, 3) / area;
        let share = (impact.crushing_pressure / peak).min(1.0);
        Self {
            stiffness,
            yields: hertz * share * share,
            deepest: 0.0,
            radius: impact.radius * impact.radius / hertz,
        }
    }

    /// R of the contact: 1/R is the sum of both curvatures \[m\].
    #[must_use]
    pub fn relative_radius(&self) -> f64 {
        self.radius
    }

    /// Force at an approach of `depth` \[m\], after what it has been through \[N\].
    pub fn force(&mut self, depth: f64) -> f64 {
        self.deepest = self.deepest.max(depth);
        let (deepest, most) = (self.deepest, self.loading(self.deepest));
        if most <= 0.0 {
            return 0.0;
        }
        // R_p/R = F_Hertz/F at the deepest, and what is left of the dent is δ_p = δ(1 − R/R_p).
        let flatter = self.stiffness * power(deepest, 3) / most;
        let dent = deepest * (1.0 - 1.0 / flatter);
        self.stiffness * flatter.sqrt() * power((depth - dent).max(0.0), 3)
    }

    /// Energy that comes back from an approach of `depth` \[m\], after what it has been through
    /// \[J\]: that of the Hertz contact on the way back.
    #[must_use]
    pub fn stored(mut self, depth: f64) -> f64 {
        let force = self.force(depth);
        if force <= 0.0 {
            return 0.0;
        }
        let flatter = self.stiffness * power(self.deepest, 3) / self.loading(self.deepest);
        let dent = self.deepest * (1.0 - 1.0 / flatter);
        0.4 * force * (depth - dent).max(0.0)
    }

    /// Energy that crushing has taken so far: what the way in to the deepest took, less what comes
    /// back from there \[J\].
    #[must_use]
    pub fn crushed(&self) -> f64 {
        let beyond = (self.deepest - self.yields).max(0.0);
        let first = 0.4 * self.stiffness * power(self.deepest.min(self.yields), 5);
        let mean = 0.5 * (self.loading(self.yields) + self.loading(self.deepest));
        (first + mean * beyond - self.stored(self.deepest)).max(0.0)
    }

    /// Force on the way in \[N\].
    fn loading(&self, depth: f64) -> f64 {
        let elastic = depth.min(self.yields);
        self.stiffness * power(elastic, 3) + self.slope() * (depth - self.yields).max(0.0)
    }

    /// πR p_c, which is the slope of Hertz's force at δ_y \[N/m\].
    fn slope(&self) -> f64 {
        1.5 * self.stiffness * self.yields.sqrt()
    }

    /// Approach that takes up `energy` \[J\] on the way in \[m\].
    #[must_use]
    pub fn depth(&self, energy: f64) -> f64 {
        let first = 0.4 * self.stiffness * power(self.yields, 5);
        let beyond = energy - first;
        if beyond <= 0.0 {
            return libm::pow(2.5 * energy / self.stiffness, 0.4);
        }
        let (force, slope) = (self.stiffness * power(self.yields, 3), self.slope());
        self.yields + ((force * force + 2.0 * slope * beyond).sqrt() - force) / slope
    }

    /// Radius of the contact at an approach of `depth`: a = √(Rδ) \[m\].
    #[must_use]
    pub fn radius(&self, depth: f64) -> f64 {
        (self.radius * depth.max(0.0)).sqrt()
    }

    /// Radius of the contact now that it has been through its deepest \[m\].
    #[must_use]
    pub fn widest(&self) -> f64 {
        self.radius(self.deepest)
    }

    /// Greatest force so far \[N\].
    #[must_use]
    pub fn greatest(&self) -> f64 {
        self.loading(self.deepest)
    }

    /// Whether an impact of `energy` \[J\] crushes the contact.
    #[must_use]
    pub fn crushes(&self, energy: f64) -> bool {
        self.depth(energy) > self.yields * (1.0 + 1e-9)
    }

    /// Force at the deepest approach of an impact of `energy` \[J\] on a rigid body \[N\].
    #[must_use]
    pub fn peak(&self, energy: f64) -> f64 {
        self.loading(self.depth(energy))
    }

    /// The same, were nothing crushed \[N\].
    #[must_use]
    pub fn elastic_peak(&self, energy: f64) -> f64 {
        self.stiffness * libm::pow(2.5 * energy / self.stiffness, 0.6)
    }
}

/// How long the contact of an impact on a rigid body takes: Hertz's duration, or for one that
/// crushes the time to come to rest against F_y + K(δ − δ_y) and the half of a Hertz contact that
/// throws back what has not been spent \[s\].
#[must_use]
pub fn duration(impact: &Impact) -> f64 {
    let spring = HertzContact::new(impact);
    if !spring.crushes(impact.energy) {
        return impact.duration;
    }
    let mass = 2.0 * impact.energy / (impact.closing_speed * impact.closing_speed);
    let first = 0.4 * spring.stiffness * power(spring.yields, 5);
    let left = (2.0 * (impact.energy - first).max(0.0) / mass).sqrt();
    let (force, slope) = (spring.stiffness * power(spring.yields, 3), spring.slope());
    let pace = (slope / mass).sqrt();
    let deepest = spring.depth(impact.energy);
    let most = spring.loading(deepest);
    let back = deepest * most / (spring.stiffness * power(deepest, 3));
    let speed = (0.8 * most * back / mass).sqrt();
    2.0 * spring.yields / (impact.closing_speed + left)
        + libm::atan2(left * slope, pace * force) / pace
        + 0.5 * HERTZ_TIME * back / speed
}

/// x^{n/2}.
fn power(x: f64, n: i32) -> f64 {
    x.sqrt().powi(n)
}

#[cfg(test)]
mod tests {
    use super::{HertzContact, duration};
    use crate::Impact;
    use cullet_geometry::Vec3;

    /// A ball of 12 mm and 57 g, at 99 m/s, on plaster.
    fn impact(crushing_pressure: f64) -> Impact {
        let (mass, closing_speed) = (0.0566, 99.0);
        let (modulus, radius) = (3.1e9, 0.012_f64);
        let stiffness = 4.0 / 3.0 * modulus * radius.sqrt();
        let energy = 0.5 * mass * closing_speed * closing_speed;
        let deepest = libm::pow(2.5 * energy / stiffness, 0.4);
        Impact {
            point: Vec3::zeros(),
            normal: Vec3::x(),
            impulse: 2.0 * mass * closing_speed,
            duration: super::HERTZ_TIME * deepest / closing_speed,
            radius: (radius * deepest).sqrt(),
            energy,
            closing_speed,
            crushing_pressure,
        }
    }

    /// Flies a mass into the spring: duration \[s\], peak force \[N\], rebound speed over closing
    /// speed.
    fn fly(impact: &Impact) -> (f64, f64, f64) {
        let mut spring = HertzContact::new(impact);
        let mass = 2.0 * impact.energy / impact.closing_speed.powi(2);
        let (mut depth, mut speed, mut time, mut peak) = (0.0, impact.closing_speed, 0.0, 0.0);
        let step = 1e-5 * impact.duration;
        loop {
            let force = spring.force(depth);
            if speed < 0.0 && force <= 0.0 {
                return (time, peak, -speed / impact.closing_speed);
            }
            peak = f64::max(peak, force);
            speed -= force / mass * step;
            depth += speed * step;
            time += step;
        }
    }

    #[test]
    fn a_strong_contact_is_hertz() {
        let hit = impact(1e12);
        let (time, peak, back) = fly(&hit);
        let stiffness = 4.0 / 3.0 * 3.1e9 * 0.012_f64.sqrt();
        let wanted = stiffness * libm::pow(2.5 * hit.energy / stiffness, 0.6);
        assert!((time / hit.duration - 1.0).abs() < 1e-3, "{time}");
        assert!((peak / wanted - 1.0).abs() < 1e-3, "{peak} N, not {wanted}");
        assert!((back - 1.0).abs() < 1e-3, "{back}");
        assert_eq!(duration(&hit), hit.duration);
        assert!(!HertzContact::new(&hit).crushes(hit.energy));
    }

    /// A tenth of the pressure: a longer push of less force that throws back little.
    #[test]
    fn a_weak_contact_crushes() {
        let hard = fly(&impact(1e12));
        let hit = impact(72e6);
        let (time, peak, back) = fly(&hit);
        let spring = HertzContact::new(&hit);
        assert!((duration(&hit) / time - 1.0).abs() < 0.02, "{} and {time} s", duration(&hit));
        assert!((spring.peak(hit.energy) / peak - 1.0).abs() < 1e-3, "{peak} N");
        assert!(peak < 0.4 * hard.1 && time > 1.5 * hard.0, "{peak} N for {time} s");
        // e = 1.18 (v_y/v)^{1/4} where v_y ≪ v  [Johnson 1985, Eq. 11.47], with v_y at p₀ = p_c
        let yielded = 0.4 * spring.stiffness * super::power(spring.yields, 5);
        let slow = (yielded / hit.energy).sqrt();
        let wanted = 1.18 * slow.powf(0.25);
        assert!((back / wanted - 1.0).abs() < 0.15, "{back}, about {wanted}");
        // The mean pressure stays at what it bears.
        let widest = spring.radius(spring.depth(hit.energy));
        let mean = peak / (std::f64::consts::PI * widest * widest);
        assert!(mean < 72e6 && mean > 0.9 * 72e6, "{mean} Pa");
    }

    /// The work of a cycle is spent, never gained, and a second push to the same depth is elastic.
    #[test]
    fn what_was_crushed_stays() {
        let hit = impact(72e6);
        let mut spring = HertzContact::new(&hit);
        let far = 0.8 * spring.depth(hit.energy);
        let mut work = [0.0; 4];
        for (pass, sum) in work.iter_mut().enumerate() {
            for i in 0..10_000 {
                let s = (f64::from(i) + 0.5) / 10_000.0;
                let depth = far * if pass % 2 == 0 { s } else { 1.0 - s };
                *sum += spring.force(depth) * far / 10_000.0;
            }
        }
        assert!(work[0] > 2.0 * work[1], "{work:?}");
        let crushed = spring.crushed();
        assert!((crushed / (work[0] - work[1]) - 1.0).abs() < 1e-3, "{work:?}, {crushed} J");
        let mut whole = HertzContact::new(&impact(1e12));
        whole.force(0.9 * whole.depth(hit.energy));
        assert!(whole.crushed() < 1e-12 * hit.energy, "{} J", whole.crushed());
        assert!((work[2] / work[1] - 1.0).abs() < 1e-3 && (work[3] / work[1] - 1.0).abs() < 1e-9);
    }
}
