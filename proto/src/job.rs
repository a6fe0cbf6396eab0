//! A fracture problem on its way to a worker.

use crate::codec::{self, WireError};
use crate::envelope::{self, Kind};
use crate::ids::JobId;
use crate::mesh::{self, Slabs};
use crate::strength::Strength;
use cullet_geometry::{Solid, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Most hits in one job: they travel in the header.
pub const MAX_IMPACTS: usize = 256;
/// Most supports in one job: they travel in the header too.
pub const MAX_SUPPORTS: usize = 256;
/// Longest solver name \[bytes\].
pub const MAX_SOLVER: usize = 64;

/// A brittle, isotropic solid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Mass density ρ \[kg/m³\].
    pub density: f64,
    /// Young's modulus E \[Pa\].
    pub young: f64,
    /// Poisson's ratio ν \[1\].
    pub poisson: f64,
    /// Rankine threshold σ_f \[Pa\].
    pub failure_stress: f64,
    /// Mode I fracture energy G_f \[J/m²\].
    pub fracture_energy: f64,
}

/// One hit, in the body's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Where the striker touched \[m\].
    pub point: Vec3,
    /// Unit direction of the push, into the body.
    pub normal: Vec3,
    /// Impulse along `normal` over the contact episode \[N·s\].
    pub impulse: f64,
    /// Hertz contact duration \[s\].
    pub duration: f64,
    /// Greatest Hertz contact radius \[m\].
    pub radius: f64,
    /// Kinetic energy of the approach \[J\].
    pub energy: f64,
    /// How fast the surfaces closed before they touched \[m/s\].
    pub closing_speed: f64,
    /// Pressure in the middle of the contact at which it crushes, body or striker \[Pa\].
    pub crushing_pressure: f64,
}

/// How crack faces look closer than the grid resolves. Lengths in grid spacings h; zero `height`,
/// `ribs` and `grain` are no detail.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detail {
    /// Longest edge of a crack face \[h\].
    pub edge: f64,
    /// Longest chevron line \[h\].
    pub length: f64,
    /// How far a chevron line keeps others away \[h\].
    pub influence: f64,
    /// Over what heights and damage times are smoothed \[h\].
    pub grid: f64,
    /// Height of chevrons \[h\].
    pub height: f64,
    /// Share of the chevron lines that grow along their way.
    pub share: f64,
    /// Height of ribs \[h\].
    pub ribs: f64,
    /// Distance between ribs \[h\].
    pub rib_spacing: f64,
    /// Height of grain \[h\].
    pub grain: f64,
    /// Size of the coarsest grain \[h\].
    pub grain_size: f64,
}

/// No detail, and the edges at which some begins.
impl Default for Detail {
    fn default() -> Self {
        Self {
            edge: 0.4,
            length: 10.0,
            influence: 0.5,
            grid: 0.8,
            height: 0.0,
            share: 0.5,
            ribs: 0.0,
            rib_spacing: 3.0,
            grain: 0.0,
            grain_size: 2.0,
        }
    }
}

impl Detail {
    fn numbers(&self) -> [f64; 10] {
        let Self { edge, length, influence, grid, height, share, ribs, rib_spacing, .. } = *self;
        let (grain, size) = (self.grain, self.grain_size);
        [edge, length, influence, grid, height, share, ribs, rib_spacing, grain, size]
    }
}

/// Where a body rests on another, in the body's own frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Support {
    /// Middle of the disc, on the surface \[m\].
    pub point: [f64; 3],
    /// Unit direction in which it can push, into the body.
    pub normal: [f64; 3],
    /// Radius of the disc \[m\].
    pub radius: f64,
    /// Velocity against `normal` that it takes up over the impulse it has given \[1/kg\].
    pub mobility: f64,
}

/// Numbers that a solve's points are worked out in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Precision {
    /// f32.
    Single,
    /// f64.
    #[default]
    Double,
}

