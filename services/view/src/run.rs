//! The page of a run: what the recording says, as the viewer reads it.

use crate::directed::{directed_figures, directed_shares};
use crate::page::{packed, page};
use cullet_proto::recording::{
    Body, EventKind, JobReport, Ledger, NewShape, RunEvent, Sampled, Tier,
};
use cullet_record::{PoseRow, Recording, Summary, event_text};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Most samples of a chart: a screen shows no more.
const MOST_SAMPLES: usize = 600;
/// The arrow keys move by this much \[s\].
const FRAME: f64 = 1.0 / 60.0;

/// What the viewer is given.
#[derive(Serialize)]
struct RunData {
    kind: &'static str,
    title: String,
    about: String,
    /// \[s\]
    duration: f64,
    /// \[s\]
    frame: f64,
    /// The moment shown first \[s\].
    first: f64,
    view: Option<ReportView>,
    /// Fastest that a body moves \[m/s\].
    fastest: f64,
    /// Least and greatest damage time \[s\].
    damage: [f64; 2],
    figures: Vec<(&'static str, String)>,
    bodies: Vec<BodyRow>,
    events: Vec<EventRow>,
    fractures: Vec<FractureRow>,
    series: ReportSeries,
}

/// Where the scene looks from \[m\], and the angle it sees \[degrees\].
#[derive(Serialize)]
struct ReportView {
    eye: [f64; 3],
    target: [f64; 3],
    fov: f64,
}

#[derive(Serialize)]
struct BodyRow {
    id: u64,
    name: String,
    object: String,
    parent: Option<u64>,
    material: String,
    tier: String,
    mass: f64,
    volume: f64,
    birth: f64,
    end: Option<f64>,
    /// How it came to be: by which solver, solved, sampled or directed.
    origin: Option<String>,
    damage: Option<[f64; 2]>,
}

#[derive(Serialize)]
struct EventRow {
    time: f64,
    kind: String,
    text: String,
    body: Option<u64>,
}

#[derive(Serialize)]
struct FractureRow {
    time: f64,
    body: u64,
    name: String,
    solver: String,
    fragments: usize,
    sampled: usize,
    directed: usize,
    mass_error: f64,
    momentum_error: f64,
    energy_before: f64,
    energy_after: f64,
    fracture_energy: f64,
    points: u64,
    spacing: f64,
}

#[derive(Serialize)]
struct ReportSeries {
    times: Vec<f64>,
    charts: Vec<ReportChart>,
}

#[derive(Serialize)]
struct ReportChart {
    title: &'static str,
    unit: &'static str,
    lines: Vec<ChartLine>,
}

#[derive(Serialize)]
struct ChartLine {
    name: &'static str,
    colour: &'static str,
    values: Vec<f64>,
}

/// The page of a run. `model`: the GLB of the whole run from its beginning.
///
/// # Errors
/// RunData that cannot be compressed or is no JSON, which does not happen in memory.
pub fn run_page(recording: &Recording, model: &[u8]) -> std::io::Result<String> {
    let data = RunData::of(recording);
    let html = include_str!("../assets/run.html");
    let made = page(&data.title, html, &data, Some(&packed(model)?));
    made.map_err(std::io::Error::other)
}

/// Three numbers of a metadata value.
fn vector(text: &str) -> Option<[f64; 3]> {
    let mut numbers = text.split_whitespace().map(str::parse::<f64>);
    let mut next = || numbers.next()?.ok().filter(|x| x.is_finite());
    Some([next()?, next()?, next()?])
}

fn view(meta: &BTreeMap<String, String>) -> Option<ReportView> {
    let eye = vector(meta.get("view.eye")?)?;
    let target = vector(meta.get("view.target")?)?;
    let fov = meta.get("view.fov").and_then(|text| text.parse().ok()).unwrap_or(40.0);
    Some(ReportView { eye, target, fov })
}

impl RunData {
    fn of(recording: &Recording) -> Self {
        let summary = recording.summary();
        let names: BTreeMap<u64, &str> =
            recording.bodies.iter().map(|body| (body.id, &body.name[..])).collect();
        let name =
            |id: u64| names.get(&id).map_or_else(|| format!("body {id}"), ToString::to_string);
        let series = SeriesBuilder::of(recording);
        let breaks = recording.events.iter().filter(|event| is_change(event));
        let first = breaks.map(|event| event.time).next().unwrap_or(0.0);
        let cut = if recording.complete { "" } else { "; the run was cut off" };
        let missing = summary.missing.as_ref().map(|of| format!("; the recording has holes: {of}"));
        let cut = missing.unwrap_or_else(|| cut.to_owned());
        let about = format!(
            "seed {}; {} steps, {:.3} s simulated; recorded by Cullet {}{cut}",
            summary.seed, summary.steps, summary.sim_seconds, summary.version
        );
        let damage = series.damage.unwrap_or([0.0, 0.0]);
        Self {
            kind: "run",
            title: summary.scene.clone(),
            about,
            duration: summary.sim_seconds,
            frame: FRAME,
            first,
            view: view(&recording.meta),
            fastest: series.fastest,
            damage,
            figures: figures(&summary),
            bodies: bodies(recording),
            events: recording.events.iter().map(|event| event_row(event, &name)).collect(),
            fractures: fractures(recording, &name),
            series: series.finish(),
        }
    }
}

/// Whether a body broke or took a new shape.
fn is_change(event: &RunEvent) -> bool {
    matches!(event.kind(), EventKind::Fractured | EventKind::Deformed)
}

fn event_row(event: &RunEvent, name: &dyn Fn(u64) -> String) -> EventRow {
    EventRow {
        time: event.time,
        kind: format!("{:?}", event.kind()).to_lowercase(),
        text: event_text(event, name),
        body: event.body,
    }
}

/// The figures of the run, by name.
fn figures(summary: &Summary) -> Vec<(&'static str, String)> {
    let ledger = &summary.ledger;
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let mut rows = vec![
        ("bodies of the scene", summary.bodies_initial.to_string()),
        ("bodies at the end", summary.bodies_final.to_string()),
        ("fractures", summary.fractures.to_string()),
        ("fragments made", summary.fragments.to_string()),
        ("grains of debris", format!("{} of {:.3e} kg", summary.grains, summary.grain_mass)),
        ("bodies dented", summary.deformed.to_string()),
    ];
    if let Some(shares) = &summary.shares {
        rows.push(("sampled pieces, of those at the end", percent(shares.sampled)));
        rows.push(("share of them in the mass of pieces", percent(shares.sampled_piece_mass())));
        rows.push(("share of all mass in grains of debris", percent(shares.grain_mass)));
        let volume = shares.sampled_volume.map(percent);
        rows.extend(volume.map(|text| ("sampled share of the broken volume", text)));
        let area = shares.sampled_crack_area.map(percent);
        rows.extend(area.map(|text| ("sampled share of the crack area", text)));
        rows.extend(directed_shares(shares));
    }
    if let Some(directed) = &summary.directed {
        rows.extend(directed_figures(directed));
    }
    let solvers = summary.solvers.iter().map(|(solver, jobs)| format!("{solver} {jobs}"));
    rows.extend([
        ("jobs by solver", solvers.collect::<Vec<_>>().join(", ")),
        ("worst error of mass", format!("{:.1e}", ledger.mass_rel_error)),
        ("worst error of momentum", format!("{:.1e}", ledger.momentum_rel_error)),
        ("worst error of angular momentum", format!("{:.1e}", ledger.angular_momentum_rel_error)),
        ("worst gain of energy", format!("{:.1e}", ledger.energy_gain_rel)),
        ("energy spent on cracks", format!("{:.4} J", ledger.fracture_energy)),
        ("open fragments", summary.open_fragments.to_string()),
        ("wall time", format!("{:.1} s", summary.wall_seconds)),
        ("digest", summary.digest.clone()),
    ]);
    rows
}

/// When each body broke or left \[s\].
fn ends(recording: &Recording) -> BTreeMap<u64, f64> {
    let gone =
        |event: &&RunEvent| matches!(event.kind(), EventKind::Fractured | EventKind::Removed);
    let events = recording.events.iter().filter(gone);
    events.filter_map(|event| Some((event.body?, event.time))).collect()
}

fn bodies(recording: &Recording) -> Vec<BodyRow> {
    let ends = ends(recording);
    let solvers = answers(recording);
    let origins = recording.origins();
    let damage: BTreeMap<&[u8], Option<[f64; 2]>> = recording
        .geometries
        .iter()
        .map(|(hash, geometry)| (&hash[..], range(geometry.damage_time.iter().copied())))
        .collect();
    let step = step(recording);
    let row = |body: &Body| {
        let origin = body.parent.map(|parent| {
            let solver = solvers.get(&parent).map_or("", |report| &report.solver[..]);
            let kind = origins.get(&body.id).map(|origin| origin.word());
            let kind = kind.unwrap_or("not recorded whether solved or sampled");
            format!("{solver} ({kind})")
        });
        BodyRow {
            id: body.id,
            name: body.name.clone(),
            object: body.object.clone(),
            parent: body.parent,
            material: body.material.clone(),
            tier: format!("{:?}", Tier::try_from(body.tier).unwrap_or_default()).to_lowercase(),
            mass: body.mass,
            volume: body.volume,
            birth: body.birth_step as f64 * step,
            end: ends.get(&body.id).copied(),
            origin,
            damage: damage.get(&body.geometry[..]).copied().flatten(),
        }
    };
    recording.bodies.iter().map(row).collect()
}

/// Time step \[s\].
fn step(recording: &Recording) -> f64 {
    recording.meta.get("step").and_then(|text| text.parse().ok()).unwrap_or(0.0)
}

/// The report of the job that broke each body: the last that made fragments.
fn answers(recording: &Recording) -> BTreeMap<u64, &JobReport> {
    let made = recording.reports.iter().filter(|report| report.fragments > 0);
    made.map(|report| (report.body, report)).collect()
}

fn sampled(recording: &Recording) -> BTreeMap<u64, &Sampled> {
    recording.sampled.iter().map(|of| (of.body, of)).collect()
}

fn fractures(recording: &Recording, name: &dyn Fn(u64) -> String) -> Vec<FractureRow> {
    let solvers = answers(recording);
    let sampled = sampled(recording);
    let row = |event: &RunEvent| {
        let body = event.body?;
        let report = solvers.get(&body);
        let ledger = event.ledger.unwrap_or_default();
        let Ledger { energy_before, energy_after, fracture_energy, .. } = ledger;
        Some(FractureRow {
            time: event.time,
            body,
            name: name(body),
            solver: report.map_or_else(String::new, |report| report.solver.clone()),
            fragments: event.fragments.len(),
            sampled: sampled.get(&body).map_or(0, |of| of.fragments.len()),
            directed: sampled.get(&body).map_or(0, |of| of.directed.len()),
            mass_error: ledger.mass_rel_error,
            momentum_error: ledger.momentum_rel_error,
            energy_before,
            energy_after,
            fracture_energy,
            points: report.map_or(0, |report| report.particles),
            spacing: report.map_or(0.0, |report| report.spacing),
        })
    };
    recording.events.iter().filter(|event| is_change(event)).filter_map(row).collect()
}

/// Least and greatest of some numbers; nothing of none.
fn range(numbers: impl Iterator<Item = f32>) -> Option<[f64; 2]> {
    let finite = numbers.filter(|x| x.is_finite()).map(f64::from);
    finite.fold(None, |range, x| {
        let [low, high] = range.unwrap_or([x, x]);
        Some([low.min(x), high.max(x)])
    })
}

/// What is drawn over time, step by step.
struct SeriesBuilder {
    times: Vec<f64>,
    bodies: Vec<f64>,
    fragments: Vec<f64>,
    kinetic: Vec<f64>,
    cracks: Vec<f64>,
    fastest: f64,
    damage: Option<[f64; 2]>,
}

impl SeriesBuilder {
    fn of(recording: &Recording) -> Self {
        let fixed: BTreeSet<u64> =
            recording.bodies.iter().filter(|body| body.fixed).map(|body| body.id).collect();
        let mut masses: BTreeMap<u64, f64> =
            recording.bodies.iter().map(|body| (body.id, body.mass)).collect();
        let fragment: BTreeSet<u64> = recording
            .bodies
            .iter()
            .filter(|body| body.parent.is_some())
            .map(|body| body.id)
            .collect();
        let ends = ends(recording);
        let mut shapes = recording.shapes.iter().peekable();
        let mut events = recording.events.iter().filter(|event| is_change(event)).peekable();
        let mut speeds: BTreeMap<u64, f64> = BTreeMap::new();
        let crack_times = recording.geometries.values().flat_map(|of| of.damage_time.iter());
        let mut series = Self {
            times: Vec::new(),
            bodies: Vec::new(),
            fragments: Vec::new(),
            kinetic: Vec::new(),
            cracks: Vec::new(),
            fastest: 0.0,
            damage: range(crack_times.copied()),
        };
        let mut spent = 0.0;
        for poses in &recording.poses {
            let now = poses.time;
            while let Some(NewShape { body, mass, .. }) = shapes.next_if(|of| of.time <= now) {
                masses.insert(*body, *mass);
            }
            while let Some(event) = events.next_if(|event| event.time <= now) {
                spent += event.ledger.map_or(0.0, |ledger| ledger.fracture_energy);
            }
            for row in PoseRow::of(poses) {
                let speed = row.velocity.norm();
                speeds.insert(row.id, if fixed.contains(&row.id) { 0.0 } else { speed });
                series.fastest = series.fastest.max(speeds[&row.id]);
            }
            speeds.retain(|id, _| ends.get(id).is_none_or(|end| *end > now));
            let energy =
                |(id, speed): (&u64, &f64)| 0.5 * masses.get(id).unwrap_or(&0.0) * speed * speed;
            series.times.push(now);
            series.bodies.push(speeds.len() as f64);
            series.fragments.push(speeds.keys().filter(|id| fragment.contains(id)).count() as f64);
            series.kinetic.push(speeds.iter().map(energy).sum());
            series.cracks.push(spent);
        }
        series
    }

