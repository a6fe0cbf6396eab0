//! A fracture problem on its way to a worker.
//!
//! The layout of a solid with the brittle law is as old as the first version: the digest of a
//! problem is its name, in recordings too. Another kind of body or law gets a kind of message of
//! its own.

mod directed;

use crate::codec::{self, WireError};
use crate::envelope::{self, MessageKind};
use crate::ids::JobId;
use crate::mesh::{self, Slabs};
use crate::strength;
use cullet_model::{
    ArtDirection, BodyShape, BondedSolid, BrittleSettings, CrackFaceDetail, Hardening, Impact,
    JohnsonCook, Law, Material, PointPrecision, Problem, Settings, StrengthField, Support,
    SurfaceLaw, Treatment,
};
use serde::{Deserialize, Serialize};
use std::ops::Range;

pub use crate::bounds::{MAX_GUIDES, MAX_IMPACTS, MAX_PIECES, MAX_SOLVER, MAX_SUPPORTS, MAX_WHOLE};

/// A problem, who is to solve it, and who if that one refuses.
#[derive(Clone, Debug, PartialEq)]
pub struct FractureJob {
    /// Name of the family asked first.
    pub solver: String,
    /// Name of the family asked if the first refuses.
    pub fallback: Option<String>,
    /// What is to be solved.
    pub problem: Problem,
    /// How the scene wants the body to come apart, if it says so.
    pub direction: Option<ArtDirection>,
}

/// [`Settings`] in the order in which they travel.
#[derive(Serialize, Deserialize)]
struct SettingsRow {
    spacing: Option<f64>,
    max_particles: u32,
    max_steps: u32,
    min_volume_ratio: f64,
    max_fragments: u32,
    detail: CrackFaceDetail,
    debris: f64,
    grain: Option<f64>,
    hairline: Option<f64>,
    precision: PointPrecision,
    error: Option<f64>,
}

#[derive(Serialize, Deserialize)]
struct JobHeader {
    solver: String,
    fallback: Option<String>,
    material: Material,
    strength: StrengthField,
    surface: SurfaceLaw,
    painted: Option<(u32, f64)>,
    impacts: Vec<Impact>,
    supports: Vec<Support>,
    spin: [f64; 3],
    settings: SettingsRow,
    seed: u64,
    vertices: u32,
    triangles: u32,
}

/// The header of a job whose glass was treated.
#[derive(Serialize, Deserialize)]
struct TreatedHeader {
    job: JobHeader,
    treatment: Treatment,
}

/// The header of a job whose material yields.
#[derive(Serialize, Deserialize)]
struct YieldingHeader {
    job: JobHeader,
    hardening: Hardening,
}

/// The header of a job whose material flows by rate and warmth, or tears.
#[derive(Serialize, Deserialize)]
struct JohnsonCookHeader {
    job: JobHeader,
    flow: JohnsonCook,
}

/// The header of a job of points and bonds.
#[derive(Serialize, Deserialize)]
struct BondedHeader {
    job: JobHeader,
    bonds: BondedSolid,
}

/// What a law has beside a material and the field of its strength.
enum LawAddition {
    Brittle,
    Treated(Treatment),
    Yielding(Hardening),
    JohnsonCook(JohnsonCook),
    Bonded(BondedSolid),
}

impl LawAddition {
    fn check(&self) -> Result<(), WireError> {
        let (what, numbers): (_, Vec<f64>) = match self {
            Self::Brittle => return Ok(()),
            Self::Treated(treatment) => {
                ("a job's treatment", treatment.bounds().iter().map(|bound| bound.1).collect())
            }
            Self::Yielding(hardening) => {
                ("a job's hardening", hardening.bounds().iter().map(|bound| bound.1).collect())
            }
            Self::JohnsonCook(flow) => {
                ("a job's flow", flow.bounds().iter().map(|bound| bound.1).collect())
            }
            Self::Bonded(bonds) => {
                ("a job's bonds", bonds.bounds().iter().map(|bound| bound.1).collect())
            }
        };
        codec::finite(what, &numbers)
    }

    fn law(self, material: Material, strength: StrengthField, surface: SurfaceLaw) -> Law {
        match self {
            Self::Brittle => Law::Brittle { material, strength, surface },
            Self::Treated(treatment) => Law::Treated { material, strength, treatment },
            Self::Yielding(hardening) => Law::Yielding { material, hardening },
            Self::JohnsonCook(flow) => Law::JohnsonCook { material, flow },
            Self::Bonded(bonds) => Law::Bonded { material, bonds },
        }
    }
}

