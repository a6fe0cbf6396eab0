//! Sweeps: one scene with many settings, here or at a coordinator, with a contact sheet and a
//! table of what came of them.

use crate::args::{self, SceneArgs};
use crate::client::{bring, connect, exit_of, follow, hand_in, print_json};
use crate::exit::{Exit, Trouble, print};
use crate::folder::{Folder, refuse_taken};
use crate::run::{draw, exit_of as exit_of_run, read_scene, start_pool, trouble};
use cullet_coordinator::link::Share;
use cullet_coordinator::preview;
use cullet_coordinator::record::Summary;
use cullet_coordinator::run::{News, RunOptions, run as run_scene, write_file};
use cullet_coordinator::scene::Scene;
use cullet_coordinator::service::sweep::{Sweep, is_sweep};
use cullet_proto::service::Which;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The contact sheet and the table of a sweep.
const SHEET: &str = "sheet.png";
const TABLE: &str = "table.csv";

/// Whether a file is a sweep and not a scene.
pub(crate) fn is_one(path: &Path) -> bool {
    path.is_file() && std::fs::read_to_string(path).is_ok_and(|text| is_sweep(&text))
}

/// A sweep with all its scenes, each checked.
struct Plan {
    name: String,
    sweep: Sweep,
    scenes: Vec<Scene>,
}

fn plan(args: &SceneArgs) -> Result<Plan, Trouble> {
    let text = std::fs::read_to_string(&args.scene);
    let text = text.map_err(|error| Trouble::file(&args.scene, error))?;
    let sweep = Sweep::read(&text)
        .map_err(|error| Trouble::new(Exit::Usage, format!("{}: {error}", args.scene.display())))?;
    let folder = args.scene.parent().unwrap_or(Path::new(""));
    let base = folder.join(&sweep.scene);
    let mut scenes = Vec::new();
    for row in &sweep.rows {
        let set = [&sweep.overrides(row)[..], &args.set[..]].concat();
        let told = |t: Trouble| Trouble::new(t.exit, format!("{}: {t}", sweep.label(row)));
        scenes.push(read_scene(&SceneArgs { scene: base.clone(), set }).map_err(told)?);
    }
    let name = args.scene.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = name.unwrap_or_default().chars().take(64).collect();
    Ok(Plan { name, sweep, scenes })
}

/// One run of a sweep that is over.
struct Row {
    folder: Option<PathBuf>,
    exit: Exit,
}

/// `cullet run SWEEP`: one after another on one pool.
pub(crate) fn run(args: &args::Run, stop: &Arc<AtomicBool>) -> Result<Exit, Trouble> {
    let plan = plan(&args.scene)?;
    let folder = Folder::of(args.out.as_deref(), &plan.name)?;
    let pool = start_pool(args).inspect_err(|_| folder.forget())?;
    let mut rows = Vec::new();
    for (index, scene) in plan.scenes.iter().enumerate() {
        let out = folder.path.join(format!("{}", index + 1));
        std::fs::create_dir_all(&out).map_err(|error| Trouble::file(&out, error))?;
        if !args.voice.quiet {
            eprintln!("{}: {}", index + 1, plan.sweep.label(&plan.sweep.rows[index]));
        }
        let options = RunOptions { out: &out, stop };
        let outcome =
            run_scene(scene, &pool.run(Share::default()), &options, &mut |news| match news {
                News::Line(line) if args.voice.verbose > 0 => eprintln!("{line}"),
                News::Line(_) | News::At(_) => {}
            });
        let exit = match &outcome {
            Ok(outcome) => {
                let drawn = args.no_pictures || draw(&outcome.recording, &out).is_ok();
                exit_of_run(outcome, drawn)
            }
            Err(error) => {
                let trouble = trouble(error);
                eprintln!("error: run {}: {trouble}", index + 1);
                trouble.exit
            }
        };
        rows.push(Row { folder: outcome.is_ok().then_some(out), exit });
        if stop.load(Ordering::Relaxed) {
            break;
        }
    }
    pool.shutdown();
    finish(&plan, &rows, &folder.path, args.json, args.voice.quiet)
}

