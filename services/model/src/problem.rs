//! What a solver is given: the body, its law, its hits and supports, and how it may be solved.

use crate::{
    BodyShape, BondedSolid, CrackFaceDetail, JohnsonCook, Law, Material, PointPrecision, Refusal,
    StrengthField, SurfaceLaw, Tolerance, Treatment,
};
use cullet_geometry::{Solid, Vec3};
use std::sync::Arc;

/// One hit, in the body's own frame (origin at the centre of mass).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Impact {
    /// Where the striker touched \[m\].
    pub point: Vec3,
    /// Unit direction of the push, *into* the body.
    pub normal: Vec3,
    /// Impulse along `normal` over the contact episode \[N·s\].
    pub impulse: f64,
    /// Hertz contact duration t_c \[s\].
    pub duration: f64,
    /// Greatest Hertz contact radius a \[m\].
    pub radius: f64,
    /// Kinetic energy of the approach, ½ m* v² \[J\]: no crack can cost more.
    pub energy: f64,
    /// How fast the surfaces closed before they touched \[m/s\].
    pub closing_speed: f64,
    /// Pressure in the middle of the contact at which it crushes, body or striker \[Pa\].
    pub crushing_pressure: f64,
}

/// Where a body rests on another: a disc that holds the surface under it against moving into it,
/// and lets it leave. In the body's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Support {
    /// Middle of the disc, on the surface \[m\].
    pub point: Vec3,
    /// Unit direction in which it can push, *into* the body.
    pub normal: Vec3,
    /// Radius of the disc \[m\].
    pub radius: f64,
    /// Velocity against `normal` that it takes up over the impulse it has given \[1/kg\]; 0 if it
    /// does not move.
    pub mobility: f64,
}

/// What the scene decides about a solve: a budget and an accuracy that hold for every family, and a
/// table for each family that needs more. `None` means "let the solver choose".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Grid spacing h \[m\].
    pub spacing: Option<f64>,
    /// Particle budget; the solver coarsens `spacing` to stay under it when it chose it itself.
    pub max_particles: u32,
    /// Budget of time steps.
    pub max_steps: u32,
    /// Fragments below this share of the body's volume are merged into a neighbour \[1\].
    pub min_volume_ratio: f64,
    /// At most this many fragments; the smallest are merged first.
    pub max_fragments: u32,
    /// Parts below this share of the body's volume become debris \[1\]; 0 makes none.
    pub debris: f64,
    /// Size of a grain of it, half the mass being in larger ones \[m\]; `None`: half the spacing.
    pub grain: Option<f64>,
    /// What points are worked out in.
    pub precision: PointPrecision,
    /// Relative error of the fragments that is good enough, in (0, 1] \[1\]: what that lets a solve
    /// leave out is [`crate::Tolerance`]. `None`: as true as can be.
    pub error: Option<f64>,
    /// What only the brittle family needs.
    pub brittle: BrittleSettings,
}

/// What the scene decides about a brittle solve beside [`Settings`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BrittleSettings {
    /// How crack faces look closer than the grid resolves.
    pub detail: CrackFaceDetail,
    /// Width of the slits that are cut along cracks which end inside a fragment \[m\], at most
    /// `cullet_fragment::cut::slit::WIDEST` of the spacing; `None` cuts none.
    pub hairline: Option<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            spacing: None,
            max_particles: 16_000,
            max_steps: 20_000,
            min_volume_ratio: 1e-4,
            max_fragments: 400,
            debris: 5e-4,
            grain: None,
            precision: PointPrecision::Double,
            error: None,
            brittle: BrittleSettings::default(),
        }
    }
}

impl Settings {
    /// How true the fragments have to be.
    #[must_use]
    pub fn tolerance(&self) -> Tolerance {
        Tolerance(self.error)
    }
}

/// A body, its hits, and how it may be solved. Everything a solver may know.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// The body in its own frame, origin at the centre of mass \[m\].
    pub body: BodyShape,
    /// How its material behaves.
    pub law: Law,
    /// Its hits; a family that needs one refuses a problem without.
    pub impacts: Vec<Impact>,
    /// What it rests on.
    pub supports: Vec<Support>,
    /// Angular velocity before the hits \[rad/s\]: zero where its stress does not matter.
    pub spin: Vec3,
    /// How it may be solved.
    pub settings: Settings,
    /// The only source of randomness.
    pub seed: u64,
}

/// A solid of a brittle material, and its hits: the problem in the terms of the families that take
/// these.
#[derive(Clone, Debug, PartialEq)]
pub struct BrittleProblem {
    /// The body in its own frame, origin at the centre of mass \[m\].
    pub solid: Arc<Solid>,
    /// Its material.
    pub material: Material,
    /// How its strength varies.
    pub strength: StrengthField,
    /// How its surface bears others, and its cracks their sides.
    pub surface: SurfaceLaw,
    /// Its hits.
    pub impacts: Vec<Impact>,
    /// What it rests on.
    pub supports: Vec<Support>,
    /// Angular velocity before the hits \[rad/s\]: zero where its stress does not matter.
    pub spin: Vec3,
    /// How it may be solved.
    pub settings: Settings,
    /// The only source of randomness.
    pub seed: u64,
}

