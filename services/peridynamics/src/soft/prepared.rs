//! What is worked out once for a soft solid: its points, bonds, cuts and surface, and how long a
//! step is.

use super::grips::LedPoints;
use super::pace::SolidPace;
use super::sampling::{LAYER, relaxed};
use super::surface::{SurfaceInput, SurfaceTemplate};
use crate::PeridynamicDomain;
use crate::bonds::BondError;
use crate::law::{PartedContact, PeridynamicLaw};
use crate::solver::setup::law;
use cullet_continuum::bytes::held;
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::math::scramble;
use cullet_geometry::sample::{self, SampleError};
use cullet_geometry::shapes::refine_solid;
use cullet_geometry::{TriMesh, Vec3};
use cullet_model::{
    BondedSolid, ContinuumBody, ContinuumSetup, Material, Refusal, SoftBody, SoftLaw,
};
use std::collections::BTreeSet;

/// Fewest and most points of a body.
const POINTS: [f64; 2] = [60.0, 5e5];
/// Greatest Poisson's ratio.
const POISSON: f64 = 0.45;
/// Greatest stretch at which bonds break, and yield strain, that the law holds for \[1\].
const MOST_CRITICAL: f64 = 1.0;
const MOST_ELASTIC: f64 = 0.1;
/// Least thickness of a body, in spacings.
const ACROSS: f64 = 2.0;
/// Longest edge of the drawn surface, in spacings.
const FINE: f64 = 1.5;
/// A bond whose middle is out of the body by more than this, in spacings, crosses a gap.
const GAP: f64 = 0.3;
/// Most steps in one step of the world.
const MOST_STEPS: f64 = 1e5;

/// A soft solid made discrete.
#[derive(Debug)]
pub struct PreparedSoftSolid {
    /// What it was made from.
    pub setup: ContinuumSetup,
    /// Its points and bonds before anything happens, in its own frame; cuts have severed theirs.
    pub domain: PeridynamicDomain,
    /// Where its points are then \[m\].
    pub rest: Vec<Vec3>,
    /// Outer area that each point bears, outward \[m²\].
    pub areas: Vec<Vec3>,
    /// Longest stable step \[s\].
    pub stable: f64,
    /// Steps in one step of the world.
    pub substeps: u32,
    /// Mean of Σwl₀ \[m\].
    pub(super) reach: f64,
    pub(super) pace: SolidPace,
    pub(super) contact: PartedContact,
    /// Whether a point lies at the surface.
    pub(super) outer: Vec<bool>,
    pub(super) grips: Vec<LedPoints>,
    pub(super) surface: SurfaceTemplate,
    /// Names this body in a state's bytes.
    pub(super) fingerprint: u64,
}

impl PreparedSoftSolid {
    /// # Errors
    ///
    /// The bound that the body breaks.
    pub fn new(setup: &ContinuumSetup) -> Result<Self, Refusal> {
        let (body, bonds) = taken(setup)?;
        check(body, bonds, setup)?;
        let pace = SolidPace::new(&body.material, bonds, body.pace)?;
        let (mesh, spacing) = (&body.solid.mesh, body.spacing);
        let points = sample_points(mesh, spacing, setup.seed)?;
        let volumes = vec![mesh.signed_volume() / points.len() as f64; points.len()];
        let law = working_law(&pace, body);
        let horizon = bonds.horizon * spacing;
        let unfit = |error: BondError| unfit(error.to_string());
        let mut domain = PeridynamicDomain::new(points, volumes, horizon, law).map_err(unfit)?;
        if domain.critical.is_finite() {
            let what = "the stretch at which bonds of a soft solid break (take a finer spacing)";
            within(what, domain.critical, 1e-6, MOST_CRITICAL)?;
        }
        domain.make_room(true, law.hardening.is_some());
        let rest = domain.places.clone();
        let gaps = sever_gaps(&mut domain, mesh, spacing);
        let grips = LedPoints::of_all(&body.grips, &rest, &body.pose, horizon)?;
        let fine = refine_solid(&body.solid, FINE * spacing);
        let fine = fine.map_err(|error| Refusal::Unfit {
            solver: super::NAME,
            lack: format!("its surface cannot be drawn: {error}"),
        })?;
        let surface = SurfaceTemplate::new(SurfaceInput {
            coarse: mesh,
            fine: fine.mesh,
            domain: &domain,
            rest: &rest,
            cuts: &body.cuts,
            gaps,
            spacing,
        });
        domain.sever(|x, y| body.cuts.iter().any(|cut| cut.parts(x, y)));
        let areas = surface.areas();
        let layer = |p: usize| surface.depth(p) < (LAYER + 0.25) * spacing;
        let outer = (0..rest.len()).map(layer).collect();
        let stable = domain.greatest_step();
        let steps = (setup.world_step / domain.stable_step()).ceil();
        if steps.is_nan() || steps > MOST_STEPS {
            let what = "the steps of a soft solid in one of the world (choose a slower pace)";
            return Err(Refusal::TooLarge { what, value: steps, limit: MOST_STEPS });
        }
        let mut prepared = Self {
            setup: setup.clone(),
            reach: domain.reach(),
            stable,
            substeps: steps.max(1.0) as u32,
            contact: PartedContact { friction: bonds.friction },
            pace,
            outer,
            grips,
            surface,
            fingerprint: 0,
            areas,
            rest,
            domain,
        };
        prepared.fingerprint = prepared.name();
        Ok(prepared)
    }

