//! From a specimen to a shell: the plate that it is, its midsurface, its notches.

use crate::domain::{ShellDomain, ShellMaterial};
use crate::midsurface::Midsurface;
use crate::section::SectionLaw;
use crate::solve::{SLENDER, SOFTENING_CELLS, refusal};
use cullet_geometry::inside::Inside;
use cullet_geometry::plate::Plate;
use cullet_geometry::{Pose, Quat, Vec3};
use cullet_model::{Material, Refusal, Strength};
use cullet_simd::{Real, SimdLevel};
use cullet_specimen::{GridFrame, Notch, Probe, SpecimenProblem, Spot, Where, idle, within};

/// Control points of a cell.
pub(super) const FUNCTIONS: usize = 9;

/// The shell of a specimen.
pub(super) type PlateDomain<R> = ShellDomain<R, FUNCTIONS>;

/// How far a plate may be turned against the specimen's axes: 1 − |cos|.
const STRAIGHT: f64 = 1e-9;

/// How far a notch may lean through the thickness: |n · normal of the plate|.
const UPRIGHT: f64 = 1e-6;

/// Links within 60° of a notch's normal are cut, as by cracks.
const ACROSS: f64 = 0.5;

/// Spacings from the nearest point at which a probe still reads the body.
const FAR: f64 = 2.0;

/// The plate that a specimen is, along its own axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct AlignedPlate {
    pub(super) plate: Plate,
    /// From the specimen's frame to the plate's.
    pub(super) frame: GridFrame,
    /// The axis of the specimen that each axis of the plate lies along.
    pub(super) axes: [usize; 3],
}

fn range(what: &'static str, value: f64, [low, high]: [f64; 2]) -> Result<(), Refusal> {
    let holds = (low..=high).contains(&value);
    if holds { Ok(()) } else { Err(Refusal::OutOfRange { what, value, low, high }) }
}

fn at_most(what: &'static str, value: f64, limit: f64) -> Result<(), Refusal> {
    if value <= limit { Ok(()) } else { Err(Refusal::TooLarge { what, value, limit }) }
}

impl AlignedPlate {
    /// Finds it.
    ///
    /// # Errors
    /// What the body lacks that is no thin plate along the axes of the specimen.
    pub(super) fn new(specimen: &SpecimenProblem) -> Result<Self, Refusal> {
        let mesh = &specimen.body.mesh;
        let found = Plate::of_mesh(mesh).map_err(|why| refusal(&why))?;
        let normal = found.pose.rotation * Vec3::z();
        let across = normal.iamax();
        let turn = (1.0 - normal[across].abs()).max(0.0);
        range("1 − |cos| between the plate's normal and an axis", turn, [0.0, STRAIGHT])?;
        let (low, high) = mesh.bounds().unwrap_or_default();
        let axes = [(across + 1) % 3, (across + 2) % 3, across];
        let rotation = Quat::from_basis_unchecked(&axes.map(|axis| Vec3::ith(axis, 1.0)));
        let middle = (low + high) / 2.0;
        let size = [0, 1].map(|k| high[axes[k]] - low[axes[k]]);
        let ratio = found.thickness / size[0].min(size[1]);
        range("thickness over the smaller extent of the plate", ratio, [0.0, SLENDER])?;
        let pose = Pose::from_parts(middle.into(), rotation);
        let plate = Plate { pose, size, ..found };
        let back = rotation.inverse();
        let frame = GridFrame::from_parts(back, -(back * middle));
        Ok(Self { plate, frame, axes })
    }

    /// Whether a place at a height over the midsurface \[t\] is in a part.
    pub(super) fn within(&self, part: &Where, x: &Vec3, height: f64, slack: f64) -> bool {
        let up = Vec3::z() * (height * self.plate.thickness);
        within(part, &self.frame.back(&(x + up)), slack)
    }
}

/// Refuses what cannot be solved, with the bound.
pub(super) fn check(specimen: &SpecimenProblem, shape: &AlignedPlate) -> Result<(), Refusal> {
    let (s, m) = (&specimen.settings, &specimen.matter.material);
    range("density [kg/m^3]", m.density, [1e-3, 1e6])?;
    range("Young's modulus [Pa]", m.young, [1.0, 1e14])?;
    range("Poisson's ratio", m.poisson, [-0.5, 0.49])?;
    if s.breaks {
        range("fracture energy [J/m^2]", m.fracture_energy, [1e-9, 1e12])?;
        range("failure stress over Young's modulus", m.failure_stress / m.young, [1e-9, 1.0])?;
    }
    if let Some(plane) = specimen.matter.strength.weak_plane {
        range("strength across a weak plane, of a shell", plane.ratio, [1.0, 1.0])?;
    }
    for patch in &specimen.matter.patches {
        range("damage of a patch, of a shell", patch.damage, [0.0, 0.0])?;
    }
    for notch in &specimen.initial.notches {
        let lean = shape.frame.turned(&notch.normal).z.abs();
        range("lean of a notch through the thickness, of a shell", lean, [0.0, UPRIGHT])?;
    }
    let [a, b] = shape.plate.size;
    at_most("the number of points", 4.0 * a * b / (s.spacing * s.spacing), s.max_points)
}

