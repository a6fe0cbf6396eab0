//! What is worked out once for a soft shell: its wall, its step, what it may touch and how it is
//! drawn.

use super::NAME;
use super::draw::DrawnLattice;
use super::held::GrippedNodes;
use super::pairs::Vicinity;
use super::wall::SoftWall;
use crate::domain::{STEP_SHARE, ShellDomain, ShellMaterial};
use crate::section::{NeoHookean, SectionLaw, SoftElasticity, SoftSection};
use crate::solve::SOFTENING_CELLS;
use cullet_continuum::WorkingPace;
use cullet_continuum::bytes::held;
use cullet_geometry::Vec3;
use cullet_geometry::math::scramble;
use cullet_model::{
    ContinuumBody, ContinuumSetup, Hardening, Material, Refusal, SoftBody, SoftLaw,
};
use cullet_simd::SimdLevel;
use std::sync::Arc;

/// Most steps of a shell in a step of the world: above it the body is too stiff, or cells too
/// small, to be moved at all.
const MOST_STEPS: f64 = 20_000.0;

/// Size of the cells that set the step of an uneven wall over that of most; parts of that step that
/// are tried; and how much mass the cells that need a smaller one may get, over that of the shell.
const SMALL: f64 = 0.78;
const STEPS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
const MOST_ADDED: f64 = 0.02;

/// Greatest distance from which a wall pushes rigid bodies off, over the spacing, where it is
/// thinner than that \[1\].
const CONTACT: f64 = 0.2;

/// A soft shell, made discrete.
#[derive(Debug)]
pub struct PreparedSoftShell(pub(super) PreparedFunctions);

/// By how many functions a cell has.
#[derive(Debug)]
pub(super) enum PreparedFunctions {
    Nine(Arc<PreparedWall<9>>),
    Sixteen(Arc<PreparedWall<16>>),
}

/// A soft shell whose cells have `N` functions.
#[derive(Debug)]
pub(super) struct PreparedWall<const N: usize> {
    pub(super) setup: ContinuumSetup,
    pub(super) body: SoftBody,
    /// As it is in the body's frame before anything moves; its cuts have been made.
    pub(super) domain: ShellDomain<f64, N>,
    pub(super) pace: WorkingPace,
    pub(super) breaks: bool,
    /// Mean thickness \[m\].
    pub(super) thickness: f64,
    pub(super) grips: Vec<GrippedNodes>,
    pub(super) vicinity: Vicinity,
    pub(super) lattice: DrawnLattice,
    /// Where control points begin in the world \[m\].
    pub(super) rest: Vec<Vec3>,
    /// σ_f of each point, as it is worked with \[Pa\].
    pub(super) strength: f64,
    /// Longest stable step \[s\].
    pub(super) stable: f64,
    /// Steps in a step of the world, as long as nothing is pressed together.
    pub(super) substeps: u32,
    /// Mass that small cells got, over that of the shell \[1\].
    pub(super) heavier: f64,
    /// Links that cuts severed.
    pub(super) cut: usize,
    /// Names this shell in a state's bytes.
    pub(super) fingerprint: u64,
}

impl PreparedSoftShell {
    /// # Errors
    /// The bound that the body breaks.
    pub(super) fn new(setup: &ContinuumSetup) -> Result<Self, Refusal> {
        let ContinuumBody::Soft(body) = &setup.body else {
            return Err(Refusal::Unknown { solver: NAME, what: "this", kind: "body" });
        };
        let SoftLaw::Shell { hardening, breaks } = body.law else {
            return Err(Refusal::Unknown { solver: NAME, what: "this", kind: "law" });
        };
        check(body, setup)?;
        let wall = SoftWall::new(body, setup.seed)?;
        let law = (hardening, breaks);
        Ok(Self(match wall.surface.functions {
            ..=9 => PreparedFunctions::Nine(PreparedWall::of_wall(setup, body, wall, law)?),
            _ => PreparedFunctions::Sixteen(PreparedWall::of_wall(setup, body, wall, law)?),
        }))
    }
}

impl PreparedSoftShell {
    /// Memory that it takes, about \[bytes\].
    pub(super) fn bytes(&self) -> u64 {
        match &self.0 {
            PreparedFunctions::Nine(wall) => wall.bytes(),
            PreparedFunctions::Sixteen(wall) => wall.bytes(),
        }
    }
}