    /// Memory that it takes, about \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let lists = held(&self.rest) + held(&self.areas) + held(&self.outer);
        let grips = self.grips.iter().map(LedPoints::bytes).sum::<u64>();
        self.domain.bytes() + lists + grips + self.surface.bytes()
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &SoftBody {
        let ContinuumBody::Soft(body) = &self.setup.body else {
            unreachable!("it was looked at before points were made")
        };
        body
    }

    /// Length of a step \[s\].
    #[must_use]
    pub fn step(&self) -> f64 {
        self.setup.world_step / f64::from(self.substeps)
    }

    /// Mass that weighs, and inertia, of a point \[kg\].
    #[must_use]
    pub fn masses(&self, point: usize) -> [f64; 2] {
        let inertia = self.domain.mass(point);
        [inertia / self.pace.inertia, inertia]
    }

    /// Distance below which a point touches a rigid body \[m\]: the outermost lie so deep under
    /// the surface.
    #[must_use]
    pub fn contact_distance(&self) -> f64 {
        LAYER * self.body().spacing
    }

    /// A number that other bodies do not have.
    fn name(&self) -> u64 {
        let (body, law) = (self.body(), &self.domain.law);
        let pose = body.pose.translation.vector;
        let turn = body.pose.rotation.coords;
        let severed = self.domain.left.iter().flat_map(|group| group.0).map(f64::from);
        let numbers = [law.density, law.bulk, law.shear, self.domain.critical, self.stable];
        let setup = [self.setup.world_step, f64::from(self.substeps), law.damping.bonds];
        let all = self.rest.iter().flatten().chain(&pose).chain(&turn).copied();
        let all = all.chain(numbers).chain(setup).chain(severed);
        all.fold(1, |name, value| scramble(name ^ value.to_bits()))
    }
}

fn unfit(lack: String) -> Refusal {
    Refusal::Unfit { solver: super::NAME, lack }
}

fn within(what: &'static str, value: f64, low: f64, high: f64) -> Result<(), Refusal> {
    match (low..=high).contains(&value) {
        true => Ok(()),
        false => Err(Refusal::OutOfRange { what, value, low, high }),
    }
}

/// The body and its bonds, if it is one of this family.
fn taken(setup: &ContinuumSetup) -> Result<(&SoftBody, &BondedSolid), Refusal> {
    if let ContinuumBody::Soft(body) = &setup.body
        && let SoftLaw::Bonded(bonds) = &body.law
    {
        return Ok((body, bonds));
    }
    Err(Refusal::Unknown { solver: super::NAME, what: "this", kind: "body" })
}

