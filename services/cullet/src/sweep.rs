//! Sweeps: one scene with many settings, here or at a coordinator, with a contact sheet and a
//! table of what came of them.

mod farm;
mod part;

pub(crate) use farm::{fetch, submit};

use crate::args::{self, SceneArgs};
use crate::client::print_json;
use crate::exit::{CommandError, Exit, print};
use crate::folder::{Folder, clear_sweep, to_replace_sweep};
use crate::live::LivePage;
use crate::logs;
use crate::run::{checked_framing, draw, exit_of, read_scene, start_pool, trouble};
use crate::shown::{lines as lines_of, shown};
use crate::signals::stop_when_told;
use crate::viewers::LiveViewers;
use cullet::{News, RunError, RunOptions, Scene, Summary};
use cullet_coordinator::sweep::{Sweep, is_sweep};
use cullet_files::output::write_file;
use cullet_files::regular;
use cullet_picture::SheetView;
use cullet_proto::service::MAX_TICKET;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// The contact sheet and the table of a sweep.
const SHEET: &str = "sheet.png";
const TABLE: &str = "table.csv";

/// Whether a file is a sweep and not a scene.
pub(crate) fn is_one(path: &Path) -> bool {
    path.is_file() && regular::read_text(path).is_ok_and(|text| is_sweep(&text))
}

/// A sweep, and what its file is called.
struct Named {
    name: String,
    sweep: Sweep,
    /// Where its scene is.
    scene: PathBuf,
}

fn read(file: &Path) -> Result<Named, CommandError> {
    let text = regular::read_text(file).map_err(|error| CommandError::file(file, error))?;
    let wrong = |text: String| {
        CommandError::new(Exit::Usage, format!("{}: {text}", file.display())).at(file.display())
    };
    if !is_sweep(&text) {
        return Err(wrong("it is no sweep: it has neither [product] nor [[zip]]".to_owned()));
    }
    let sweep = Sweep::read(&text).map_err(|error| wrong(error.to_string()))?;
    let name = file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let mut name = name.unwrap_or_default();
    name.truncate(name.floor_char_boundary(MAX_TICKET));
    let scene = file.parent().unwrap_or(Path::new("")).join(&sweep.scene);
    Ok(Named { name, sweep, scene })
}

/// A sweep with all its scenes, each checked.
struct PreparedSweep {
    named: Named,
    scenes: Vec<Scene>,
}

fn plan(args: &SceneArgs) -> Result<PreparedSweep, CommandError> {
    let named = read(&args.scene)?;
    let mut scenes = Vec::new();
    for index in 0..named.sweep.rows.len() {
        scenes.push(named.scene(index, &args.set)?);
    }
    Ok(PreparedSweep { named, scenes })
}

/// The name of a sweep, its number of runs and where its scene is; all of its scenes are checked.
pub(crate) fn measure(args: &SceneArgs) -> Result<(String, usize, PathBuf), CommandError> {
    let PreparedSweep { named, scenes } = plan(args)?;
    Ok((named.name, scenes.len(), named.scene))
}

impl Named {
    /// The scene of a row, with what is set for all.
    fn scene(&self, index: usize, more: &[String]) -> Result<Scene, CommandError> {
        let row = &self.sweep.rows[index];
        let set = [&self.sweep.overrides(row)[..], more].concat();
        let args = SceneArgs { scene: self.scene.clone(), set, set_file: None, draft: None };
        read_scene(&args).map_err(|trouble| {
            let text = format!("{}: {trouble}", self.sweep.label(row));
            trouble.said(text)
        })
    }

    /// What is set for each run, with what is set for all.
    fn sets(&self, more: &[String]) -> Vec<Vec<String>> {
        let set = |row: &Vec<String>| [&self.sweep.overrides(row)[..], more].concat();
        self.sweep.rows.iter().map(set).collect()
    }
}

/// What came of one run of a sweep.
struct SweepRow {
    /// Its number at the coordinator.
    run: Option<u64>,
    folder: Option<PathBuf>,
    /// How it ended, or why it has no end here.
    exit: Exit,
}

impl SweepRow {
    /// Its exit code, if it is over.
    fn code(&self) -> Option<u8> {
        (!matches!(self.exit, Exit::Unknown | Exit::Later)).then(|| self.exit.code())
    }
}

