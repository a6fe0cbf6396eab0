//! `cullet export`: a run for other programs.

use crate::args;
use crate::exit::{CommandError, Exit, print};
use crate::folder::{Folder, spare_recording};
use crate::inspect::{open_to_export, unreadable, within};
use crate::logs;
use crate::shown::shown;
use cullet_export::{ExportError, ExportOptions, ExportReport, Moments, export, export_pieces};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

pub(crate) fn run(args: &args::ExportArgs) -> Result<Exit, CommandError> {
    let path = within(&args.recording)?;
    let file = args
        .output
        .clone()
        .or_else(|| args.pieces.is_none().then(|| path.with_file_name("export.glb")));
    if let Some(file) = &file {
        refuse(file)?;
    }
    let recording = open_to_export(&path)?;
    let mut reports = Vec::new();
    if let Some(file) = &file {
        let moments = match (args.at, args.every) {
            (Some(time), _) => Moments::At(time),
            (None, Some(every)) => Moments::Every(every),
            (None, None) => Moments::Motion,
        };
        let options = ExportOptions {
            fps: args.fps,
            start: args.start,
            end: args.end,
            moments,
            grains: !args.no_grains,
        };
        let done = export(&recording, &options, file).map_err(|error| failed(&error, &path))?;
        reports.push(done);
    }
    if let Some(pieces) = &args.pieces {
        let folder = Folder::at(pieces)?;
        let done = export_pieces(&recording, pieces).map_err(|error| {
            folder.forget();
            failed(&error, &path)
        });
        reports.push(done?);
    }
    let left_out = reports.iter().flat_map(|report| &report.pictures_left_out);
    for text in left_out.collect::<BTreeSet<_>>() {
        logs::warn(format!("{}; what is written is without it", shown(text)));
    }
    for note in reports.iter().flat_map(|report| &report.notes).collect::<BTreeSet<_>>() {
        logs::warn(shown(note));
    }
    if args.json {
        let text = serde_json::to_string_pretty(&reports).unwrap_or_default();
        print(text + "\n")?;
    } else {
        reports.iter().for_each(|report| logs::say(line(report)));
    }
    Ok(Exit::Done)
}

fn refuse(file: &Path) -> Result<(), CommandError> {
    spare_recording(file)?;
    if file.is_dir() {
        return Err(CommandError::file(file, "it is a folder; name a file in it, such as run.glb"));
    }
    Ok(())
}

/// What was written, in words.
fn line(report: &ExportReport) -> String {
    let picture =
        |file: &&PathBuf| file.extension().is_some_and(|end| end == "png" || end == "jpg");
    let files: Vec<&PathBuf> = report.files.iter().filter(|file| !picture(file)).collect();
    let beside = report.files.iter().find(picture).and_then(|file| file.parent());
    let beside = beside.map_or_else(String::new, |folder| format!(" in {}", folder.display()));
    let place = match files[..] {
        [one] => one.display().to_string(),
        [first, .., last] => {
            format!("{} to {} ({} files)", first.display(), last.display(), files.len())
        }
        [] => "nothing".to_owned(),
    };
    let grains = match (report.grains, report.grains_left_out) {
        (0, 0) => String::new(),
        (some, 0) => format!(", {some} grains"),
        (some, left) => format!(", {some} grains ({left} left out)"),
    };
    let sheets = match report.sheets {
        0 => String::new(),
        1 => ", 1 sheet".to_owned(),
        some => format!(", {some} sheets"),
    };
    let frames = match report.frames {
        0 | 1 => String::new(),
        frames => format!(", {frames} frames"),
    };
    let pictures = match report.pictures {
        0 => String::new(),
        1 => format!(", 1 picture{beside}"),
        some => format!(", {some} pictures{beside}"),
    };
    let (bodies, size) = (report.bodies, report.bytes as f64 / 1e6);
    format!("{place}: {bodies} bodies{grains}{sheets}{frames}{pictures}, {size:.1} MB")
}

fn failed(error: &ExportError, recording: &Path) -> CommandError {
    match error {
        ExportError::Record(error) => unreadable(error, recording),
        ExportError::Write { path, source } => {
            CommandError::file(path, cullet_files::regular::words(source))
        }
        ExportError::Format { path, .. } => {
            CommandError::new(Exit::Usage, error).at(path.display())
        }
        ExportError::Encode(_) => CommandError::new(Exit::Broken, error).at(recording.display()),
        ExportError::Fps { .. }
        | ExportError::Range { .. }
        | ExportError::Sequence { .. }
        | ExportError::NoPieces => CommandError::new(Exit::Usage, error).at(recording.display()),
    }
}
