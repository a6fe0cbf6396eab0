//! The messages of a recording that are ours. Tags are never reused; fields are only added.

use super::schema::{Declarations, enumeration, message};
use super::vector::{self, Vector3};
use super::{appearance, joints};

enumeration! {
    /// How much of the original body a fragment is, and what may still happen to it.
    Tier {
        /// An original body.
        Whole = 0,
        /// May break again.
        Large = 1,
        /// Breaks no more.
        Small = 2,
        /// Breaks no more and collides as one convex part.
        Tiny = 3,
    }
}

enumeration! {
    /// How a fracture job ended.
    Verdict {
        /// Not said.
        Unspecified = 0,
        /// Taken apart.
        Broken = 1,
        /// Nothing separated.
        Kept = 2,
        /// No solver took the problem.
        Refused = 3,
        /// Numerics went wrong.
        Failed = 4,
        /// The pool lost it for good.
        Abandoned = 5,
        /// One body still, of another shape.
        Deformed = 6,
    }
}

enumeration! {
    /// What a run event tells.
    EventKind {
        /// Not said.
        Unspecified = 0,
        /// A contact episode over the threshold.
        Impact = 1,
        /// The gate kept an impact from a solver.
        Gate = 2,
        /// A fracture job was handed to the pool.
        JobOpened = 3,
        /// A fracture job has its verdict.
        JobSettled = 4,
        /// A body was replaced by fragments.
        Fractured = 5,
        /// A body stayed whole after a job.
        KeptWhole = 6,
        /// A body left the world.
        Removed = 7,
        /// What the scene expected, and whether it held.
        Expectation = 8,
        /// The last step was taken.
        Finished = 9,
        /// A body was given a new shape.
        Deformed = 10,
        /// A joint broke under its load.
        JointBroken = 11,
        /// A joint went with one of its bodies, which broke or left the world.
        JointGone = 12,
        /// The work that a driven body did on others in the run; told at its end.
        Driven = 13,
    }
}

message! {
    /// One solid, recorded once and named by the digest of its content. Nothing is rounded.
    Geometry {
        /// BLAKE3 of the content, 32 bytes: equal solids have equal digests.
        "1" [bytes = "vec"] hash: Vec<u8>,
        /// x, y, z of each vertex in the body's frame \[m\].
        "2" [double, repeated] vertices: Vec<f64>,
        /// Three vertex indices a triangle, counter-clockwise seen from outside.
        "3" [uint32, repeated] triangles: Vec<u32>,
        /// One byte a triangle: 0 the surface the object was made with, 1 a crack face.
        "4" [bytes = "vec"] crack: Vec<u8>,
        /// For each crack triangle in order: the interior vertices at its three corners. An
        /// interior vertex is a vertex as crack faces see it, doubled where charts meet.
        "10" [uint32, repeated] corner: Vec<u32>,
        /// Of each interior vertex: the vertex that it lies at.
        "11" [uint32, repeated] interior_vertex: Vec<u32>,
        /// Of each interior vertex: its two texture coordinates \[m\].
        "12" [float, repeated] uv: Vec<f32>,
        /// Of each interior vertex: time from the impact to full damage \[s\].
        "13" [float, repeated] damage_time: Vec<f32>,
        /// Of each interior vertex: speed of the crack front, 1/|∇τ| \[m/s\]; 0 where not known.
        "14" [float, repeated] front_speed: Vec<f32>,
        /// Of each interior vertex: the body that broke there plus one, that is `Body.id` + 1; 0
        /// where not known.
        "15" [uint32, repeated] parent: Vec<u32>,
        /// Of each interior vertex: the material inside, as its place among the keys of the
        /// metadata record `materials` in order, from 1 on; 0 where not known.
        "16" [uint32, repeated] material: Vec<u32>,
    }
}

message! {
    /// A body or fragment at its birth.
    Body {
        /// Its number, never reused in a run.
        "1" [uint64] id: u64,
        /// Its own name.
        "2" [string] name: String,
        /// Name of the object of the scene that it is, or is a part of.
        "3" [string] object: String,
        /// The body that it broke from.
        "4" [uint64, optional] parent: Option<u64>,
        /// How many fractures lie between it and the object.
        "5" [uint32] generation: u32,
        /// What may still happen to it.
        "6" [enumeration = "Tier"] tier: i32,
        /// Name of its material.
        "7" [string] material: String,
        /// Digest of its [`Geometry`].
        "8" [bytes = "vec"] geometry: Vec<u8>,
        /// Mass \[kg\].
        "9" [double] mass: f64,
        /// Volume \[m³\].
        "10" [double] volume: f64,
        /// True if nothing moves it.
        "11" [bool] fixed: bool,
        /// The step at which it appeared.
        "12" [uint64] birth_step: u64,
    }
}

