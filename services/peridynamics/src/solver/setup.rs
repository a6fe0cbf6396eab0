//! What a problem must be like for this method, and the points that its budget allows.

use super::body::PressedDomain;
use super::state::{BondRecord, BondSetup, Peridynamics};
use crate::PeridynamicDomain;
use crate::anisotropy::{BondAnisotropy, isotropic};
use crate::bonds::neighbours::in_rows;
use crate::bonds::{BOND_BYTES, BondError};
use crate::law::{BondBreaking, PartedContact, PeridynamicDamping, PeridynamicLaw};
use cullet_fragment::kinetic_damping::KineticDamping;
use cullet_fragment::press::{RigidPress, share_out};
use cullet_fragment::surface_particles::{SurfaceParticle, SurfaceParticles};
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::sample::{self, SampleError};
use cullet_geometry::{Mat3, Vec3};
use cullet_model::brittle::POINTS_PER_CELL;
use cullet_model::preconditions::{check_impacts, check_supports, within};
use cullet_model::{BondedSolid, BrittleProblem, Cost, Impact, Material, Refusal, Solver};
use cullet_simd::SimdLevel;

/// Fewest points worth solving.
const LEAST_POINTS: f64 = 200.0;

/// Bytes of a point beside its bonds, and share of empty places in their lists, measured in
/// scattered points.
const POINT_BYTES: f64 = 600.0;
const EMPTY: f64 = 1.3;

/// Most bytes that a solve takes.
const MOST_BYTES: f64 = 4.0 * (1_u64 << 30) as f64;

/// Fewest points across a section.
const ACROSS: f64 = 4.0;

/// Yield stress over Young's modulus, and stretch at which bonds break, that small strains hold
/// for \[1\].
const MOST_ELASTIC: f64 = 0.1;

/// Σw l₀ over the horizon, of weights ∝ l₀ in a ball \[1\].
const MEAN_REACH: f64 = 0.8;

/// Transits that a typical push takes, and share of the step of evenly spaced points that scattered
/// ones bear, for the estimate of the cost.
const TYPICAL_TRANSITS: f64 = 20.0;
const SCATTERED: f64 = 0.5;

/// Radius of the discs of supports and over which a surface is fitted, in points' distances.
const LEAST_RADIUS: f64 = 4.0;

/// The size of a cell of eight points \[m\]: the spacing asked for, or what the budget allows.
fn cell(problem: &BrittleProblem) -> Result<f64, Refusal> {
    let volume = problem.solid.mesh.signed_volume();
    within("the body's volume [m^3]", volume, 1e-18, 1e12)?;
    let most = f64::from(problem.settings.max_particles.max(1));
    let spacing = problem.settings.spacing;
    let spacing = spacing.unwrap_or_else(|| libm::cbrt(POINTS_PER_CELL * volume / most));
    within("the spacing [m]", spacing, 1e-9, 1e6)?;
    Ok(spacing)
}

/// L/c_s \[s\].
fn transit(problem: &BrittleProblem) -> f64 {
    problem.solid.mesh.diagonal() / problem.material.shear_speed()
}

/// The law of the bonds.
pub(crate) fn law(material: &Material, bonds: &BondedSolid) -> PeridynamicLaw {
    let breaking = bonds
        .breaks
        .then_some(BondBreaking { fracture_energy: material.fracture_energy, dust: bonds.dust });
    let anisotropy = bonds.grain.map(|grain| {
        let axis = grain.axis;
        let g = Mat3::identity() + axis * axis.transpose() * (grain.stretch - 1.0);
        let quartic = match grain.stretch == 1.0 {
            true => isotropic(),
            false => BondAnisotropy::of_matrix(&g).quartic,
        };
        BondAnisotropy { quartic, axis, strength: grain.strength }
    });
    PeridynamicLaw {
        hardening: bonds.hardening,
        breaking,
        ductile: bonds.failure,
        max_plastic_stretch: bonds.max_plastic_stretch,
        anisotropy,
        contact: Some(PartedContact { friction: bonds.friction }),
        damping: PeridynamicDamping { bonds: bonds.bond_damping, air: bonds.air_damping },
        ..PeridynamicLaw::elastic(material.density, material.young, material.poisson)
    }
}

