//! Where a run puts its files.

use crate::exit::{CommandError, Exit};
use cullet::{is_free_to_fetch, is_taken};
use cullet_files::claim::hold_folder;
use cullet_files::output::{next_folder, refuse_recording};
use cullet_files::regular::words;
use cullet_pool::{Fetching, ResultFile};
use cullet_run::RESULTS;
use std::path::{Path, PathBuf};

/// Where runs go when no folder is named.
const RUNS: &str = "runs";

/// A folder for one run.
#[derive(Debug)]
pub(crate) struct Folder {
    pub(crate) path: PathBuf,
    /// What was not there before, the innermost first.
    made: Vec<PathBuf>,
}

impl Folder {
    /// The folder that was asked for, made if it is not there, or a new one.
    pub(crate) fn of(asked: Option<&Path>, scene: &str) -> Result<Self, CommandError> {
        asked.map_or(Ok(()), refuse_taken)?;
        Self::to_fetch(asked, scene)
    }

    /// The same for what is fetched, which may go on where it was broken off: see
    /// [`refuse_fetched`].
    pub(crate) fn to_fetch(asked: Option<&Path>, scene: &str) -> Result<Self, CommandError> {
        let target = asked.unwrap_or(Path::new(RUNS));
        if asked.is_some() {
            return Self::at(target);
        }
        let mut made = missing(target);
        let path = next_folder(target, scene).map_err(|error| CommandError::file(target, error))?;
        made.insert(0, path.clone());
        Ok(Self { path, made })
    }

    /// That folder, made if it is not there.
    pub(crate) fn at(target: &Path) -> Result<Self, CommandError> {
        let made = missing(target);
        let there = made.last().map_or(Some(target), |outermost| outermost.parent());
        if let Some(file) = there.filter(|there| there.is_file()) {
            let text = format!("{}: it is a file, not a folder", file.display());
            return Err(CommandError::new(Exit::Usage, text).at(file.display()));
        }
        std::fs::create_dir_all(target).map_err(|error| CommandError::file(target, error))?;
        Ok(Self { path: target.to_owned(), made })
    }

    /// The same for a fetch of which nothing came.
    pub(crate) fn forget_fetch(&self) {
        Fetching::take_back(&self.path);
        self.forget();
    }

    /// Takes back what was made for a run that never began. A folder that was there before stays,
    /// as does one that is not empty.
    pub(crate) fn forget(&self) {
        for folder in &self.made {
            if std::fs::remove_dir(folder).is_err() {
                return;
            }
        }
    }
}

/// The folders on the way to `path` that are not there, the innermost first.
fn missing(path: &Path) -> Vec<PathBuf> {
    let named = path.ancestors().filter(|folder| !folder.as_os_str().is_empty());
    named.take_while(|folder| !folder.exists()).map(Path::to_owned).collect()
}

/// A folder that holds a run is not fetched into, unless that was begun there and broken off.
pub(crate) fn refuse_fetched(folder: &Path) -> Result<(), CommandError> {
    if is_free_to_fetch(folder) { Ok(()) } else { refuse_taken(folder) }
}

/// A folder that holds a run is not written into.
pub(crate) fn refuse_taken(folder: &Path) -> Result<(), CommandError> {
    if is_taken(folder) { Err(taken(folder, "a run")) } else { Ok(()) }
}

fn taken(folder: &Path, what: &str) -> CommandError {
    let text = format!("{}: there is {what} in this folder; name another", folder.display());
    CommandError::new(Exit::Usage, text).at(folder.display())
}

/// What a run leaves in its folder.
const OF_RUN: [&str; 9] = [
    "run.mcap",
    "run.mcap.partial",
    "summary.json",
    "preview.png",
    "preview.gif",
    "timeline.svg",
    "timeline.trace.json",
    "job.bin",
    "attempts.txt",
];
/// What a sweep leaves beside the folders of its runs.
const OF_SWEEP: [&str; 2] = ["table.csv", "sheet.png"];

/// Whether a run is or was recorded in a folder.
fn has_run(folder: &Path) -> bool {
    ["run.mcap", "run.mcap.partial"].iter().any(|name| folder.join(name).exists())
}

/// The folders of the runs of a sweep, from the first on.
fn runs_of(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let numbered = (1_u64..).map(move |number| folder.join(number.to_string()));
    numbered.take_while(|run| run.is_dir())
}

/// A folder in which a run may take the place of another: it has no sweep.
pub(crate) fn to_replace_run(folder: &Path) -> Result<Folder, CommandError> {
    match folder.join("table.csv").exists() && !has_run(folder)
        || runs_of(folder).any(|run| has_run(&run))
    {
        true => Err(taken(folder, "a sweep")),
        false => Folder::at(folder),
    }
}

/// A folder in which a sweep may take the place of another: it has no run of its own.
pub(crate) fn to_replace_sweep(folder: &Path) -> Result<Folder, CommandError> {
    if has_run(folder) { Err(taken(folder, "a run")) } else { Folder::at(folder) }
}

/// Deletes the files of the run in a folder, and no others, so that another run takes its place.
/// Where there is no run, nothing is deleted.
pub(crate) fn clear_run(folder: &Path) -> Result<(), CommandError> {
    if !has_run(folder) {
        return Ok(());
    }
    let _held = hold_folder(folder).map_err(|error| CommandError::file(folder, error))?;
    let results = folder.join(RESULTS);
    ResultFile::delete_all(&results).map_err(|error| CommandError::file(&results, error))?;
    delete(folder, &OF_RUN)
}

