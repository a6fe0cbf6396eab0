//! A specimen on its way to a process that solves it, and what came out.
//!
//! Twins of the types of `services/fracture/src/specimen`; see there for what they mean.

mod check;
mod result;

pub use result::{Ending, Frame, Price, SpecimenResult};

use crate::codec::WireError;
use crate::envelope::{self, Kind};
use crate::ids::JobId;
use crate::mesh::{self, Slabs};
use cullet_geometry::Solid;
use cullet_model::strength::Region;
use cullet_model::{Material, StrengthField};
use serde::{Deserialize, Serialize};

/// Most samples of a probe.
pub const MAX_SAMPLES: u64 = 1 << 20;
/// Most probes.
pub const MAX_PROBES: u64 = 1024;
/// Most frames.
pub const MAX_FRAMES: u64 = 10_000;

/// The points in all of these; none means everywhere.
pub type Where = Vec<Region>;

/// How a load or a velocity goes with time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Course {
    /// Time \[s\] and factor.
    Table(Vec<(f64, f64)>),
    /// Start and duration \[s\].
    HalfSine(f64, f64),
}

/// A part of another material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Zone {
    /// Where.
    pub part: Where,
    /// What it is made of.
    pub material: Material,
}

/// Strength and damage of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Patch {
    /// Where.
    pub part: Where,
    /// Strength over the material's \[1\].
    pub strength: f64,
    /// Damage \[1\].
    pub damage: f64,
}

/// A crack from the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Notch {
    /// A point of the plane \[m\].
    pub point: [f64; 3],
    /// Its unit normal.
    pub normal: [f64; 3],
    /// Where of the plane.
    pub part: Where,
}

/// Nodes whose velocity is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hold {
    /// Which.
    pub part: Where,
    /// Which axes.
    pub axes: [bool; 3],
    /// Velocity \[m/s\].
    pub velocity: [f64; 3],
    /// Rows of its gradient \[1/s\].
    pub gradient: [[f64; 3]; 3],
    /// Where it is `velocity` \[m\].
    pub centre: [f64; 3],
    /// Its course.
    pub course: Course,
    /// When it lets go \[s\].
    pub until: Option<f64>,
}

/// What a load is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Push {
    /// \[Pa\]
    Traction([f64; 3]),
    /// \[Pa\]
    Pressure(f64),
    /// \[N\]
    Force([f64; 3]),
    /// \[m/s²\]
    Acceleration([f64; 3]),
}

/// A load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Where.
    pub part: Where,
    /// What.
    pub push: Push,
    /// Its course.
    pub course: Course,
}

/// How a part starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Where.
    pub part: Where,
    /// Velocity \[m/s\].
    pub velocity: [f64; 3],
    /// Rows of its gradient \[1/s\].
    pub gradient: [[f64; 3]; 3],
    /// Where it is `velocity` \[m\].
    pub centre: [f64; 3],
    /// Random velocity \[m/s\].
    pub noise: f64,
}

/// What points carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Field {
    /// \[m\]
    Displacement,
    /// \[m/s\]
    Velocity,
    /// \[Pa\]
    Stress,
    /// \[1\]
    Strain,
    /// \[1\]
    Damage,
}

/// One number of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Part {
    /// A component of a vector.
    Axis(u8),
    /// A component of a tensor: xx, yy, zz, xy, yz, zx.
    Pair(u8),
    /// Length or norm.
    Size,
    /// Greatest principal value.
    Greatest,
    /// Least principal value.
    Least,
    /// Von Mises' equivalent.
    Mises,
    /// A third of the trace.
    Mean,
}

/// What becomes of the numbers of many points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reduce {
    /// Their mean.
    Mean,
    /// The greatest.
    Max,
    /// The least.
    Min,
}

/// Where points are looked at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Spot {
    /// At a place \[m\].
    At([f64; 3]),
    /// All of a part.
    Over(Where, Reduce),
}

/// What is sampled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Probe {
    /// Of the points' fields.
    Points(Field, Part, Spot),
    /// Force of a support \[N\].
    Reaction(u32, Part),
    /// Force of a load \[N\].
    Applied(u32, Part),
    /// \[J\]
    Kinetic,
    /// \[J\]
    Elastic,
    /// \[J\]
    Dissipated,
    /// \[J\]
    Damped,
    /// \[J\]
    Work,
    /// \[J\]
    Balance,
    /// \[kg·m/s\]
    Momentum(Part),
    /// \[kg·m²/s\]
    AngularMomentum(Part),
    /// \[1\]
    Broken(Where),
    /// Above a damage \[m³\].
    DamagedVolume(Where, f64),
    /// Across a unit direction \[m²\].
    CrackArea(Where, [f64; 3]),
    /// Which points, along what, share behind, before there are any \[m\].
    CrackTip(Where, [f64; 3], f64, f64),
    /// Which points, about what \[m\], from one unit direction towards another \[rad\].
    CrackAngle(Where, [f64; 3], [[f64; 3]; 2]),
    /// Of at least a share \[1\].
    Pieces(f64),
    /// \[1\]
    Largest,
    /// \[J\]
    Met,
}

