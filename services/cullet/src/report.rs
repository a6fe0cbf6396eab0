//! A run or a sweep as one page for a browser.

use crate::args;
use crate::exit::{CommandError, Exit};
use crate::folder::spare_recording;
use crate::inspect::{background, open, within};
use crate::logs;
use cullet_export::page_glb;
use cullet_files::cells::read_cell;
use cullet_files::output::write_file;
use cullet_view::{SweepPicture, SweepTable, run_page, sweep_page};
use std::path::{Path, PathBuf};

/// The table of a sweep, and the picture of one of its runs: its contact sheet.
const TABLE: &str = "table.csv";
const PICTURE: &str = "preview.png";

/// What a page without a name is called.
const PAGE: &str = "report.html";

pub(crate) fn report(args: &args::ReportArgs) -> Result<Exit, CommandError> {
    background(args.background);
    let named = &args.run;
    let is_sweep = named.is_dir() && named.join(TABLE).is_file();
    let output = args.output.clone().unwrap_or_else(|| default_output(named));
    spare_recording(&output)?;
    let page = if is_sweep { sweep(named)? } else { run(&within(named)?)? };
    write_file(&output, page.as_bytes()).map_err(|error| CommandError::file(&output, error))?;
    logs::say(output.display());
    Ok(Exit::Done)
}

/// In the folder that is shown, or beside the recording.
fn default_output(named: &Path) -> PathBuf {
    if named.is_dir() { named.join(PAGE) } else { named.with_file_name(PAGE) }
}

fn run(path: &Path) -> Result<String, CommandError> {
    let recording = open(path)?;
    let model = page_glb(&recording).map_err(|error| CommandError::file(path, error))?;
    run_page(&recording, &model).map_err(|error| CommandError::file(path, error))
}

/// The page of a sweep: the rows of its table, and a picture of each run that is there.
fn sweep(folder: &Path) -> Result<String, CommandError> {
    let path = folder.join(TABLE);
    let trouble = |error: csv::Error| CommandError::file(&path, error);
    let mut reader = csv::Reader::from_path(&path).map_err(trouble)?;
    let texts = |cells: &csv::StringRecord| -> Vec<String> {
        cells.iter().map(|cell| read_cell(cell).into_owned()).collect()
    };
    let columns = texts(reader.headers().map_err(trouble)?);
    let mut table = SweepTable { columns, ..SweepTable::default() };
    for record in reader.records() {
        table.rows.push(texts(&record.map_err(trouble)?));
    }
    let name = folder.canonicalize().ok().and_then(|path| Some(path.file_name()?.to_owned()));
    table.title = name.map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    for (row, cells) in table.rows.iter().enumerate() {
        let Some(number) = cells.first() else { continue };
        let file = folder.join(number).join(PICTURE);
        if !file.is_file() {
            continue;
        }
        let png = std::fs::read(&file).map_err(|error| CommandError::file(&file, error))?;
        table.pictures.push(SweepPicture { row, name: caption(&table.columns, cells), png });
    }
    table.about = format!("{} runs, {} with a picture", table.rows.len(), table.pictures.len());
    sweep_page(&table).map_err(|error| CommandError::file(&path, error))
}

/// What a run of a sweep was set to: its number, then the settings, which stand before `code`.
fn caption(columns: &[String], cells: &[String]) -> String {
    let settings = columns.iter().zip(cells).take_while(|(column, _)| *column != "code");
    let text = settings.map(|(column, cell)| format!("{column} {cell}"));
    text.collect::<Vec<_>>().join(", ")
}
