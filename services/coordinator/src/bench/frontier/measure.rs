//! The runs of a chart, each in a process of its own, and what they cost.

use super::super::{Limits, Measured, Point, run_all, status};
use super::row::Row;
use super::set::{Chart, FINEST, MASSES, Planned, Work};
use super::stats::mass_distance;
use crate::record::Recording;
use cullet_proto::recording::EventKind;
use cullet_proto::specimen::{Ending, SpecimenResult};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How often a run of a scene is looked at.
const LOOK: Duration = Duration::from_millis(10);

/// Runs all of a chart; equal runs are run once. `say` is told each, as it ends: its number, how
/// many there are, and its row, for a scene still without its value.
pub fn measure(
    chart: &Chart,
    limits: &Limits,
    say: &mut dyn FnMut(usize, usize, &Row),
) -> Vec<Row> {
    let mut first: BTreeMap<&str, usize> = BTreeMap::new();
    for (k, run) in chart.runs.iter().enumerate() {
        first.entry(&run.id).or_insert(k);
    }
    let mut order: Vec<usize> = first.values().copied().collect();
    order.sort_unstable();
    let of = |run: &Planned| first.get(run.id.as_str()).copied().unwrap_or_default();
    let mut told = 0;
    let mut tell = |row: &Row| {
        told += 1;
        say(told, order.len(), row);
    };
    let scene = chart.runs.iter().any(|run| matches!(run.work, Work::Scene(..)));
    if scene {
        scenes(chart, &order, &of, limits, &mut tell)
    } else {
        specimens(chart, &order, &of, limits, &mut tell)
    }
}

/// What is known of a row before its run.
fn blank(chart: &Chart, run: &Planned) -> Row {
    Row {
        chart: chart.name.clone(),
        option: run.option.clone(),
        along: run.along.clone(),
        seed: run.seed,
        standard: run.standard,
        bench: chart.bench.clone(),
        metric: chart.metric.clone(),
        reference: chart.reference,
        ..Row::default()
    }
}

fn weighed(chart: &Chart, row: &mut Row, value: f64) {
    row.value = Some(value).filter(|v| v.is_finite());
    row.error = row.value.map(|v| (v - chart.reference) / chart.scale);
}

fn specimens(
    chart: &Chart,
    order: &[usize],
    of: &dyn Fn(&Planned) -> usize,
    limits: &Limits,
    tell: &mut dyn FnMut(&Row),
) -> Vec<Row> {
    let point = |k: &usize| match &chart.runs[*k].work {
        Work::Specimen(specimen) => Some(Point { specimen: (**specimen).clone(), swept: vec![] }),
        Work::Scene(..) => None,
    };
    let points: Vec<Point> = order.iter().filter_map(point).collect();
    let mut done: BTreeMap<usize, Row> = BTreeMap::new();
    run_all(&points, limits, &mut |index, result| {
        let row = row_of(chart, &chart.runs[order[index]], &points[index], result, limits);
        tell(&row);
        done.insert(order[index], row);
    });
    let with = |run: &Planned| {
        let (own, same) = (blank(chart, run), done.get(&of(run)).cloned().unwrap_or_default());
        Row { option: own.option, along: own.along, standard: own.standard, ..same }
    };
    chart.runs.iter().map(with).collect()
}

fn row_of(
    chart: &Chart,
    run: &Planned,
    point: &Point,
    mut result: SpecimenResult,
    limits: &Limits,
) -> Row {
    // A run that was ended has cost what it was given.
    if matches!(result.ending, Ending::Timeout(_)) {
        result.price.wall = limits.time.as_secs_f64();
        result.price.cpu = result.price.wall;
    }
    let settings = &point.specimen.job.setup.settings;
    let (spacing, per_cell, threads) = (settings.spacing, settings.per_cell, settings.threads);
    let precision = if settings.single { "single" } else { "double" }.to_owned();
    let (step, steps, price) = (result.step, result.steps, result.price);
    let particle_steps = steps.saturating_mul(result.points);
    let word = status(&result.ending).to_owned();
    let measured = Measured::new(point.clone(), result);
    let found = measured.rows.iter().find(|row| row.metric == chart.metric);
    let mut row = Row {
        solver: point.specimen.solver.to_owned(),
        spacing,
        step,
        per_cell,
        precision,
        threads,
        wall: price.wall,
        cpu: price.cpu,
        steps,
        particle_steps,
        peak: price.peak,
        status: word,
        ..blank(chart, run)
    };
    weighed(chart, &mut row, found.map_or(f64::NAN, |row| row.value));
    row
}

/// What a run of a scene left.
struct Broken {
    row: Row,
    /// Of what broke no further: its object, whether it is broken off it, its mass \[kg\].
    parts: Vec<(String, bool, f64)>,
}

