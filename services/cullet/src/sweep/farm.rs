//! Sweeps at a coordinator: handed in at once, fetched together, then or later.

use super::named::{Named, PreparedSweep, plan, read};
use super::table::{FinishOptions, SweepRow, finish, lines, worst};
use crate::client::{bring, connect, exit_of, follow, hand_in, has_summary, known, print_json};
use crate::exit::{CommandError, Exit, print, refused};
use crate::folder::{Folder, refuse_fetched, refuse_taken};
use crate::shown::shown;
use crate::{args, logs};
use cullet::{Client, Terms};
use cullet_document::Bundle;
use cullet_picture::SheetView;
use cullet_pool::{Fetching, mark};
use cullet_proto::service::{RunInfo, Which};
use cullet_scene::{Scene, name_at};
use std::collections::BTreeMap;
use std::path::Path;

/// `cullet submit SWEEP`: all at once to a coordinator.
pub(crate) fn submit(args: &args::SubmitArgs) -> Result<Exit, CommandError> {
    let PreparedSweep { named, scenes } = plan(&args.scene)?;
    args.sheet.fits(Some(scenes.len()))?;
    args.out.as_deref().map_or(Ok(()), refuse_taken)?;
    let client = connect(&args.place)?;
    let mut runs = vec![None; scenes.len()];
    let handed = hand_all(args, &client, (&named, &scenes), &mut runs);
    let (place, times) = (&args.place, &args.sheet.at[..]);
    let how = FetchOptions { client: &client, place, follows: true, bar: args.watch, times };
    let file = args.scene.scene.as_path();
    handed.map_err(|trouble| advice(trouble, &runs, file, args))?;
    if args.detach {
        if !args.place.who.voice.quiet {
            let set = set_of(&args.scene.set);
            let file = file.display();
            logs::say(format!("fetch them together: cullet fetch {file} --follow{set}"));
        }
        return Ok(Exit::Done);
    }
    let rows = how.rows(&named, &runs, args.out.as_deref());
    rows.map_err(|trouble| advice(trouble, &runs, file, args))
}

/// Hands in the runs of a sweep one after another, or those that are not there yet.
fn hand_all(
    args: &args::SubmitArgs,
    client: &Client,
    (named, scenes): (&Named, &[Scene]),
    runs: &mut [Option<u64>],
) -> Result<(), CommandError> {
    let quiet = args.place.who.voice.quiet;
    let sets = named.sets(&args.scene.set);
    let marks: Result<Vec<String>, _> = scenes.iter().map(|scene| mark(&scene.bundle())).collect();
    let marks = marks.map_err(|error| refused(&error))?;
    if args.rest {
        let there = find(client, named, &sets, Some(&marks))?;
        runs.copy_from_slice(&there);
    }
    let waits = (!args.detach).then_some(!quiet);
    for (index, scene) in scenes.iter().enumerate() {
        let run = match runs[index] {
            Some(run) => run,
            None => {
                let ticket = format!("{}-{}", marks[index], Terms::unique().ticket);
                let (priority, sweep) = (args.priority, named.name.clone());
                let terms = Terms { ticket, priority, sweep, ..Terms::default() };
                let bundle: Bundle = scene.bundle();
                hand_in(client, &bundle, terms, waits)?
            }
        };
        runs[index] = Some(run);
        if args.detach {
            client.enough(run);
            match args.place.who.json {
                true => print_json(&Which { run })?,
                false => print(format!("{run}\n"))?,
            }
        } else if !quiet {
            let label = named.sweep.label(&named.sweep.rows[index]);
            logs::say(format!("run {run}: {}", shown(&label)));
        }
    }
    Ok(())
}