message! {
    /// Where bodies are after a step: one row a body whose state changed since its last row.
    BodyPoses {
        /// Steps taken.
        "1" [uint64] step: u64,
        /// Simulated time \[s\].
        "2" [double] time: f64,
        /// The bodies of the rows.
        "3" [uint64, repeated] ids: Vec<u64>,
        /// x, y, z of each centre of mass \[m\].
        "4" [double, repeated] positions: Vec<f64>,
        /// x, y, z, w of each unit quaternion, body frame to world frame.
        "5" [double, repeated] rotations: Vec<f64>,
        /// x, y, z of each velocity of the centre of mass \[m/s\].
        "6" [double, repeated] velocities: Vec<f64>,
        /// x, y, z of each angular velocity \[rad/s\].
        "7" [double, repeated] spins: Vec<f64>,
    }
}

message! {
    /// Grains of debris after a step: those that are new, or those that moved. A grain has its row
    /// in `ids` or in `flying`; one without a row lies where it was.
    Grains {
        /// Steps taken.
        "1" [uint64] step: u64,
        /// Simulated time \[s\].
        "2" [double] time: f64,
        /// Grains that are new, that came to rest, or whose motion was changed; numbers of their
        /// own, never reused in a run. In older recordings all that do not lie for good.
        "3" [uint64, repeated] ids: Vec<u64>,
        /// x, y, z of each of `ids` \[m\].
        "4" [double, repeated] positions: Vec<f64>,
        /// x, y, z of the velocity of each of `ids` \[m/s\].
        "5" [double, repeated] velocities: Vec<f64>,
        /// Of new ones only: the mass of each \[kg\].
        "6" [double, repeated] masses: Vec<f64>,
        /// Of new ones only: the diameter of each \[m\].
        "7" [double, repeated] sizes: Vec<f64>,
        /// Of new ones only: the body that each broke from.
        "8" [uint64, repeated] parents: Vec<u64>,
        /// Grains that flew freely through this step: to the last bit of a double v grew by g Δt,
        /// then p by v Δt. Each product is rounded, then each sum.
        "9" [uint64, repeated] flying: Vec<u64>,
        /// x, y, z of each of `flying`, rounded to the nearest float \[m\].
        "10" [float, repeated] flown_positions: Vec<f32>,
        /// x, y, z of the velocity of each of `flying`, rounded likewise \[m/s\].
        "11" [float, repeated] flown_velocities: Vec<f32>,
        /// The first grain that does not lie for good; the digest has a row of each from it to
        /// `last`. Nothing where the message has such a row of each of them in `ids`.
        "12" [uint64, optional] first: Option<u64>,
        /// The last grain that was there a step before.
        "13" [uint64, optional] last: Option<u64>,
    }
}

message! {
    /// Cracks that end inside a body, as an open surface: with its birth, or after a job that left
    /// it whole; several messages of one body add up.
    Cracks {
        /// The body.
        "1" [uint64] body: u64,
        /// Steps taken.
        "2" [uint64] step: u64,
        /// Simulated time \[s\].
        "3" [double] time: f64,
        /// x, y, z of each vertex in the body's frame \[m\].
        "4" [double, repeated] vertices: Vec<f64>,
        /// Three vertex indices a triangle; which side is seen means nothing.
        "5" [uint32, repeated] triangles: Vec<u32>,
        /// Of each vertex: time from the impact to full damage \[s\].
        "6" [float, repeated] damage_time: Vec<f32>,
        /// Of each vertex: speed of the crack front \[m/s\]; 0 where not known.
        "7" [float, repeated] front_speed: Vec<f32>,
    }
}

message! {
    /// One hit that a job was asked about, in the body's own frame.
    Hit {
        /// Where \[m\].
        "1" [message, optional] point: Option<Vector3>,
        /// Unit direction of the push, into the body.
        "2" [message, optional] normal: Option<Vector3>,
        /// Impulse over the contact episode \[N·s\].
        "3" [double] impulse: f64,
        /// Hertz contact duration \[s\].
        "4" [double] duration: f64,
        /// Hertz contact radius \[m\].
        "5" [double] radius: f64,
        /// Kinetic energy of the approach \[J\].
        "6" [double] energy: f64,
        /// How fast the surfaces closed before they touched \[m/s\].
        "7" [double] closing_speed: f64,
    }
}

