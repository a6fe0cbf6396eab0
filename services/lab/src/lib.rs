//! The laboratory: specimens and the bench. Specimens run over sweeps of their settings, each in a
//! process of its own.
//!
//! A run of a body is a pure job of the pool: its id is the digest of what is solved. One of the
//! whole is a scene, run as `cullet run` does, and read off its recording. A process that hangs
//! is ended at the time limit; one that crashes has a status like any other: a failed run is a
//! point of a chart, never a missing row. Several run at once, and results come in the order of
//! the plan.

pub mod chart;
mod crew;
pub mod frontier;
mod limits;
mod pool;
mod process;
pub mod specimen;
mod sweep;
mod table;
#[cfg(test)]
mod tests;
mod whole;

pub use limits::Limits;
pub use pool::run_all;
pub use sweep::{SweptSetting, plan};
pub use table::{COLUMNS, csv, file_names, history, json, text};

use crate::specimen::{Ends, MetricCheck, MetricVerdict, Specimen, reduce, speeds, weigh};
use cullet_files::output::{copy_file, write_file};
use cullet_proto::specimen::{Ending, Price, SpecimenOutcome, SpecimenResult};
use cullet_record::{RecordError, points};
use std::path::Path;

/// One run of a sweep: a specimen with its overrides.
#[derive(Clone, Debug)]
pub struct SweepPoint {
    /// The specimen, with its overrides.
    pub specimen: Specimen,
    /// What was swept, `key=value` each.
    pub swept: Vec<String>,
}

/// One metric of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricRow {
    /// The metric.
    pub metric: String,
    /// Its value; not a number where the run came to none.
    pub value: f64,
    /// Whether it is no number because a sample is none.
    pub spoiled: bool,
    /// Compared with what is expected.
    pub weighed: MetricCheck,
    /// Where the reference comes from.
    pub source: String,
    /// Why it is known not to hold.
    pub gap: Option<String>,
}

/// A run and what came out.
#[derive(Clone, Debug)]
pub struct Measured {
    /// What was run.
    pub point: SweepPoint,
    /// What came back.
    pub result: SpecimenOutcome,
    /// What it cost.
    pub price: Price,
    /// Its numbers.
    pub rows: Vec<MetricRow>,
}

impl SweepPoint {
    /// What it is called in tables: the specimen, and what was swept beside what has a column.
    #[must_use]
    pub fn label(&self) -> String {
        self.titled(&["spacing", "points_per_cell", "precision", "threads"])
    }

    /// What it is called for people, who see its spacing beside it.
    #[must_use]
    pub fn title(&self) -> String {
        self.titled(&["spacing"])
    }

    /// The specimen, and what was swept beside those keys.
    fn titled(&self, own: &[&str]) -> String {
        let key = |text: &str| text.split('=').next().unwrap_or_default().to_owned();
        let more = self.swept.iter().filter(|text| !own.contains(&key(text).as_str()));
        let more: Vec<&str> = more.map(String::as_str).collect();
        if more.is_empty() {
            return self.specimen.name.clone();
        }
        format!("{}[{}]", self.specimen.name, more.join(";"))
    }

    /// A name for its files, which another run may have too.
    fn file_name(&self) -> String {
        let keep = |c: char| c.is_ascii_alphanumeric() || "-._".contains(c);
        let plain = |text: &str| -> String {
            text.replace('=', "-").chars().map(|c| if keep(c) { c } else { '_' }).collect()
        };
        let parts =
            [self.specimen.name.as_str()].into_iter().chain(self.swept.iter().map(|s| &**s));
        parts.map(plain).collect::<Vec<_>>().join(".")
    }
}

/// One word for how a run ended.
#[must_use]
pub const fn status(ending: &Ending) -> &'static str {
    match ending {
        Ending::Ok => "ok",
        Ending::Unstable(_) => "unstable",
        Ending::NotFinite(_) => "nan",
        Ending::Refused(_) => "refused",
        Ending::Crashed(_) => "crashed",
        Ending::Timeout(_) => "timeout",
        Ending::Geometry(_) => "geometry",
    }
}