/// The shell at rest, or moving as it starts, with its notches.
pub(super) fn domain<R: Real>(
    specimen: &SpecimenProblem,
    shape: &AlignedPlate,
) -> Result<PlateDomain<R>, Refusal> {
    let (s, plate) = (&specimen.settings, &shape.plate);
    let inside = Inside::new(&specimen.body.mesh);
    let surface = Midsurface::of_plate(plate, &inside, s.spacing, 0.0)
        .map_err(|_| Refusal::Unknown { solver: "shell", what: "a body", kind: "solid" })?;
    let material = material(specimen);
    let points = surface.points();
    let places: Vec<Vec3> = (0..points).map(|p| surface.surface_point(p).place).collect();
    let shell = ShellMaterial {
        law: SectionLaw::new(&material),
        density: material.density,
        thickness: vec![plate.thickness; points],
        strength: strengths(specimen, shape, &places),
        softening_cells: SOFTENING_CELLS,
    };
    let mut domain = ShellDomain::new(surface, shell, SimdLevel::best());
    let mass: f64 = domain.live().map(|p| domain.state(p).area * plate.thickness).sum();
    domain.scale_mass(specimen.body.mesh.signed_volume() / mass);
    taken(specimen, shape, &domain)?;
    let stretch = specimen.initial.stretch;
    for node in 0..domain.mass.len() {
        let x = shape.frame.back(&domain.surface.nodes[node]);
        let moved = shape.frame.turned(&(stretch * x));
        domain.displacement[node] = [moved.x, moved.y, moved.z, 0.0];
        domain.velocity[node] = launch(specimen, shape, &x);
    }
    let cut =
        specimen.initial.notches.iter().map(|notch| cut(&mut domain, shape, notch, s.spacing));
    idle("notch", cut.collect::<Vec<_>>().into_iter().map(|some| !some))?;
    Ok(domain)
}

/// The material; one that cannot break has no end of strength.
fn material(specimen: &SpecimenProblem) -> Material {
    let own = specimen.matter.material;
    if specimen.settings.breaks {
        return own;
    }
    Material { failure_stress: f64::INFINITY, fracture_energy: 1.0, ..own }
}

fn strengths(specimen: &SpecimenProblem, shape: &AlignedPlate, places: &[Vec3]) -> Vec<f64> {
    let base = material(specimen).failure_stress;
    let field = Strength::new(&specimen.matter.strength, specimen.settings.spacing);
    let of = |x: &Vec3| {
        let patches = specimen.matter.patches.iter();
        let here = patches.filter(|patch| shape.within(&patch.part, x, 0.0, 0.0));
        let factor: f64 = here.map(|patch| patch.strength).product();
        base * field.factor(&shape.frame.back(x)) * factor
    };
    places.iter().map(of).collect()
}

/// Refuses patches, starts and places of probes that take none of the points.
fn taken<R: Real>(
    specimen: &SpecimenProblem,
    shape: &AlignedPlate,
    domain: &PlateDomain<R>,
) -> Result<(), Refusal> {
    let places: Vec<Vec3> = domain.live().map(|p| domain.surface.surface_point(p).place).collect();
    let none = |part: &Where| !places.iter().any(|x| shape.within(part, x, 0.0, 0.0));
    idle("patch", specimen.matter.patches.iter().map(|patch| none(&patch.part)))?;
    let starts = specimen.initial.starts.iter();
    idle("start", starts.map(|start| !start.is_none() && none(&start.part)))?;
    let near = FAR * specimen.settings.spacing + 0.5 * shape.plate.thickness;
    let away = |probe: &Probe| match probe {
        Probe::Points(_, _, Spot::At(x)) => {
            let x = shape.frame.onto(x);
            !places.iter().any(|at| (at - x).norm() <= near)
        }
        _ => false,
    };
    idle("probe", specimen.output.probes.iter().map(away))
}

/// Velocity at the start of a place of the specimen, in the plate's frame.
fn launch(specimen: &SpecimenProblem, shape: &AlignedPlate, x: &Vec3) -> Vec3 {
    let starts = specimen.initial.starts.iter().filter(|start| within(&start.part, x, 0.0));
    shape.frame.turned(&starts.map(|start| start.at(x, specimen.settings.seed)).sum())
}

/// Breaks the row of points just under a notch, as a crack along it would have; whether there are
/// any.
fn cut<R: Real>(
    domain: &mut PlateDomain<R>,
    shape: &AlignedPlate,
    notch: &Notch,
    spacing: f64,
) -> bool {
    let point = shape.frame.onto(&notch.point);
    let normal = shape.frame.turned(&notch.normal);
    let slack = 1e-9 * spacing;
    let place = |p: usize| domain.surface.surface_point(p).place;
    let under = |p: &usize| {
        let x = place(*p);
        let below = (x - point).dot(&normal);
        let crosses = |&q: &u32| {
            let way = place(q as usize) - x;
            let rise = way.dot(&normal);
            let above = below + rise;
            let is_across = above >= 0.0 && rise >= ACROSS * way.norm();
            is_across && shape.within(&notch.part, &(x - way * (below / rise)), 0.0, slack)
        };
        below < 0.0 && domain.surface.around(*p).iter().any(crosses)
    };
    let row: Vec<usize> = domain.live().filter(under).collect();
    for &p in &row {
        let [e1, e2] = domain.surface.surface_point(p).frame();
        domain.notch(p, [e1.dot(&normal), e2.dot(&normal)]);
    }
    !row.is_empty()
}

/// Stress at which cracks run over σ_f: ahead of a tip a point bears no more than makes a crack
/// cost G_f \[1\].
pub(super) fn strength_ratio<R: Real>(domain: &PlateDomain<R>, specimen: &SpecimenProblem) -> f64 {
    if !specimen.settings.breaks {
        return 1.0;
    }
    let extents = domain.live().map(|p| domain.surface.surface_point(p).extent);
    let tip = domain.tip_strength(extents.fold(0.0, f64::max));
    (tip / specimen.matter.material.failure_stress).min(1.0)
}