fn scenes(
    chart: &Chart,
    order: &[usize],
    of: &dyn Fn(&Planned) -> usize,
    limits: &Limits,
    tell: &mut dyn FnMut(&Row),
) -> Vec<Row> {
    let mut done: BTreeMap<usize, Broken> = BTreeMap::new();
    for &k in order {
        let broken = scene(chart, &chart.runs[k], limits);
        tell(&broken.row);
        done.insert(k, broken);
    }
    let all: Vec<(&Planned, Option<&Broken>)> =
        chart.runs.iter().map(|run| (run, done.get(&of(run)))).collect();
    let good = |broken: &Option<&Broken>| broken.is_some_and(|b| b.row.status == "ok");
    let finest: Vec<(u64, &Broken)> = all
        .iter()
        .filter(|(run, broken)| run.option == FINEST && good(broken))
        .filter_map(|(run, broken)| Some((run.seed, (*broken)?)))
        .collect();
    let parts = || finest.iter().flat_map(|(_, broken)| &broken.parts);
    let mut objects: BTreeSet<&str> = parts().filter(|p| p.1).map(|p| p.0.as_str()).collect();
    if let Some(object) = &chart.object {
        objects = [object.as_str()].into();
    }
    let of_objects = |broken: &Broken| -> Vec<f64> {
        let these = broken.parts.iter().filter(|part| objects.contains(part.0.as_str()));
        these.map(|part| part.2).collect()
    };
    let row = |(run, broken): &(&Planned, Option<&Broken>)| {
        let own = blank(chart, run);
        let Some(broken) = broken else { return own };
        let mut row = Row {
            option: own.option,
            along: own.along,
            standard: own.standard,
            ..broken.row.clone()
        };
        // The finest is held against its other seeds: how far chance alone carries.
        let others = finest.iter().filter(|(seed, _)| run.option != FINEST || *seed != run.seed);
        let reference: Vec<f64> = others.flat_map(|(_, broken)| of_objects(broken)).collect();
        if row.status == "ok" {
            weighed(chart, &mut row, mass_distance(&of_objects(broken), &reference));
        }
        row
    };
    all.iter().map(row).collect()
}

/// Runs a scene with one worker of one thread, in a folder that goes again.
fn scene(chart: &Chart, run: &Planned, limits: &Limits) -> Broken {
    let mut row = blank(chart, run);
    row.metric = MASSES.to_owned();
    row.precision = "double".to_owned();
    row.threads = 1;
    let (Work::Scene(path, overrides), Ok(folder)) = (&run.work, tempfile::tempdir()) else {
        row.status = "crashed".to_owned();
        return Broken { row, parts: Vec::new() };
    };
    let out = folder.path().join("run");
    let before = spent();
    let start = Instant::now();
    row.status = told(&limits.program.0, path, overrides, &out, limits.time);
    row.wall = start.elapsed().as_secs_f64();
    row.cpu = spent() - before;
    if row.status == "timeout" {
        row.cpu = row.cpu.max(limits.time.as_secs_f64());
    }
    let mut parts = Vec::new();
    let recording = out.join("run.mcap");
    if row.status == "ok" {
        match Recording::open(&recording) {
            Ok(opened) => {
                let report = opened.reports.first();
                row.spacing = report.map_or(0.0, |report| report.spacing);
                row.solver = report.map(|report| report.solver.clone()).unwrap_or_default();
                row.steps = opened.reports.iter().map(|r| r.steps).sum();
                row.particle_steps = opened.reports.iter().map(|r| r.steps * r.particles).sum();
                parts = parts_of(&opened);
            }
            Err(_) => row.status = "crashed".to_owned(),
        }
    }
    Broken { row, parts }
}

/// What broke no further, whole bodies with it.
fn parts_of(recording: &Recording) -> Vec<(String, bool, f64)> {
    let broken: BTreeSet<u64> = recording
        .events
        .iter()
        .filter(|event| event.kind() == EventKind::Fractured)
        .filter_map(|event| event.body)
        .collect();
    let left = recording.bodies.iter().filter(|body| !broken.contains(&body.id));
    left.map(|body| (body.object.clone(), body.generation > 0, body.mass)).collect()
}

/// One word for how a run of a scene ended.
fn told(
    program: &PathBuf,
    scene: &Path,
    overrides: &[String],
    out: &Path,
    limit: Duration,
) -> String {
    let mut command = Command::new(program);
    command.arg("run").arg(scene).arg("--out").arg(out);
    command.args(["--quiet", "--no-pictures", "--workers", "1", "--threads", "1"]);
    for setting in overrides {
        command.arg("--set").arg(setting);
    }
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let Ok(mut child) = command.spawn() else {
        return "crashed".to_owned();
    };
    let start = Instant::now();
    let code = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status.code(),
            Ok(None) if start.elapsed() > limit => {
                let _ended_already = child.kill();
                let _reaped_already = child.wait();
                return "timeout".to_owned();
            }
            Ok(None) => std::thread::sleep(LOOK),
            Err(_) => break None,
        }
    };
    // An expectation of the scene that does not hold is no failure of the run.
    match code {
        Some(0 | 3) => "ok",
        Some(64) => "refused",
        _ => "crashed",
    }
    .to_owned()
}

/// Processor time of all processes that this one has waited for, and those that they waited for
/// \[s\]; 0 where the system does not tell.
fn spent() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let rest = text.rsplit(')').next().unwrap_or_default();
    let fields: Vec<f64> = rest.split_whitespace().map(|f| f.parse().unwrap_or(0.0)).collect();
    // After the name: the state, twelve more, then user and system time of children, in 1/100 s.
    fields.get(13..15).map_or(0.0, |times| times.iter().sum::<f64>() / 100.0)
}