impl BrittleProblem {
    /// The problem, for the family of that name. Bonds that break and do not yield are a brittle
    /// solid to families that know no bonds.
    ///
    /// # Errors
    /// [`Refusal::Unknown`] where the body is no solid or its law is not the brittle one.
    pub fn of(problem: Problem, solver: &'static str) -> Result<Self, Refusal> {
        let kind = problem.law.kind();
        match Self::treated(problem, solver)? {
            (problem, None) => Ok(problem),
            (_, Some(_)) => Err(Refusal::Unknown { solver, what: "a law", kind }),
        }
    }

    /// The problem of a metal that yields, for the family of that name, as one that does not crack,
    /// and how it flows. Of bonds that yield, it is what does not break.
    ///
    /// # Errors
    /// [`Refusal::Unknown`] where the body is no solid or its law is another;
    /// [`Refusal::OutOfRange`] where a number of its flow does not hold.
    pub fn yielding(
        problem: Problem,
        solver: &'static str,
    ) -> Result<(Self, JohnsonCook), Refusal> {
        let (material, flow) = match &problem.law {
            Law::Yielding { material, hardening }
            | Law::Bonded { material, bonds: BondedSolid { hardening: Some(hardening), .. } } => {
                (*material, JohnsonCook::from(*hardening))
            }
            Law::JohnsonCook { material, flow } => (*material, *flow),
            law => return Err(Refusal::Unknown { solver, what: "a law", kind: law.kind() }),
        };
        hold(&flow.bounds())?;
        let law = Law::even(material);
        Ok((Self::of(Problem { law, ..problem }, solver)?, flow))
    }

    /// The problem of a solid of points and bonds, for the family of that name, as one that breaks
    /// alike everywhere, and its bonds.
    ///
    /// # Errors
    /// [`Refusal::Unknown`] where the body is no solid or its law is another;
    /// [`Refusal::OutOfRange`] where a number of its bonds does not hold.
    pub fn bonded(problem: Problem, solver: &'static str) -> Result<(Self, BondedSolid), Refusal> {
        let Law::Bonded { material, bonds } = problem.law else {
            return Err(Refusal::Unknown { solver, what: "a law", kind: problem.law.kind() });
        };
        hold(&bonds.bounds())?;
        let law = Law::even(material);
        Ok((Self::of(Problem { law, ..problem }, solver)?, bonds))
    }

    /// The problem, for the family of that name, with what was done to its glass.
    ///
    /// # Errors
    /// [`Refusal::Unknown`] where the body is no solid or its law is not known.
    pub fn treated(
        problem: Problem,
        solver: &'static str,
    ) -> Result<(Self, Option<Treatment>), Refusal> {
        let Problem { body, law, impacts, supports, spin, settings, seed } = problem;
        let unknown = |what, kind| Refusal::Unknown { solver, what, kind };
        let kind = body.kind();
        let solid = Arc::clone(body.solid().ok_or(unknown("a body", kind))?);
        let of = SurfaceLaw::of;
        let (material, strength, surface, treatment) = match law {
            Law::Brittle { material, strength, surface } => (material, strength, surface, None),
            Law::Treated { material, strength, treatment } => {
                (material, strength, of(&material), Some(treatment))
            }
            Law::Bonded { material, bonds } if bonds.hardening.is_none() => {
                (material, StrengthField::even(), of(&material), None)
            }
            Law::Yielding { .. } | Law::JohnsonCook { .. } | Law::Bonded { .. } => {
                return Err(unknown("a law", law.kind()));
            }
        };
        let problem =
            Self { solid, material, strength, surface, impacts, supports, spin, settings, seed };
        Ok((problem, treatment))
    }
}

/// That numbers lie within their bounds.
fn hold(bounds: &[(&'static str, f64, f64, f64)]) -> Result<(), Refusal> {
    for &(what, value, low, high) in bounds {
        if !(low..=high).contains(&value) {
            return Err(Refusal::OutOfRange { what, value, low, high });
        }
    }
    Ok(())
}

impl From<BrittleProblem> for Problem {
    fn from(problem: BrittleProblem) -> Self {
        let BrittleProblem { solid, material, strength, surface, .. } = problem;
        let BrittleProblem { impacts, supports, spin, settings, seed, .. } = problem;
        let (body, law) = (BodyShape::Solid(solid), Law::Brittle { material, strength, surface });
        Self { body, law, impacts, supports, spin, settings, seed }
    }
}