/// How it is solved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Grid spacing h \[m\].
    pub spacing: f64,
    /// Time step over its bound \[1\].
    pub step_factor: f64,
    /// Points a cell.
    pub per_cell: f64,
    /// In rows, or else scattered.
    pub rows: bool,
    /// The points' pass in f32, or else f64.
    pub single: bool,
    /// One velocity field, or else one for each side of a crack.
    pub welded: bool,
    /// Whether the material can break.
    pub breaks: bool,
    /// In place of the calibrated length \[m\].
    pub softening_length: Option<f64>,
    /// \[1/s\]
    pub damping: f64,
    /// \[s\]
    pub damped_until: Option<f64>,
    /// Most points.
    pub max_points: f64,
    /// Most steps.
    pub max_steps: f64,
    /// Threads; they decide nothing.
    pub threads: u32,
    /// The only source of randomness.
    pub seed: u64,
    /// Steps from one look at what has parted to the next.
    pub look: u32,
}

/// All of a specimen but its mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// To the grid's frame: w, x, y, z.
    pub turn: [f64; 4],
    /// Where the origin lies on the grid \[m\].
    pub shift: [f64; 3],
    /// The first triangle of each body but the first, ascending.
    pub bodies: Vec<u32>,
    /// Its material.
    pub material: Material,
    /// Parts of other materials; the last of several holds.
    pub zones: Vec<Zone>,
    /// How strength varies; nothing painted on the surface.
    pub strength: StrengthField,
    /// Parts that differ.
    pub patches: Vec<Patch>,
    /// Cracks from the start.
    pub notches: Vec<Notch>,
    /// Axis and place \[m\].
    pub symmetries: Vec<(u8, f64)>,
    /// Rows of the displacement gradient \[1\].
    pub stretch: [[f64; 3]; 3],
    /// How parts start.
    pub starts: Vec<Start>,
    /// Supports.
    pub holds: Vec<Hold>,
    /// Loads.
    pub loads: Vec<Load>,
    /// What is watched.
    pub probes: Vec<Probe>,
    /// How it is solved.
    pub settings: Settings,
    /// Simulated time \[s\].
    pub end: f64,
    /// Samples of the probes.
    pub samples: u32,
    /// Pictures of all points.
    pub frames: u32,
    /// What colours them.
    pub colour: (Field, Part),
}

/// A specimen to be solved.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecimenJob {
    /// The body in its own frame \[m\].
    pub solid: Solid,
    /// All the rest.
    pub setup: Setup,
}