impl<const N: usize> PreparedWall<N> {
    pub(super) fn of_wall(
        setup: &ContinuumSetup,
        body: &SoftBody,
        wall: SoftWall,
        (hardening, breaks): (Option<Hardening>, bool),
    ) -> Result<Arc<Self>, Refusal> {
        let pace = WorkingPace::new(body.material.young, body.material.density, body.pace)?;
        let strength = body.material.failure_stress / pace.stretches;
        let (thickness, spacing) = (wall.typical(), body.spacing);
        let grips = body.grips.iter().enumerate();
        let place = (&body.pose, spacing);
        let grips = grips
            .map(|(k, grip)| GrippedNodes::new(grip, k + 1, &wall, place))
            .collect::<Result<Vec<_>, _>>()?;
        let lattice = DrawnLattice::new(&wall.surface, &wall.axes);
        let vicinity = Vicinity::new(&wall.surface);
        let is_even = wall.is_even;
        let limit = if breaks { strength } else { f64::INFINITY };
        let mut domain = domain_of(body, wall, law(&body.material, &pace, hardening), limit);
        // The mesh's mass, whatever the cells make of it.
        let whole = body.solid.mesh.signed_volume() * body.material.density;
        let made: f64 = domain.mass.iter().sum();
        domain.scale_mass(whole / made * pace.inertia);
        let (stable, heavier) =
            stable_step(&mut domain, (thickness * pace.stretches, spacing), is_even)?;
        let cut = match body.cuts.is_empty() {
            true => 0,
            false => domain.cut(|a, b| body.cuts.iter().any(|cut| cut.parts(a, b))),
        };
        let rest = domain.surface.nodes.iter();
        let rest = rest.map(|x| crate::midsurface::placed(&body.pose, x)).collect();
        let mut prepared = Self {
            setup: setup.clone(),
            body: body.clone(),
            pace,
            breaks,
            thickness,
            grips,
            vicinity,
            lattice,
            rest,
            strength,
            stable,
            substeps: 0,
            heavier,
            cut,
            fingerprint: 0,
            domain,
        };
        prepared.substeps = prepared.steps_for(1.0)?;
        prepared.fingerprint = prepared.name();
        Ok(Arc::new(prepared))
    }

    /// Memory that it takes, about \[bytes\].
    fn bytes(&self) -> u64 {
        let grips = self.grips.iter().map(|grip| held(&grip.nodes) + held(&grip.guarded));
        let lists = self.vicinity.bytes() + self.lattice.bytes() + held(&self.rest);
        self.domain.bytes() + lists + grips.sum::<u64>()
    }

    /// Steps of a step of the world for points that are at most so many times as stiff as at rest.
    ///
    /// # Errors
    /// If there are too many.
    fn steps_for(&self, stiffer: f64) -> Result<u32, Refusal> {
        let damping = self.body.damping;
        let share = STEP_SHARE * ((1.0 + damping * damping).sqrt() - damping);
        let steps = (self.setup.world_step * stiffer.sqrt() / (share * self.stable)).ceil();
        if steps.is_nan() || steps > MOST_STEPS {
            let what = "the steps of a soft shell in one of the world";
            return Err(Refusal::TooLarge { what, value: steps, limit: MOST_STEPS });
        }
        Ok(steps.max(1.0) as u32)
    }

    /// The same, at most `most` times those at rest.
    pub(super) fn substeps_for(&self, stiffer: f64, most: u32) -> u32 {
        let limit = self.substeps.saturating_mul(most);
        self.steps_for(stiffer).map_or(limit, |steps| steps.clamp(self.substeps, limit))
    }

    /// Length of a step, as long as nothing is pressed together \[s\].
    pub(super) fn step(&self) -> f64 {
        self.setup.world_step / f64::from(self.substeps)
    }

    /// Distance below which the midsurface touches a rigid body \[m\].
    pub(super) fn contact(&self) -> f64 {
        (0.5 * self.thickness).max(CONTACT * self.body.spacing)
    }

    /// A number that other shells do not have.
    fn name(&self) -> u64 {
        let material = &self.body.material;
        let law = &self.domain.law;
        let numbers = [
            material.density,
            material.young,
            material.poisson,
            material.failure_stress,
            material.fracture_energy,
            law.hardening.map_or(0.0, |h| h.yield_stress + h.hardening + h.exponent),
            f64::from(u8::from(self.breaks)),
            self.stable,
            self.setup.world_step,
            self.cut as f64,
        ];
        let all = self.rest.iter().flatten().chain(&self.domain.mass).chain(&numbers);
        all.fold(1, |name, value| scramble(name ^ value.to_bits()))
    }
}

