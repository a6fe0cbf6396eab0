//! A specimen on its way to a process that solves it, and what came out.
//!
//! Twins of the types of `services/fracture/src/specimen`; see there for what they mean.

use crate::codec::{self, WireError};
use crate::envelope::{self, Kind};
use crate::ids::JobId;
use crate::job::Material;
use crate::mesh::{self, Slabs};
use crate::strength::{Region, Strength};
use cullet_geometry::Solid;
use serde::{Deserialize, Serialize};

/// Most samples of a probe.
pub const MAX_SAMPLES: u64 = 1 << 20;
/// Most probes.
pub const MAX_PROBES: u64 = 1024;
/// Most numbers of all frames together.
pub const MAX_FRAME_NUMBERS: u64 = 1 << 28;

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
}

/// All of a specimen but its mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// To the grid's frame: w, x, y, z.
    pub turn: [f64; 4],
    /// Where the origin lies on the grid \[m\].
    pub shift: [f64; 3],
    /// Its material.
    pub material: Material,
    /// How strength varies; nothing painted on the surface.
    pub strength: Strength,
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
        codec::limit("a specimen's probes", self.setup.probes.len() as u64, MAX_PROBES)?;
        codec::limit("a specimen's samples", u64::from(self.setup.samples), MAX_SAMPLES)?;
        let mut slabs = Vec::new();
        mesh::put_solid(&mut slabs, &self.solid);
        envelope::seal(Kind::Specimen, &(&self.setup, vertices, triangles), &slabs)
    }

    /// The specimen in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        let (header, slabs) = envelope::open::<(Setup, u32, u32)>(Kind::Specimen, bytes)?;
        let (setup, vertices, triangles) = header;
        codec::limit("a specimen's probes", setup.probes.len() as u64, MAX_PROBES)?;
        codec::limit("a specimen's samples", u64::from(setup.samples), MAX_SAMPLES)?;
        setup.strength.check()?;
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

/// How a run ended. Each is a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Ending {
    /// At its end.
    Ok,
    /// Energy appeared from nowhere.
    Unstable(String),
    /// A number stopped being one.
    NotFinite(String),
    /// It was not for this solver.
    Refused(String),
    /// The body cannot be filled or cut.
    Geometry(String),
    /// It took too long, or its process ended.
    Timeout(String),
}

/// All points at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// When \[s\].
    pub time: f64,
    /// Place \[m\] and colouring number of each.
    pub points: Vec<[f32; 4]>,
}

/// What it cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Price {
    /// Wall time of the solve \[s\].
    pub wall: f64,
    /// Processor time of the process \[s\].
    pub cpu: f64,
    /// Most memory of the process \[bytes\].
    pub peak: u64,
}

/// What came out of a specimen.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecimenResult {
    /// How it ended.
    pub ending: Ending,
    /// Time step \[s\].
    pub step: f64,
    /// Steps taken.
    pub steps: u64,
    /// Points.
    pub points: u64,
    /// Stress at which cracks grow over σ_f \[1\].
    pub strength_ratio: f64,
    /// What it cost.
    pub price: Price,
    /// Shares of the body that its pieces have \[1\].
    pub pieces: Vec<f64>,
    /// Times of the samples \[s\].
    pub times: Vec<f64>,
    /// A row for each probe.
    pub rows: Vec<Vec<f64>>,
    /// Pictures.
    pub frames: Vec<Frame>,
}

#[derive(Serialize, Deserialize)]
struct Header {
    ending: Ending,
    step: f64,
    steps: u64,
    points: u64,
    strength_ratio: f64,
    price: Price,
    pieces: u32,
    times: u32,
    rows: u32,
    frames: Vec<(f64, u32)>,
}

impl SpecimenResult {
    /// A run that came to nothing.
    #[must_use]
    pub fn ended(ending: Ending) -> Self {
        Self {
            ending,
            step: 0.0,
            steps: 0,
            points: 0,
            strength_ratio: 1.0,
            price: Price::default(),
            pieces: Vec::new(),
            times: Vec::new(),
            rows: Vec::new(),
            frames: Vec::new(),
        }
    }

    /// The bytes.
    ///
    /// # Errors
    /// The limit of the wire that it breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        let frames = self.frames.iter().map(|f| (f.time, f.points.len() as u32)).collect();
        let header = Header {
            ending: self.ending.clone(),
            step: self.step,
            steps: self.steps,
            points: self.points,
            strength_ratio: self.strength_ratio,
            price: self.price,
            pieces: self.pieces.len() as u32,
            times: self.times.len() as u32,
            rows: self.rows.len() as u32,
            frames,
        };
        let mut bulk = Vec::new();
        let numbers = self.pieces.iter().chain(&self.times).chain(self.rows.iter().flatten());
        numbers.for_each(|x| bulk.extend_from_slice(&x.to_le_bytes()));
        let points = self.frames.iter().flat_map(|frame| frame.points.iter().flatten());
        points.for_each(|x| bulk.extend_from_slice(&x.to_le_bytes()));
        envelope::seal(Kind::SpecimenResult, &header, &bulk)
    }

    /// The result in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        let (header, bulk) = envelope::open::<Header>(Kind::SpecimenResult, bytes)?;
        codec::limit("a result's rows", u64::from(header.rows), MAX_PROBES)?;
        codec::limit("a result's samples", u64::from(header.times), 2 * MAX_SAMPLES)?;
        let all: u64 = header.frames.iter().map(|frame| 4 * u64::from(frame.1)).sum();
        codec::limit("the numbers of a result's frames", all, MAX_FRAME_NUMBERS)?;
        let mut slabs = Slabs::new(bulk);
        let mut row = |count: u32| -> Result<Vec<f64>, WireError> {
            let bytes = slabs.take("a result's samples", count as usize, 8)?;
            Ok(bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect())
        };
        let (pieces, times) = (row(header.pieces)?, row(header.times)?);
        let rows = (0..header.rows).map(|_| row(header.times)).collect::<Result<_, _>>()?;
        let mut frames = Vec::new();
        for (time, count) in header.frames {
            let bytes = slabs.take("a result's frames", count as usize, 16)?;
            let numbers: Vec<f32> =
                bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
            frames.push(Frame { time, points: numbers.as_chunks::<4>().0.to_vec() });
        }
        slabs.end("a result")?;
        let Header { ending, step, steps, points, strength_ratio, price, .. } = header;
        let (ending, price) = (ending, price);
        Ok(Self { ending, step, steps, points, strength_ratio, price, pieces, times, rows, frames })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::tests::tetrahedron;

    fn job() -> SpecimenJob {
        let part = vec![Region::Sphere([0.0; 3], 1.0)];
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
            material,
            strength: Strength::default(),
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

    #[test]
    fn a_result_comes_back_as_it_went_or_says_what_is_missing() -> Result<(), WireError> {
        let frame = Frame { time: 0.5, points: vec![[1.0, 2.0, 3.0, 4.0]; 3] };
        let result = SpecimenResult {
            times: vec![0.0, 1.0],
            rows: vec![vec![1.0, 2.0], vec![f64::INFINITY, -1.0], vec![0.0; 2]],
            pieces: vec![1.0],
            frames: vec![frame],
            ..SpecimenResult::ended(Ending::Unstable("why".into()))
        };
        let bytes = result.encode()?;
        assert_eq!(SpecimenResult::decode(&bytes)?, result);
        let short = SpecimenResult::decode(&bytes[..bytes.len() - 1]);
        assert!(matches!(short, Err(WireError::Short { what: "a result's frames", .. })));
        Ok(())
    }
}
