//! From a specimen to a body on its grid.

use super::{Points, Settings, Specimen, Start, within};
use crate::damage::Softening;
use crate::material::Material;
use crate::mpm::domain::stable_step;
use crate::mpm::door;
use crate::mpm::kernel::Path;
use crate::mpm::{Domain, quadrature};
use crate::particles::Particles;
use crate::solver::Refusal;
use crate::strength::Strength;
use cullet_geometry::inside::Inside;
use cullet_geometry::math::unit;
use cullet_geometry::sample::{self, SampleError};
use cullet_geometry::{Pose, Quat, Vec3};

/// Stress that no specimen reaches \[Pa\], and the energy it would take \[J/m²\].
const UNBREAKABLE: (f64, f64) = (1e20, 1e40);

/// Spacings from a notch within which cracks may grow from it.
const TIP: f64 = 0.75;

/// From the specimen's frame to the grid's and back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    turn: Quat,
    shift: Vec3,
}

impl Frame {
    pub(super) fn new(specimen: &Specimen) -> Self {
        Self { turn: specimen.turn, shift: specimen.shift }
    }

    /// A place of the specimen on the grid \[m\].
    pub(super) fn onto(&self, x: &Vec3) -> Vec3 {
        self.turn * x + self.shift
    }

    /// A place of the grid in the specimen \[m\].
    pub(super) fn back(&self, x: &Vec3) -> Vec3 {
        self.turn.inverse() * (x - self.shift)
    }

    /// A direction of the specimen on the grid.
    pub(super) fn turned(&self, v: &Vec3) -> Vec3 {
        self.turn * v
    }

    /// A direction of the grid in the specimen.
    pub(super) fn unturned(&self, v: &Vec3) -> Vec3 {
        self.turn.inverse() * v
    }

    /// Whether both have the same axes.
    pub(super) fn is_straight(&self) -> bool {
        self.turn.angle() < 1e-12
    }
}

/// Refuses what cannot be solved, with the bound.
pub(super) fn check(specimen: &Specimen) -> Result<(), Refusal> {
    let (m, s) = (&specimen.material, &specimen.settings);
    door::within("density [kg/m^3]", m.density, 1e-3, 1e6)?;
    door::within("Young's modulus [Pa]", m.young, 1.0, 1e14)?;
    door::within("Poisson's ratio", m.poisson, -0.99, 0.49)?;
    door::within("the spacing [m]", s.spacing, 1e-9, 1e6)?;
    door::within("the step over its bound", s.step_factor, 1e-6, 100.0)?;
    door::within("points a cell", s.per_cell, 0.5, 1000.0)?;
    door::within("the end [s]", specimen.end, f64::MIN_POSITIVE, 1e9)?;
    if s.breaks {
        door::within("fracture energy [J/m^2]", m.fracture_energy, 1e-9, 1e12)?;
        door::within("failure stress over Young's modulus", m.failure_stress / m.young, 1e-9, 1.0)?;
    }
    let volume = specimen.mesh.signed_volume();
    door::within("the body's volume [m^3]", volume, 1e-18, 1e12)?;
    let points = s.per_cell * volume / (s.spacing * s.spacing * s.spacing);
    at_most("the number of points", points, s.max_points)?;
    at_most("the number of steps", specimen.end / step(m, s), s.max_steps)
}

fn at_most(what: &'static str, value: f64, limit: f64) -> Result<(), Refusal> {
    if value <= limit { Ok(()) } else { Err(Refusal::TooLarge { what, value, limit }) }
}

/// The time step \[s\].
pub(super) fn step(material: &Material, settings: &Settings) -> f64 {
    settings.step_factor * stable_step(material, settings.spacing)
}

/// The body on its grid, moving as it starts.
pub(super) fn domain(specimen: &Specimen) -> Result<Domain, Refusal> {
    let (s, frame) = (&specimen.settings, Frame::new(specimen));
    let pose = Pose::from_parts(specimen.shift.into(), specimen.turn);
    let mesh = specimen.mesh.transformed(&pose);
    let (inside, volume) = (Inside::new(&mesh), mesh.signed_volume());
    let points = points(&inside, s)?;
    let count = points.len() as f64;
    door::within("the number of points in the body", count, 8.0, s.max_points * 1.2)?;
    let mut particles = Particles::at_rest(&points, volume, specimen.material.density);
    if s.points == Points::Scattered {
        let spacing = Vec3::repeat(s.spacing);
        particles.volume = quadrature::volumes(&points, &inside, spacing, volume);
    }
    let strength = Strength::new(&specimen.strength, s.spacing);
    for (p, x) in points.iter().map(|x| frame.back(x)).enumerate() {
        particles.strength[p] = strength.factor(&x);
        for patch in specimen.patches.iter().filter(|patch| within(&patch.part, &x, 0.0)) {
            particles.strength[p] *= patch.strength;
            particles.damage[p] = particles.damage[p].max(patch.damage);
        }
    }
    let mut domain =
        Domain::new(particles, &specimen.material, softening(specimen), Vec3::repeat(s.spacing));
    domain.select(s.precision, Path::best());
    domain.fields = s.fields;
    domain.step = step(&specimen.material, s);
    notch(specimen, &frame, &mut domain);
    if specimen.stretch.norm() > 0.0 {
        domain.displace(|x| frame.turned(&(specimen.stretch * frame.back(x))));
    }
    launch(specimen, &frame, &mut domain);
    Ok(domain)
}