/// `cullet submit SWEEP`: all at once to a coordinator.
pub(crate) fn submit(args: &args::Submit) -> Result<Exit, Trouble> {
    let plan = plan(&args.scene)?;
    args.out.as_deref().map_or(Ok(()), refuse_taken)?;
    let client = connect(&args.place)?;
    let mut runs = Vec::new();
    for (row, scene) in plan.sweep.rows.iter().zip(&plan.scenes) {
        let run = hand_in(&client, &scene.bundle(), args.priority, &plan.name)?;
        if !args.place.who.voice.quiet && !args.detach {
            eprintln!("run {run}: {}", plan.sweep.label(row));
        }
        runs.push(run);
    }
    if args.detach {
        for run in runs {
            client.enough(run);
            match args.place.who.json {
                true => print_json(&Which { run })?,
                false => print(format!("{run}\n"))?,
            }
        }
        return Ok(Exit::Done);
    }
    let folder = Folder::of(args.out.as_deref(), &plan.name)?;
    let mut rows = Vec::new();
    for (index, run) in runs.into_iter().enumerate() {
        let info = follow(&client, run, u64::MAX, &args.place, args.watch)?;
        let out = folder.path.join(format!("{}", index + 1));
        let folder = bring(&client, &info, Some(&out))?;
        if !args.place.who.voice.quiet {
            eprintln!("run {run} is {}", info.state.word());
        }
        rows.push(Row { folder, exit: exit_of(&info) });
    }
    finish(&plan, &rows, &folder.path, args.place.who.json, args.place.who.voice.quiet)
}

/// Draws the sheet, writes the table; the worst end is the end of the whole.
fn finish(plan: &Plan, rows: &[Row], out: &Path, json: bool, quiet: bool) -> Result<Exit, Trouble> {
    let path = out.join(TABLE);
    let table = table(plan, rows)?;
    write_file(&path, table.as_bytes()).map_err(|error| Trouble::file(&path, error))?;
    let labelled = |(row, values): (&Row, &Vec<String>)| {
        let recording = row.folder.as_ref()?.join("run.mcap");
        Some((recording, plan.sweep.label(values)))
    };
    let shown: Vec<_> = rows.iter().zip(&plan.sweep.rows).filter_map(labelled).collect();
    if let Err(error) = preview::side_by_side(&shown, &out.join(SHEET)) {
        eprintln!("warning: the sweep has no sheet: {error}");
    }
    if json {
        lines(plan, rows)?;
    }
    if !quiet {
        eprintln!("{}", out.display());
    }
    let worst = rows.iter().map(|row| row.exit).max_by_key(|exit| exit.code());
    Ok(worst.unwrap_or(Exit::Interrupted))
}

fn table(plan: &Plan, rows: &[Row]) -> Result<String, Trouble> {
    let keys: Vec<String> = plan.sweep.keys.iter().map(|key| quoted(key)).collect();
    let mut text = format!(
        "run,{},code,fractures,fragments,grains,bodies,jobs,wall_seconds,digest\n",
        keys.join(",")
    );
    for (index, (row, values)) in rows.iter().zip(&plan.sweep.rows).enumerate() {
        let values: Vec<String> = values.iter().map(|value| quoted(bare(value))).collect();
        text += &format!("{},{},{}", index + 1, values.join(","), row.exit.code());
        match &row.folder {
            Some(folder) => {
                let s = summary(folder)?;
                text += &format!(
                    ",{},{},{},{},{},{:.3},{}\n",
                    s.fractures,
                    s.fragments,
                    s.grains,
                    s.bodies_final,
                    s.jobs.opened,
                    s.wall_seconds,
                    s.digest
                );
            }
            None => text += ",,,,,,,\n",
        }
    }
    Ok(text)
}

/// The same as JSON, a line a run.
fn lines(plan: &Plan, rows: &[Row]) -> Result<(), Trouble> {
    for (index, (row, values)) in rows.iter().zip(&plan.sweep.rows).enumerate() {
        let set: BTreeMap<_, _> =
            plan.sweep.keys.iter().zip(values.iter().map(|value| bare(value))).collect();
        let summary = row.folder.as_deref().map(summary).transpose()?;
        let code = row.exit.code();
        print_json(&json!({ "run": index + 1, "set": set, "code": code, "summary": summary }))?;
    }
    Ok(())
}

/// A value without the quotes of TOML.
fn bare(value: &str) -> &str {
    let inside = value.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
    inside.unwrap_or(value)
}

fn summary(folder: &Path) -> Result<Summary, Trouble> {
    let path = folder.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|error| Trouble::file(&path, error))?;
    serde_json::from_str(&text).map_err(|error| Trouble::file(&path, error))
}

/// A field of a CSV table.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}
