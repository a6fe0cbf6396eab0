//! Commands that look: at recordings, materials, the schema of scenes.

use crate::args;
use crate::exit::{Exit, Trouble, print};
use crate::folder::Folder;
use crate::logs;
use crate::shown::{lines, shown};
use cullet_coordinator::preview::{self, Still, from_recording};
use cullet_coordinator::{record, scene};
use std::path::{Path, PathBuf};

pub(crate) fn inspect(args: &args::Inspect) -> Result<Exit, Trouble> {
    if args.masses {
        let mut masses = Vec::new();
        for recording in std::iter::once(&args.recording).chain(&args.more) {
            masses
                .extend(record::masses(recording).map_err(|error| unreadable(&error, recording))?);
        }
        print(record::table(&masses, args.cells))?;
        return Ok(Exit::Done);
    }
    let told =
        record::inspect(&args.recording).map_err(|error| unreadable(&error, &args.recording))?;
    if !told.complete {
        let name = args.recording.display().to_string();
        let name = shown(&name);
        logs::say(format!("{name}: cut off or damaged; what could be saved follows"));
    }
    if args.json {
        print(told.summary.to_json())?;
        return Ok(Exit::Done);
    }
    let events = told.events.iter().map(|event| shown(event) + "\n");
    print(events.collect::<String>())?;
    print(told.summary.to_json())?;
    Ok(Exit::Done)
}

pub(crate) fn recover(args: &args::Recover) -> Result<Exit, Trouble> {
    if args.recording.is_dir() {
        return Err(Trouble::file(&args.recording, "it is a folder; name the recording in it"));
    }
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.recording));
    if output.exists() {
        let text = format!("{} is there already; name another with -o", output.display());
        return Err(Trouble::new(Exit::Usage, text));
    }
    let saved = record::recover(&args.recording, &output);
    let saved = saved.map_err(|error| unreadable(&error, &args.recording))?;
    logs::say(saved);
    Ok(Exit::Done)
}

/// `run.mcap.partial` becomes `run.mcap`; anything else gets `.recovered.mcap`.
fn default_output(recording: &Path) -> PathBuf {
    let is_partial = recording.extension().is_some_and(|end| end == "partial");
    let plain = recording.with_extension("");
    if is_partial && !plain.exists() { plain } else { recording.with_extension("recovered.mcap") }
}

pub(crate) fn preview(args: &args::Preview) -> Result<Exit, Trouble> {
    let beside = args.recording.parent().unwrap_or(Path::new("")).to_owned();
    let out = args.out.clone().unwrap_or(beside);
    let folder = Folder::at(&out)?;
    let drawn = from_recording(&args.recording, &folder.path);
    drawn.map(|_| Exit::Done).map_err(|error| {
        folder.forget();
        unreadable(&error, &args.recording)
    })
}

pub(crate) fn still(args: &args::Still) -> Result<Exit, Trouble> {
    let beside = || args.recording.with_file_name("still.png");
    let file = args.output.clone().unwrap_or_else(beside);
    let wanted = Still { time: args.at, size: args.size, close: args.close };
    let time = preview::still(&args.recording, &wanted, &file);
    let time = time.map_err(|error| unreadable(&error, &args.recording))?;
    logs::say(format!("{}: the run at {time:.4} s", file.display()));
    Ok(Exit::Done)
}

pub(crate) fn materials(args: &args::Materials) -> Result<Exit, Trouble> {
    if args.json {
        print(format!("{:#}\n", scene::presets_json()))?;
    } else {
        print(scene::presets_text())?;
    }
    Ok(Exit::Done)
}

pub(crate) fn schema(args: &args::Schema) -> Result<Exit, Trouble> {
    print(match (args.specimen, args.whole, args.frontier) {
        (true, _, _) => scene::specimen::schema(),
        (_, true, _) => scene::specimen::whole::schema(),
        (_, _, true) => cullet_coordinator::bench::frontier::schema(),
        _ => scene::schema(),
    })?;
    Ok(Exit::Done)
}

fn unreadable(error: &record::RecordError, recording: &Path) -> Trouble {
    let exit = match error {
        record::RecordError::NotMcap { .. } | record::RecordError::Specimen { .. } => Exit::Usage,
        _ => Exit::File,
    };
    Trouble::new(exit, lines(&error.to_string())).at(recording.display())
}