    /// The charts, thinned to what a screen shows.
    fn finish(self) -> ReportSeries {
        let stride = self.times.len().div_ceil(MOST_SAMPLES).max(1);
        let last = self.times.len().saturating_sub(1);
        let kept = |values: &[f64]| -> Vec<f64> {
            let each = values.iter().enumerate();
            each.filter(|(k, _)| k % stride == 0 || *k == last).map(|(_, v)| *v).collect()
        };
        let line = |name, colour, values: &[f64]| ChartLine { name, colour, values: kept(values) };
        ReportSeries {
            charts: vec![
                ReportChart {
                    title: "Bodies",
                    unit: "1",
                    lines: vec![
                        line("all", "#4b5563", &self.bodies),
                        line("fragments", "#b45309", &self.fragments),
                    ],
                },
                ReportChart {
                    title: "Kinetic energy, rotation left out",
                    unit: "J",
                    lines: vec![line("kinetic", "#2563eb", &self.kinetic)],
                },
                ReportChart {
                    title: "Energy spent on cracks and dents",
                    unit: "J",
                    lines: vec![line("spent", "#15803d", &self.cracks)],
                },
            ],
            times: kept(&self.times),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{RunData, run_page};
    use cullet_record::{Recording, synthetic};

    fn recorded() -> Recording {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        synthetic::run(&path, &synthetic::meta()).expect("a recording");
        Recording::open(&path).expect("it reads")
    }

    /// A cube that breaks into two parts and two grains at 0.4 s.
    #[test]
    fn the_page_has_what_the_recording_says() {
        let recording = recorded();
        let data = RunData::of(&recording);
        let summary = recording.summary();
        assert_eq!(data.bodies.len(), recording.bodies.len());
        assert_eq!(data.events.len(), recording.events.len());
        assert_eq!(data.fractures.len(), summary.fractures as usize);
        let broken = &data.fractures[0];
        assert_eq!(data.first, broken.time);
        assert_eq!((broken.body, broken.fragments), (1, 2));
        let ledger = recording.events.iter().find_map(|event| event.ledger).expect("a ledger");
        assert_eq!(broken.fracture_energy, ledger.fracture_energy);
        let cube = data.bodies.iter().find(|body| body.id == 1).expect("the cube");
        assert_eq!(cube.end, Some(broken.time));
        let part = data.bodies.iter().find(|body| body.parent == Some(1)).expect("a part");
        assert!((part.birth - broken.time).abs() < 1e-9, "{} s", part.birth);
        assert!(part.origin.is_some() && cube.origin.is_none());
    }

    #[test]
    fn the_head_of_a_page_says_what_is_missing() {
        let mut recording = recorded();
        recording.holes.unborn = 2;
        let about = RunData::of(&recording).about;
        assert!(about.contains("the recording has holes: 2 bodies"), "{about}");
    }

    #[test]
    fn the_charts_count_bodies_and_energy() {
        let recording = recorded();
        let data = RunData::of(&recording);
        let charts = &data.series.charts;
        let times = &data.series.times;
        assert!(
            charts.iter().flat_map(|chart| &chart.lines).all(|of| of.values.len() == times.len())
        );
        let at = |time: f64| times.iter().position(|&t| t > time).expect("a sample");
        let (before, after) = (at(0.2), at(0.5));
        let fragments = &charts[0].lines[1].values;
        assert_eq!((fragments[before], fragments[after]), (0.0, 2.0));
        let all = &charts[0].lines[0].values;
        assert_eq!(all[after] - all[before], 1.0, "one goes, two come");
        // By hand: half the mass times the speed squared of each row of that step.
        let poses = recording.poses.iter().find(|poses| poses.time == times[0]).expect("a step");
        let energy: f64 = cullet_record::PoseRow::of(poses)
            .map(|row| {
                let body = recording.bodies.iter().find(|body| body.id == row.id).expect("known");
                if body.fixed { 0.0 } else { 0.5 * body.mass * row.velocity.norm_squared() }
            })
            .sum();
        assert!((charts[1].lines[0].values[0] - energy).abs() <= 1e-12 * energy.max(1.0));
        let spent = &charts[2].lines[0].values;
        assert!(spent[before] == 0.0 && spent[after] > 0.0);
    }

    #[test]
    fn a_page_is_one_file() {
        let page = run_page(&recorded(), b"model").expect("a page");
        assert!(page.starts_with("<!doctype html>") && page.ends_with("</html>\n"));
        for part in ["id=\"report\"", "id=\"model\"", "id=\"canvas\"", "three.js"] {
            assert!(page.contains(part), "{part}");
        }
        assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
    }
}
