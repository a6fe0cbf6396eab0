//! From a specimen to a body on its grid.

use crate::Ductile;
use crate::damage::{BodyWeakPlane, Softening};
use crate::mpm::domain::{BodySurface, VelocityFields, stable_step};
use crate::mpm::{Domain, preconditions, quadrature};
use crate::particles::Particles;
use cullet_geometry::inside::Inside;
use cullet_geometry::{Pose, TriMesh, Vec3};
use cullet_model::{Material, Refusal, Solver, Strength};
use cullet_simd::SimdLevel;
use cullet_specimen::{
    GridFrame, PointLayout, Probe, SpecimenProblem, SpecimenSettings, Spot, Where, Zone, filling,
    idle, within,
};
use std::cell::Cell;

/// Stress that no specimen reaches \[Pa\], and the energy it would take \[J/m²\].
const UNBREAKABLE: (f64, f64) = (1e20, 1e40);

/// Most materials of a specimen: their numbers are a byte.
const MOST_MATERIALS: f64 = 256.0;

/// Spacings from the nearest point at which a probe still reads the body.
const FAR: f64 = 2.0;

/// Spacings from a notch within which cracks may grow from it.
const TIP: f64 = 0.75;

/// Refuses what cannot be solved, with the bound.
pub(super) fn check(specimen: &SpecimenProblem) -> Result<(), Refusal> {
    let s = &specimen.settings;
    if specimen.family == Ductile::NAME {
        let number = f64::from(u8::from(specimen.matter.flow.is_some()));
        preconditions::within("the number of materials that yield", number, 1.0, 1.0)?;
    }
    let several = specimen.matter.zones.len() as f64 + 1.0;
    preconditions::within("the number of materials", several, 1.0, MOST_MATERIALS)?;
    for m in specimen.matter.materials() {
        preconditions::within("density [kg/m^3]", m.density, 1e-3, 1e6)?;
        preconditions::within("Young's modulus [Pa]", m.young, 1.0, 1e14)?;
        preconditions::within(
            "Poisson's ratio",
            m.poisson,
            preconditions::POISSON_RANGE.0,
            preconditions::POISSON_RANGE.1,
        )?;
        if s.breaks {
            let ratio = m.failure_stress / m.young;
            preconditions::within("fracture energy [J/m^2]", m.fracture_energy, 1e-9, 1e12)?;
            preconditions::within("failure stress over Young's modulus", ratio, 1e-9, 1.0)?;
        }
    }
    preconditions::within("points a cell", s.points.per_cell, 0.5, 1000.0)?;
    let cell = s.spacing * s.spacing * s.spacing;
    let points = s.points.per_cell * specimen.body.mesh.signed_volume() / cell;
    at_most("the number of points", points, s.max_points)
}

fn at_most(what: &'static str, value: f64, limit: f64) -> Result<(), Refusal> {
    if value <= limit { Ok(()) } else { Err(Refusal::TooLarge { what, value, limit }) }
}

/// The greatest stable step \[s\].
pub(super) fn step(specimen: &SpecimenProblem) -> f64 {
    let spacing = specimen.settings.spacing;
    let steps = specimen.matter.materials().map(|m| stable_step(m, spacing));
    steps.fold(f64::INFINITY, f64::min)
}

/// Points of all bodies, with their volumes \[m³\] and bodies.
#[derive(Default)]
struct Filling {
    points: Vec<Vec3>,
    volumes: Vec<f64>,
    bodies: Vec<u8>,
}

impl Filling {
    fn add(&mut self, mesh: &TriMesh, body: u8, s: &SpecimenSettings) -> Result<(), Refusal> {
        let (inside, volume) = (Inside::new(mesh), mesh.signed_volume());
        let points = points(&inside, s)?;
        let count = points.len() as f64;
        preconditions::within("the number of points in the body", count, 8.0, s.max_points * 1.2)?;
        self.bodies.extend(points.iter().map(|_| body));
        self.volumes.extend(match s.points.layout {
            PointLayout::Scattered => {
                quadrature::volumes(&points, &inside, Vec3::repeat(s.spacing), volume)
            }
            PointLayout::Rows => vec![volume / count; points.len()],
        });
        self.points.extend(points);
        Ok(())
    }
}