/// Points that fill the body.
fn sample_points(mesh: &TriMesh, spacing: f64, seed: u64) -> Result<Vec<Vec3>, Refusal> {
    let too_many = |value| Refusal::TooLarge {
        what: "the number of points in the body's box",
        value,
        limit: sample::MAX_CANDIDATES,
    };
    let points = relaxed(mesh, spacing, seed).map_err(|error| match error {
        SampleError::TooMany { candidates, .. } => too_many(candidates),
        SampleError::Spacing { spacing } => too_many(spacing),
    })?;
    let thickness = Nearest::new(mesh).thickness(&points);
    if thickness < ACROSS * spacing {
        let cells = thickness / spacing;
        return Err(Refusal::TooThin { thickness, cells, minimum: ACROSS });
    }
    Ok(points)
}

/// The law of its bonds: contact and air are worked out here, not in the domain.
fn working_law(pace: &SolidPace, body: &SoftBody) -> PeridynamicLaw {
    let density = pace.material.density * pace.inertia;
    let bonds = BondedSolid { bond_damping: body.damping, air_damping: 0.0, ..pace.bonds };
    PeridynamicLaw { contact: None, ..law(&Material { density, ..pace.material }, &bonds) }
}

/// Severs bonds whose middles lie out of the body: those between two limbs. Short ones of them.
fn sever_gaps(domain: &mut PeridynamicDomain, mesh: &TriMesh, spacing: f64) -> BTreeSet<[u32; 2]> {
    let (inside, nearest) = (Inside::new(mesh), Nearest::new(mesh));
    let mut gaps = BTreeSet::new();
    let depths: Vec<f64> = domain.places.iter().map(|x| nearest.distance(*x)).collect();
    for p in 0..domain.places.len() {
        let bonds: Vec<_> = domain.bonds.of(p).filter(|bond| bond.end > p).collect();
        for bond in bonds {
            let length = domain.rest(p, bond);
            if 0.5 * length < depths[p].max(depths[bond.end]) {
                continue;
            }
            let middle = 0.5 * (domain.places[p] + domain.places[bond.end]);
            if inside.contains(middle) || nearest.distance(middle) < GAP * spacing {
                continue;
            }
            let Some(twin) = domain.bonds.find(bond.end, p) else { continue };
            domain.left[bond.group].0[bond.lane] = 0.0;
            domain.left[twin.group].0[twin.lane] = 0.0;
            if length <= 2.0 * spacing {
                gaps.insert([p as u32, bond.end as u32]);
            }
        }
    }
    gaps
}

/// That numbers are within their bounds.
fn check(body: &SoftBody, bonds: &BondedSolid, setup: &ContinuumSetup) -> Result<(), Refusal> {
    let mut bounds = body.bounds();
    bounds.push(("Poisson's ratio of a soft solid [1]", body.material.poisson, 0.0, POISSON));
    bounds.push(("step of the world [s]", setup.world_step, 1e-9, 1.0));
    bounds.push(("density of the air [kg/m³]", body.air.density, 0.0, 1e4));
    bounds.push(("drag of a soft solid [1]", body.air.drag, 0.0, 1e3));
    bounds.push(("greatest gust over the wind [1]", body.air.gusts[0], 0.0, 1e3));
    bounds.push(("gusts in a second [1/s]", body.air.gusts[1], 0.0, 1e6));
    for (what, value, low, high) in bounds {
        within(what, value, low, high)?;
    }
    if let Some(hardening) = bonds.hardening {
        let ratio = hardening.yield_stress / body.material.young;
        within("yield stress over Young's modulus", ratio, 1e-6, MOST_ELASTIC)?;
    }
    let pose = body.pose.translation.vector;
    let vectors = [setup.gravity, body.velocity, body.spin, body.air.wind, pose];
    let corners = body.cuts.iter().flat_map(|cut| &cut.corners).flatten();
    if !vectors.iter().flatten().chain(corners).chain([&body.air.pressure]).all(|c| c.is_finite()) {
        let lack = "its place, its motion, its cuts and the air need finite numbers".to_owned();
        return Err(unfit(lack));
    }
    if let Some(number) = body.cuts.iter().position(|cut| cut.corners.len() < 3) {
        return Err(unfit(format!("cut {} needs three corners or more", number + 1)));
    }
    let volume = body.solid.mesh.signed_volume();
    within("the volume of a soft solid [m³]", volume, 1e-18, 1e12)?;
    let spacing = body.spacing;
    let points = volume / (spacing * spacing * spacing);
    within("the number of points of a soft solid", points, POINTS[0], POINTS[1])
}