impl SettingsRow {
    fn of(settings: &Settings) -> Self {
        let BrittleSettings { detail, hairline } = settings.brittle;
        Self {
            spacing: settings.spacing,
            max_particles: settings.max_particles,
            max_steps: settings.max_steps,
            min_volume_ratio: settings.min_volume_ratio,
            max_fragments: settings.max_fragments,
            detail,
            debris: settings.debris,
            grain: settings.grain,
            hairline,
            precision: settings.precision,
            error: settings.error,
        }
    }

    fn settings(self) -> Settings {
        Settings {
            spacing: self.spacing,
            max_particles: self.max_particles,
            max_steps: self.max_steps,
            min_volume_ratio: self.min_volume_ratio,
            max_fragments: self.max_fragments,
            debris: self.debris,
            grain: self.grain,
            precision: self.precision,
            error: self.error,
            brittle: BrittleSettings { detail: self.detail, hairline: self.hairline },
        }
    }

    fn check(&self) -> Result<(), WireError> {
        codec::finite("a job's spacing", self.spacing.as_slice())?;
        codec::finite("a job's detail", &self.detail.bounds().map(|(_, value, ..)| value))?;
        codec::finite("a job's grain", self.grain.as_slice())?;
        codec::finite("a job's hairline", self.hairline.as_slice())?;
        codec::finite("a job's error", self.error.as_slice())?;
        codec::finite("a job's least volume ratios", &[self.min_volume_ratio, self.debris])
    }
}

impl FractureJob {
    /// The canonical bytes: equal problems give equal bytes.
    ///
    /// # Errors
    /// The limit of the wire that the job breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        Ok(self.slabs()?.0)
    }

    /// The canonical bytes, and where in them the mesh and what is painted on one are. A job
    /// without direction has the bytes that it had before there was direction.
    pub(crate) fn slabs(&self) -> Result<(Vec<u8>, [Range<usize>; 2]), WireError> {
        let (inner, slabs) = self.undirected()?;
        match &self.direction {
            None => Ok((inner, slabs)),
            Some(direction) => directed::wrap(direction, &inner, slabs),
        }
    }

    fn undirected(&self) -> Result<(Vec<u8>, [Range<usize>; 2]), WireError> {
        let Problem { body, law, impacts, supports, spin, settings, seed } = &self.problem;
        let BodyShape::Solid(solid) = body else {
            return Err(WireError::Unknown { what: "a job's body", kind: body.kind() });
        };
        let even = StrengthField::even();
        let (material, strength, addition) = match law {
            Law::Brittle { material, strength, .. } => (material, strength, LawAddition::Brittle),
            Law::Treated { material, strength, treatment } => {
                (material, strength, LawAddition::Treated(*treatment))
            }
            Law::Yielding { material, hardening } => {
                (material, &even, LawAddition::Yielding(*hardening))
            }
            Law::JohnsonCook { material, flow } => {
                (material, &even, LawAddition::JohnsonCook(*flow))
            }
            Law::Bonded { material, bonds } => (material, &even, LawAddition::Bonded(*bonds)),
            _ => return Err(WireError::Unknown { what: "a job's law", kind: law.kind() }),
        };
        let surface = match law {
            Law::Brittle { surface, .. } => *surface,
            _ => SurfaceLaw::of(material),
        };
        let (vertices, triangles) = mesh::counts(solid)?;
        let header = JobHeader {
            solver: self.solver.clone(),
            fallback: self.fallback.clone(),
            material: *material,
            strength: StrengthField { vertices: None, ..strength.clone() },
            surface,
            painted: strength::announced(strength)?,
            impacts: impacts.clone(),
            supports: supports.clone(),
            spin: (*spin).into(),
            settings: SettingsRow::of(settings),
            seed: *seed,
            vertices,
            triangles,
        };
        header.check()?;
        let mut slabs = Vec::new();
        mesh::put_solid(&mut slabs, solid);
        let middle = slabs.len();
        strength::put(strength, &mut slabs);
        addition.check()?;
        let bytes = match addition {
            LawAddition::Brittle => envelope::seal(MessageKind::Job, &header, &slabs)?,
            LawAddition::Treated(treatment) => {
                let header = TreatedHeader { job: header, treatment };
                envelope::seal(MessageKind::TreatedJob, &header, &slabs)?
            }
            LawAddition::Yielding(hardening) => {
                let header = YieldingHeader { job: header, hardening };
                envelope::seal(MessageKind::YieldingJob, &header, &slabs)?
            }
            LawAddition::JohnsonCook(flow) => {
                let header = JohnsonCookHeader { job: header, flow };
                envelope::seal(MessageKind::JohnsonCookJob, &header, &slabs)?
            }
            LawAddition::Bonded(bonds) => {
                let header = BondedHeader { job: header, bonds };
                envelope::seal(MessageKind::BondedJob, &header, &slabs)?
            }
        };
        let first = bytes.len() - slabs.len();
        let (middle, last) = (first + middle, bytes.len());
        Ok((bytes, [first..middle, middle..last]))
    }

    /// The job in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        let (direction, bytes) = directed::unwrap(bytes)?;
        let (mut header, addition, slabs) = opened(bytes)?;
        header.check()?;
        let mut slabs = Slabs::new(slabs);
        let solid = slabs.solid(header.vertices, header.triangles)?;
        strength::take(&mut header.strength, header.painted, &mut slabs)?;
        slabs.end("a job")?;
        let problem = Problem {
            body: solid.into(),
            law: addition.law(header.material, header.strength, header.surface),
            impacts: header.impacts,
            supports: header.supports,
            spin: header.spin.into(),
            settings: header.settings.settings(),
            seed: header.seed,
        };
        Ok(Self { solver: header.solver, fallback: header.fallback, problem, direction })
    }

    /// The digest of [`FractureJob::encode`].
    ///
    /// # Errors
    /// As [`FractureJob::encode`].
    pub fn id(&self) -> Result<JobId, WireError> {
        Ok(JobId::of(&self.encode()?))
    }
}

