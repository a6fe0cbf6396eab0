//! One run of a sweep, and the sheet and the table of runs that are there: for batch systems, which
//! do the runs of a sweep as tasks of a job, on any machine, and then one task more.

use super::named::{Named, read};
use super::table::{FinishOptions, SweepRow, finish};
use crate::args::RunArgs;
use crate::exit::{CommandError, Exit};
use crate::logs;
use crate::run::{checked_framing, run_scene};
use crate::shown::shown;
use cullet::Recording;
use cullet_picture::{Framing, SheetView};
use cullet_proto::recording::EventKind;
use cullet_run::OVERRIDES;
use std::collections::BTreeMap;
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
    let folder = |index: usize| out.join((index + 1).to_string());
    let sets = named.sets(&args.scene.set);
    let found: Vec<RowRun> =
        sets.iter().enumerate().map(|(k, sets)| RowRun::of(&folder(k), sets)).collect();
    let others = found.iter().filter(|run| matches!(run, RowRun::Other)).count();
    let row = |(k, run): (usize, RowRun)| match run {
        RowRun::There(exit) => SweepRow { run: None, folder: Some(folder(k)), exit },
        RowRun::Missing | RowRun::Other => {
            SweepRow { run: None, folder: None, exit: Exit::Unknown }
        }
    };
    let rows: Vec<SweepRow> = found.into_iter().enumerate().map(row).collect();
    let missing = rows.iter().filter(|row| row.folder.is_none()).count();
    let again = if others > 0 { " --replace" } else { "" };
    if missing == count {
        let (file, folder) = (args.scene.scene.display(), out.display());
        let text = format!(
            "{folder}: no run of {file} is there: cullet run {file} --only N{again} makes one"
        );
        return Err(CommandError::new(Exit::Unknown, text).at(folder));
    }
    if missing > 0 && !args.voice.quiet {
        let gone = rows.iter().zip(1..).filter(|(row, _)| row.folder.is_none());
        let numbers: Vec<String> = gone.map(|(_, number)| number.to_string()).collect();
        let numbers = numbers.join(", ");
        logs::say(format!("the rows of {missing} of {count} runs are empty: {numbers}"));
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

/// What is in the folder of a row.
enum RowRun {
    /// Its run, and how that ended.
    There(Exit),
    Missing,
    /// A run that was made with other values than the row has.
    Other,
}

impl RowRun {
    /// Overrides are those of the row, and of the command. A run says by the expectations of its
    /// scene how it ended; one that ended early says nothing.
    fn of(folder: &Path, overrides: &[String]) -> Self {
        let file = folder.join("run.mcap");
        if !file.is_file() || !folder.join("summary.json").is_file() {
            return Self::Missing;
        }
        let Ok(recording) = Recording::open(&file) else { return Self::Missing };
        let had = recording.attachments.get(OVERRIDES).map(|text| String::from_utf8_lossy(text));
        // What is missing may be the values with which it was made.
        let unknown = had.is_none() && !recording.holes.is_empty();
        let had = had.unwrap_or_default();
        if !unknown && !is_of(&had, overrides) {
            let (row, run) = (overrides.join(", "), had.replace('\n', ", "));
            let number = folder.file_name().unwrap_or_default().display();
            let folder = folder.display();
            logs::warn(format!(
                "{folder} was made with other values than its row has, and is left out"
            ));
            logs::warn(format!("the row: {}; the run: {}", shown(&row), shown(&run)));
            logs::warn(format!("--only {number} --replace makes it anew"));
            return Self::Other;
        }
        if !recording.holes.is_empty() {
            let (folder, missing) = (folder.display(), recording.holes.to_string());
            logs::warn(format!("the recording in {folder} has holes: {}", shown(&missing)));
            return Self::There(Exit::File);
        }
        let told = recording.events.iter().filter(|event| event.kind() == EventKind::Expectation);
        let held: Vec<bool> = told.map(|event| event.held).collect();
        Self::There(match held[..] {
            [] => Exit::Interrupted,
            _ if held.contains(&false) => Exit::Unmet,
            _ => Exit::Done,
        })
    }
}

/// Whether a run that was made with the overrides `had`, one after another, has the values of
/// these: of those that set the same key the last is in force.
fn is_of(had: &str, overrides: &[String]) -> bool {
    let pair = |set: &str| {
        let (key, value) = set.split_once('=').unwrap_or((set, ""));
        (key.trim().to_owned(), value.trim().to_owned())
    };
    // A line that does not begin as a key goes on with the value of the last.
    let begins = |line: &str| {
        line.starts_with(|c: char| c.is_alphabetic() || c == '_') && line.contains('=')
    };
    let mut sets: Vec<String> = Vec::new();
    for line in had.lines() {
        match sets.last_mut() {
            Some(last) if !begins(line) => *last = format!("{last}\n{line}"),
            _ => sets.push(line.to_owned()),
        }
    }
    let had: BTreeMap<String, String> = sets.iter().map(|set| pair(set)).collect();
    let wanted: BTreeMap<String, String> = overrides.iter().map(|set| pair(set)).collect();
    wanted.iter().all(|(key, value)| had.get(key) == Some(value))
}

#[cfg(test)]
mod tests {
    use super::{Exit, OVERRIDES, RowRun, is_of};
    use cullet_record::synthetic;

    /// A damaged part may be the one that says with which values a run was made.
    #[test]
    fn a_run_whose_values_are_damaged_is_damaged_and_not_of_another_row() {
        let dir = tempfile::tempdir().expect("a folder");
        let (file, set) = (dir.path().join("run.mcap"), "world.seed=6".to_owned());
        let files = vec![(OVERRIDES.to_owned(), set.clone().into_bytes())];
        let meta = cullet_record::RunMeta { files, ..synthetic::meta() };
        synthetic::run(&file, &meta).expect("records");
        std::fs::write(dir.path().join("summary.json"), "{}").expect("writes");
        let of = |set: &str| RowRun::of(dir.path(), &[set.to_owned()]);
        assert!(matches!(of(&set), RowRun::There(Exit::Done | Exit::Unmet | Exit::Interrupted)));
        assert!(matches!(of("world.seed=7"), RowRun::Other));
        let mut bytes = std::fs::read(&file).expect("reads");
        let at = bytes.windows(set.len()).position(|part| part == set.as_bytes());
        bytes[at.expect("it is attached")] ^= 1;
        std::fs::write(&file, bytes).expect("writes");
        assert!(matches!(of(&set), RowRun::There(Exit::File)));
    }

    #[test]
    fn a_run_is_of_the_row_whose_values_it_has() {
        let row = ["a.b=[\n1,\n2]", "world.seed=6"].map(str::to_owned);
        let had = |text: &str| is_of(text, &row);
        assert!(had("a.b=[\n1,\n2]\nworld.seed=6"));
        assert!(had("a.b=[\n1,\n2]\nworld.seed=6\nexpect.fractures.max=0"));
        assert!(had("world.seed=9\na.b=[\n1,\n2]\nworld.seed=6"), "the last is in force");
        assert!(!had("a.b=[\n1,\n2]\nworld.seed=61"), "another value");
        assert!(!had("a.b=[\n1,\n2]\nworld.seed=6\nworld.seed=9"), "set again");
        assert!(!had("world.seed=6"), "one is missing");
        assert!(!had(""));
        assert!(is_of("", &[]) && is_of("world.seed=6", &[]));
    }
}