/// The bodies one by one, on the grid.
fn bodies(specimen: &SpecimenProblem) -> Vec<TriMesh> {
    let pose = Pose::from_parts(specimen.body.shift.into(), specimen.body.turn);
    let mesh = specimen.body.mesh.transformed(&pose);
    if specimen.body.parts.is_empty() {
        return vec![mesh];
    }
    let end = mesh.triangles.len();
    let starts: Vec<usize> = specimen.body.parts.iter().map(|&first| first as usize).collect();
    let bounds: Vec<usize> = [0].into_iter().chain(starts).chain([end]).collect();
    let part = |w: &[usize]| mesh.submesh(&(w[0]..w[1]).collect::<Vec<_>>());
    bounds.windows(2).map(part).collect()
}

/// The number of the material at a place: 0 outside of all zones.
fn kind(zones: &[Zone], x: &Vec3) -> u8 {
    zones.iter().rposition(|zone| within(&zone.part, x, 0.0)).map_or(0, |k| k as u8 + 1)
}

/// Refuses zones, patches, starts and places of probes that take none of the points.
fn taken(specimen: &SpecimenProblem, places: &[Vec3]) -> Result<(), Refusal> {
    let none = |part: &Where| !places.iter().any(|x| within(part, x, 0.0));
    idle("zone", specimen.matter.zones.iter().map(|zone| none(&zone.part)))?;
    idle("patch", specimen.matter.patches.iter().map(|patch| none(&patch.part)))?;
    let starts = specimen.initial.starts.iter();
    idle("start", starts.map(|start| !start.is_none() && none(&start.part)))?;
    let near = FAR * specimen.settings.spacing;
    let beside = |x: &Vec3| !places.iter().any(|at| (at - x).norm() <= near);
    let away = |probe: &Probe| match probe {
        Probe::Points(_, _, Spot::At(x)) => beside(x),
        _ => false,
    };
    idle("probe", specimen.output.probes.iter().map(away))
}

/// The body on its grid, moving as it starts.
pub(super) fn domain(specimen: &SpecimenProblem) -> Result<Domain, Refusal> {
    let (s, frame) = (&specimen.settings, GridFrame::new(&specimen.body));
    let meshes = bodies(specimen);
    let mut filling = Filling::default();
    for (body, mesh) in meshes.iter().enumerate() {
        filling.add(mesh, body as u8, s)?;
    }
    let Filling { points, volumes, bodies } = filling;
    let several = meshes.len() > 1;
    let surfaces: Vec<BodySurface> =
        meshes.iter().filter(|_| several).map(BodySurface::new).collect();
    clear(&points, &bodies, &surfaces)?;
    let volume = volumes.iter().sum();
    let mut particles = Particles::at_rest(&points, volume, specimen.matter.material.density);
    particles.volume = volumes;
    particles.density = specimen.matter.materials().map(|m| m.density).collect();
    let places: Vec<Vec3> = points.iter().map(|x| frame.back(x)).collect();
    taken(specimen, &places)?;
    let strength = Strength::new(&specimen.matter.strength, s.spacing);
    for (p, x) in places.iter().enumerate() {
        particles.kind[p] = kind(&specimen.matter.zones, x);
        particles.strength[p] = strength.factor(x);
        for patch in specimen.matter.patches.iter().filter(|patch| within(&patch.part, x, 0.0)) {
            particles.strength[p] *= patch.strength;
            particles.damage[p] = particles.damage[p].max(patch.damage);
        }
    }
    let plane = specimen.matter.strength.weak_plane;
    let weak_plane = plane
        .map(|weak| BodyWeakPlane { normal: frame.turned(&weak.normal).into(), ratio: weak.ratio });
    let law = |m: &Material| {
        let mut law = softening(m, s);
        law.weak_plane = weak_plane;
        (*m, law)
    };
    let laws: Vec<_> = specimen.matter.materials().map(law).collect();
    let mut domain = Domain::mixed(particles, &laws, Vec3::repeat(s.spacing));
    if let Some(rule) = &specimen.matter.flow {
        domain.let_flow(&specimen.matter.material, rule);
    }
    domain.select(s.precision, SimdLevel::best());
    domain.rub(specimen.matter.surface.friction);
    domain.fields = if s.points.welded { VelocityFields::Single } else { VelocityFields::Split };
    domain.check_cracks_every(s.points.look.into());
    if several {
        domain.part_bodies(&bodies, &surfaces);
    }
    notch(specimen, &frame, &mut domain)?;
    let stretch = specimen.initial.stretch;
    if stretch.norm() > 0.0 {
        domain.displace(|x| frame.turned(&(stretch * frame.back(x))));
    }
    launch(specimen, &frame, &mut domain);
    Ok(domain)
}