/// The header, what its law has of its own, and the slabs.
fn opened(bytes: &[u8]) -> Result<(JobHeader, LawAddition, &[u8]), WireError> {
    let (header, addition, slabs) = if envelope::is(MessageKind::TreatedJob, bytes) {
        let (header, slabs) = envelope::open::<TreatedHeader>(MessageKind::TreatedJob, bytes)?;
        (header.job, LawAddition::Treated(header.treatment), slabs)
    } else if envelope::is(MessageKind::YieldingJob, bytes) {
        let (header, slabs) = envelope::open::<YieldingHeader>(MessageKind::YieldingJob, bytes)?;
        (header.job, LawAddition::Yielding(header.hardening), slabs)
    } else if envelope::is(MessageKind::JohnsonCookJob, bytes) {
        let kind = MessageKind::JohnsonCookJob;
        let (header, slabs) = envelope::open::<JohnsonCookHeader>(kind, bytes)?;
        (header.job, LawAddition::JohnsonCook(header.flow), slabs)
    } else if envelope::is(MessageKind::BondedJob, bytes) {
        let (header, slabs) = envelope::open::<BondedHeader>(MessageKind::BondedJob, bytes)?;
        (header.job, LawAddition::Bonded(header.bonds), slabs)
    } else {
        let (header, slabs) = envelope::open::<JobHeader>(MessageKind::Job, bytes)?;
        (header, LawAddition::Brittle, slabs)
    };
    addition.check()?;
    Ok((header, addition, slabs))
}

impl JobHeader {
    fn check(&self) -> Result<(), WireError> {
        let names = [Some(&self.solver), self.fallback.as_ref()];
        for name in names.into_iter().flatten() {
            codec::limit("a solver name's length", name.len() as u64, MAX_SOLVER as u64)?;
        }
        codec::limit("a job's impacts", self.impacts.len() as u64, MAX_IMPACTS as u64)?;
        codec::limit("a job's supports", self.supports.len() as u64, MAX_SUPPORTS as u64)?;
        let Material { density, young, poisson, failure_stress, fracture_energy } = self.material;
        let material = [density, young, poisson, failure_stress, fracture_energy];
        codec::finite("a job's material", &material)?;
        codec::finite("a job's surface", &[self.surface.hardness, self.surface.friction])?;
        strength::check(&self.strength, ("a job's painted regions", "a job's strength"))?;
        for Impact { point, normal, impulse, duration, radius, energy, .. } in &self.impacts {
            codec::finite("a job's impacts", point.as_slice())?;
            codec::finite("a job's impacts", normal.as_slice())?;
            codec::finite("a job's impacts", &[*impulse, *duration, *radius, *energy])?;
        }
        for Impact { closing_speed, crushing_pressure, .. } in &self.impacts {
            codec::finite("a job's impacts", &[*closing_speed, *crushing_pressure])?;
        }
        for Support { point, normal, radius, mobility } in &self.supports {
            codec::finite("a job's supports", point.as_slice())?;
            codec::finite("a job's supports", normal.as_slice())?;
            codec::finite("a job's supports", &[*radius, *mobility])?;
        }
        codec::finite("a job's spin", &self.spin)?;
        self.settings.check()
    }
}

#[cfg(test)]
pub(crate) mod tests;
