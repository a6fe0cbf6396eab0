//! The specimen loader: a TOML file to a job that any process can solve, or every error at once.
//!
//! Units, overrides, materials and errors are those of scenes; `format` is the one source of the
//! schema and of the reader; `metric` makes numbers of what comes back.

mod asked;
pub mod format;
mod materials;
mod metric;
mod resolve;
#[cfg(test)]
mod tests;
mod watch;
pub mod whole;

pub use format::{Ends, Expected, Metric, Reduction};
pub use metric::{Verdict, Weighed, reduce, speeds, weigh};

use cullet_document::error::{SceneError, SceneErrors};
use cullet_document::files::{Files, SCENE_BASE, Source};
use cullet_document::overrides::{Known, apply_overrides};
use cullet_document::tree::Node;
use cullet_document::{check, document};
use cullet_proto::specimen::{Field, Settings, SpecimenJob};
use cullet_scene::is_preset;
use cullet_scene::schema::{plain_brackets, printed};
use serde_json::Value as Json;
use std::path::Path;
use std::sync::OnceLock;
use whole::Whole;

/// The sections whose keys may be given without it.
const SHORT: [&str; 2] = ["solver", "run"];

/// A specimen, checked and complete.
#[derive(Clone, Debug)]
pub struct Specimen {
    /// The name of its file.
    pub name: String,
    /// What it shows, in a line.
    pub description: String,
    /// Which solver.
    pub solver: &'static str,
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
    pub fn settings(&self) -> Option<&Settings> {
        self.job().map(|job| &job.setup.settings)
    }

    /// What the colours of its points tell, with the unit; nothing where it is no body.
    #[must_use]
    pub fn colour(&self) -> &'static str {
        let field = self.job().map(|job| job.setup.colour.0);
        field.map_or("", |field| match field {
            Field::Damage => "damage [1]",
            Field::Stress => "greatest principal stress [Pa]",
            Field::Velocity => "speed [m/s]",
            Field::Displacement => "displacement [m]",
            Field::Strain => "strain [1]",
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

/// Loads a specimen. `overrides` are `path=value` arguments, applied in order; a path of one name
/// is one of `[solver]` or `[run]`.
///
/// # Errors
/// Everything that is wrong with it, in the order of the text.
pub fn load(path: &Path, overrides: &[String]) -> Result<Specimen, SceneErrors> {
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    let Some(base) = path.file_name().map(|name| name.to_string_lossy().into_owned()) else {
        let message = format!("{} is no file", path.display());
        return Err(SceneErrors { errors: vec![SceneError::without_place(message)] });
    };
    let name = path.file_stem().map_or_else(|| base.clone(), |s| s.to_string_lossy().into_owned());
    let mut files = Files::new(Source::Disk { folder });
    let (root, text, errors) = document::read(&mut files, &format!("{SCENE_BASE}{base}"));
    if text.is_none() {
        return Err(SceneErrors { errors });
    }
    if root.get(document::SCENE).is_some() {
        return whole::build(name, path, &mut files, (root, errors), overrides);
    }
    build(name, &mut files, (root, errors), overrides)
}

fn build(
    name: String,
    files: &mut Files,
    (mut root, mut errors): (Node, Vec<SceneError>),
    overrides: &[String],
) -> Result<Specimen, SceneErrors> {
    let schema = schema_json();
    let keys = |node: &Json| -> Vec<String> {
        let keys = check::resolve(schema, node)["properties"].as_object();
        keys.map(|keys| keys.keys().cloned().collect()).unwrap_or_default()
    };
    // What `spelled_out` leaves alone is no key of these: they are there to be suggested.
    let short = SHORT.iter().flat_map(|name| keys(&schema["properties"][*name]));
    let sections: Vec<String> = keys(schema).into_iter().chain(short).collect();
    let sections: Vec<&str> = sections.iter().map(String::as_str).collect();
    let full: Vec<String> = overrides.iter().map(|text| spelled_out(schema, text)).collect();
    errors.extend(apply_overrides(&mut root, Known { sections: &sections, is_preset }, &full));
    let findings = check::check(schema, &mut root);
    errors.extend(findings.errors.iter().cloned());
    if !errors.is_empty() {
        return Err(SceneErrors::sorted(errors));
    }
    let resolved = resolve::resolve(&root, files);
    match resolved {
        Ok(specimen) => Ok(Specimen { name, ..specimen }),
        Err(errors) => Err(SceneErrors::sorted(errors)),
    }
}

/// `spacing=…` for `solver.spacing=…`.
fn spelled_out(schema: &Json, argument: &str) -> String {
    let name = argument.split('=').next().unwrap_or_default().trim();
    let has = |section: &str| {
        let section = check::resolve(schema, &schema["properties"][section]);
        section["properties"].get(name).is_some()
    };
    match SHORT.into_iter().find(|section| has(section)) {
        Some(section) => format!("{section}.{argument}"),
        None => argument.to_owned(),
    }
}

fn schema_json() -> &'static Json {
    static SCHEMA: OnceLock<Json> = OnceLock::new();
    SCHEMA.get_or_init(|| {
        let mut schema = schemars::schema_for!(format::Document).to_value();
        schema["title"] = Json::String("A Cullet specimen".to_owned());
        plain_brackets(&mut schema);
        schema
    })
}

/// The schema that editors take: `cullet schema --specimen` prints it.
#[must_use]
pub fn schema() -> String {
    printed(schema_json())
}