/// Why a run did not end at its end, if so.
#[must_use]
pub fn trouble(ending: &Ending) -> Option<&str> {
    match ending {
        Ending::Ok => None,
        Ending::Unstable(why)
        | Ending::NotFinite(why)
        | Ending::Refused(why)
        | Ending::Crashed(why)
        | Ending::Timeout(why)
        | Ending::Geometry(why) => Some(why),
    }
}

impl Measured {
    /// Makes the numbers of a run.
    #[must_use]
    pub fn new(point: SweepPoint, result: SpecimenResult) -> Self {
        let SpecimenResult { outcome: mut result, price } = result;
        for &(probe, window) in &point.specimen.speeds {
            if let Some(row) = result.rows.get_mut(probe) {
                *row = speeds(&result.times, row, window);
            }
        }
        let ended = result.ending == Ending::Ok;
        let pairs = point.specimen.metrics.iter().zip(&point.specimen.expected);
        let mut rows: Vec<MetricRow> = Vec::new();
        for ((metric, probe), expected) in pairs {
            let samples = result.rows.get(*probe).filter(|_| ended);
            let own = samples.map_or(f64::NAN, |row| reduce(metric, &result.times, row));
            let named = |name: &Option<String>| {
                name.as_ref().and_then(|name| rows.iter().find(|row| row.metric == *name))
            };
            let (minus, over) = (named(&metric.minus), named(&metric.over));
            let left = own - minus.map_or(0.0, |row| row.value);
            let value = left / over.map_or(1.0, |row| row.value);
            let other = [minus, over].into_iter().flatten().any(|row| row.spoiled);
            let none = samples.is_some_and(|row| row.iter().any(|sample| sample.is_nan()));
            rows.push(MetricRow {
                metric: metric.name.clone(),
                value,
                spoiled: value.is_nan() && (none || other),
                weighed: weigh(expected.as_ref(), value),
                source: expected.as_ref().map(|e| e.source.clone()).unwrap_or_default(),
                gap: expected.as_ref().and_then(|e| e.gap.clone()),
            });
        }
        Self { point, result, price, rows }
    }

    /// Whether anything that was expected does not hold, or the run ended otherwise than it must.
    #[must_use]
    pub fn fails(&self) -> bool {
        let ends = match self.point.specimen.ends {
            Ends::Ok => "ok",
            Ends::Unstable => "unstable",
            Ends::Nan => "nan",
            Ends::Refused => "refused",
            Ends::Geometry => "geometry",
        };
        let ended = self.result.ending == Ending::Ok;
        let missed = |row: &MetricRow| row.weighed.verdict == MetricVerdict::Fails;
        status(&self.result.ending) != ends || ended && self.rows.iter().any(missed)
    }

    /// Writes the samples as CSV, the frames as MCAP and four of them as PNG into a folder,
    /// under a name of [`file_names`]; of a scene its recording and its picture.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn save(
        &self,
        folder: &Path,
        name: &str,
        recording: Option<&Path>,
    ) -> Result<(), RecordError> {
        let path = folder.join(format!("{name}.csv"));
        write_file(&path, history(self).as_bytes()).map_err(RecordError::io(&path))?;
        if let Some(recording) = recording {
            let path = folder.join(format!("{name}.mcap"));
            copy_file(recording, &path).map_err(RecordError::io(&path))?;
            return cullet_picture::sheet(&path, &folder.join(format!("{name}.png")));
        }
        if self.result.frames.is_empty() {
            return Ok(());
        }
        points::record(&folder.join(format!("{name}.mcap")), name, &self.result.frames)?;
        let what = self.point.specimen.colour();
        let picture = cullet_picture::points::sheet(&self.result.frames, what);
        picture.save(&folder.join(format!("{name}.png")))
    }
}
