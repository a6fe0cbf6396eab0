//! From a standing set to the runs that its charts need.

use super::super::sweep::SweptSetting;
use super::format::{ChartForm, FrontierDocument, OptionForm};
use crate::specimen::{self, Specimen};
use cullet_document::error::{SceneError, SceneErrors};
use cullet_document::sheet::{ConfigDocument, schema_of};
use serde_json::Value as Json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Least seeds of an ensemble: fewer say nothing of a chaotic outcome (F78).
pub const LEAST_SEEDS: u32 = 8;

/// Values along a curve, and seeds, of a quick run.
const QUICK: (usize, u32) = (2, 2);

/// The name of the curve that a scene's runs are compared with.
pub const FINEST: &str = "finest";

/// What a scene's charts measure: how far masses are from those of the run [`FINEST`].
pub const MASSES: &str = "mass distance";

/// Or how far the resolved ones are from Mott's law (G2).
pub(super) const MOTT: &str = "KS of Mott's law";

/// Or how many of the pieces at the end were sampled, not solved.
pub(super) const PIECES: &str = "share of pieces sampled";

/// Or how much of their mass.
pub(super) const MASS: &str = "share of mass sampled";

/// What changes along a curve of a scene: its points, times this.
const POINTS: &str = "points";

/// What a run of a chart solves.
#[derive(Clone, Debug)]
pub enum ChartWork {
    /// A specimen, with its overrides.
    Specimen(Box<Specimen>),
    /// A scene and its overrides.
    Scene(PathBuf, Vec<String>),
}

/// One run of one point of a chart.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The curve.
    pub option: String,
    /// Where on it.
    pub along: String,
    /// Which seed.
    pub seed: u64,
    /// Whether this is the default setting.
    pub standard: bool,
    /// What is measured.
    pub metric: String,
    /// What to solve.
    pub work: ChartWork,
    /// Equal for equal work.
    pub id: String,
}

/// A chart, ready to be run or drawn.
#[derive(Clone, Debug)]
pub struct FrontierChart {
    /// Its name, and that of its files.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// The specimen or scene.
    pub bench: String,
    /// What is measured.
    pub metric: String,
    /// What it must come to.
    pub reference: f64,
    /// Where that comes from.
    pub source: String,
    /// What errors are divided by.
    pub scale: f64,
    /// Whose fragments, of a scene.
    pub object: Option<String>,
    /// Its runs, a curve after the other, the coarsest first.
    pub runs: Vec<Planned>,
}

/// A standing set.
#[derive(Clone, Debug)]
pub struct Set {
    /// What it is for.
    pub description: String,
    /// Its charts, in the order of the file.
    pub charts: Vec<FrontierChart>,
}

fn schema_json() -> &'static Json {
    static SCHEMA: OnceLock<Json> = OnceLock::new();
    SCHEMA.get_or_init(|| schema_of::<FrontierDocument>("A Cullet standing set"))
}

/// The schema that editors take: `cullet schema --frontier` prints it.
#[must_use]
pub fn schema() -> String {
    cullet_document::printed(schema_json())
}

/// Loads a standing set; `only` its charts of these names, all if there are none. A quick one has
/// the two coarsest points of each curve with two seeds at most.
///
/// # Errors
/// Everything that is wrong with it and with the specimens and scenes that it names.
pub fn load(path: &Path, only: &[String], quick: bool) -> Result<Set, SceneErrors> {
    let (document, sheet) = ConfigDocument::read::<FrontierDocument>(path, schema_json())?;
    let names: Vec<&str> = document.chart.iter().map(|chart| chart.name.as_str()).collect();
    let unknown = only.iter().find(|name| !names.contains(&name.as_str()));
    let mut desk = SetBuilder {
        sheet,
        folder: path.parent().unwrap_or(Path::new("")),
        quick,
        errors: Vec::new(),
    };
    if let Some(name) = unknown {
        let message = format!("there is no chart \"{name}\" in it; known: {}", names.join(", "));
        desk.errors.push(SceneError::without_place(message));
    }
    if document.chart.is_empty() {
        desk.wrong("", "a standing set has a `[[chart]]` at least");
    }
    let (mut charts, mut known) = (Vec::new(), BTreeSet::new());
    for (k, form) in document.chart.iter().enumerate() {
        let at = format!("chart[{k}]");
        desk.name(&form.name, &at);
        if !known.insert(form.name.as_str()) {
            desk.wrong(&format!("{at}.name"), format!("\"{}\" is taken", form.name));
        }
        if only.is_empty() || only.contains(&form.name) {
            charts.extend(desk.chart(form, &at));
        }
    }
    if !desk.errors.is_empty() {
        return Err(ConfigDocument::all(desk.errors));
    }
    Ok(Set { description: document.description, charts })
}

