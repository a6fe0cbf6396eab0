//! One run of a sweep, and the sheet and the table of runs that are there: for batch systems, which
//! do the runs of a sweep as tasks of a job, on any machine, and then one task more.

use super::{FinishOptions, Named, SweepRow, finish, read};
use crate::args::RunArgs;
use crate::exit::{CommandError, Exit};
use crate::logs;
use crate::run::{checked_framing, run_scene};
use crate::shown::shown;
use cullet::Recording;
use cullet_picture::{Framing, SheetView};
use cullet_proto::recording::EventKind;
use cullet_run::OVERRIDES;
use std::path::Path;

/// `cullet run SWEEP --only N --out DIR`: the run of row N, into DIR/N. It is done also where an
/// expectation does not hold: a batch system does not gather what has failed.
pub(super) fn only(args: &RunArgs, number: usize) -> Result<Exit, CommandError> {
    let named = read(&args.scene.scene)?;
    if !args.sheet.at.is_empty() {
        let text = "--at is for the sheet, which --gather draws and --only does not";
        return Err(CommandError::new(Exit::Usage, text));
    }
    let rows = named.sweep.rows.len();
    let Some(index) = number.checked_sub(1).filter(|index| *index < rows) else {
        let file = args.scene.scene.display();
        let text = format!("--only {number}: {file} has runs 1 to {rows}");
        return Err(CommandError::new(Exit::Usage, text).at(file));
    };
    let scene = named.scene(index, &args.scene.set)?;
    let set = &named.sets(&args.scene.set)[index];
    if !args.voice.quiet {
        logs::say(format!("{number}: {}", shown(&named.sweep.label(&named.sweep.rows[index]))));
    }
    let out = args.out.as_deref().map(|out| out.join(number.to_string()));
    match run_scene(&scene, args, (set, out.as_deref()))? {
        Exit::Unmet => Ok(Exit::Done),
        exit => Ok(exit),
    }
}

/// `cullet run SWEEP --gather --out DIR`: the sheet and the table of the runs in DIR.
pub(super) fn gather(args: &RunArgs) -> Result<Exit, CommandError> {
    let named = read(&args.scene.scene)?;
    let count = named.sweep.rows.len();
    args.sheet.fits(Some(count))?;
    let out = args.out.as_deref().unwrap_or(Path::new(""));
    let row = |(index, values): (usize, &Vec<String>)| {
        let folder = out.join((index + 1).to_string());
        let exit = end_of(&folder, &named.sweep.overrides(values));
        let folder = (exit != Exit::Unknown).then_some(folder);
        SweepRow { run: None, folder, exit }
    };
    let rows: Vec<SweepRow> = named.sweep.rows.iter().enumerate().map(row).collect();
    let missing = rows.iter().filter(|row| row.folder.is_none()).count();
    if missing == count {
        let (file, folder) = (args.scene.scene.display(), out.display());
        let text =
            format!("{folder}: no run of {file} is there: cullet run {file} --only N makes one");
        return Err(CommandError::new(Exit::Unknown, text).at(folder));
    }
    if missing > 0 && !args.voice.quiet {
        logs::say(format!("{missing} of {count} runs are not there: their rows are empty"));
    }
    let framing = framing(args, &named)?;
    let view = SheetView { times: args.sheet.at.clone(), framing };
    finish(
        &named.sweep,
        &rows,
        &FinishOptions { out, view, json: args.json, quiet: args.voice.quiet },
    )
}

/// What the sheet shows; a body that is named must be in the scene.
fn framing(args: &RunArgs, named: &Named) -> Result<Framing, CommandError> {
    match args.close.framing() {
        body @ Framing::Body(_) => checked_framing(body, &named.scene(0, &args.scene.set)?),
        framing => Ok(framing),
    }
}

/// How the run in a folder ended: what it says of the expectations of its scene; one that ended
/// early says nothing. One that was made with other values than its row has is not of the row.
fn end_of(folder: &Path, overrides: &[String]) -> Exit {
    let file = folder.join("run.mcap");
    if !file.is_file() || !folder.join("summary.json").is_file() {
        return Exit::Unknown;
    }
    let Ok(recording) = Recording::open(&file) else { return Exit::Unknown };
    let had = recording.attachments.get(OVERRIDES).map(|text| String::from_utf8_lossy(text));
    let had: Vec<&str> = had.iter().flat_map(|text| text.lines()).collect();
    if let Some(other) = overrides.iter().find(|set| !had.contains(&set.as_str())) {
        let (folder, had) = (folder.display(), had.join(", "));
        logs::warn(format!(
            "{folder} is of another row: the sweep says {}, it was made with \"{}\"",
            shown(other),
            shown(&had)
        ));
        return Exit::Unknown;
    }
    let told = recording.events.iter().filter(|event| event.kind() == EventKind::Expectation);
    let held: Vec<bool> = told.map(|event| event.held).collect();
    match held[..] {
        [] => Exit::Interrupted,
        _ if held.contains(&false) => Exit::Unmet,
        _ => Exit::Done,
    }
}
