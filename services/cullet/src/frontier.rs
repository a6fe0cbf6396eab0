//! `cullet frontier`: error over cost.

use crate::args::{self, Memory};
use crate::exit::{CommandError, Exit, print, refused};
use crate::folder::Folder;
use crate::logs;
use cullet_files::output::write_file;
use cullet_lab::frontier::{FrontierChart, FrontierRow, Set, csv, load, measure, read, rows, text};
use cullet_lab::{Limits, chart};
use std::path::Path;
use std::time::Duration;

/// Longest name of a machine \[letters\].
const NAME: usize = 48;

pub(crate) fn frontier(args: &args::Frontier) -> Result<Exit, CommandError> {
    let usage = |errors| CommandError::new(Exit::Usage, errors);
    let set = load(&args.set, &args.only, args.quick).map_err(usage)?;
    let name = args.machine.clone().unwrap_or_else(this_machine);
    let name = if args.quick { format!("{name}-quick") } else { name };
    let table = args.out.join(format!("{name}.csv"));
    let mut all = known(&table, args.redraw)?;
    if !args.redraw {
        Folder::at(&args.out)?;
        run(args, &set, &table, &mut all)?;
    }
    // Drawn from what the file holds, so that a later --redraw draws the same.
    let all = known(&table, true)?;
    let folder = args.out.join(&name);
    Folder::at(&folder)?;
    for chart in &set.charts {
        if all.iter().any(|row| row.chart == chart.name) {
            show(args, chart, (&all, &name), &folder)?;
        } else {
            logs::warn(format!("{} has no chart \"{}\"", table.display(), chart.name));
        }
    }
    Ok(Exit::Done)
}

/// The rows of a table; none where there is no file, if it need not be there.
fn known(table: &Path, needed: bool) -> Result<Vec<FrontierRow>, CommandError> {
    if !needed && !table.exists() {
        return Ok(Vec::new());
    }
    let text = cullet_files::regular::read_text(table)
        .map_err(|error| CommandError::file(table, error))?;
    let bad = |why: String| CommandError::new(Exit::Usage, format!("{}: {why}", table.display()));
    rows(&text).map_err(bad)
}

/// Runs the charts of a set, each written as soon as it is done.
fn run(
    args: &args::Frontier,
    set: &Set,
    table: &Path,
    all: &mut Vec<FrontierRow>,
) -> Result<(), CommandError> {
    let exe = std::env::current_exe().map_err(|error| CommandError::new(Exit::Broken, error))?;
    let limits = Limits {
        exe,
        words: [args.voice.words(), Memory::Auto.words(usize::from(args.workers)).to_vec()]
            .concat(),
        workers: usize::from(args.workers),
        time: Duration::from_secs_f64(args.limit.clamp(1e-3, 1e9)),
    };
    for chart in &set.charts {
        let measured = measure(chart, &limits, &mut |k, count, row| {
            if !args.voice.quiet {
                logs::say(format!("{} {k}/{count} {}", chart.name, told(row)));
            }
        })
        .map_err(|error| refused(&error))?;
        let at = all.iter().position(|row| row.chart == chart.name).unwrap_or(all.len());
        all.retain(|row| row.chart != chart.name);
        let at = at.min(all.len());
        all.splice(at..at, measured);
        write_file(table, csv(all).as_bytes()).map_err(|error| CommandError::file(table, error))?;
    }
    Ok(())
}

fn told(row: &FrontierRow) -> String {
    let (option, along, seed, status) = (&row.option, &row.along, row.seed, &row.status);
    format!("{option} {along} seed={seed}: {status}, {:.2} s", row.cpu)
}

/// Prints a chart and draws it.
fn show(
    args: &args::Frontier,
    set: &FrontierChart,
    (all, machine): (&[FrontierRow], &str),
    folder: &Path,
) -> Result<(), CommandError> {
    let reading = read(set, all);
    if !args.voice.quiet {
        print(text(set, &reading) + "\n")?;
    }
    let failed = |why| CommandError::new(Exit::Broken, format!("{}: {why}", set.name));
    let path = folder.join(format!("{}.svg", set.name));
    let drawn = chart::svg(set, &reading, machine).map_err(failed)?;
    write_file(&path, drawn.as_bytes()).map_err(|error| CommandError::file(&path, error))?;
    let picture = chart::picture(set, &reading, machine).map_err(failed)?;
    let save = |error| CommandError::new(Exit::File, error);
    picture.save(&folder.join(format!("{}.png", set.name))).map_err(save)
}

/// The processor's name as a file's.
fn this_machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let name = line.map_or("machine", |(_, name)| name.trim()).to_lowercase();
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { ' ' };
    let words: String = name.replace("(r)", " ").replace("(tm)", " ").chars().map(plain).collect();
    let joined = words.split_whitespace().collect::<Vec<_>>().join("-");
    joined.chars().take(NAME).collect::<String>().trim_start_matches('.').to_owned()
}
