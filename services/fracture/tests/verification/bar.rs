//! F-B: a pulled bar breaks in a band that dissipates G_f per area, whatever the grid.

use cullet_fracture::damage::Softening;
use cullet_fracture::mpm::domain::PrescribedVelocity;
use cullet_fracture::mpm::{Domain, quadrature};
use cullet_fracture::particles::Particles;
use cullet_geometry::{Mat3, Quat, Vec3, inside::Inside, sample, shapes};
use cullet_model::{Material, Strength, StrengthField};
use rayon::prelude::*;
use std::sync::Arc;

const STONE: Material = Material {
    density: 2450.0,
    young: 32e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 3.0,
};

/// A bar along x, pulled at both ends.
#[derive(Clone, Copy)]
struct Bar {
    material: Material,
    /// Grid spacing \[m\].
    spacing: f64,
    /// Size \[m\].
    size: Vec3,
    /// Depth of a notch of one spacing from the side \[m\].
    notch: f64,
    /// Speed of each end \[m/s\].
    speed: f64,
    seed: u64,
    /// Turn of the bar on its grid about z \[rad\], and its shift along itself, in spacings.
    turn: f64,
    phase: f64,
}

/// A bar without a notch that lies along its grid.
const STRAIGHT: Bar = Bar {
    material: STONE,
    spacing: 0.004,
    size: Vec3::new(0.12, 0.056, 0.012),
    notch: 0.0,
    speed: 0.02,
    seed: 0,
    turn: 0.0,
    phase: 0.0,
};

/// What a pull came to.
struct Broken {
    /// Dissipated energy over G_f times the section \[1\].
    energy: f64,
    /// Greatest mean stress over σ_f \[1\].
    peak: f64,
}

impl Bar {
    /// A place on the grid in the bar's own frame.
    fn local(&self, x: &Vec3) -> Vec3 {
        self.way().transpose() * x - Vec3::x() * (self.phase * self.spacing)
    }

    /// The bar's axes on the grid.
    fn way(&self) -> Mat3 {
        Quat::from_axis_angle(&Vec3::z_axis(), self.turn).to_rotation_matrix().into_inner()
    }

    /// The bar, already moving as it will, with a sawn notch; `strength` at a point over σ_f.
    fn domain(&self, strength: impl Fn(&Vec3) -> f64) -> Domain {
        let (h, half, bar) = (self.spacing, 0.5 * self.size.x, *self);
        let mut mesh = shapes::cuboid(self.size, shapes::Detail::default()).expect("a box");
        let (way, shift) = (self.way(), Vec3::x() * (self.phase * h));
        mesh.vertices.iter_mut().for_each(|x| *x = way * (*x + shift));
        let inside = Inside::new(&mesh);
        let points = sample::poisson(&inside, 0.5 * h, self.seed).expect("points");
        let mut particles =
            Particles::at_rest(&points, mesh.signed_volume(), self.material.density);
        particles.volume =
            quadrature::volumes(&points, &inside, Vec3::repeat(h), mesh.signed_volume());
        for (p, x) in points.iter().enumerate() {
            // The grips hold.
            let grip = bar.local(x).x.abs() > 0.7 * half;
            particles.strength[p] = if grip { 10.0 } else { strength(&bar.local(x)) };
        }
        let law = Softening::on_grid(&self.material, h);
        let mut domain = Domain::new(particles, &self.material, law, Vec3::repeat(h));
        let tip = self.notch - 0.5 * self.size.y;
        domain.sever(|a, b| {
            let (a, b) = (bar.local(a), bar.local(b));
            let apart = a.x < 0.0 && b.x >= 0.0;
            apart && a.y + (b.y - a.y) * (a.x / (a.x - b.x)) < tip
        });
        let at_notch = |x: &Vec3| x.x.abs() < 0.75 * h && x.y < tip;
        let near =
            (0..points.len() as u32).filter(|&id| at_notch(&bar.local(&points[id as usize])));
        near.for_each(|id| domain.open(id, 0.0));
        let speed = self.speed;
        domain.launch(|x| {
            way * Vec3::x() * (speed * (bar.local(x).x / (0.9 * half)).clamp(-1.0, 1.0))
        });
        let grip = move |at: Vec3| {
            let x = bar.local(&at).x;
            (x.abs() > 0.9 * half).then(|| way * Vec3::new(speed * x.signum(), 0.0, 0.0))
        };
        domain.prescribed = Some(PrescribedVelocity(Arc::new(grip)));
        domain
    }

