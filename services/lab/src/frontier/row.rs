//! One run of one point of a chart, as a line of the CSV that a machine leaves in the tree.

use super::super::table::COLUMNS;
use cullet_files::cells::{quote_cell, read_cell};
use std::collections::BTreeMap;

/// Columns before those of the bench.
const OWN: &str = "chart,option,along,seed,standard";

/// One run: a member of a point of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrontierRow {
    /// The chart.
    pub chart: String,
    /// The curve.
    pub option: String,
    /// Where on the curve: `spacing=2mm`.
    pub along: String,
    /// Which seed.
    pub seed: u64,
    /// Whether this is the default setting.
    pub standard: bool,
    /// The specimen or scene.
    pub bench: String,
    /// Which solver.
    pub solver: String,
    /// Grid spacing \[m\]; 0 where it is not known.
    pub spacing: f64,
    /// Time step \[s\]; 0 where it is not known.
    pub step: f64,
    /// Points a cell \[1\]; 0 where it is not known.
    pub per_cell: f64,
    /// `double` or `single`.
    pub precision: String,
    /// Threads of the solve.
    pub threads: u32,
    /// Wall time \[s\].
    pub wall: f64,
    /// Processor time \[s\].
    pub cpu: f64,
    /// Time steps.
    pub steps: u64,
    /// Points times steps.
    pub particle_steps: u64,
    /// Most memory \[bytes\].
    pub peak: u64,
    /// What was measured.
    pub metric: String,
    /// What it came to.
    pub value: Option<f64>,
    /// What it must come to.
    pub reference: f64,
    /// Their difference over the chart's scale \[1\].
    pub error: Option<f64>,
    /// How the run ended, in a word.
    pub status: String,
}

impl FrontierRow {
    fn line(&self) -> String {
        let number = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
        let text = [&self.chart, &self.option, &self.along].map(|text| quote_cell(text)).join(",");
        format!(
            "{text},{},{},{},{},{},{},{},{},{},{:.4},{:.2},{},{},{},{},{},{},{},{}\n",
            self.seed,
            u8::from(self.standard),
            quote_cell(&self.bench),
            self.solver,
            self.spacing,
            self.step,
            self.per_cell,
            self.precision,
            self.threads,
            self.wall,
            self.cpu,
            self.steps,
            self.particle_steps,
            self.peak,
            quote_cell(&self.metric),
            number(self.value),
            self.reference,
            number(self.error),
            self.status,
        )
    }

    fn of(cell: &dyn Fn(&str) -> Result<String, String>) -> Result<Self, String> {
        Ok(Self {
            chart: cell("chart")?,
            option: cell("option")?,
            along: cell("along")?,
            seed: number(cell, "seed")?,
            standard: cell("standard")? == "1",
            bench: cell("bench")?,
            solver: cell("solver")?,
            spacing: number(cell, "h")?,
            step: number(cell, "dt")?,
            per_cell: number(cell, "ppc")?,
            precision: cell("precision")?,
            threads: number(cell, "threads")?,
            wall: number(cell, "wall_s")?,
            cpu: number(cell, "cpu_s")?,
            steps: number(cell, "steps")?,
            particle_steps: number(cell, "particle_steps")?,
            peak: number(cell, "peak_bytes")?,
            metric: cell("metric")?,
            value: maybe(cell, "value")?,
            reference: number(cell, "ref")?,
            error: maybe(cell, "err")?,
            status: cell("status")?,
        })
    }
}

type Cell<'a> = &'a dyn Fn(&str) -> Result<String, String>;

fn number<T: std::str::FromStr>(cell: Cell<'_>, column: &str) -> Result<T, String> {
    let text = cell(column)?;
    text.parse().map_err(|_| format!("\"{text}\" in `{column}` is not such a number"))
}

fn maybe(cell: Cell<'_>, column: &str) -> Result<Option<f64>, String> {
    if cell(column)?.is_empty() { Ok(None) } else { number(cell, column).map(Some) }
}

/// The rows as CSV, with a head.
#[must_use]
pub fn csv(rows: &[FrontierRow]) -> String {
    let lines: String = rows.iter().map(FrontierRow::line).collect();
    format!("{OWN},{COLUMNS}\n{lines}")
}

/// The rows of such a text; columns may stand in any order, and others beside them.
///
/// # Errors
/// The line, and what is wrong with it.
pub fn rows(text: &str) -> Result<Vec<FrontierRow>, String> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let head = lines.next().map(|(_, line)| cells(line)).unwrap_or_default();
    let names: BTreeMap<&str, usize> =
        head.iter().enumerate().map(|(k, name)| (name.as_str(), k)).collect();
    let read = |(k, line): (usize, &str)| {
        let values = cells(line);
        let cell = |column: &str| {
            let at = names.get(column).ok_or_else(|| format!("no column `{column}`"))?;
            let text = values.get(*at).map(|cell| read_cell(cell).into_owned());
            text.ok_or_else(|| format!("nothing in column `{column}`"))
        };
        FrontierRow::of(&cell).map_err(|why| format!("line {}: {why}", k + 1))
    };
    lines.map(read).collect()
}

/// The cells of a line; quotes keep commas together, and two of them are one.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    let mut letters = line.chars().peekable();
    while let Some(c) = letters.next() {
        match c {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                if let Some(cell) = cells.last_mut() {
                    cell.push('"');
                }
            }
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            other => {
                if let Some(cell) = cells.last_mut() {
                    cell.push(other);
                }
            }
        }
    }
    cells
}