message! {
    /// How a fracture job came out: the same bytes whoever computed it, and how often.
    JobReport {
        /// Digest of the problem.
        "1" [bytes = "vec"] job: Vec<u8>,
        /// The body in question.
        "2" [uint64] body: u64,
        /// The hits.
        "3" [message, repeated] hits: Vec<Hit>,
        /// The family that was asked first.
        "4" [string] asked: String,
        /// The family that gave the answer.
        "5" [string] solver: String,
        /// How it ended.
        "6" [enumeration = "Verdict"] verdict: i32,
        /// What a solver that declined or failed had to say; empty otherwise.
        "7" [string] refusal: String,
        /// Fragments delivered.
        "8" [uint32] fragments: u32,
        /// Grid spacing h \[m\]; zero where a method has none.
        "9" [double] spacing: f64,
        /// Material points.
        "10" [uint64] particles: u64,
        /// Time steps.
        "11" [uint64] steps: u64,
        /// Time simulated by the solver \[s\].
        "12" [double] simulated: f64,
        /// Area of the crack between fragments \[m²\], counted once.
        "13" [double] crack_area: f64,
        /// G_f times that area \[J\].
        "14" [double] fracture_energy: f64,
        /// Energy the damage law dissipated \[J\].
        "15" [double] dissipated_energy: f64,
        /// Stress at which cracks grow over σ_f \[1\].
        "16" [double] strength_ratio: f64,
        /// Share of particles with damage above one half \[1\].
        "17" [double] damaged_fraction: f64,
        /// Impulse that the solve put into the body \[N·s\].
        "18" [double] delivered_impulse: f64,
        /// What the detectors noticed and let pass.
        "19" [string, repeated] warnings: Vec<String>,
        /// What only the family knows, beside fields 16 to 18.
        "20" [message, repeated] details: Vec<ReportFigure>,
    }
}

message! {
    /// A number that a family of solvers reports beside what all of them do.
    ReportFigure {
        /// What it is.
        "1" [string] name: String,
        /// Its SI unit; 1 where it has none.
        "2" [string] unit: String,
        /// The value itself.
        "3" [double] value: f64,
    }
}

message! {
    /// The new shape of a body that was deformed and did not break. Its body frame is a new one,
    /// with its origin at the new centre of mass, from the pose of this step on.
    NewShape {
        /// Steps taken.
        "1" [uint64] step: u64,
        /// Simulated time \[s\].
        "2" [double] time: f64,
        /// The body.
        "3" [uint64] body: u64,
        /// Digest of its new [`Geometry`].
        "4" [bytes = "vec"] geometry: Vec<u8>,
        /// Mass \[kg\].
        "5" [double] mass: f64,
        /// Volume \[m³\].
        "6" [double] volume: f64,
    }
}

message! {
    /// Which fragments of a fracture were sampled, that is drawn from a law, or directed, that is
    /// divided or joined because the scene asked for it, and not solved.
    /// Decides nothing and is left out of the digest.
    Sampled {
        /// Steps taken.
        "1" [uint64] step: u64,
        /// Simulated time \[s\].
        "2" [double] time: f64,
        /// The body that broke.
        "3" [uint64] body: u64,
        /// Its fragments that were sampled; those that were neither sampled nor directed were
        /// solved.
        "4" [uint64, repeated] fragments: Vec<u64>,
        /// Digest of the problem that was solved.
        "5" [bytes = "vec"] job: Vec<u8>,
        /// Volume of the fragments that were solved \[m³\].
        "6" [double] solved_volume: f64,
        /// Volume of the fragments that were sampled, and of the debris \[m³\].
        "7" [double] sampled_volume: f64,
        /// Crack area of the fragments that were solved: half of their faces \[m²\].
        "8" [double] solved_crack_area: f64,
        /// Crack area of those that were sampled, likewise \[m²\].
        "9" [double] sampled_crack_area: f64,
        /// Its fragments that were directed.
        "10" [uint64, repeated] directed: Vec<u64>,
        /// Volume of those that were directed \[m³\].
        "11" [double] directed_volume: f64,
        /// Crack area of those that were directed, likewise \[m²\].
        "12" [double] directed_crack_area: f64,
    }
}

message! {
    /// Who computed a job and for how long. Decides nothing and is left out of the digest.
    PoolReport {
        /// Digest of the problem.
        "1" [bytes = "vec"] job: Vec<u8>,
        /// The worker whose result counted.
        "2" [string] worker: String,
        /// Wall time from opening to result \[s\].
        "3" [double] wall_seconds: f64,
        /// How often the job was handed out again.
        "4" [uint32] resent: u32,
        /// True if a kept result was used.
        "5" [bool] cached: bool,
    }
}

message! {
    /// What a replacement kept and what it cost.
    #[derive(Copy)]
    Ledger {
        /// |Σ mass − mass| over mass \[1\].
        "1" [double] mass_rel_error: f64,
        /// |Σ volume − volume| over volume \[1\].
        "2" [double] volume_rel_error: f64,
        /// Change of the linear momentum of the pair, relative \[1\].
        "3" [double] momentum_rel_error: f64,
        /// Change of the angular momentum of the pair, relative \[1\].
        "4" [double] angular_momentum_rel_error: f64,
        /// Kinetic energy of the pair before \[J\].
        "5" [double] energy_before: f64,
        /// Kinetic energy of the pair and fragments after \[J\].
        "6" [double] energy_after: f64,
        /// G_f·A debited \[J\].
        "7" [double] fracture_energy: f64,
        /// (after + fracture energy − before) over before where positive, else 0 \[1\].
        "8" [double] energy_gain_rel: f64,
    }
}