/// A curve on its way to its runs.
struct Curve<'a> {
    at: String,
    name: &'a str,
    set: &'a [String],
    metric: Option<&'a str>,
    key: String,
    values: Vec<String>,
    first: bool,
}

struct SetBuilder<'a> {
    sheet: ConfigDocument,
    folder: &'a Path,
    quick: bool,
    errors: Vec<SceneError>,
}

impl SetBuilder<'_> {
    fn wrong(&mut self, at: &str, message: impl Into<String>) {
        let error = self.sheet.wrong(at, message);
        self.errors.push(error);
    }

    fn name(&mut self, name: &str, at: &str) {
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if name.is_empty() || name.len() > 64 || !name.chars().all(fits) {
            let message = format!("\"{name}\" must be 1 to 64 letters, digits, `-` or `_`");
            self.wrong(&format!("{at}.name"), message);
        }
    }

    fn chart(&mut self, form: &ChartForm, at: &str) -> Option<FrontierChart> {
        let before = self.errors.len();
        if (2..LEAST_SEEDS).contains(&form.seeds) {
            let message = format!("must be 1, or at least {LEAST_SEEDS}; it is {}", form.seeds);
            self.wrong(&format!("{at}.seeds"), message);
        }
        let (mut chart, file) = match (&form.specimen, &form.scene) {
            (Some(specimen), None) => self.specimen(form, at, &self.folder.join(specimen))?,
            (None, Some(scene)) => self.scene(form, at, &self.folder.join(scene))?,
            _ => {
                self.wrong(at, "takes `specimen` or `scene`, one of them");
                return None;
            }
        };
        for curve in self.curves(form, at) {
            let metric = self.metric(&curve, &chart.metric);
            self.runs(form, (&curve, &metric), &file, &mut chart.runs);
        }
        if form.scene.is_some() && chart.metric == MASSES {
            let set = [&form.set[..], &form.finest[..]].concat();
            let standard = form.finest.is_empty() && form.default.is_none();
            for seed in 1..=self.seeds(form) {
                let mut overrides = set.clone();
                overrides.push(format!("world.seed={seed}"));
                let work = ChartWork::Scene(file.clone(), overrides);
                chart.runs.push(planned((FINEST, FINEST), MASSES, (seed, standard), work));
            }
        }
        let marked = chart.runs.iter().any(|run| run.standard);
        if let Some(value) = form.default.as_ref().filter(|_| !marked) {
            let message = format!("\"{value}\" is not along the first option's curve");
            self.wrong(&format!("{at}.default"), message);
        }
        (self.errors.len() == before).then_some(chart)
    }

    fn seeds(&self, form: &ChartForm) -> u64 {
        u64::from(if self.quick { form.seeds.min(QUICK.1) } else { form.seeds })
    }

    fn specimen(
        &mut self,
        form: &ChartForm,
        at: &str,
        file: &Path,
    ) -> Option<(FrontierChart, PathBuf)> {
        let only_scenes = [("object", form.object.is_some()), (FINEST, !form.finest.is_empty())];
        for (key, _) in only_scenes.iter().filter(|(_, given)| *given) {
            self.wrong(&format!("{at}.{key}"), format!("`{key}` is for scenes"));
        }
        let specimen = match specimen::load(file, &form.set) {
            Ok(specimen) => specimen,
            Err(errors) => {
                self.wrong(&format!("{at}.specimen"), errors.to_string());
                return None;
            }
        };
        let names: Vec<&str> = specimen.metrics.iter().map(|(m, _)| m.name.as_str()).collect();
        let index = form.metric.as_ref().and_then(|name| names.iter().position(|n| n == name));
        let Some(index) = index else {
            let message = format!("the specimen's metrics are: {}", names.join(", "));
            let key = if form.metric.is_some() { ".metric" } else { "" };
            self.wrong(&format!("{at}{key}"), format!("`metric` must be one of them: {message}"));
            return None;
        };
        let expected = specimen.expected.get(index).and_then(Option::as_ref);
        let Some(reference) = form.reference.or(expected.and_then(|e| e.value)) else {
            self.wrong(at, "the specimen expects no value of that metric: give a `reference`");
            return None;
        };
        let scale = form.scale.unwrap_or(reference.abs());
        if scale == 0.0 {
            self.wrong(at, "the reference is 0: give a `scale` for errors");
        }
        let source = form.source.clone().or(expected.map(|e| e.source.clone()));
        let chart = FrontierChart {
            bench: specimen.name.clone(),
            metric: names[index].to_owned(),
            reference,
            source: source.unwrap_or_default(),
            scale,
            ..empty(form)
        };
        Some((chart, file.to_owned()))
    }

    fn scene(
        &mut self,
        form: &ChartForm,
        at: &str,
        file: &Path,
    ) -> Option<(FrontierChart, PathBuf)> {
        let metric = form.metric.as_deref().unwrap_or(MASSES);
        let known = [MASSES, MOTT, PIECES, MASS];
        if !known.contains(&metric) {
            let known = known.map(|name| format!("\"{name}\"")).join(", ");
            let message = format!("of a scene it is one of {known}, not \"{metric}\"");
            self.wrong(&format!("{at}.metric"), message);
        }
        if metric != MASSES && !form.finest.is_empty() {
            let message = format!("only \"{MASSES}\" needs a run to be held against");
            self.wrong(&format!("{at}.{FINEST}"), message);
        }
        for (key, given) in
            [("reference", form.reference.is_some()), ("scale", form.scale.is_some())]
        {
            if given {
                self.wrong(&format!("{at}.{key}"), format!("`{key}` is for specimens"));
            }
        }
        let set = [&form.set[..], &form.finest[..]].concat();
        let scene = match cullet_scene::load(file, &set) {
            Ok(scene) => scene,
            Err(errors) => {
                self.wrong(&format!("{at}.scene"), errors.to_string());
                return None;
            }
        };
        let there = |name: &&String| scene.bodies.iter().any(|body| body.name == **name);
        if let Some(object) = form.object.as_ref().filter(|name| !there(name)) {
            self.wrong(&format!("{at}.object"), format!("the scene has no body \"{object}\""));
        }
        let own = match form.finest.is_empty() {
            _ if metric == MOTT => "fitted to solved pieces of at least 64 cells".to_owned(),
            _ if metric != MASSES => "of what is there at the end".to_owned(),
            true => "its own run as it is".to_owned(),
            false => format!("its own run with {}", form.finest.join(" ")),
        };
        let source = form.source.clone().unwrap_or(own);
        let (metric, scale) = (metric.to_owned(), 1.0);
        let chart = FrontierChart { bench: scene.name, metric, source, scale, ..empty(form) };
        Some((chart, file.to_owned()))
    }

    fn curves<'f>(&mut self, form: &'f ChartForm, at: &str) -> Vec<Curve<'f>> {
        let own = |at: String, name: &'f str, option: Option<&'f OptionForm>| {
            let along = option.and_then(|option| option.along.as_ref()).unwrap_or(&form.along);
            let set = option.map_or(&[][..], |option| &option.set[..]);
            let metric = option.and_then(|option| option.metric.as_deref());
            let (key, values) = (String::new(), Vec::new());
            (Curve { at, name, set, metric, key, values, first: false }, along)
        };
        let options: Vec<(Curve<'f>, &'f String)> = if form.option.is_empty() {
            vec![own(at.to_owned(), "default", None)]
        } else {
            let with = |(k, option): (usize, &'f OptionForm)| {
                own(format!("{at}.option[{k}]"), &option.name, Some(option))
            };
            form.option.iter().enumerate().map(with).collect()
        };
        let mut known = BTreeSet::new();
        let mut curves = Vec::new();
        for (k, (curve, along)) in options.into_iter().enumerate() {
            let (at, name) = (&curve.at, curve.name);
            if name.is_empty() || name == FINEST || !known.insert(name) {
                self.wrong(at, format!("the option's name \"{name}\" is empty or taken"));
            }
            match along.parse::<SweptSetting>() {
                Ok(SweptSetting { key, mut values }) => {
                    values.truncate(if self.quick { QUICK.0 } else { usize::MAX });
                    curves.push(Curve { key, values, first: k == 0, ..curve });
                }
                Err(why) => self.wrong(&format!("{at}.along"), why),
            }
        }
        curves
    }

    /// What a curve shows: the chart's metric, or the other share of what was sampled.
    fn metric(&mut self, curve: &Curve<'_>, charts: &str) -> String {
        let Some(own) = curve.metric else { return charts.to_owned() };
        if [own, charts].iter().any(|name| ![PIECES, MASS].contains(name)) {
            let message =
                format!("a curve's own is \"{PIECES}\" or \"{MASS}\", of a chart of either");
            self.wrong(&format!("{}.metric", curve.at), message);
        }
        own.to_owned()
    }

    /// The runs of a curve.
    fn runs(
        &mut self,
        form: &ChartForm,
        (curve, metric): (&Curve<'_>, &str),
        file: &Path,
        into: &mut Vec<Planned>,
    ) {
        let plain = form.specimen.as_ref().and_then(|_| specimen::load(file, &form.set).ok());
        let seed_key = match &plain {
            Some(specimen) if specimen.job().is_some() => "seed",
            Some(_) => "scene.world.seed",
            None => "world.seed",
        };
        let own = plain.and_then(|_| {
            let seeded = [&form.set[..], &[format!("{seed_key}=1")]].concat();
            Some(specimen::load(file, &seeded).ok()?.id())
        });
        for value in &curve.values {
            let along = format!("{}={value}", curve.key);
            let mut overrides = [&form.set[..], curve.set].concat();
            let change = match form.scene.is_some() && curve.key == POINTS {
                true => multiplied(file, &overrides, value),
                false => Ok(along.clone()),
            };
            match change {
                Ok(change) => overrides.push(change),
                Err(why) => return self.wrong(&curve.at, format!("{}: {why}", curve.name)),
            }
            let named = form.default.as_ref().map(|default| default.trim() == value);
            let mut standard = false;
            for seed in 1..=self.seeds(form) {
                let mut overrides = overrides.clone();
                overrides.push(format!("{seed_key}={seed}"));
                let work = match self.work(form, file, overrides, seed == 1) {
                    Ok(work) => work,
                    Err(why) => return self.wrong(&curve.at, format!("{}: {why}", curve.name)),
                };
                if seed == 1 {
                    let same = match &work {
                        ChartWork::Specimen(specimen) => own.as_ref() == Some(&specimen.id()),
                        ChartWork::Scene(..) => false,
                    };
                    standard = curve.first && named.unwrap_or(same);
                }
                into.push(planned((curve.name, &along), metric, (seed, standard), work));
            }
        }
    }

    /// A run's work; a scene is looked at if it is the `first` of its point.
    fn work(
        &self,
        form: &ChartForm,
        file: &Path,
        overrides: Vec<String>,
        first: bool,
    ) -> Result<ChartWork, SceneErrors> {
        if form.specimen.is_some() {
            return Ok(ChartWork::Specimen(Box::new(specimen::load(file, &overrides)?)));
        }
        if first {
            cullet_scene::load(file, &overrides)?;
        }
        Ok(ChartWork::Scene(file.to_owned(), overrides))
    }
}

