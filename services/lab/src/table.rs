//! Results as a table for people, as CSV, and as JSON.

use super::{Measured, MetricRow, SweepPoint, status, trouble};
use crate::specimen::MetricVerdict;
use cullet_files::cells::quote_cell;
use cullet_model::PointPrecision;
use cullet_specimen::SpecimenSettings;
use serde_json::json;

/// Columns of the CSV.
pub const COLUMNS: &str = "bench,solver,h,dt,ppc,precision,threads,wall_s,cpu_s,steps,\
    particle_steps,peak_bytes,metric,value,ref,err,status";

/// A name for the files of each run, none twice, whatever the case of its letters.
#[must_use]
pub fn file_names(points: &[SweepPoint]) -> Vec<String> {
    let mut taken = std::collections::BTreeSet::new();
    let mut free = |name: String| {
        let more = (2..).map(|k| format!("{name}.{k}"));
        let mut names = [name.clone()].into_iter().chain(more);
        names.find(|name| taken.insert(name.to_lowercase())).unwrap_or(name)
    };
    points.iter().map(|point| free(point.file_name())).collect()
}

/// The rows of one run as CSV, a line a metric; a run without metrics has one line.
#[must_use]
pub fn csv(measured: &Measured) -> String {
    let settings = measured.point.specimen.settings();
    let result = &measured.result;
    let grid = |number: fn(&SpecimenSettings) -> String| settings.map(number).unwrap_or_default();
    let head = format!(
        "{},{},{},{},{},{},{},{:.4},{:.2},{},{},{}",
        quote_cell(&measured.point.label()),
        measured.point.specimen.solver,
        grid(|s| s.spacing.to_string()),
        result.step,
        grid(|s| s.points.per_cell.to_string()),
        grid(|s| precision_word(s.precision).to_owned()),
        settings.map_or(1, |s| s.threads),
        measured.price.wall,
        measured.price.cpu,
        result.steps,
        settings
            .map(|_| result.steps.saturating_mul(result.points).to_string())
            .unwrap_or_default(),
        measured.price.peak,
    );
    let word = status(&result.ending);
    let line = |row: &MetricRow| {
        let number = |value: Option<f64>| {
            value.filter(|v| v.is_finite()).map(|v| v.to_string()).unwrap_or_default()
        };
        format!(
            "{head},{},{},{},{},{}\n",
            quote_cell(&row.metric),
            number(Some(row.value)),
            number(row.weighed.reference),
            number(row.weighed.error),
            if row.spoiled { "nan" } else { word },
        )
    };
    if measured.rows.is_empty() {
        return format!("{head},,,,,{word}\n");
    }
    measured.rows.iter().map(line).collect()
}

pub(super) const fn precision_word(precision: PointPrecision) -> &'static str {
    match precision {
        PointPrecision::Single => "single",
        PointPrecision::Double => "double",
    }
}

/// The samples of a run as CSV: a column a probe, its unit in the head.
#[must_use]
pub fn history(measured: &Measured) -> String {
    let names = measured.point.specimen.probes.iter();
    let names = names.map(|(name, unit)| quote_cell(&format!("{name} [{unit}]")));
    let mut text = ["time [s]".to_owned()].into_iter().chain(names).collect::<Vec<_>>().join(",");
    text.push('\n');
    for (k, time) in measured.result.times.iter().enumerate() {
        text.push_str(&time.to_string());
        for row in &measured.result.rows {
            text.push_str(&format!(",{}", row.get(k).copied().unwrap_or(f64::NAN)));
        }
        text.push('\n');
    }
    text
}

/// Five digits of a number.
fn short(value: f64) -> String {
    let size = value.abs();
    if value.is_nan() {
        "-".to_owned()
    } else if size != 0.0 && !(1e-3..1e5).contains(&size) {
        format!("{value:.4e}")
    } else {
        let digits =
            if size > 0.0 { (4.0 - libm::log10(size).floor()).clamp(0.0, 7.0) } else { 1.0 };
        format!("{value:.0$}", digits as usize)
    }
}