impl SpecimenJob {
    /// The canonical bytes: equal specimens give equal bytes.
    ///
    /// # Errors
    /// The limit of the wire that it breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        let (vertices, triangles) = mesh::counts(&self.solid)?;
        check::check(&self.setup, triangles)?;
        let mut slabs = Vec::new();
        mesh::put_solid(&mut slabs, &self.solid);
        envelope::seal(Kind::Specimen, &(&self.setup, vertices, triangles), &slabs)
    }

    /// Whether these bytes hold a specimen, and no body to be broken.
    #[must_use]
    pub fn is(bytes: &[u8]) -> bool {
        envelope::is(Kind::Specimen, bytes)
    }

    /// The specimen in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        let (header, slabs) = envelope::open::<(Setup, u32, u32)>(Kind::Specimen, bytes)?;
        let (setup, vertices, triangles) = header;
        check::check(&setup, triangles)?;
        let mut slabs = Slabs::new(slabs);
        let solid = slabs.solid(vertices, triangles)?;
        slabs.end("a specimen")?;
        Ok(Self { solid, setup })
    }

    /// The digest of [`SpecimenJob::encode`], whatever the number of threads.
    ///
    /// # Errors
    /// As [`SpecimenJob::encode`].
    pub fn id(&self) -> Result<JobId, WireError> {
        let mut same = self.clone();
        same.setup.settings.threads = 1;
        Ok(JobId::of(&same.encode()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::tests::tetrahedron;
    use cullet_geometry::Vec3;

    fn job() -> SpecimenJob {
        let part = vec![Region::Sphere { centre: Vec3::zeros(), radius: 1.0 }];
        let settings = Settings {
            spacing: 0.01,
            step_factor: 0.8,
            per_cell: 8.0,
            rows: true,
            single: false,
            welded: false,
            breaks: true,
            softening_length: None,
            damping: 0.0,
            damped_until: None,
            max_points: 1e6,
            max_steps: 1e6,
            threads: 2,
            seed: 3,
            look: 4,
        };
        let material = Material {
            density: 1.0,
            young: 2.0,
            poisson: 0.2,
            failure_stress: 3.0,
            fracture_energy: 4.0,
        };
        let setup = Setup {
            turn: [1.0, 0.0, 0.0, 0.0],
            shift: [0.0; 3],
            bodies: vec![2],
            zones: vec![Zone { part: part.clone(), material }],
            material,
            strength: StrengthField::even(),
            patches: vec![Patch { part: part.clone(), strength: 2.0, damage: 0.0 }],
            notches: Vec::new(),
            symmetries: vec![(1, 0.5)],
            stretch: [[0.0; 3]; 3],
            starts: Vec::new(),
            holds: Vec::new(),
            loads: Vec::new(),
            probes: vec![Probe::Kinetic, Probe::Broken(part)],
            settings,
            end: 1.0,
            samples: 10,
            frames: 0,
            colour: (Field::Damage, Part::Size),
        };
        SpecimenJob { solid: tetrahedron(), setup }
    }

    #[test]
    fn a_specimen_comes_back_as_it_went_and_threads_do_not_name_it() -> Result<(), WireError> {
        let first = job();
        assert_eq!(SpecimenJob::decode(&first.encode()?)?, first);
        let mut other = first.clone();
        other.setup.settings.threads = 7;
        assert_eq!(first.id()?, other.id()?);
        other.setup.settings.seed = 4;
        assert_ne!(first.id()?, other.id()?);
        Ok(())
    }

    /// A job as bytes whose setup nothing was held to.
    fn bytes(job: &SpecimenJob) -> Vec<u8> {
        let (vertices, triangles) = mesh::counts(&job.solid).expect("a mesh");
        let mut slabs = Vec::new();
        mesh::put_solid(&mut slabs, &job.solid);
        envelope::seal(Kind::Specimen, &(&job.setup, vertices, triangles), &slabs).expect("sealed")
    }

    /// Words of an error, and what brings it about.
    type Spoiled<'a> = (&'a str, &'a dyn Fn(&mut Setup));

    /// What is wrong is told at the door, before anything is solved.
    #[test]
    fn bad_numbers_and_indices_are_told_at_the_door() {
        let line = |rows: &[(f64, f64)]| Load {
            part: Vec::new(),
            push: Push::Pressure(1.0),
            course: Course::Table(rows.to_vec()),
        };
        let cases: [Spoiled<'_>; 16] = [
            ("support of a probe is 1", &|s| s.probes = vec![Probe::Reaction(0, Part::Size)]),
            ("load of a probe is 4", &|s| s.probes = vec![Probe::Applied(3, Part::Size)]),
            ("axis of a probe is 3", &|s| s.probes = vec![Probe::Momentum(Part::Axis(3))]),
            ("share of a probe is 1.5", &|s| {
                s.probes = vec![Probe::CrackTip(Vec::new(), [1.0, 0.0, 0.0], 1.5, 0.0)];
            }),
            ("share of a probe is NaN", &|s| s.probes = vec![Probe::Pieces(f64::NAN)]),
            ("direction of a probe is not finite", &|s| {
                s.probes = vec![Probe::CrackArea(Vec::new(), [0.0; 3])];
            }),
            ("frames is 10001", &|s| s.frames = 10_001),
            ("material is not finite", &|s| s.material.young = f64::NAN),
            ("material is not finite", &|s| s.zones[0].material.density = f64::INFINITY),
            ("turn is not finite", &|s| s.turn = [0.0; 4]),
            ("settings is not finite", &|s| s.settings.damped_until = Some(f64::NAN)),
            ("region of a specimen is not finite", &|s| {
                s.patches[0].part =
                    vec![Region::Sphere { centre: Vec3::new(0.0, f64::NAN, 0.0), radius: 1.0 }];
            }),
            ("first triangle of a body is 5", &|s| s.bodies = vec![4]),
            ("behind 2", &|s| s.bodies = vec![2, 2]),
            ("plane of symmetry is 3", &|s| s.symmetries = vec![(3, 0.0)]),
            ("1 s follows 2 s", &|s| s.loads = vec![line(&[(2.0, 0.0), (1.0, 1.0)])]),
        ];
        assert_eq!(SpecimenJob::decode(&bytes(&job())), Ok(job()));
        for (words, spoil) in cases {
            let mut job = job();
            spoil(&mut job.setup);
            let told = SpecimenJob::decode(&bytes(&job)).expect_err(words).to_string();
            assert!(told.contains(words), "{words}: {told}");
            assert!(job.encode().is_err(), "{words}");
        }
    }
}
