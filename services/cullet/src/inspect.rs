//! Commands that look: at recordings, materials, the schema of scenes.

use crate::exit::{CommandError, Exit, print};
use crate::folder::{Folder, spare_recording};
use crate::shown::{lines, shown};
use crate::{args, logs};
use cullet_picture::{Framing, Still, StillTime, framed};
use cullet_record::Recording;
use std::path::{Path, PathBuf};

pub(crate) fn inspect(args: &args::Inspect) -> Result<Exit, CommandError> {
    let mut exit = Exit::Done;
    let mut look = |recording: &Path| {
        let recording = within(recording)?;
        let told =
            cullet_record::inspect(&recording).map_err(|error| unreadable(&error, &recording))?;
        warn_of_gaps(&recording, (told.complete, told.summary.missing.as_deref()));
        if told.damaged {
            exit = Exit::Unwell;
        }
        Ok::<_, CommandError>((recording, told))
    };
    if args.masses {
        let mut masses = Vec::new();
        for recording in std::iter::once(&args.recording).chain(&args.more) {
            let (recording, _) = look(recording)?;
            let more =
                cullet_record::masses(&recording).map_err(|error| unreadable(&error, &recording));
            masses.extend(more?);
        }
        print(cullet_record::table(&masses, args.cells))?;
        return Ok(exit);
    }
    if let Some(reference) = &args.against {
        let (run, reference) = (look(&args.recording)?.0, look(reference)?.0);
        against(&run, &reference, args.largest)?;
        return Ok(exit);
    }
    let (_, told) = look(&args.recording)?;
    if !args.json {
        let events = told.events.iter().map(|event| shown(event) + "\n");
        print(events.collect::<String>())?;
    }
    print(told.summary.to_json())?;
    Ok(exit)
}

/// Prints how the largest pieces of a run compare with those of another, and how long both took.
fn against(run: &Path, reference: &Path, count: usize) -> Result<(), CommandError> {
    let read = |path: &Path| Recording::open(path).map_err(|error| unreadable(&error, path));
    let (run, reference) = (read(run)?, read(reference)?);
    print(cullet_record::rank_table(&cullet_record::ranks(&run, &reference, count)))?;
    let (own, others) = (run.summary().wall_seconds, reference.summary().wall_seconds);
    print(format!("{own:.1} s of time on the clock, and the reference {others:.1} s\n"))
}

/// Opens a recording, and says what it lacks.
pub(crate) fn open(path: &Path) -> Result<Recording, CommandError> {
    let recording = Recording::open(path).map_err(|error| unreadable(&error, path))?;
    let missing = (!recording.holes.is_empty()).then(|| recording.holes.to_string());
    warn_of_gaps(path, (recording.complete, missing.as_deref()));
    Ok(recording)
}

/// Says of a recording that is not complete what it lacks.
fn warn_of_gaps(path: &Path, (complete, missing): (bool, Option<&str>)) {
    let name = path.display().to_string();
    let name = shown(&name);
    match missing {
        Some(missing) => logs::warn(format!(
            "{name} is cut off or damaged and has holes: {}; whatever is made of it lacks that",
            shown(missing)
        )),
        None if !complete => {
            logs::say(format!("{name}: cut off or damaged; what could be saved follows"));
        }
        None => {}
    }
}

/// Opens a recording of which files are written; their notes tell of its holes.
pub(crate) fn open_to_export(path: &Path) -> Result<Recording, CommandError> {
    let recording = Recording::open(path).map_err(|error| unreadable(&error, path))?;
    warn_of_gaps(path, (recording.complete, None));
    Ok(recording)
}

/// The recording that is meant: of a folder of a run the one in it.
pub(crate) fn within(named: &Path) -> Result<PathBuf, CommandError> {
    if !named.is_dir() {
        return Ok(named.to_owned());
    }
    let recording = named.join("run.mcap");
    if recording.exists() || named.join("run.mcap.partial").exists() {
        return Ok(recording);
    }
    let one = named.join("1");
    let sweep = one.join("run.mcap").exists().then(|| format!("; {} has one", one.display()));
    let more = sweep.unwrap_or_default();
    Err(CommandError::file(named, format!("it is a folder, and there is no run.mcap in it{more}")))
}