    /// Pulls until the bar has parted and for a good while after.
    fn pull(&self, strength: impl Fn(&Vec3) -> f64) -> Broken {
        let mut domain = self.domain(strength);
        let (mut energy, mut peak, mut parted) = (0.0, 0.0_f64, f64::INFINITY);
        while domain.time < 1.7 * parted {
            energy += domain.advance().dissipated;
            if !domain.steps.is_multiple_of(4) {
                continue;
            }
            let now = self.mean_stress(&domain, 0.35 * self.size.x);
            peak = peak.max(now);
            if peak > 0.2 * self.cap() && now < 0.15 * peak {
                parted = parted.min(domain.time);
            }
        }
        let area = (self.size.y - self.notch) * self.size.z;
        Broken {
            energy: energy / (area * self.material.fracture_energy),
            peak: peak / self.material.failure_stress,
        }
    }

    /// Mean stress along the bar within `reach` of its middle \[Pa\].
    fn mean_stress(&self, domain: &Domain, reach: f64) -> f64 {
        let (particles, stresses) = (&domain.particles, domain.stresses());
        let n = self.way() * Vec3::x();
        let (mut sum, mut volume) = (0.0, 0.0);
        for (p, x) in particles.reference.iter().enumerate() {
            if self.local(x).x.abs() < reach {
                let s = &stresses[p];
                let along = s[0] * n.x * n.x + s[1] * n.y * n.y + 2.0 * s[3] * n.x * n.y;
                sum += along * particles.volume[p];
                volume += particles.volume[p];
            }
        }
        sum / volume
    }