/// What is there of a sweep that was broken off, and how to go on with it.
fn advice(
    trouble: CommandError,
    runs: &[Option<u64>],
    file: &Path,
    args: &args::SubmitArgs,
) -> CommandError {
    let there: Vec<u64> = runs.iter().flatten().copied().collect();
    if there.is_empty() {
        return trouble;
    }
    let set = set_of(&args.scene.set);
    let (file, numbers) = (file.display(), numbers(&there));
    let next = match there.len() < runs.len() {
        true => {
            let detach = if args.detach { " --detach" } else { "" };
            format!("hand in the rest: cullet submit {file} --rest{set}{detach}")
        }
        false => format!("fetch them: cullet fetch {file} --follow{set}"),
    };
    let (count, all) = (there.len(), runs.len());
    let text = format!("{trouble}\n{count} of {all} runs are there and go on: {numbers}; {next}");
    trouble.said(text)
}

/// Overrides as they are typed.
fn set_of(set: &[String]) -> String {
    set.iter().map(|set| format!(" --set '{set}'")).collect()
}

/// Numbers as people write them.
fn numbers(runs: &[u64]) -> String {
    let mut sorted = runs.to_vec();
    sorted.sort_unstable();
    let mut spans: Vec<(u64, u64)> = Vec::new();
    for run in sorted {
        match spans.last_mut() {
            Some((_, to)) if run <= *to + 1 => *to = run,
            _ => spans.push((run, run)),
        }
    }
    let word = |(from, to): &(u64, u64)| match to - from {
        0 => from.to_string(),
        _ => format!("{from} to {to}"),
    };
    spans.iter().map(word).collect::<Vec<_>>().join(", ")
}

/// `cullet fetch SWEEP`: what its runs recorded, with the sheet and the table.
pub(crate) fn fetch(args: &args::FetchArgs, file: &Path) -> Result<Exit, CommandError> {
    if !file.is_file() {
        let text = format!(
            "{}: it is neither the number of a run nor the file of a sweep that exists",
            file.display()
        );
        return Err(CommandError::new(Exit::Usage, text).at(file.display()));
    }
    let named = read(file)?;
    args.sheet.fits(Some(named.sweep.rows.len()))?;
    args.out.as_deref().map_or(Ok(()), refuse_fetched)?;
    let client = connect(&args.place)?;
    let runs = find(&client, &named, &named.sets(&args.set), None)?;
    let place = &args.place;
    if runs.iter().all(Option::is_none) {
        let (name, user, at) = (&named.name, client.user(), &place.connect);
        return Err(CommandError::new(
            Exit::Unknown,
            format!(
                "{}: no run of it is at {at}: none that {user} has handed in as part of the sweep \
                 {name:?} has these values (--set as it was submitted)",
                file.display()
            ),
        ));
    }
    let times = &args.sheet.at[..];
    let how = FetchOptions { client: &client, place, follows: args.follow, bar: true, times };
    how.rows(&named, &runs, args.out.as_deref())
}

/// The newest runs of a sweep, those of whom one is, one for each row that has one. `marks`: only
/// of the scenes that have these marks.
fn find(
    client: &Client,
    named: &Named,
    sets: &[Vec<String>],
    marks: Option<&[String]>,
) -> Result<Vec<Option<u64>>, CommandError> {
    let runs = client.runs().map_err(|error| refused(&error))?;
    let scene = name_at(&named.scene);
    let own = runs
        .iter()
        .rev()
        .filter(|run| run.user == client.user() && run.sweep == named.name && run.name == scene);
    let mut wanted: BTreeMap<&[String], Vec<usize>> = BTreeMap::new();
    for (index, set) in sets.iter().enumerate() {
        wanted.entry(set).or_default().push(index);
    }
    let mut found = vec![None; sets.len()];
    for run in own {
        let info: RunInfo = match known(client, run.run) {
            // It went in between.
            Err(trouble) if trouble.exit == Exit::Unknown => continue,
            info => info?,
        };
        let fits = |row: &usize| marks.is_none_or(|marks| info.ticket.starts_with(&marks[*row]));
        let same = wanted.get(info.overrides.as_slice()).into_iter().flatten().copied();
        if let Some(row) = same.filter(fits).rfind(|row| found[*row].is_none()) {
            found[row] = Some(run.run);
        }
        if found.iter().all(Option::is_some) {
            break;
        }
    }
    Ok(found)
}

