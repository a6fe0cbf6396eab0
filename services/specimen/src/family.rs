//! The row of a family in the table of those that solve specimens, and what keeps a specimen from
//! one.

use crate::discretisation::Discrete;
use crate::frame::GridFrame;
use crate::probe::{PointField, Probe};
use crate::problem::{LoadKind, SpecimenProblem};
use cullet_model::{PointPrecision, Refusal};
use std::fmt;

/// What a specimen may ask for and not every family has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// A field of the points.
    Field(PointField),
    /// What points are worked out in.
    Precision(PointPrecision),
    /// A load on the surface.
    Traction,
    /// A load on the surface, along its normal.
    Pressure,
    /// A load on all mass of a part together.
    Force,
    /// A load on all mass of a part by kilogramme.
    Acceleration,
    /// A prescribed velocity.
    Support,
    /// A plane that stands for the other half.
    Symmetry,
    /// Velocities that fall off by themselves.
    Damping,
    /// A displacement gradient at the start.
    Stretch,
    /// Velocities at the start.
    Start,
    /// Cracks at the start.
    Notch,
    /// A material that breaks.
    Breaking,
    /// A material that yields.
    Flow,
    /// Parts of other materials.
    Zone,
    /// Parts that are stronger, weaker or damaged.
    Patch,
    /// Several bodies that touch.
    Bodies,
    /// A specimen that is turned against the grid.
    Turn,
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Field(field) => return write!(f, "field {}", field.name()),
            Self::Precision(PointPrecision::Single) => "precision single",
            Self::Precision(PointPrecision::Double) => "precision double",
            Self::Traction => "load by traction",
            Self::Pressure => "load by pressure",
            Self::Force => "load by force",
            Self::Acceleration => "load by acceleration",
            Self::Support => "support",
            Self::Symmetry => "plane of symmetry",
            Self::Damping => "damping",
            Self::Stretch => "displacement gradient at the start",
            Self::Start => "velocity at the start",
            Self::Notch => "notch",
            Self::Breaking => "material that breaks",
            Self::Flow => "material that yields",
            Self::Zone => "zone of another material",
            Self::Patch => "patch",
            Self::Bodies => "second body",
            Self::Turn => "specimen turned against its grid",
        })
    }
}

impl SpecimenProblem {
    /// Everything that this problem asks for.
    #[must_use]
    pub fn features(&self) -> Vec<Feature> {
        let s = &self.settings;
        let mut asked = vec![Feature::Precision(s.precision)];
        let mut ask = |some: bool, feature: Feature| asked.extend(some.then_some(feature));
        ask(!self.body.parts.is_empty(), Feature::Bodies);
        ask(!GridFrame::new(&self.body).is_straight(), Feature::Turn);
        ask(!self.matter.zones.is_empty(), Feature::Zone);
        ask(!self.matter.patches.is_empty(), Feature::Patch);
        ask(s.breaks, Feature::Breaking);
        ask(self.matter.flow.is_some(), Feature::Flow);
        ask(s.damping > 0.0, Feature::Damping);
        ask(self.initial.stretch.norm_squared() > 0.0, Feature::Stretch);
        ask(!self.initial.starts.is_empty(), Feature::Start);
        ask(!self.initial.notches.is_empty(), Feature::Notch);
        ask(!self.holds.is_empty(), Feature::Support);
        ask(!self.symmetries.is_empty(), Feature::Symmetry);
        asked.extend(self.loads.iter().map(|load| match load.push {
            LoadKind::Traction(_) => Feature::Traction,
            LoadKind::Pressure(_) => Feature::Pressure,
            LoadKind::Force(_) => Feature::Force,
            LoadKind::Acceleration(_) => Feature::Acceleration,
        }));
        asked.extend(self.output.probes.iter().filter_map(Probe::field).map(Feature::Field));
        let colour = (self.output.frames > 0).then_some(Feature::Field(self.output.colour.0));
        asked.extend(colour);
        asked
    }
}

/// Why a specimen is not solved. Normal: it is reported with the run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unfit {
    /// Nobody has that name.
    #[error("there is no family \"{name}\" for specimens; there are: {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// The family does not have what the specimen asks for.
    #[error("the family \"{family}\" has no {feature}; it has: {has}")]
    Lacks {
        /// The family.
        family: &'static str,
        /// What it has not.
        feature: Feature,
        /// What it has of the kind.
        has: String,
    },
    /// A bound is broken.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// A family: a row of the table of those that solve specimens.
#[derive(Clone, Copy, Debug)]
pub struct SpecimenFamily {
    /// Its name in files.
    pub name: &'static str,
    /// What it has.
    pub features: &'static [Feature],
    /// Makes a specimen discrete, or says which bound it breaks.
    pub build: fn(&SpecimenProblem) -> Result<Discrete, Refusal>,
}

impl SpecimenFamily {
    /// Whether it has all that a problem asks for.
    ///
    /// # Errors
    /// The first thing that it has not, and what it has of that kind.
    pub fn check(&self, problem: &SpecimenProblem) -> Result<(), Unfit> {
        let asked = problem.features();
        let Some(&feature) = asked.iter().find(|feature| !self.features.contains(feature)) else {
            return Ok(());
        };
        let same = |other: &&Feature| match (feature, **other) {
            (Feature::Field(_), Feature::Field(_)) => true,
            (Feature::Precision(_), Feature::Precision(_)) => true,
            (Feature::Field(_) | Feature::Precision(_), _) => false,
            (_, other) => !matches!(other, Feature::Field(_) | Feature::Precision(_)),
        };
        let has: Vec<String> = self.features.iter().filter(same).map(Feature::to_string).collect();
        let has = if has.is_empty() { "none".to_owned() } else { has.join(", ") };
        Err(Unfit::Lacks { family: self.name, feature, has })
    }
}

/// The family of a name in a table.
///
/// # Errors
/// There is none; the names that there are.
pub fn by_name<'a>(table: &'a [SpecimenFamily], name: &str) -> Result<&'a SpecimenFamily, Unfit> {
    table.iter().find(|family| family.name == name).ok_or_else(|| {
        let known: Vec<&str> = table.iter().map(|family| family.name).collect();
        Unfit::Unknown { name: name.to_owned(), known: known.join(", ") }
    })
}