/// `cullet check SWEEP`: what each of its runs is.
pub(crate) fn check(args: &SceneArgs) -> Result<Exit, CommandError> {
    let PreparedSweep { named: Named { name, sweep, .. }, scenes } = plan(args)?;
    let mut lines = vec![format!("{}: {} runs", shown(&name), scenes.len())];
    for (scene, row) in scenes.iter().zip(&sweep.rows) {
        let (name, bodies) = (shown(&scene.name), scene.bodies.len());
        let (steps, step) = (scene.steps(), scene.world.step);
        let label = sweep.label(row);
        let label = shown(&label);
        lines.push(format!("  {label}: {name}, {bodies} bodies, {steps} steps of {step} s"));
        lines.extend(scene.warnings.iter().map(|line| format!("    warning: {line}")));
    }
    print(lines.join("\n") + "\n")?;
    Ok(Exit::Done)
}

/// `cullet run SWEEP`: one after another on one pool.
pub(crate) fn run(args: &args::RunArgs) -> Result<Exit, CommandError> {
    match args.part.only {
        Some(number) => part::only(args, number),
        None if args.part.gather => part::gather(args),
        None => run_all(args),
    }
}

fn run_all(args: &args::RunArgs) -> Result<Exit, CommandError> {
    let stop = &stop_when_told("the recording is finished first")?;
    let PreparedSweep { named, scenes } = plan(&args.scene)?;
    let sweep = &named.sweep;
    args.sheet.fits(Some(scenes.len()))?;
    let mut framing = args.close.framing();
    for scene in &scenes {
        framing = checked_framing(framing, scene)?;
    }
    // Once for all, before anything is deleted or made.
    let again = args.again.of_sweep();
    again.check_sweep(args.out.as_deref(), &scenes).map_err(|error| trouble(&error))?;
    let folder = match args.out.as_deref().filter(|_| args.replace) {
        Some(out) => to_replace_sweep(out)?,
        None => Folder::of(args.out.as_deref(), &named.name)?,
    };
    let sets = named.sets(&args.scene.set);
    let runs = scenes.iter().map(|scene| scene.name.clone()).zip(sets);
    let live = LivePage::open(args.live, runs, args.voice.quiet);
    let mut live = live.inspect_err(|_| folder.forget())?;
    let viewers = LiveViewers::open(args.foxglove, args.voice.quiet);
    let viewers = viewers.inspect_err(|_| folder.forget())?;
    let pool = start_pool(args).inspect_err(|_| folder.forget())?;
    if args.replace {
        clear_sweep(&folder.path)?;
    }
    let tells_results = args.again.from.is_some() && !args.voice.quiet;
    let mut rows = Vec::new();
    for (index, scene) in scenes.iter().enumerate() {
        let out = folder.path.join(format!("{}", index + 1));
        std::fs::create_dir_all(&out).map_err(|error| CommandError::file(&out, error))?;
        if !args.voice.quiet {
            logs::say(format!("{}: {}", index + 1, shown(&sweep.label(&sweep.rows[index]))));
        }
        let tap = viewers.as_ref().map(|viewers| viewers.begin(&sweep.label(&sweep.rows[index])));
        let options = RunOptions { out: &out, stop, tap, again };
        live.iter_mut().for_each(|page| page.begin(index, &out, &pool));
        let outcome = pool.run(scene, &options, &mut |news| {
            live.iter_mut().for_each(|page| page.show(news, &pool));
            match news {
                News::Line(line) if args.voice.verbose > 0 => logs::say(lines_of(line)),
                News::Results(line) if args.voice.verbose > 0 || tells_results => {
                    logs::say(lines_of(line));
                }
                News::Line(_) | News::Results(_) | News::At(_) => {}
            }
        });
        let exit = match &outcome {
            Ok(outcome) => {
                let drawn = args.no_pictures || draw(&outcome.recording, &out, &framing).is_ok();
                exit_of(outcome, drawn)
            }
            Err(error) => failed_row(index + 1, error),
        };
        let why = outcome.as_ref().err().map(ToString::to_string).unwrap_or_default();
        live.iter_mut().for_each(|page| page.end(exit, &why, &pool));
        rows.push(SweepRow { run: None, folder: outcome.is_ok().then_some(out), exit });
        if stop.load(Ordering::Relaxed) {
            break;
        }
    }
    viewers.iter().for_each(LiveViewers::end);
    live.iter().for_each(|page| page.linger(&pool, stop, args.voice.quiet));
    drop((live, pool));
    let view = SheetView { times: args.sheet.at.clone(), framing };
    let how = FinishOptions { out: &folder.path, view, json: args.json, quiet: args.voice.quiet };
    finish(sweep, &rows, &how)
}