pub(crate) fn recover(args: &args::Recover) -> Result<Exit, CommandError> {
    let mut named = within(&args.recording)?;
    if args.recording.is_dir() && !named.exists() {
        named.set_extension("mcap.partial");
    }
    let recording = &named;
    let output = args.output.clone().unwrap_or_else(|| default_output(recording));
    if output.exists() {
        let text = format!("{} is there already; name another with -o", output.display());
        return Err(CommandError::new(Exit::Usage, text));
    }
    let saved = cullet_record::recover(recording, &output);
    let saved = saved.map_err(|error| unreadable(&error, recording))?;
    logs::say(saved);
    Ok(Exit::Done)
}

/// `run.mcap.partial` becomes `run.mcap`; anything else gets `.recovered.mcap`.
fn default_output(recording: &Path) -> PathBuf {
    let is_partial = recording.extension().is_some_and(|end| end == "partial");
    let plain = recording.with_extension("");
    if is_partial && !plain.exists() { plain } else { recording.with_extension("recovered.mcap") }
}

pub(crate) fn preview(args: &args::Preview) -> Result<Exit, CommandError> {
    let recording = within(&args.recording)?;
    let beside = recording.parent().unwrap_or(Path::new("")).to_owned();
    let out = args.out.clone().unwrap_or(beside);
    for picture in ["preview.png", "preview.gif"] {
        spare_recording(&out.join(picture))?;
    }
    let read = open(&recording)?;
    let folder = Folder::at(&out)?;
    let drawn = framed(&read, &folder.path, &args.close.framing());
    drawn.map(|_| Exit::Done).map_err(|error| {
        folder.forget();
        unreadable(&error, &recording)
    })
}

pub(crate) fn still(args: &args::StillArgs) -> Result<Exit, CommandError> {
    let recording = within(&args.recording)?;
    let beside = || recording.with_file_name("still.png");
    let file = args.output.clone().unwrap_or_else(beside);
    spare_recording(&file)?;
    if file.is_dir() {
        return Err(CommandError::file(
            &file,
            "it is a folder; name a file in it, such as still.png",
        ));
    }
    if file.extension().is_none_or(|end| !end.eq_ignore_ascii_case("png")) {
        let text = format!("{}: a still is written as PNG; name it .png", file.display());
        return Err(CommandError::new(Exit::Usage, text).at(file.display()));
    }
    background(args.background);
    let time = match (args.at, args.last) {
        (Some(time), _) => StillTime::At(time),
        (None, true) => StillTime::Last,
        (None, false) => StillTime::Telling,
    };
    let framing = args.close.as_deref().map_or(Framing::Whole, Framing::of_close);
    let wanted = Still { time, size: args.size, framing };
    let time = cullet_picture::still(&open(&recording)?, &wanted, &file);
    let time = time.map_err(|error| unreadable(&error, &recording))?;
    logs::say(format!("{}: the run at {time:.4} s", file.display()));
    Ok(Exit::Done)
}

/// Lets others go first, if that is wished; where it cannot be done it does not matter.
pub(crate) fn background(wished: bool) {
    #[cfg(unix)]
    if wished {
        let _as_it_was = rustix::process::nice(10);
    }
    #[cfg(not(unix))]
    let _ = wished;
}

pub(crate) fn materials(args: &args::Materials) -> Result<Exit, CommandError> {
    if args.json {
        print(format!("{:#}\n", cullet_scene::presets_json()))?;
    } else {
        print(cullet_scene::presets_text())?;
    }
    Ok(Exit::Done)
}

pub(crate) fn schema(args: &args::Schema) -> Result<Exit, CommandError> {
    let page = match (args.reference, args.recording) {
        (true, _) => Some(cullet_scene::reference()),
        (_, true) => Some(cullet_proto::recording::schema_text()),
        _ => None,
    };
    if let Some(page) = page {
        print(page)?;
        return Ok(Exit::Done);
    }
    print(match (args.specimen, args.whole, args.frontier) {
        (true, _, _) => cullet_lab::specimen::schema(),
        (_, true, _) => cullet_lab::specimen::whole::schema(),
        (_, _, true) => cullet_lab::frontier::schema(),
        _ => cullet_scene::schema(),
    })?;
    Ok(Exit::Done)
}

pub(crate) fn unreadable(error: &cullet_record::RecordError, recording: &Path) -> CommandError {
    let exit = match error {
        cullet_record::RecordError::NotMcap { .. }
        | cullet_record::RecordError::Foreign { .. }
        | cullet_record::RecordError::Beyond { .. }
        | cullet_record::RecordError::NoBody { .. }
        | cullet_record::RecordError::Specimen { .. }
        | cullet_record::RecordError::Swollen { .. } => Exit::Usage,
        _ => Exit::File,
    };
    CommandError::new(exit, lines(&error.to_string())).at(recording.display())
}
