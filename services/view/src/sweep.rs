//! The page of a sweep: its table, and a picture a run.

use crate::page::{base64, page};
use serde::Serialize;

/// The column behind those of what was set: how the run ended.
const CODE: &str = "code";
/// The column of digests.
const DIGEST: &str = "digest";

/// What a sweep came to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SweepTable {
    /// What it is called.
    pub title: String,
    /// A sentence on it.
    pub about: String,
    /// The names of the columns.
    pub columns: Vec<String>,
    /// A row a run, as text.
    pub rows: Vec<Vec<String>>,
    /// Pictures of the runs.
    pub pictures: Vec<SweepPicture>,
}

/// The picture of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SweepPicture {
    /// The row of the run.
    pub row: usize,
    /// What is written below it.
    pub name: String,
    /// A PNG.
    pub png: Vec<u8>,
}

#[derive(Serialize)]
struct SweepData<'a> {
    kind: &'static str,
    title: &'a str,
    about: &'a str,
    columns: &'a [String],
    rows: Vec<Vec<serde_json::Value>>,
    pictures: Vec<EncodedPicture<'a>>,
}

#[derive(Serialize)]
struct EncodedPicture<'a> {
    row: usize,
    name: &'a str,
    png: String,
}

/// A number where the text is one, else the text. What is set stays as it was written, for a seed
/// is no quantity, and so does a digest.
fn cell(text: &str, column: &str, is_set: bool) -> serde_json::Value {
    let figure = Some(text).filter(|_| !is_set && column != DIGEST);
    let number = figure.and_then(|text| text.parse::<f64>().ok());
    let number = number.and_then(serde_json::Number::from_f64);
    number.map_or_else(|| text.into(), Into::into)
}

/// The cells of a row.
fn cells(row: &[String], columns: &[String]) -> Vec<serde_json::Value> {
    let set = columns.iter().position(|column| column == CODE).unwrap_or(0);
    let all = row.iter().zip(columns).enumerate();
    all.map(|(k, (text, column))| cell(text, column, k < set)).collect()
}

/// The page of a sweep.
///
/// # Errors
/// SweepData that is no JSON, which does not happen with text and numbers.
pub fn sweep_page(table: &SweepTable) -> serde_json::Result<String> {
    let data = SweepData {
        kind: "sweep",
        title: &table.title,
        about: &table.about,
        columns: &table.columns,
        rows: table.rows.iter().map(|row| cells(row, &table.columns)).collect(),
        pictures: table
            .pictures
            .iter()
            .map(|of| EncodedPicture { row: of.row, name: &of.name, png: base64(&of.png) })
            .collect(),
    };
    page(&table.title, include_str!("../assets/sweep.html"), &data, None)
}

#[cfg(test)]
mod tests {
    use super::cells;
    use serde_json::json;

    #[test]
    fn figures_are_numbers_and_what_is_set_is_text() {
        let text = |row: &[&str]| row.iter().map(|cell| (*cell).to_owned()).collect::<Vec<_>>();
        let columns = text(&["row", "world.seed", "code", "grains", "wall_seconds", "digest"]);
        let row = text(&["1", "18446744073709551615", "0", "", "0.250", "12e4"]);
        let wanted = json!(["1", "18446744073709551615", 0.0, "", 0.25, "12e4"]);
        assert_eq!(json!(cells(&row, &columns)), wanted);
    }
}
