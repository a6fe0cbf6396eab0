//! Sweeps: which runs there are.

use super::SweepPoint;
use crate::specimen::load;
use cullet_document::SceneErrors;
use std::path::{Path, PathBuf};

/// Most runs of one plan: more are a mistake.
const MAX_RUNS: usize = 100_000;

/// A setting and the values that it takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweptSetting {
    /// Its path, as overrides take it.
    pub key: String,
    /// As they are written.
    pub values: Vec<String>,
}

impl std::str::FromStr for SweptSetting {
    type Err = String;

    /// Reads `key=a,b,c`; commas in brackets or quotes belong to a value.
    fn from_str(text: &str) -> Result<Self, String> {
        let Some((key, values)) = text.split_once('=') else {
            return Err("a sweep is KEY=VALUE,VALUE,…, such as spacing=2mm,1mm".to_owned());
        };
        let (mut depth, mut quoted, mut parts) = (0_i32, false, vec![String::new()]);
        for c in values.chars() {
            match c {
                '"' => quoted = !quoted,
                '[' | '{' => depth += 1,
                ']' | '}' => depth -= 1,
                _ => {}
            }
            if c == ',' && depth == 0 && !quoted {
                parts.push(String::new());
            } else if let Some(last) = parts.last_mut() {
                last.push(c);
            }
        }
        let values: Vec<String> = parts.iter().map(|part| part.trim().to_owned()).collect();
        if key.trim().is_empty() || values.iter().any(String::is_empty) {
            return Err(format!("\"{text}\" has an empty key or value"));
        }
        Ok(Self { key: key.trim().to_owned(), values })
    }
}

/// Every combination of the values of all sweeps, the last sweep fastest.
fn combinations(sweeps: &[SweptSetting]) -> Result<Vec<Vec<String>>, String> {
    let count = sweeps.iter().try_fold(1_usize, |all, s| all.checked_mul(s.values.len()));
    if count.is_none_or(|count| count > MAX_RUNS) {
        return Err(format!("the sweeps make more than {MAX_RUNS} runs"));
    }
    let mut all = vec![Vec::new()];
    for sweep in sweeps {
        let with = |row: &Vec<String>| {
            let one = |value: &String| {
                let setting = format!("{}={value}", sweep.key);
                row.iter().cloned().chain([setting]).collect::<Vec<_>>()
            };
            sweep.values.iter().map(one).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(with).collect();
    }
    Ok(all)
}

/// Specimen files: a file is itself, a folder is every `.toml` in it, by name.
fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let fail = |error: std::io::Error| format!("{}: {error}", path.display());
        let mut found = Vec::new();
        for entry in std::fs::read_dir(path).map_err(fail)? {
            let entry = entry.map_err(fail)?.path();
            if entry.extension().is_some_and(|end| end == "toml") {
                found.push(entry);
            }
        }
        if found.is_empty() {
            return Err(format!("{}: there is no .toml file in it", path.display()));
        }
        found.sort();
        files.extend(found);
    }
    Ok(files)
}

/// Every run: each specimen with every combination of the sweeps, over `set`.
///
/// # Errors
/// A sentence for what is wrong with the sweeps or the files, every error of a specimen.
pub fn plan(
    paths: &[PathBuf],
    set: &[String],
    sweeps: &[SweptSetting],
) -> Result<Vec<SweepPoint>, String> {
    let combinations = combinations(sweeps)?;
    let mut points = Vec::new();
    for file in files(paths)? {
        for swept in &combinations {
            points.push(point(&file, set, swept).map_err(|errors| errors.to_string())?);
        }
    }
    Ok(points)
}

fn point(file: &Path, set: &[String], swept: &[String]) -> Result<SweepPoint, SceneErrors> {
    let overrides: Vec<String> = set.iter().chain(swept).cloned().collect();
    Ok(SweepPoint { specimen: load(file, &overrides)?, swept: swept.to_vec() })
}