/// The law of its sections.
fn law(real: &Material, pace: &WorkingPace, hardening: Option<Hardening>) -> SectionLaw {
    let material = Material {
        density: real.density * pace.inertia,
        young: pace.young,
        failure_stress: real.failure_stress / pace.stretches,
        ..*real
    };
    // A softer wall yields where the real one does by energy, as it breaks.
    let flow = hardening.map(|real| Hardening {
        yield_stress: real.yield_stress / pace.stretches,
        hardening: real.hardening / pace.stretches,
        ..real
    });
    let law = SectionLaw { hardening: flow, ..SectionLaw::new(&material) };
    let elastic = match flow {
        Some(_) => SoftElasticity::Linear(law.elastic),
        None => SoftElasticity::NeoHookean(NeoHookean::new(material.young, material.poisson)),
    };
    law.soft(SoftSection { elastic, bend: pace.stretches, viscosity: 0.0 })
}

/// The shell of a wall, whose points have the strength `limit` \[Pa\].
fn domain_of<const N: usize>(
    body: &SoftBody,
    wall: SoftWall,
    law: SectionLaw,
    limit: f64,
) -> ShellDomain<f64, N> {
    let shell = ShellMaterial {
        law,
        density: body.material.density,
        thickness: wall.thickness,
        strength: vec![limit; wall.surface.points()],
        softening_cells: SOFTENING_CELLS,
    };
    ShellDomain::new(wall.surface, shell, SimdLevel::best())
}

/// Longest stable step \[s\], and the mass that small cells of an uneven wall get for it, over that
/// of the shell. The thickness is that by which it bends.
fn stable_step<const N: usize>(
    domain: &mut ShellDomain<f64, N>,
    (thickness, spacing): (f64, f64),
    is_even: bool,
) -> Result<(f64, f64), Refusal> {
    let speed = (domain.law.elastic.modulus / domain.law.material.density).sqrt();
    let bounds = domain.surface.steps;
    if is_even {
        let extent = |p: usize| domain.surface.surface_point(p).extent;
        let least = (0..domain.points()).map(extent).fold(f64::INFINITY, f64::min);
        return Ok((bounds.step(least, thickness, speed), 0.0));
    }
    let step = STEP_SHARE * bounds.step(SMALL * spacing, thickness, speed);
    for share in STEPS {
        if let Some(added) = domain.steady(share * step, MOST_ADDED) {
            return Ok((share * step / STEP_SHARE, added));
        }
    }
    let lack = format!("its cells are so uneven that over {MOST_ADDED} of its mass would be added");
    Err(Refusal::Unfit { solver: NAME, lack })
}

/// That numbers are within their bounds.
fn check(body: &SoftBody, setup: &ContinuumSetup) -> Result<(), Refusal> {
    let mut bounds = body.bounds();
    bounds.push(("step of the world [s]", setup.world_step, 1e-9, 1.0));
    bounds.push(("density of the air [kg/m³]", body.air.density, 0.0, 1e4));
    bounds.push(("drag of a soft body [1]", body.air.drag, 0.0, 1e3));
    bounds.push(("greatest gust over the wind [1]", body.air.gusts[0], 0.0, 1e3));
    bounds.push(("gusts in a second [1/s]", body.air.gusts[1], 0.0, 1e6));
    for (what, value, low, high) in bounds {
        if value.is_nan() || value < low || value > high {
            return Err(Refusal::OutOfRange { what, value, low, high });
        }
    }
    let place = body.pose.translation.vector;
    let vectors = [setup.gravity, body.velocity, body.spin, body.air.wind, place];
    let finite = vectors.iter().flatten().all(|c| c.is_finite()) && body.air.pressure.is_finite();
    let corners = body.cuts.iter().flat_map(|cut| &cut.corners).flatten();
    if !finite || !corners.copied().all(f64::is_finite) {
        let lack = "its motion, its cuts and the air need finite numbers".to_owned();
        return Err(Refusal::Unfit { solver: NAME, lack });
    }
    Ok(())
}