fn points(inside: &Inside, s: &SpecimenSettings) -> Result<Vec<Vec3>, Refusal> {
    // A row begins half a distance from a node: two a cell lie at its quarter points.
    filling::points(inside, s.spacing / libm::cbrt(s.points.per_cell), Vec3::repeat(0.5), s)
}

/// Refuses bodies that overlap.
fn clear(points: &[Vec3], bodies: &[u8], surfaces: &[BodySurface]) -> Result<(), Refusal> {
    if surfaces.len() < 2 {
        return Ok(());
    }
    let shared = points.iter().zip(bodies).filter(|&(x, &own)| {
        let mut others = (0_u8..).zip(surfaces).filter(|(body, _)| *body != own);
        others.any(|(_, other)| other.contains(x))
    });
    let what = "points of a body that lie in another: bodies may touch, not overlap; their number";
    preconditions::within(what, shared.count() as f64, 0.0, 0.0)
}

/// The least stress at which cracks grow over σ_f of its material \[1\].
pub(super) fn strength_ratio(specimen: &SpecimenProblem) -> f64 {
    let ratio = |m: &Material| softening(m, &specimen.settings).strength_ratio;
    specimen.matter.materials().map(ratio).fold(1.0, f64::min)
}

fn softening(material: &Material, s: &SpecimenSettings) -> Softening {
    if !s.breaks {
        let (failure_stress, fracture_energy) = UNBREAKABLE;
        let strong = Material { failure_stress, fracture_energy, ..*material };
        return Softening::new(&strong, s.spacing);
    }
    match s.points.softening_length {
        Some(length) => Softening::new(material, length),
        None => Softening::on_grid(material, s.spacing),
    }
}

/// Cuts the bonds that cross a notch, and lets cracks grow from there.
fn notch(
    specimen: &SpecimenProblem,
    frame: &GridFrame,
    domain: &mut Domain,
) -> Result<(), Refusal> {
    let slack = 1e-9 * specimen.settings.spacing;
    let mut cut = Vec::new();
    for notch in &specimen.initial.notches {
        let height = |x: &Vec3| (frame.back(x) - notch.point).dot(&notch.normal);
        let some = Cell::new(false);
        domain.sever(|a, b| {
            let (above, below) = (height(a), height(b));
            if above < 0.0 || below >= 0.0 {
                return false;
            }
            let crossing = a + (b - a) * (above / (above - below));
            let cuts = within(&notch.part, &frame.back(&crossing), slack);
            some.set(some.get() || cuts);
            cuts
        });
        cut.push(some.get());
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
    idle("notch", cut.into_iter().map(|some| !some))
}

fn launch(specimen: &SpecimenProblem, frame: &GridFrame, domain: &mut Domain) {
    let starts = &specimen.initial.starts;
    if starts.is_empty() {
        return;
    }
    let seed = specimen.settings.seed;
    domain.launch(|x| {
        let at = frame.back(x);
        let parts = starts.iter().filter(|start| within(&start.part, &at, 0.0));
        frame.turned(&parts.map(|start| start.at(&at, seed)).sum())
    });
}