fn points(inside: &Inside, s: &Settings) -> Result<Vec<Vec3>, Refusal> {
    let apart = s.spacing / libm::cbrt(s.per_cell);
    if s.points == Points::Scattered {
        return sample::poisson(inside, apart, s.seed).map_err(|error| {
            let value = match error {
                SampleError::TooMany { candidates, .. } => candidates,
                SampleError::Spacing { spacing } => spacing,
            };
            let limit = sample::MAX_CANDIDATES;
            Refusal::TooLarge { what: "the number of points in the body's box", value, limit }
        });
    }
    let (low, high) = inside.bounds();
    // A row begins half a distance from a node: two a cell lie at its quarter points.
    let first = low.map(|x| (x / apart).floor() as i64);
    let count = (high - low).map(|x| (x / apart).ceil() as i64 + 1);
    let all = count.map(|n| n as f64).product();
    at_most("the number of points in the body's box", all, sample::MAX_CANDIDATES)?;
    let mut points = Vec::new();
    for (i, j) in (0..count.x).flat_map(|i| (0..count.y).map(move |j| (i, j))) {
        for k in 0..count.z {
            let place = Vec3::new((first.x + i) as f64, (first.y + j) as f64, (first.z + k) as f64);
            let x = (place + Vec3::repeat(0.5)) * apart;
            if inside.contains(x) {
                points.push(x);
            }
        }
    }
    Ok(points)
}

/// Stress at which cracks grow over σ_f \[1\].
pub(super) fn strength_ratio(specimen: &Specimen) -> f64 {
    softening(specimen).strength_ratio
}

fn softening(specimen: &Specimen) -> Softening {
    let (material, s) = (&specimen.material, &specimen.settings);
    if !s.breaks {
        let (failure_stress, fracture_energy) = UNBREAKABLE;
        let strong = Material { failure_stress, fracture_energy, ..*material };
        return Softening::new(&strong, s.spacing);
    }
    match s.softening_length {
        Some(length) => Softening::new(material, length),
        None => Softening::on_grid(material, s.spacing),
    }
}

/// Cuts the bonds that cross a notch, and lets cracks grow from there.
fn notch(specimen: &Specimen, frame: &Frame, domain: &mut Domain) {
    let slack = 1e-9 * specimen.settings.spacing;
    for notch in &specimen.notches {
        let height = |x: &Vec3| (frame.back(x) - notch.point).dot(&notch.normal);
        domain.sever(|a, b| {
            let (above, below) = (height(a), height(b));
            if above < 0.0 || below >= 0.0 {
                return false;
            }
            let crossing = a + (b - a) * (above / (above - below));
            within(&notch.part, &frame.back(&crossing), slack)
        });
        let reach = TIP * specimen.settings.spacing;
        let near: Vec<u32> = (0..domain.particles.len())
            .filter(|&p| {
                let x = domain.particles.reference[p];
                let (at, above) = (frame.back(&x), height(&x));
                above.abs() < reach && within(&notch.part, &(at - notch.normal * above), slack)
            })
            .map(|p| domain.particles.id[p])
            .collect();
        near.into_iter().for_each(|id| domain.open(id, 0.0));
    }
}

fn launch(specimen: &Specimen, frame: &Frame, domain: &mut Domain) {
    if specimen.starts.is_empty() {
        return;
    }
    let seed = specimen.settings.seed;
    domain.launch(|x| {
        let at = frame.back(x);
        let parts = specimen.starts.iter().filter(|start| within(&start.part, &at, 0.0));
        frame.turned(&parts.map(|start| velocity(start, &at, seed)).sum())
    });
}

fn velocity(start: &Start, at: &Vec3, seed: u64) -> Vec3 {
    let bits = at.iter().fold(0_u64, |bits, c| bits.rotate_left(21) ^ c.to_bits());
    let noise = Vec3::from([0, 1, 2].map(|axis| 2.0 * unit(seed, axis, bits) - 1.0));
    start.velocity + start.gradient * (at - start.centre) + noise * start.noise
}