fn empty(form: &ChartForm) -> FrontierChart {
    FrontierChart {
        name: form.name.clone(),
        title: if form.title.is_empty() { form.name.clone() } else { form.title.clone() },
        bench: String::new(),
        metric: String::new(),
        reference: 0.0,
        source: String::new(),
        scale: 1.0,
        object: form.object.clone(),
        runs: Vec::new(),
    }
}

/// The override that gives a scene `factor` times its points.
fn multiplied(file: &Path, overrides: &[String], factor: &str) -> Result<String, String> {
    let times: f64 = factor.trim().parse().unwrap_or(f64::NAN);
    if !(times > 0.0 && times <= 1e3) {
        return Err(format!("`{POINTS}` must be above 0 and at most 1000; it is \"{factor}\""));
    }
    let scene = cullet_scene::load(file, overrides).map_err(|errors| errors.to_string())?;
    if let Some(body) = scene.bodies.iter().find(|body| body.particles.is_some()) {
        return Err(format!("\"{}\" has points of its own: give values of these", body.name));
    }
    let points = (f64::from(scene.fracture.max_particles) * times).round();
    Ok(format!("fracture.max_particles={points}"))
}

fn planned(
    (option, along): (&str, &str),
    metric: &str,
    (seed, standard): (u64, bool),
    work: ChartWork,
) -> Planned {
    let id = match &work {
        ChartWork::Specimen(specimen) => specimen.id(),
        ChartWork::Scene(_, overrides) => overrides.join(" "),
    };
    let [option, along, metric] = [option, along, metric].map(str::to_owned);
    Planned { option, along, seed, standard, metric, work, id }
}