/// Deletes the files of the sweep in a folder and of all its runs, and no others. Where there is no
/// sweep, nothing is deleted.
pub(crate) fn clear_sweep(folder: &Path) -> Result<(), CommandError> {
    if !runs_of(folder).any(|run| has_run(&run)) {
        return Ok(());
    }
    runs_of(folder).try_for_each(|run| clear_run(&run))?;
    delete(folder, &OF_SWEEP)
}

fn delete(folder: &Path, names: &[&str]) -> Result<(), CommandError> {
    for name in names {
        let path = folder.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if path.exists() => return Err(CommandError::file(&path, error)),
            _ => {}
        }
    }
    Ok(())
}

/// Refuses a file that is to be written where a recording is, before any work is done for it;
/// [`cullet_files::output`] would in the end.
pub(crate) fn spare_recording(output: &Path) -> Result<(), CommandError> {
    refuse_recording(output).map_err(|error| {
        let text = format!("{}: {}", output.display(), words(&error));
        CommandError::new(Exit::Usage, text).at(output.display())
    })
}

/// Refuses to write over a file that is read, under whatever name.
pub(crate) fn refuse_itself(read: &Path, output: &Path) -> Result<(), CommandError> {
    if is_same(read, output) {
        let text = format!("{}: that is what is read; name another file", output.display());
        return Err(CommandError::new(Exit::Usage, text).at(output.display()));
    }
    Ok(())
}

/// Whether two paths are names of one file.
fn is_same(a: &Path, b: &Path) -> bool {
    let same = |one: Option<PathBuf>, other| one.is_some() && one == other;
    same(a.canonicalize().ok(), b.canonicalize().ok()) || is_linked(a, b)
}

#[cfg(unix)]
fn is_linked(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let one = |path: &Path| std::fs::metadata(path).ok().map(|known| (known.dev(), known.ino()));
    one(a).is_some_and(|a| Some(a) == one(b))
}

#[cfg(not(unix))]
fn is_linked(_: &Path, _: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::{Folder, clear_run, clear_sweep, to_replace_run, to_replace_sweep};
    use std::fs;

    /// What is replaced is a run by a run and a sweep by a sweep; files of the user's stay.
    #[test]
    fn only_a_run_gives_place_to_a_run() {
        let dir = tempfile::tempdir().expect("a folder");
        let base = dir.path();
        let write = |name: &str| {
            let path = base.join(name);
            fs::create_dir_all(path.parent().expect("below the base")).expect("a folder");
            fs::write(path, "").expect("a file");
        };
        let is = |name: &str| base.join(name).exists();
        ["mine/table.csv", "mine/preview.png", "mine/1/note"].into_iter().for_each(write);
        let mine = base.join("mine");
        assert!(to_replace_run(&mine).is_err(), "that table may be a sweep's");
        clear_run(&mine).and(clear_sweep(&mine)).unwrap_or_else(|why| panic!("{why}"));
        assert!(is("mine/table.csv") && is("mine/preview.png"), "there was no run");
        ["sweep/table.csv", "sweep/1/run.mcap", "sweep/2/run.mcap.partial", "sweep/2/note"]
            .into_iter()
            .for_each(write);
        let sweep = base.join("sweep");
        assert!(to_replace_run(&sweep).is_err() && to_replace_sweep(&sweep).is_ok());
        clear_run(&sweep).unwrap_or_else(|why| panic!("{why}"));
        assert!(is("sweep/table.csv") && is("sweep/1/run.mcap"));
        clear_sweep(&sweep).unwrap_or_else(|why| panic!("{why}"));
        assert!(!is("sweep/table.csv") && !is("sweep/1/run.mcap") && is("sweep/2/note"));
        assert!(!is("sweep/2/run.mcap.partial"));
        ["run/run.mcap", "run/summary.json", "run/table.csv"].into_iter().for_each(write);
        let run = base.join("run");
        assert!(to_replace_sweep(&run).is_err() && to_replace_run(&run).is_ok());
        clear_run(&run).unwrap_or_else(|why| panic!("{why}"));
        assert!(!is("run/run.mcap") && !is("run/summary.json") && is("run/table.csv"));
    }

    #[test]
    fn only_what_was_made_for_a_run_is_taken_back() {
        let base = std::env::temp_dir().join(format!("cullet-folder-{}", std::process::id()));
        let (own, new) = (base.join("own"), base.join("own/a/b"));
        fs::create_dir_all(&own).expect("a folder");
        let of = |path| Folder::of(Some(path), "pot").unwrap_or_else(|why| panic!("{why}"));
        of(&own).forget();
        assert!(own.is_dir(), "an empty folder of the user's is gone");
        of(&new).forget();
        assert!(own.is_dir() && !own.join("a").exists(), "what was made is left");
        let used = of(&new);
        fs::write(own.join("a/note"), "").expect("a file");
        used.forget();
        let (inner, outer) = (new.exists(), own.join("a/note").exists());
        fs::remove_dir_all(&base).expect("it goes");
        assert_eq!((inner, outer), (false, true));
    }
}
