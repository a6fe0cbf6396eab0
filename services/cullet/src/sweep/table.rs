//! What came of the runs of a sweep: its contact sheet and its table.

use crate::client::print_json;
use crate::exit::{CommandError, Exit};
use crate::logs;
use cullet::Summary;
use cullet_coordinator::sweep::Sweep;
use cullet_files::cells::quote_cell;
use cullet_files::output::write_file;
use cullet_picture::SheetView;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The contact sheet and the table of a sweep.
const SHEET: &str = "sheet.png";
const TABLE: &str = "table.csv";

/// What came of one run of a sweep.
pub(super) struct SweepRow {
    /// Its number at the coordinator.
    pub(super) run: Option<u64>,
    pub(super) folder: Option<PathBuf>,
    /// How it ended, or why it has no end here.
    pub(super) exit: Exit,
}

impl SweepRow {
    /// Its exit code, if it is over.
    pub(super) fn code(&self) -> Option<u8> {
        (!matches!(self.exit, Exit::Unknown | Exit::Later)).then(|| self.exit.code())
    }
}

/// What is made of the runs of a sweep.
pub(super) struct FinishOptions<'a> {
    /// The folder for the sheet and the table.
    pub(super) out: &'a Path,
    /// What the sheet shows.
    pub(super) view: SheetView,
    /// Whether the rows are printed.
    pub(super) json: bool,
    pub(super) quiet: bool,
}

/// Draws the sheet, writes the table; the worst end is the end of the whole.
pub(super) fn finish(
    sweep: &Sweep,
    rows: &[SweepRow],
    how: &FinishOptions<'_>,
) -> Result<Exit, CommandError> {
    let path = how.out.join(TABLE);
    let table = table(sweep, rows)?;
    write_file(&path, table.as_bytes()).map_err(|error| CommandError::file(&path, error))?;
    let labelled = |(row, values): (&SweepRow, &Vec<String>)| {
        let recording = row.folder.as_ref()?.join("run.mcap");
        Some((recording, sweep.label(values)))
    };
    let drawn: Vec<_> = rows.iter().zip(&sweep.rows).filter_map(labelled).collect();
    if let Err(error) = cullet_picture::side_by_side(&drawn, &how.view, &how.out.join(SHEET)) {
        logs::warn(format!("the sweep has no sheet: {error}"));
    }
    if how.json {
        lines(sweep, rows)?;
    }
    if !how.quiet {
        logs::say(how.out.display());
    }
    Ok(worst(rows))
}

/// The worst end of all.
pub(super) fn worst(rows: &[SweepRow]) -> Exit {
    rows.iter().map(|row| row.exit).reduce(Exit::worse).unwrap_or(Exit::Interrupted)
}

fn table(sweep: &Sweep, rows: &[SweepRow]) -> Result<String, CommandError> {
    let keys: Vec<String> = sweep.keys.iter().map(|key| quote_cell(key)).collect();
    let mut text = format!(
        "row,{},code,run,fractures,fragments,grains,bodies,jobs,wall_seconds,digest\n",
        keys.join(",")
    );
    for (index, (row, values)) in rows.iter().zip(&sweep.rows).enumerate() {
        let values: Vec<String> = values.iter().map(|value| quote_cell(bare(value))).collect();
        let code = row.code().map(|code| code.to_string()).unwrap_or_default();
        let run = row.run.map(|run| run.to_string()).unwrap_or_default();
        text += &format!("{},{},{code},{run}", index + 1, values.join(","));
        match &row.folder {
            Some(folder) => {
                let s = summary(folder)?;
                text += &format!(
                    ",{},{},{},{},{},{:.3},{}\n",
                    s.fractures,
                    s.fragments,
                    s.grains,
                    s.bodies_final,
                    s.jobs.opened,
                    s.wall_seconds,
                    s.digest
                );
            }
            None => text += ",,,,,,,\n",
        }
    }
    Ok(text)
}

/// The same as JSON, a line a run.
pub(super) fn lines(sweep: &Sweep, rows: &[SweepRow]) -> Result<(), CommandError> {
    for (index, (row, values)) in rows.iter().zip(&sweep.rows).enumerate() {
        let set: BTreeMap<_, _> =
            sweep.keys.iter().zip(values.iter().map(|value| bare(value))).collect();
        let summary = row.folder.as_deref().map(summary).transpose()?;
        let code = row.code();
        let (row, run) = (index + 1, row.run);
        print_json(&json!({
            "row": row, "run": run, "set": set, "code": code, "summary": summary
        }))?;
    }
    Ok(())
}

/// A value without the quotes of TOML.
fn bare(value: &str) -> &str {
    let inside = value.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
    inside.unwrap_or(value)
}

fn summary(folder: &Path) -> Result<Summary, CommandError> {
    let path = folder.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|error| CommandError::file(&path, error))?;
    serde_json::from_str(&text).map_err(|error| CommandError::file(&path, error))
}

#[cfg(test)]
mod tests {
    use super::{Exit, Sweep, SweepRow, table};
    use cullet_files::cells::read_cell;

    #[test]
    fn values_of_a_sweep_are_no_formulas() {
        let values = ["\"=1+1\"", "-9.81"].map(str::to_owned).to_vec();
        let keys = ["world.name", "world.gravity"].map(str::to_owned).to_vec();
        let sweep = Sweep { scene: String::new(), keys, rows: vec![values], set: Vec::new() };
        let rows = [SweepRow { run: None, folder: None, exit: Exit::Later }];
        let text = table(&sweep, &rows).unwrap_or_else(|why| panic!("{why}"));
        let row = text.lines().nth(1).expect("a row");
        assert!(row.starts_with("1,'=1+1,-9.81,"), "{text}");
        let name = row.split(',').nth(1).map(read_cell);
        assert_eq!(name.as_deref(), Some("=1+1"), "a page has it as it was");
    }
}