    /// Strength at which cracks grow on this grid \[Pa\].
    fn cap(&self) -> f64 {
        Softening::on_grid(&self.material, self.spacing).strength
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// F-B, the calibration: one crack from a notch through a bar 14 spacings wide. The ends move the
/// more slowly the larger the bar, so that the waves in it matter as much.
#[test]
fn a_crack_spends_the_fracture_energy_on_four_grids() {
    let mut off = Vec::new();
    for spacing in [0.008, 0.004, 0.002, 0.001] {
        let (size, speed) = (Vec3::new(30.0, 14.0, 3.0) * spacing, 0.02 * (0.004 / spacing).sqrt());
        let bar = Bar { spacing, size, notch: 4.0 * spacing, speed, ..STRAIGHT };
        let all: Vec<f64> = (0..6_u64)
            .into_par_iter()
            .map(|seed| Bar { seed, phase: seed as f64 / 6.0, ..bar }.pull(|_| 1.0).energy)
            .collect();
        let spent = mean(&all);
        println!("h = {spacing} m: {spent:.3} G_f {all:.2?}");
        if (spent - 1.0).abs() > 0.06 || all.iter().any(|g| (g - 1.0).abs() > 0.10) {
            off.push((spacing, spent, all));
        }
    }
    assert!(off.is_empty(), "{off:?} G_f");
}

/// F-B without a notch, of the strength that a ceramic has: Weibull modulus 10. The bar holds five
/// times the energy of a crack when it starts to break, so that a second crack may follow the
/// first before the relief arrives; most bars get one.
#[test]
fn a_bar_without_a_notch_breaks_near_its_strength() {
    let spacing = 0.004;
    let size = Vec3::new(0.1, 4.0 * spacing, 4.0 * spacing);
    let bar = Bar { material: STONE, spacing, size, speed: 0.01, ..STRAIGHT };
    let all: Vec<Broken> = (0..8_u64)
        .into_par_iter()
        .map(|seed| {
            let field = StrengthField { seed, weibull: 10.0, ..StrengthField::default() };
            let strength = Strength::new(&field, spacing);
            Bar { seed, ..bar }.pull(|x| strength.factor(x))
        })
        .collect();
    let spent: Vec<f64> = all.iter().map(|b| b.energy).collect();
    assert!((0.7..1.6).contains(&mean(&spent)), "{spent:?} G_f");
    let peak: Vec<f64> = all.iter().map(|b| b.peak).collect();
    // Where flaws scatter by an eighth, the weakest place of the bar decides.
    assert!((mean(&peak) - 0.8).abs() < 0.1, "{peak:?} of the strength");
}

/// Points of equal volume break at 0.8 of the strength; those of the quadrature come close to it.
#[test]
fn a_thick_bar_reaches_its_strength() {
    let spacing = 0.004;
    let size = Vec3::new(0.1, 8.0 * spacing, 8.0 * spacing);
    let bar = Bar { material: STONE, spacing, size, speed: 0.01, seed: 1, ..STRAIGHT };
    let weak = |x: &Vec3| if x.x.abs() < 0.25 * spacing { 0.98 } else { 1.0 };
    let peak = bar.pull(weak).peak;
    assert!((peak - 0.95).abs() < 0.03, "{peak}");
}

/// F01: on a grid too coarse for the material a crack that is there grows for G_f an area, and
/// where there is none the material holds to its own strength.
#[test]
fn a_coarse_grid_keeps_toughness_and_strength() {
    let spacing = 0.004;
    let material = Material { failure_stress: 6.0 * STONE.failure_stress, ..STONE };
    let size = Vec3::new(30.0, 14.0, 3.0) * spacing;
    let bar = Bar { material, spacing, size, notch: 4.0 * spacing, ..STRAIGHT };
    assert!(bar.cap() < 0.3 * material.failure_stress);
    let notched: Vec<Broken> =
        (0..4_u64).into_par_iter().map(|seed| Bar { seed, ..bar }.pull(|_| 1.0)).collect();
    let spent: Vec<f64> = notched.iter().map(|b| b.energy).collect();
    assert!((mean(&spent) - 1.0).abs() < 0.08, "{spent:?} G_f");
    assert!(notched.iter().all(|b| b.peak * material.failure_stress < bar.cap()));

    let whole = Bar { notch: 0.0, speed: 0.06, ..bar }.pull(|_| 1.0);
    // The first point to break decides: stress scatters by a tenth and more at the surface.
    assert!((0.7..1.0).contains(&whole.peak), "{} of the strength", whole.peak);
}

/// F-B at eight places of the grid beside the crack's plane and four turns of it: what a crack
/// costs does not go by where it lies and whichever way it runs, nor does the force that drives it.
#[test]
fn a_crack_costs_as_much_wherever_it_lies() {
    // k = 0.05, 0.19 as it is in most scenes, and far above the cap.
    let mut off = Vec::new();
    for share in [0.516, 1.0, 1.63] {
        let material = Material { failure_stress: share * STONE.failure_stress, ..STONE };
        let notched = Bar { material, notch: 0.016, ..STRAIGHT };
        let cases: Vec<Bar> = [0.0_f64, 17.0, 30.0, 45.0]
            .into_iter()
            .flat_map(|turn| (0..8).map(move |k| (turn.to_radians(), f64::from(k) / 8.0)))
            .map(|(turn, phase)| Bar { turn, phase, ..notched })
            .collect();
        let all: Vec<Broken> = cases.par_iter().map(|bar| bar.pull(|_| 1.0)).collect();
        let spent: Vec<f64> = all.iter().map(|b| b.energy).collect();
        let peaks: Vec<f64> = all.iter().map(|b| b.peak * share).collect();
        let (energy, force) = (mean(&spent), mean(&peaks));
        for (k, bars) in cases.chunks(8).enumerate() {
            let of = |all: &[f64]| -> Vec<f64> { all[8 * k..8 * k + 8].to_vec() };
            println!(
                "{share} σ_f at {:.0}°: {:.3} G_f {:.2?}, peak {:.3} of the mean {:.2?}",
                bars[0].turn.to_degrees(),
                mean(&of(&spent)),
                of(&spent),
                mean(&of(&peaks)) / force,
                of(&peaks).iter().map(|peak| peak / force).collect::<Vec<f64>>(),
            );
        }
        println!("{share} σ_f: {energy:.3} G_f, peak {force:.3} of 3 MPa");
        let far = |all: &[f64], wanted: f64, bound: f64| {
            all.iter().any(|value| (value / wanted - 1.0).abs() > bound)
        };
        let faults = [
            ((energy - 1.0).abs() > 0.06, "the mean energy"),
            (far(&spent, 1.0, 0.10), "an energy"),
            (far(&peaks, force, 0.10), "a peak"),
        ];
        off.extend(faults.iter().filter(|fault| fault.0).map(|fault| (share, fault.1)));
    }
    assert!(off.is_empty(), "too far off: {off:?}");
}