/// Head of the table, and its rows for one run.
#[must_use]
pub fn text(all: &[Measured]) -> String {
    let head = ["bench", "h [mm]", "metric", "value", "reference", "error", "asked", "cost", ""];
    let mut lines: Vec<[String; 9]> = vec![head.map(str::to_owned)];
    let mut notes = Vec::new();
    for measured in all {
        let result = &measured.result;
        let name = measured.point.title();
        let settings = measured.point.specimen.settings();
        let spacing = settings.map(|s| short(1e3 * s.spacing)).unwrap_or_default();
        let whole = settings.map_or(name.clone(), |_| format!("{name} at h = {spacing} mm"));
        let cost = format!("{:.2} s", measured.price.wall);
        if let Some(why) = trouble(&result.ending) {
            // A place in `[geometry]` begins with the status' own word.
            let word = format!("{}: ", status(&result.ending));
            notes.push(format!("{whole}: {word}{}", why.strip_prefix(&*word).unwrap_or(why)));
        }
        let ended = trouble(&result.ending).is_none();
        if ended && result.strength_ratio < 1.0 {
            notes.push(format!(
                "{whole}: cracks grow at {} of the strength, which this grid is too coarse for \
                 (F01)",
                short(result.strength_ratio)
            ));
        }
        for (k, row) in measured.rows.iter().enumerate() {
            let error = match (row.weighed.reference, row.weighed.error.filter(|e| e.is_finite())) {
                (Some(0.0), Some(error)) => short(error),
                (_, Some(error)) => format!("{:+.2} %", 100.0 * error),
                _ => String::new(),
            };
            let word = match (ended, row.weighed.verdict) {
                (false, _) => status(&result.ending),
                _ if row.spoiled => "nan",
                (_, MetricVerdict::Free) => "",
                (_, MetricVerdict::Holds) => "ok",
                (_, MetricVerdict::Fails) => "FAILS",
                (_, MetricVerdict::Gap) => "gap",
            };
            if let (MetricVerdict::Gap, Some(why)) = (row.weighed.verdict, &row.gap) {
                notes.push(format!("{name}, {}: gap: {why}", row.metric));
            }
            let first = |text: &String| if k == 0 { text.clone() } else { String::new() };
            lines.push([
                first(&name),
                first(&spacing),
                row.metric.clone(),
                short(row.value),
                row.weighed.reference.map(short).unwrap_or_default(),
                error,
                row.weighed.asked.clone(),
                first(&cost),
                word.to_owned(),
            ]);
        }
        if measured.rows.is_empty() {
            let none = String::new;
            let word = status(&result.ending).to_owned();
            lines.push([name, spacing, none(), none(), none(), none(), none(), cost, word]);
        }
    }
    notes.dedup();
    aligned(&lines) + &notes.iter().map(|note| format!("{note}\n")).collect::<String>()
}

fn aligned(lines: &[[String; 9]]) -> String {
    let width = |k: usize| lines.iter().map(|line| line[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..9).map(width).collect();
    let mut text = String::new();
    for line in lines {
        let cells = line.iter().zip(&widths).enumerate().map(|(k, (cell, &width))| {
            let number = matches!(k, 1 | 3 | 4 | 5 | 7);
            if number { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
        });
        text.push_str(cells.collect::<Vec<_>>().join("  ").trim_end());
        text.push('\n');
    }
    text
}

/// One run as JSON.
#[must_use]
pub fn json(measured: &Measured) -> serde_json::Value {
    let settings = measured.point.specimen.settings();
    let result = &measured.result;
    let number = |value: f64| if value.is_finite() { json!(value) } else { json!(null) };
    let rows: Vec<_> = measured
        .rows
        .iter()
        .map(|row| {
            json!({
                "metric": row.metric,
                "spoiled": row.spoiled,
                "value": number(row.value),
                "reference": row.weighed.reference,
                "error": row.weighed.error.map(number),
                "asked": row.weighed.asked,
                "verdict": match row.weighed.verdict {
                    MetricVerdict::Free => "free",
                    MetricVerdict::Holds => "holds",
                    MetricVerdict::Fails => "fails",
                    MetricVerdict::Gap => "gap",
                },
                "source": row.source,
                "gap": row.gap,
            })
        })
        .collect();
    json!({
        "bench": measured.point.specimen.name,
        "description": measured.point.specimen.description,
        "swept": measured.point.swept,
        "job": measured.point.specimen.id(),
        "solver": measured.point.specimen.solver,
        "spacing": settings.map(|s| s.spacing),
        "step": result.step,
        "steps": result.steps,
        "points": result.points,
        "strength_ratio": result.strength_ratio,
        "wall_s": measured.price.wall,
        "cpu_s": measured.price.cpu,
        "peak_bytes": measured.price.peak,
        "pieces": result.pieces,
        "status": status(&result.ending),
        "trouble": trouble(&result.ending),
        "metrics": rows,
    })
}