message! {
    /// Something that happened in the run. Which fields are set depends on `kind`.
    RunEvent {
        /// What kind of event it is.
        "1" [enumeration = "EventKind"] kind: i32,
        /// Steps taken.
        "2" [uint64] step: u64,
        /// Simulated time \[s\].
        "3" [double] time: f64,
        /// The body that it happened to.
        "4" [uint64, optional] body: Option<u64>,
        /// The other body of an impact or of a joint.
        "5" [uint64, optional] striker: Option<u64>,
        /// Digest of the problem; empty where there is none.
        "6" [bytes = "vec"] job: Vec<u8>,
        /// A reason, a refusal, an expectation or what of a joint gave way, in words.
        "7" [string] text: String,
        /// Where, in the world \[m\].
        "8" [message, optional] point: Option<Vector3>,
        /// Impulse of an impact \[N·s\].
        "9" [double] impulse: f64,
        /// Closing speed of an impact \[m/s\].
        "10" [double] closing_speed: f64,
        /// Kinetic energy of the approach; the work of a driven body \[J\].
        "11" [double] energy: f64,
        /// The fragments of a fracture.
        "12" [uint64, repeated] fragments: Vec<u64>,
        /// Factor α applied to the fragments' own velocities so that energy does not grow \[1\].
        "13" [double] alpha: f64,
        /// What a fracture kept and cost.
        "14" [message, optional] ledger: Option<Ledger>,
        /// How a job ended.
        "15" [enumeration = "Verdict"] verdict: i32,
        /// Whether an expectation held.
        "16" [bool] held: bool,
        /// Grains of debris of a fracture.
        "17" [uint64] grains: u64,
        /// Their mass \[kg\].
        "18" [double] grain_mass: f64,
        /// Hertz contact duration of an impact \[s\].
        "19" [double] duration: f64,
        /// Greatest Hertz contact radius \[m\].
        "20" [double] radius: f64,
        /// Greatest Hertz force \[N\].
        "21" [double] peak_force: f64,
        /// Kinetic energy that the contact took out of the pair \[J\].
        "22" [double] dissipated: f64,
        /// The joint that broke or went.
        "23" [uint64, optional] joint: Option<u64>,
        /// Force that broke a joint, the mean over a step \[N\].
        "24" [double] force: f64,
        /// Moment that it bore with it \[N·m\].
        "25" [double] torque: f64,
        /// The load of a joint that broke over what it bears \[1\].
        "26" [double] load_share: f64,
        /// Whether a job is of a hit to which the scene gave settings of its own; of its first job
        /// alone.
        "27" [bool] directed: bool,
    }
}

message! {
    /// Numbers worth a plot.
    RunStats {
        /// Steps taken.
        "1" [uint64] step: u64,
        /// Simulated time \[s\].
        "2" [double] time: f64,
        /// Bodies in the world.
        "3" [uint64] bodies: u64,
        /// Fragments made so far.
        "4" [uint64] fragments: u64,
        /// Fractures so far.
        "5" [uint64] fractures: u64,
        /// Jobs opened and not settled.
        "6" [uint64] jobs_open: u64,
        /// Σ ½ m v² of the moving bodies, rotation left out \[J\].
        "7" [double] translational_energy: f64,
    }
}

pub(super) fn declarations() -> Declarations {
    let mut messages = vec![
        vector::declaration(),
        Geometry::declaration(),
        Body::declaration(),
        BodyPoses::declaration(),
        Grains::declaration(),
        Cracks::declaration(),
        Hit::declaration(),
        JobReport::declaration(),
        ReportFigure::declaration(),
        NewShape::declaration(),
        Sampled::declaration(),
        PoolReport::declaration(),
        Ledger::declaration(),
        RunEvent::declaration(),
        RunStats::declaration(),
    ];
    messages.extend(appearance::declarations());
    let (joint, joint_type) = joints::declarations();
    messages.push(joint);
    let (tier, verdict, event) =
        (Tier::declaration(), Verdict::declaration(), EventKind::declaration());
    let enums = vec![tier, verdict, event, joint_type];
    Declarations { messages, enums }
}

/// The schema that messages of ours are recorded with: a `FileDescriptorSet`. Those of sheets are
/// in [`super::sheet_schema_bytes`].
#[must_use]
pub fn schema_bytes() -> Vec<u8> {
    declarations().to_bytes()
}
