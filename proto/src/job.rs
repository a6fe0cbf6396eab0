//! A fracture problem on its way to a worker.
//!
//! The layout of a solid with the brittle law is as old as the first version: the digest of a
//! problem is its name, in recordings too. Another kind of body or law gets a kind of message of
//! its own.

use crate::codec::{self, WireError};
use crate::envelope::{self, MessageKind};
use crate::ids::JobId;
use crate::mesh::{self, Slabs};
use crate::strength;
use cullet_model::{
    BodyShape, BrittleSettings, CrackFaceDetail, Impact, Law, Material, PointPrecision, Problem,
    Settings, StrengthField, Support, Treatment,
};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Most hits in one job: they travel in the header.
pub const MAX_IMPACTS: usize = 256;
/// Most supports in one job: they travel in the header too.
pub const MAX_SUPPORTS: usize = 256;
/// Longest solver name \[bytes\].
pub const MAX_SOLVER: usize = 64;

/// A problem, who is to solve it, and who if that one refuses.
#[derive(Clone, Debug, PartialEq)]
pub struct FractureJob {
    /// Name of the family asked first.
    pub solver: String,
    /// Name of the family asked if the first refuses.
    pub fallback: Option<String>,
    /// What is to be solved.
    pub problem: Problem,
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

    /// The canonical bytes, and where in them the mesh and what is painted on one are.
    pub(crate) fn slabs(&self) -> Result<(Vec<u8>, [Range<usize>; 2]), WireError> {
        let Problem { body, law, impacts, supports, spin, settings, seed } = &self.problem;
        let BodyShape::Solid(solid) = body else {
            return Err(WireError::Unknown { what: "a job's body", kind: body.kind() });
        };
        let (material, strength, treatment) = match law {
            Law::Brittle { material, strength } => (material, strength, None),
            Law::Treated { material, strength, treatment } => (material, strength, Some(treatment)),
            _ => return Err(WireError::Unknown { what: "a job's law", kind: law.kind() }),
        };
        let (vertices, triangles) = mesh::counts(solid)?;
        let header = JobHeader {
            solver: self.solver.clone(),
            fallback: self.fallback.clone(),
            material: *material,
            strength: StrengthField { vertices: None, ..strength.clone() },
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
        let bytes = match treatment {
            None => envelope::seal(MessageKind::Job, &header, &slabs)?,
            Some(treatment) => {
                check_treatment(treatment)?;
                let header = TreatedHeader { job: header, treatment: *treatment };
                envelope::seal(MessageKind::TreatedJob, &header, &slabs)?
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
        let (mut header, treatment, slabs) = opened(bytes)?;
        header.check()?;
        let mut slabs = Slabs::new(slabs);
        let solid = slabs.solid(header.vertices, header.triangles)?;
        strength::take(&mut header.strength, header.painted, &mut slabs)?;
        slabs.end("a job")?;
        let problem = Problem {
            body: solid.into(),
            law: law_of(header.material, header.strength, treatment),
            impacts: header.impacts,
            supports: header.supports,
            spin: header.spin.into(),
            settings: header.settings.settings(),
            seed: header.seed,
        };
        Ok(Self { solver: header.solver, fallback: header.fallback, problem })
    }

    /// The digest of [`FractureJob::encode`].
    ///
    /// # Errors
    /// As [`FractureJob::encode`].
    pub fn id(&self) -> Result<JobId, WireError> {
        Ok(JobId::of(&self.encode()?))
    }
}

/// The header, what was done to the glass, and the slabs.
fn opened(bytes: &[u8]) -> Result<(JobHeader, Option<Treatment>, &[u8]), WireError> {
    if envelope::is(MessageKind::TreatedJob, bytes) {
        let (header, slabs) = envelope::open::<TreatedHeader>(MessageKind::TreatedJob, bytes)?;
        check_treatment(&header.treatment)?;
        return Ok((header.job, Some(header.treatment), slabs));
    }
    let (header, slabs) = envelope::open::<JobHeader>(MessageKind::Job, bytes)?;
    Ok((header, None, slabs))
}

fn law_of(material: Material, strength: StrengthField, treatment: Option<Treatment>) -> Law {
    match treatment {
        None => Law::Brittle { material, strength },
        Some(treatment) => Law::Treated { material, strength, treatment },
    }
}

fn check_treatment(treatment: &Treatment) -> Result<(), WireError> {
    let numbers: Vec<f64> = treatment.bounds().into_iter().map(|(_, value, ..)| value).collect();
    codec::finite("a job's treatment", &numbers)
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
pub(crate) mod tests {
    use super::*;
    use cullet_geometry::{Solid, Surface, TriMesh, Vec3};
    use cullet_model::strength::{Region, StrengthLayers, Stroke, VertexPaint};
    use cullet_model::{Interlayer, PatternWeakPlane};
    use std::sync::Arc;

    pub(crate) fn tetrahedron() -> Solid {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mut solid = Solid::outer(TriMesh { vertices, triangles });
        solid.surface[3] = Surface::crack(1.5e-5);
        solid
    }

    fn strength() -> StrengthField {
        StrengthField {
            seed: 3,
            correlation: Some(0.02),
            weak_plane: Some(PatternWeakPlane { normal: Vec3::z(), ratio: 0.3 }),
            layers: Some(StrengthLayers {
                normal: Vec3::y(),
                thickness: 0.1,
                ratio: 0.5,
                jitter: 0.2,
            }),
            strokes: vec![
                Stroke {
                    region: Region::Box { low: Vec3::zeros(), high: Vec3::repeat(1.0) },
                    factor: 0.5,
                    edge: 0.01,
                },
                Stroke {
                    region: Region::Sphere { centre: Vec3::zeros(), radius: 1.0 },
                    factor: 0.5,
                    edge: 0.0,
                },
                Stroke {
                    region: Region::HalfSpace { point: Vec3::zeros(), normal: Vec3::repeat(1.0) },
                    factor: 2.0,
                    edge: 0.0,
                },
                Stroke {
                    region: Region::Cylinder {
                        from: Vec3::zeros(),
                        to: Vec3::repeat(1.0),
                        radius: 0.2,
                    },
                    factor: 2.0,
                    edge: 0.0,
                },
            ],
            vertices: Some(Arc::new(VertexPaint {
                points: vec![Vec3::x(), Vec3::y()],
                factors: vec![0.5, 1.0],
                reach: 0.1,
            })),
            ..StrengthField::even()
        }
    }

    pub(crate) fn sample() -> FractureJob {
        let material = Material {
            density: 2500.0,
            young: 7e10,
            poisson: 0.22,
            failure_stress: 4e7,
            fracture_energy: 8.0,
        };
        let impact = Impact {
            point: Vec3::new(0.1, 0.2, 0.3),
            normal: -Vec3::z(),
            impulse: 0.5,
            duration: 1e-4,
            radius: 1e-3,
            energy: 2.0,
            closing_speed: 3.0,
            crushing_pressure: 1e9,
        };
        let (point, normal) = (Vec3::zeros(), Vec3::z());
        let detail = CrackFaceDetail { height: 0.1, ..CrackFaceDetail::default() };
        let problem = Problem {
            body: tetrahedron().into(),
            law: Law::Brittle { material, strength: strength() },
            impacts: vec![impact],
            supports: vec![Support { point, normal, radius: 0.02, mobility: 0.5 }],
            spin: Vec3::new(0.0, 0.0, 100.0),
            settings: Settings {
                grain: Some(1e-3),
                error: Some(0.5),
                brittle: BrittleSettings { detail, hairline: Some(1e-4) },
                ..Settings::default()
            },
            seed: 7,
        };
        FractureJob { solver: "brittle".into(), fallback: Some("geometric".into()), problem }
    }

    fn solid(job: &mut FractureJob) -> &mut Solid {
        let BodyShape::Solid(solid) = &mut job.problem.body else { panic!("another body") };
        Arc::make_mut(solid)
    }

    fn law(job: &mut FractureJob) -> (&mut Material, &mut StrengthField) {
        let Law::Brittle { material, strength } = &mut job.problem.law else {
            panic!("another law")
        };
        (material, strength)
    }

    fn paint(job: &mut FractureJob) -> &mut VertexPaint {
        Arc::make_mut(law(job).1.vertices.as_mut().expect("paint"))
    }

    #[test]
    fn a_job_comes_back_and_its_id_is_fixed() -> Result<(), WireError> {
        let job = sample();
        let bytes = job.encode()?;
        assert_eq!(FractureJob::decode(&bytes)?, job);
        assert_eq!(job.id()?, JobId::of(&bytes));
        assert_eq!(job.id()?.short(), "a52793ca");
        Ok(())
    }

    #[test]
    fn a_job_of_treated_glass_comes_back_and_its_id_is_its_own() -> Result<(), WireError> {
        let interlayer = Interlayer { thickness: 0.76e-3, strength: 20e6, stretch: 2.0 };
        let all = [
            Treatment::HeatStrengthened { surface_stress: 40e6 },
            Treatment::Toughened { surface_stress: 40e6 },
            Treatment::Toughened { surface_stress: 90e6 },
            Treatment::Laminated { interlayer },
        ];
        let mut ids = vec![sample().id()?];
        for treatment in all {
            let mut job = sample();
            let (material, strength) = law(&mut job);
            let (material, strength) = (*material, strength.clone());
            job.problem.law = Law::Treated { material, strength, treatment };
            let bytes = job.encode()?;
            assert_eq!(FractureJob::decode(&bytes)?, job);
            assert!(!ids.contains(&job.id()?), "{treatment:?}");
            ids.push(job.id()?);
        }
        assert_eq!(ids[2].short(), "c685c360");
        let mut job = sample();
        let (material, strength) = law(&mut job);
        let (material, strength) = (*material, strength.clone());
        let treatment = Treatment::Toughened { surface_stress: f64::NAN };
        job.problem.law = Law::Treated { material, strength, treatment };
        assert_eq!(job.encode(), Err(WireError::NotFinite { what: "a job's treatment" }));
        Ok(())
    }

    #[test]
    fn any_change_of_the_problem_changes_its_id() -> Result<(), WireError> {
        let change: [fn(&mut FractureJob); 21] = [
            |j| j.problem.settings.brittle.hairline = None,
            |j| j.problem.settings.error = None,
            |j| j.problem.settings.brittle.detail.height = 0.2,
            |j| j.problem.seed += 1,
            |j| j.solver.push('x'),
            |j| j.fallback = None,
            |j| law(j).0.young *= 1.0 + f64::EPSILON,
            |j| law(j).1.seed += 1,
            |j| law(j).1.offset[0] = 1e-9,
            |j| law(j).1.strokes[3].edge = 1e-9,
            |j| paint(j).factors[1] = 0.9,
            |j| j.problem.impacts[0].energy += 1.0,
            |j| j.problem.impacts[0].closing_speed += 1.0,
            |j| j.problem.impacts[0].crushing_pressure += 1.0,
            |j| j.problem.settings.spacing = Some(0.1),
            |j| j.problem.settings.grain = None,
            |j| j.problem.settings.precision = PointPrecision::Single,
            |j| j.problem.supports[0].radius = 0.03,
            |j| j.problem.spin.x = 1.0,
            |j| solid(j).mesh.vertices[0].x = 1e-300,
            |j| solid(j).surface[0] = Surface::crack(0.0),
        ];
        for (index, change) in change.iter().enumerate() {
            let mut other = sample();
            change(&mut other);
            assert_ne!(other.id()?, sample().id()?, "change {index}");
        }
        Ok(())
    }

    #[test]
    fn nonsense_is_refused_with_its_bound() {
        let refused = |change: fn(&mut FractureJob)| {
            let mut job = sample();
            change(&mut job);
            job.encode().err()
        };
        let nan = refused(|j| law(j).0.young = f64::NAN);
        assert_eq!(nan, Some(WireError::NotFinite { what: "a job's material" }));
        let strength = refused(|j| law(j).1.strokes[1].factor = f64::NAN);
        assert_eq!(strength, Some(WireError::NotFinite { what: "a job's strength" }));
        let strength = refused(|j| law(j).1.offset[1] = f64::NAN);
        assert_eq!(strength, Some(WireError::NotFinite { what: "a job's strength" }));
        let short = refused(|j| paint(j).factors.clear());
        assert!(matches!(short, Some(WireError::Short { have: 0, need: 2, .. })));
        let support = refused(|j| j.problem.supports[0].point[2] = f64::NAN);
        assert_eq!(support, Some(WireError::NotFinite { what: "a job's supports" }));
        let many = refused(|j| j.problem.supports = vec![j.problem.supports[0]; MAX_SUPPORTS + 1]);
        assert!(matches!(many, Some(WireError::Limit { limit: 256, .. })));
        let many = refused(|j| j.problem.impacts = vec![j.problem.impacts[0]; MAX_IMPACTS + 1]);
        assert!(matches!(many, Some(WireError::Limit { limit: 256, .. })));
        let tags = refused(|j| solid(j).surface.clear());
        assert!(matches!(tags, Some(WireError::Short { .. })));
        let mut far = sample();
        solid(&mut far).mesh.triangles[2][1] = 4;
        let far = far.encode().and_then(|bytes| FractureJob::decode(&bytes));
        assert_eq!(far, Err(WireError::Index { triangle: 2, index: 4, vertices: 4 }));
        let mut early = sample();
        solid(&mut early).surface[3] = Surface::crack(f32::NAN);
        let early = early.encode().and_then(|bytes| FractureJob::decode(&bytes));
        assert!(matches!(early, Err(WireError::Mark { index: 0, .. })));
        let mut lost = sample();
        solid(&mut lost).mesh.vertices[1].y = f64::INFINITY;
        let lost = lost.encode().and_then(|bytes| FractureJob::decode(&bytes));
        assert_eq!(lost, Err(WireError::NotFinite { what: "a mesh's vertices" }));
    }
}