/// Tells why a run of a sweep failed.
fn failed_row(number: usize, error: &RunError) -> Exit {
    let trouble = trouble(error);
    let text = format!("run {number}: {trouble}");
    let trouble = trouble.said(text);
    logs::error(&trouble);
    trouble.exit
}

/// What is made of the runs of a sweep.
struct FinishOptions<'a> {
    /// The folder for the sheet and the table.
    out: &'a Path,
    /// What the sheet shows.
    view: SheetView,
    /// Whether the rows are printed.
    json: bool,
    quiet: bool,
}

/// Draws the sheet, writes the table; the worst end is the end of the whole.
fn finish(sweep: &Sweep, rows: &[SweepRow], how: &FinishOptions<'_>) -> Result<Exit, CommandError> {
    let path = how.out.join(TABLE);
    let table = table(sweep, rows)?;
    write_file(&path, table.as_bytes()).map_err(|error| CommandError::file(&path, error))?;
    let labelled = |(row, values): (&SweepRow, &Vec<String>)| {
        let recording = row.folder.as_ref()?.join("run.mcap");
        Some((recording, sweep.label(values)))
    };
    let drawn: Vec<_> = rows.iter().zip(&sweep.rows).filter_map(labelled).collect();
    if let Err(error) = cullet_picture::side_by_side(&drawn, &how.view, &how.out.join(SHEET)) {
        logs::warn(format!("the sweep has no sheet: {error}"));
    }
    if how.json {
        lines(sweep, rows)?;
    }
    if !how.quiet {
        logs::say(how.out.display());
    }
    Ok(worst(rows))
}

/// The worst end of all.
fn worst(rows: &[SweepRow]) -> Exit {
    rows.iter().map(|row| row.exit).reduce(Exit::worse).unwrap_or(Exit::Interrupted)
}

fn table(sweep: &Sweep, rows: &[SweepRow]) -> Result<String, CommandError> {
    let keys: Vec<String> = sweep.keys.iter().map(|key| quoted(key)).collect();
    let mut text = format!(
        "row,{},code,run,fractures,fragments,grains,bodies,jobs,wall_seconds,digest\n",
        keys.join(",")
    );
    for (index, (row, values)) in rows.iter().zip(&sweep.rows).enumerate() {
        let values: Vec<String> = values.iter().map(|value| quoted(bare(value))).collect();
        let code = row.code().map(|code| code.to_string()).unwrap_or_default();
        let run = row.run.map(|run| run.to_string()).unwrap_or_default();
        text += &format!("{},{},{code},{run}", index + 1, values.join(","));
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
fn lines(sweep: &Sweep, rows: &[SweepRow]) -> Result<(), CommandError> {
    for (index, (row, values)) in rows.iter().zip(&sweep.rows).enumerate() {
        let set: BTreeMap<_, _> =
            sweep.keys.iter().zip(values.iter().map(|value| bare(value))).collect();
        let summary = row.folder.as_deref().map(summary).transpose()?;
        let code = row.code();
        let (row, run) = (index + 1, row.run);
        print_json(&json!({
            "row": row, "run": run, "set": set, "code": code, "summary": summary
        }))?;
    }
    Ok(())
}

/// A value without the quotes of TOML.
fn bare(value: &str) -> &str {
    let inside = value.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
    inside.unwrap_or(value)
}

fn summary(folder: &Path) -> Result<Summary, CommandError> {
    let path = folder.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|error| CommandError::file(&path, error))?;
    serde_json::from_str(&text).map_err(|error| CommandError::file(&path, error))
}

/// A field of a CSV table.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}