/// What the scene decides about a solve. `None` means "let the solver choose".
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Grid spacing h \[m\].
    pub spacing: Option<f64>,
    /// Particle budget.
    pub max_particles: u32,
    /// Budget of time steps.
    pub max_steps: u32,
    /// Fragments below this share of the body's volume are merged \[1\].
    pub min_volume_ratio: f64,
    /// At most this many fragments.
    pub max_fragments: u32,
    /// How crack faces look.
    pub detail: Detail,
    /// Parts below this share of the body's volume become debris \[1\].
    pub debris: f64,
    /// Size of a grain of it \[m\].
    pub grain: Option<f64>,
    /// Width of the slits cut along cracks that end inside a fragment \[m\]; `None` cuts none.
    pub hairline: Option<f64>,
    /// What points are worked out in.
    pub precision: Precision,
    /// Relative error of the fragments that is good enough \[1\]; `None`: as true as can be.
    pub error: Option<f64>,
}

/// A problem, who is to solve it, and who if that one refuses.
#[derive(Clone, Debug, PartialEq)]
pub struct FractureJob {
    /// Name of the family asked first.
    pub solver: String,
    /// Name of the family asked if the first refuses.
    pub fallback: Option<String>,
    /// The body in its own frame, origin at the centre of mass \[m\].
    pub solid: Solid,
    /// Its material.
    pub material: Material,
    /// How its strength varies.
    pub strength: Strength,
    /// At least one hit.
    pub impacts: Vec<Impact>,
    /// What it rests on.
    pub supports: Vec<Support>,
    /// Angular velocity before the hits \[rad/s\]; zero where its stress does not matter.
    pub spin: Vec3,
    /// How it may be solved.
    pub settings: Settings,
    /// The only source of randomness.
    pub seed: u64,
}

#[derive(Serialize, Deserialize)]
struct Header {
    solver: String,
    fallback: Option<String>,
    material: Material,
    strength: Strength,
    painted: Option<(u32, f64)>,
    impacts: Vec<[f64; 12]>,
    supports: Vec<Support>,
    spin: [f64; 3],
    settings: Settings,
    seed: u64,
    vertices: u32,
    triangles: u32,
}

impl Impact {
    fn row(&self) -> [f64; 12] {
        let (p, n) = (self.point, self.normal);
        let (t, a, e) = (self.duration, self.radius, self.energy);
        let (v, c) = (self.closing_speed, self.crushing_pressure);
        [p.x, p.y, p.z, n.x, n.y, n.z, self.impulse, t, a, e, v, c]
    }

    fn from_row(row: [f64; 12]) -> Self {
        let [px, py, pz, nx, ny, nz, impulse, duration, radius, energy, closing_speed, c] = row;
        let (point, normal) = (Vec3::new(px, py, pz), Vec3::new(nx, ny, nz));
        Self {
            point,
            normal,
            impulse,
            duration,
            radius,
            energy,
            closing_speed,
            crushing_pressure: c,
        }
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
        let (vertices, triangles) = mesh::counts(&self.solid)?;
        let header = Header {
            solver: self.solver.clone(),
            fallback: self.fallback.clone(),
            material: self.material,
            strength: Strength { vertices: None, ..self.strength.clone() },
            painted: self.strength.announced()?,
            impacts: self.impacts.iter().map(Impact::row).collect(),
            supports: self.supports.clone(),
            spin: self.spin.into(),
            settings: self.settings,
            seed: self.seed,
            vertices,
            triangles,
        };
        header.check()?;
        let mut slabs = Vec::new();
        mesh::put_solid(&mut slabs, &self.solid);
        let solid = slabs.len();
        self.strength.put(&mut slabs);
        let bytes = envelope::seal(Kind::Job, &header, &slabs)?;
        let first = bytes.len() - slabs.len();
        let (middle, last) = (first + solid, bytes.len());
        Ok((bytes, [first..middle, middle..last]))
    }

    /// The job in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        let (mut header, slabs) = envelope::open::<Header>(Kind::Job, bytes)?;
        header.check()?;
        let mut slabs = Slabs::new(slabs);
        let solid = slabs.solid(header.vertices, header.triangles)?;
        header.strength.take(header.painted, &mut slabs)?;
        slabs.end("a job")?;
        Ok(Self {
            solver: header.solver,
            fallback: header.fallback,
            solid,
            material: header.material,
            strength: header.strength,
            impacts: header.impacts.into_iter().map(Impact::from_row).collect(),
            supports: header.supports,
            spin: header.spin.into(),
            settings: header.settings,
            seed: header.seed,
        })
    }

    /// The digest of [`FractureJob::encode`].
    ///
    /// # Errors
    /// As [`FractureJob::encode`].
    pub fn id(&self) -> Result<JobId, WireError> {
        Ok(JobId::of(&self.encode()?))
    }
}

