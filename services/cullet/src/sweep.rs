//! Sweeps: one scene with many settings, here or at a coordinator, with a contact sheet and a
//! table of what came of them.

mod farm;
mod named;
mod part;
mod table;

pub(crate) use farm::{fetch, submit};

use crate::args::{self, SceneArgs};
use crate::exit::{CommandError, Exit, print};
use crate::folder::{Folder, clear_sweep, to_replace_sweep};
use crate::live::LivePage;
use crate::logs;
use crate::run::{checked_framing, draw, exit_of, start_pool, trouble};
use crate::shown::{lines as lines_of, shown};
use crate::signals::stop_when_told;
use crate::viewers::LiveViewers;
use cullet::{News, RunError, RunOptions};
use cullet_coordinator::sweep::is_sweep;
use cullet_files::regular;
use cullet_picture::SheetView;
use named::{Named, PreparedSweep, plan};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use table::{FinishOptions, SweepRow, finish};

/// Whether a file is a sweep and not a scene.
pub(crate) fn is_one(path: &Path) -> bool {
    path.is_file() && regular::read_text(path).is_ok_and(|text| is_sweep(&text))
}

/// The name of a sweep, its number of runs and where its scene is; all of its scenes are checked.
pub(crate) fn measure(args: &SceneArgs) -> Result<(String, usize, PathBuf), CommandError> {
    let PreparedSweep { named, scenes } = plan(args)?;
    Ok((named.name, scenes.len(), named.scene))
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
