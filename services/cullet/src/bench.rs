//! `cullet bench`.

use crate::args::{self, Memory};
use crate::exit::{CommandError, Exit, print, refused};
use crate::folder::{Folder, refuse_itself, spare_recording};
use crate::logs;
use cullet_files::output::create_file;
use cullet_lab::{
    COLUMNS, Limits, Measured, SweepPoint, csv, file_names, json, plan, run_all, status, text,
};
use std::io::Write;
use std::path::Path;
use std::time::Duration;

pub(crate) fn bench(args: &args::Bench) -> Result<Exit, CommandError> {
    let usage = |error: String| CommandError::new(Exit::Usage, error);
    let points = plan(&args.specimens, &args.set, &args.sweep).map_err(usage)?;
    if !args.voice.quiet {
        for warning in warnings(&points) {
            logs::warn(warning);
        }
    }
    let names = file_names(&points);
    if let Some(folder) = &args.out {
        for name in &names {
            spare_recording(&folder.join(format!("{name}.mcap")))?;
        }
        Folder::at(folder)?;
    }
    let mut table = match &args.csv {
        Some(path) => {
            for specimen in &args.specimens {
                refuse_itself(specimen, path)?;
            }
            spare_recording(path)?;
            let file = create_file(path).map_err(|error| CommandError::file(path, error))?;
            Some((path, file))
        }
        None => None,
    };
    let mut write = |line: &str| match &mut table {
        Some((path, file)) => {
            let done = file.write_all(line.as_bytes()).and_then(|()| file.flush());
            done.map_err(|error| CommandError::file(path, error))
        }
        None => Ok(()),
    };
    write(&format!("{COLUMNS}\n"))?;
    let exe = std::env::current_exe().map_err(|error| CommandError::new(Exit::Broken, error))?;
    let workers = args.workers.map_or_else(spare_cores, usize::from).clamp(1, points.len().max(1));
    let limits = Limits {
        exe,
        words: [args.voice.words(), Memory::Auto.words(workers).to_vec()].concat(),
        workers,
        time: Duration::from_secs_f64(args.limit.clamp(1e-3, 1e9)),
    };
    let (mut all, mut trouble) = (Vec::new(), None);
    run_all(&points, &limits, &mut |index, result, recording| {
        let measured = Measured::new(points[index].clone(), result);
        let kept = (names[index].as_str(), recording);
        let written = write(&csv(&measured)).and_then(|()| keep(args, &measured, kept));
        trouble = trouble.take().or(written.err());
        if !args.voice.quiet {
            logs::say(format!("{}/{} {}", index + 1, points.len(), told(&measured)));
        }
        all.push(measured);
    })
    .map_err(|error| refused(&error))?;
    if let Some(trouble) = trouble {
        return Err(trouble);
    }
    if !args.json {
        print(text(&all))?;
    }
    Ok(if all.iter().any(Measured::fails) { Exit::Unmet } else { Exit::Done })
}

fn warnings(points: &[SweepPoint]) -> Vec<String> {
    let all = points.iter().flat_map(|point| {
        point.specimen.warnings.iter().map(|line| format!("{}: {line}", point.specimen.name))
    });
    let mut all: Vec<String> = all.collect();
    all.dedup();
    all
}

/// Files and JSON of one run.
fn keep(
    args: &args::Bench,
    measured: &Measured,
    (name, recording): (&str, Option<&Path>),
) -> Result<(), CommandError> {
    if args.json {
        print(format!("{}\n", json(measured)))?;
    }
    match &args.out {
        Some(folder) => {
            let saved = measured.save(folder, name, recording);
            saved.map_err(|error| CommandError::new(Exit::File, error))
        }
        None => Ok(()),
    }
}

fn told(measured: &Measured) -> String {
    let (result, point) = (&measured.result, &measured.point);
    let swept = point.swept.join(" ");
    if point.specimen.job().is_none() {
        let (name, ending, wall) = (&point.specimen.name, &result.ending, measured.price.wall);
        let (word, steps) = (status(ending), result.steps);
        return format!("{name} {swept}: {word}, {steps} steps of the world, {wall:.2} s");
    }
    format!(
        "{} {swept}: {}, {} points, {} steps, {:.2} s",
        point.specimen.name,
        status(&result.ending),
        result.points,
        result.steps,
        measured.price.wall
    )
}

fn spare_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from).saturating_sub(1).max(1)
}
