//! A specimen, checked and complete.

use super::format::{Ends, Expected, Metric};
use super::whole::Whole;
use cullet_proto::specimen::SpecimenJob;
use cullet_specimen::{PointField, SpecimenSettings};

/// A specimen, checked and complete.
#[derive(Clone, Debug)]
pub struct Specimen {
    /// The name of its file.
    pub name: String,
    /// What it shows, in a line.
    pub description: String,
    /// The family of solvers, or `world`.
    pub solver: String,
    /// What is to be solved or run.
    pub subject: Subject,
    /// Names of the probes, with their units.
    pub probes: Vec<(String, &'static str)>,
    /// Probes whose samples are places that become speeds, and over how long each is taken \[s\].
    pub speeds: Vec<(usize, f64)>,
    /// What is made of the samples, each with the number of its probe.
    pub metrics: Vec<(Metric, usize)>,
    /// What they must come to, beside each metric.
    pub expected: Vec<Option<Expected>>,
    /// How it must end.
    pub ends: Ends,
    /// Why the body cannot be made, if so: then the job has none.
    pub flaw: Option<String>,
    /// What is unusual, a line each.
    pub warnings: Vec<String>,
}

/// What a specimen is about.
#[derive(Clone, Debug)]
pub enum Subject {
    /// A body under supports and loads.
    Body(Box<SpecimenJob>),
    /// A scene, with all that the product does of it.
    Whole(Box<Whole>),
}

impl Specimen {
    /// What is to be solved, where that is a body.
    #[must_use]
    pub fn job(&self) -> Option<&SpecimenJob> {
        match &self.subject {
            Subject::Body(job) => Some(job),
            Subject::Whole(_) => None,
        }
    }

    /// The settings of its solver, where it is a body.
    #[must_use]
    pub fn settings(&self) -> Option<&SpecimenSettings> {
        self.job().map(|job| &job.0.settings)
    }

    /// What the colours of its points tell, with the unit; nothing where it is no body.
    #[must_use]
    pub fn colour(&self) -> &'static str {
        let field = self.job().map(|job| job.0.output.colour.0);
        field.map_or("", |field| match field {
            PointField::Damage => "damage [1]",
            PointField::Stress => "greatest principal stress [Pa]",
            PointField::Velocity => "speed [m/s]",
            PointField::Displacement => "displacement [m]",
            PointField::Strain => "strain [1]",
            PointField::PlasticStrain => "plastic strain [1]",
            PointField::VolumeRatio => "volume ratio [1]",
        })
    }

    /// Digest of what is solved or run; why there is none otherwise.
    #[must_use]
    pub fn id(&self) -> String {
        match &self.subject {
            Subject::Body(job) => job.id().map_or_else(|why| why.to_string(), |id| id.to_string()),
            Subject::Whole(whole) => whole.id.to_string(),
        }
    }
}