/// How the runs of a sweep are fetched.
struct FetchOptions<'a> {
    client: &'a Client,
    place: &'a args::ConnectArgs,
    /// To its end first; otherwise what is not over is left out.
    follows: bool,
    bar: bool,
    /// Moments that the sheet shows \[s\].
    times: &'a [f64],
}

impl FetchOptions<'_> {
    /// Fetches the runs into a folder, with the sheet and the table; where none is over, there is
    /// no folder.
    fn rows(
        &self,
        named: &Named,
        runs: &[Option<u64>],
        out: Option<&Path>,
    ) -> Result<Exit, CommandError> {
        let folder = Folder::to_fetch(out, &named.name)?;
        let who = &self.place.who;
        let what = format!("sweep {}: {runs:?}\n", named.name);
        let fetching = Fetching::begin(&folder.path, &what).map_err(|error| refused(&error))?;
        let (mut rows, mut missing, mut going) = (Vec::new(), 0, Vec::new());
        for (index, run) in runs.iter().enumerate() {
            let out = folder.path.join((index + 1).to_string());
            let row = match run {
                Some(run) => self.row(*run, &out).inspect_err(|_| folder.forget_fetch())?,
                None => SweepRow { run: None, folder: None, exit: Exit::Unknown },
            };
            match (row.exit, run) {
                (Exit::Later, Some(run)) => going.push(*run),
                (Exit::Unknown, _) => missing += 1,
                _ => {}
            }
            rows.push(row);
        }
        if missing > 0 && !who.voice.quiet {
            logs::say(format!(
                "{missing} of {} runs are not there: their rows are empty",
                rows.len()
            ));
        }
        if !going.is_empty() && !who.voice.quiet {
            let (count, all, numbers) = (going.len(), rows.len(), numbers(&going));
            logs::say(format!(
                "{count} of {all} runs are not over, and their rows are empty: {numbers}; \
                 --follow waits for them"
            ));
        }
        let over = rows.iter().any(|row| row.code().is_some());
        let view = SheetView { times: self.times.to_vec(), ..SheetView::default() };
        let (json, quiet) = (who.json, who.voice.quiet);
        let how = FinishOptions { out: &folder.path, view, json, quiet };
        let exit = over.then(|| finish(&named.sweep, &rows, &how)).transpose()?;
        fetching.done().map_err(|error| refused(&error))?;
        if let Some(exit) = exit {
            return Ok(exit);
        }
        folder.forget();
        if who.json {
            lines(&named.sweep, &rows)?;
        }
        Ok(worst(&rows))
    }

    /// Fetches one run.
    fn row(&self, run: u64, out: &Path) -> Result<SweepRow, CommandError> {
        let info = match self.follows {
            true => follow(self.client, run, u64::MAX, self.place, self.bar),
            false => known(self.client, run),
        };
        let info = match info {
            Err(trouble) if trouble.exit == Exit::Unknown => {
                logs::error(&trouble);
                return Ok(SweepRow { run: None, folder: None, exit: Exit::Unknown });
            }
            info => info?,
        };
        if !info.state.is_over() {
            return Ok(SweepRow { run: Some(run), folder: None, exit: Exit::Later });
        }
        // One that stalled has files, and is not done.
        let folder = bring(self.client, &info, Some(out))?.filter(|_| has_summary(&info));
        if !self.place.who.voice.quiet {
            logs::say(format!("run {run} is {}", info.state.word()));
        }
        Ok(SweepRow { run: Some(run), folder, exit: exit_of(&info) })
    }
}

#[cfg(test)]
mod tests {
    use super::numbers;

    #[test]
    fn numbers_are_told_as_spans() {
        assert_eq!(numbers(&[]), "");
        assert_eq!(numbers(&[3]), "3");
        assert_eq!(numbers(&[9, 1, 2, 3, 7, 8]), "1 to 3, 7 to 9");
        assert_eq!(numbers(&[1, 3]), "1, 3");
    }
}
