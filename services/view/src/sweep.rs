//! The page of a sweep: its table, and a picture a run.

use crate::page::{base64, page};
use serde::Serialize;

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

/// A number where the text is one, else the text.
fn cell(text: &str) -> serde_json::Value {
    let number = text.parse::<f64>().ok().and_then(serde_json::Number::from_f64);
    number.map_or_else(|| text.into(), Into::into)
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
        rows: table.rows.iter().map(|row| row.iter().map(|text| cell(text)).collect()).collect(),
        pictures: table
            .pictures
            .iter()
            .map(|of| EncodedPicture { row: of.row, name: &of.name, png: base64(&of.png) })
            .collect(),
    };
    page(&table.title, include_str!("../assets/sweep.html"), &data, None)
}