/// What a problem would cost, or the bound that it breaks.
pub(super) fn estimate_cost(
    problem: &BrittleProblem,
    bonds: &BondedSolid,
) -> Result<Cost, Refusal> {
    let material = &problem.material;
    within("density [kg/m^3]", material.density, 1e-3, 1e6)?;
    within("Young's modulus [Pa]", material.young, 1.0, 1e14)?;
    within("Poisson's ratio", material.poisson, 0.0, 0.45)?;
    if let Some(hardening) = bonds.hardening {
        let ratio = hardening.yield_stress / material.young;
        within("yield stress over Young's modulus", ratio, 1e-6, MOST_ELASTIC)?;
    }
    if problem.spin != Vec3::zeros() {
        let spin = problem.spin.norm();
        let lack =
            format!("it knows no stress of a spin before the hits, and here is {spin:.3e} rad/s");
        return Err(Refusal::Unfit { solver: Peridynamics::NAME, lack });
    }
    check_impacts(&problem.impacts)?;
    check_supports(&problem.supports)?;
    let cell = cell(problem)?;
    let (spacing, law) = (0.5 * cell, law(material, bonds));
    let horizon = bonds.horizon * spacing;
    if let Some(breaking) = law.breaking {
        within("fracture energy [J/m^2]", material.fracture_energy, 1e-9, 1e9)?;
        let critical = breaking.critical_stretch(law.bulk, law.shear, MEAN_REACH * horizon);
        within("stretch at which bonds break", critical, 1e-7, MOST_ELASTIC)?;
    }
    let volume = problem.solid.mesh.signed_volume();
    let particles = POINTS_PER_CELL * volume / (cell * cell * cell);
    within("the number of particles", particles, LEAST_POINTS, f64::INFINITY)?;
    let too_large = |what, value, limit| Err(Refusal::TooLarge { what, value, limit });
    let most = f64::from(problem.settings.max_particles);
    if particles > 1.05 * most {
        return too_large("the number of particles", particles, most);
    }
    let neighbours = 4.0 / 3.0 * std::f64::consts::PI * bonds.horizon.powi(3);
    let bytes = particles * (POINT_BYTES + EMPTY * neighbours * BOND_BYTES as f64);
    if bytes > MOST_BYTES {
        return too_large("the memory of bonds [B]", bytes, MOST_BYTES);
    }
    let fastest = 2.0 * law.stiffness() * 4.0 / (horizon * horizon * material.density);
    let step = SCATTERED * 2.0 / fastest.sqrt();
    let steps = TYPICAL_TRANSITS * transit(problem) / step;
    let limit = f64::from(problem.settings.max_steps);
    if steps > limit {
        return too_large("the number of steps", steps, limit);
    }
    Ok(Cost { particles, steps, bytes })
}

/// Points that fill the body, those that are near each other near in the list.
fn sample_points(problem: &BrittleProblem, spacing: f64) -> Result<Vec<Vec3>, Refusal> {
    let inside = Inside::new(&problem.solid.mesh);
    let points = sample::poisson(&inside, spacing, problem.seed).map_err(|error| {
        let value = match error {
            SampleError::TooMany { candidates, .. } => candidates,
            SampleError::Spacing { spacing } => spacing,
        };
        let limit = sample::MAX_CANDIDATES;
        Refusal::TooLarge { what: "the number of points in the body's box", value, limit }
    })?;
    Ok(in_rows(&points, spacing))
}

/// All points: those at the surface, and those that come to lie at it where it breaks.
fn touchable(body: &PressedDomain, cell: f64, problem: &BrittleProblem) -> SurfaceParticles {
    let mesh = &problem.solid.mesh;
    let mut surface = SurfaceParticles::new(body.first.iter().copied(), cell, mesh);
    let mut under = vec![true; body.first.len()];
    surface.all.iter().for_each(|point| under[point.id as usize] = false);
    let area = 0.25 * cell * cell;
    let more = (0..).zip(&under).filter(|(_, under)| **under);
    surface.all.extend(more.map(|(id, _)| SurfaceParticle { id, area, offset: Vec3::zeros() }));
    surface
}

/// Velocity along `n` that a unit impulse along `n` at `point` gives the whole body there:
/// 1/m + n·[I⁻¹(r×n)]×r \[1/kg\].
fn mobility(problem: &BrittleProblem, Impact { point, normal: n, .. }: &Impact) -> f64 {
    let whole = problem.solid.mesh.mass_properties();
    let arm = (point - whole.centroid).cross(n);
    let turned = whole.inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * arm);
    (1.0 / whole.volume + turned.dot(&arm)) / problem.material.density
}

impl Peridynamics {
    /// Like `begin`, with other instructions of the processor.
    ///
    /// # Errors
    /// If the problem is not for this solver.
    pub fn with(
        problem: BrittleProblem,
        bonds: BondedSolid,
        simd_level: SimdLevel,
    ) -> Result<Self, Refusal> {
        estimate_cost(&problem, &bonds)?;
        let (mesh, cell) = (&problem.solid.mesh, cell(&problem)?);
        let spacing = 0.5 * cell;
        let points = sample_points(&problem, spacing)?;
        within("the number of particles", points.len() as f64, LEAST_POINTS, 1e9)?;
        let thickness = Nearest::new(mesh).thickness(&points);
        if thickness < ACROSS * spacing {
            let (cells, minimum) = (thickness / cell, 0.5 * ACROSS);
            return Err(Refusal::TooThin { thickness, cells, minimum });
        }
        let volumes = vec![mesh.signed_volume() / points.len() as f64; points.len()];
        let unfit =
            |error: BondError| Refusal::Unfit { solver: Self::NAME, lack: error.to_string() };
        let law = law(&problem.material, &bonds);
        let domain = PeridynamicDomain::new(points, volumes, bonds.horizon * spacing, law);
        let mut domain = domain.map_err(unfit)?;
        domain.level = simd_level;
        let step = domain.stable_step();
        let body = PressedDomain::new(domain, step);
        let surface = touchable(&body, cell, &problem);
        let least = LEAST_RADIUS * spacing;
        let striker = |hit| RigidPress::striker(hit, mobility(&problem, hit), mesh, least);
        let mut strikers: Vec<RigidPress> = problem.impacts.iter().map(striker).collect();
        let mut supports: Vec<RigidPress> =
            problem.supports.iter().map(|it| RigidPress::support(it, least)).collect();
        let all = strikers.iter_mut().chain(&mut supports);
        all.for_each(|press| press.put(problem.material.young, &surface, &body, step));
        share_out(&mut supports, &surface, &body);
        Ok(Self {
            transit: transit(&problem),
            setup: BondSetup { spacing, halvings: 0, simd_level },
            problem,
            bonds,
            body,
            points: surface,
            strikers,
            supports,
            settling: KineticDamping::default(),
            record: BondRecord::default(),
        })
    }
}