impl Header {
    fn check(&self) -> Result<(), WireError> {
        let names = [Some(&self.solver), self.fallback.as_ref()];
        for name in names.into_iter().flatten() {
            codec::limit("a solver name's length", name.len() as u64, MAX_SOLVER as u64)?;
        }
        codec::limit("a job's impacts", self.impacts.len() as u64, MAX_IMPACTS as u64)?;
        codec::limit("a job's supports", self.supports.len() as u64, MAX_SUPPORTS as u64)?;
        if self.impacts.is_empty() {
            return Err(WireError::Short { what: "a job's impacts", have: 0, need: 1 });
        }
        let Material { density, young, poisson, failure_stress, fracture_energy } = self.material;
        let material = [density, young, poisson, failure_stress, fracture_energy];
        codec::finite("a job's material", &material)?;
        self.strength.check()?;
        codec::finite("a job's impacts", self.impacts.as_flattened())?;
        for Support { point, normal, radius, mobility } in &self.supports {
            let numbers = [point.as_slice(), normal, &[*radius, *mobility]].concat();
            codec::finite("a job's supports", &numbers)?;
        }
        codec::finite("a job's spin", &self.spin)?;
        codec::finite("a job's spacing", self.settings.spacing.as_slice())?;
        codec::finite("a job's detail", &self.settings.detail.numbers())?;
        codec::finite("a job's grain", self.settings.grain.as_slice())?;
        codec::finite("a job's hairline", self.settings.hairline.as_slice())?;
        codec::finite("a job's error", self.settings.error.as_slice())?;
        let Settings { min_volume_ratio, debris, .. } = self.settings;
        codec::finite("a job's least volume ratios", &[min_volume_ratio, debris])
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::strength::{Layers, Region, Stroke, VertexPaint, WeakPlane};
    use cullet_geometry::{Surface, TriMesh};

    pub(crate) fn tetrahedron() -> Solid {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mut solid = Solid::outer(TriMesh { vertices, triangles });
        solid.surface[3] = Surface::crack(1.5e-5);
        solid
    }

    fn strength() -> Strength {
        Strength {
            seed: 3,
            correlation: Some(0.02),
            weak_plane: Some(WeakPlane { normal: [0.0, 0.0, 1.0], ratio: 0.3 }),
            layers: Some(Layers {
                normal: [0.0, 1.0, 0.0],
                thickness: 0.1,
                ratio: 0.5,
                jitter: 0.2,
            }),
            strokes: vec![
                Stroke { region: Region::Box([0.0; 3], [1.0; 3]), factor: 0.5, edge: 0.01 },
                Stroke { region: Region::Sphere([0.0; 3], 1.0), factor: 0.5, edge: 0.0 },
                Stroke { region: Region::HalfSpace([0.0; 3], [1.0; 3]), factor: 2.0, edge: 0.0 },
                Stroke {
                    region: Region::Cylinder([0.0; 3], [1.0; 3], 0.2),
                    factor: 2.0,
                    edge: 0.0,
                },
            ],
            vertices: Some(VertexPaint {
                points: vec![Vec3::x(), Vec3::y()],
                factors: vec![0.5, 1.0],
                reach: 0.1,
            }),
            ..Strength::default()
        }
    }

    pub(crate) fn sample() -> FractureJob {
        FractureJob {
            solver: "brittle".into(),
            fallback: Some("geometric".into()),
            solid: tetrahedron(),
            material: Material {
                density: 2500.0,
                young: 7e10,
                poisson: 0.22,
                failure_stress: 4e7,
                fracture_energy: 8.0,
            },
            strength: strength(),
            impacts: vec![Impact {
                point: Vec3::new(0.1, 0.2, 0.3),
                normal: -Vec3::z(),
                impulse: 0.5,
                duration: 1e-4,
                radius: 1e-3,
                energy: 2.0,
                closing_speed: 3.0,
                crushing_pressure: 1e9,
            }],
            supports: vec![Support {
                point: [0.0; 3],
                normal: [0.0, 0.0, 1.0],
                radius: 0.02,
                mobility: 0.5,
            }],
            spin: Vec3::new(0.0, 0.0, 100.0),
            settings: Settings {
                spacing: None,
                max_particles: 16_000,
                max_steps: 20_000,
                min_volume_ratio: 1e-4,
                max_fragments: 400,
                detail: Detail { height: 0.1, ..Detail::default() },
                debris: 5e-4,
                grain: Some(1e-3),
                hairline: Some(1e-4),
                precision: Precision::Double,
                error: Some(0.5),
            },
            seed: 7,
        }
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
    fn any_change_of_the_problem_changes_its_id() -> Result<(), WireError> {
        let change: [fn(&mut FractureJob); 21] = [
            |j| j.settings.hairline = None,
            |j| j.settings.error = None,
            |j| j.settings.detail.height = 0.2,
            |j| j.seed += 1,
            |j| j.solver.push('x'),
            |j| j.fallback = None,
            |j| j.material.young *= 1.0 + f64::EPSILON,
            |j| j.strength.seed += 1,
            |j| j.strength.offset[0] = 1e-9,
            |j| j.strength.strokes[3].edge = 1e-9,
            |j| j.strength.vertices.iter_mut().for_each(|paint| paint.factors[1] = 0.9),
            |j| j.impacts[0].energy += 1.0,
            |j| j.impacts[0].closing_speed += 1.0,
            |j| j.impacts[0].crushing_pressure += 1.0,
            |j| j.settings.spacing = Some(0.1),
            |j| j.settings.grain = None,
            |j| j.settings.precision = Precision::Single,
            |j| j.supports[0].radius = 0.03,
            |j| j.spin.x = 1.0,
            |j| j.solid.mesh.vertices[0].x = 1e-300,
            |j| j.solid.surface[0] = Surface::crack(0.0),
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
        let nan = refused(|j| j.material.young = f64::NAN);
        assert_eq!(nan, Some(WireError::NotFinite { what: "a job's material" }));
        let strength = refused(|j| j.strength.strokes[1].factor = f64::NAN);
        assert_eq!(strength, Some(WireError::NotFinite { what: "a job's strength" }));
        let strength = refused(|j| j.strength.offset[1] = f64::NAN);
        assert_eq!(strength, Some(WireError::NotFinite { what: "a job's strength" }));
        let short = refused(|j| j.strength.vertices.iter_mut().for_each(|p| p.factors.clear()));
        assert!(matches!(short, Some(WireError::Short { have: 0, need: 2, .. })));
        let none = refused(|j| j.impacts.clear());
        assert!(matches!(none, Some(WireError::Short { .. })));
        let support = refused(|j| j.supports[0].point[2] = f64::NAN);
        assert_eq!(support, Some(WireError::NotFinite { what: "a job's supports" }));
        let many = refused(|j| j.supports = vec![j.supports[0]; MAX_SUPPORTS + 1]);
        assert!(matches!(many, Some(WireError::Limit { limit: 256, .. })));
        let many = refused(|j| j.impacts = vec![j.impacts[0]; MAX_IMPACTS + 1]);
        assert!(matches!(many, Some(WireError::Limit { limit: 256, .. })));
        let tags = refused(|j| j.solid.surface.clear());
        assert!(matches!(tags, Some(WireError::Short { .. })));
        let mut far = sample();
        far.solid.mesh.triangles[2][1] = 4;
        let far = far.encode().and_then(|bytes| FractureJob::decode(&bytes));
        assert_eq!(far, Err(WireError::Index { triangle: 2, index: 4, vertices: 4 }));
        let mut early = sample();
        early.solid.surface[3] = Surface::crack(f32::NAN);
        let early = early.encode().and_then(|bytes| FractureJob::decode(&bytes));
        assert!(matches!(early, Err(WireError::Mark { index: 0, .. })));
        let mut lost = sample();
        lost.solid.mesh.vertices[1].y = f64::INFINITY;
        let lost = lost.encode().and_then(|bytes| FractureJob::decode(&bytes));
        assert_eq!(lost, Err(WireError::NotFinite { what: "a mesh's vertices" }));
    }
}
