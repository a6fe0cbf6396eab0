//! Measures what f32 costs and saves: the same scenes, with the settings of the rigid world, in
//! both. Each runs in a process of its own, so that its memory can be told.

#![allow(
    clippy::duplicate_mod,
    clippy::unnecessary_cast,
    clippy::useless_conversion,
    reason = "the same scenes over two engines, one of which needs no conversion"
)]

mod double;
mod single;

use std::fmt::Write as _;
use std::process::{Command, ExitCode};

/// One line of the table: what, in which unit, and how it came out.
type Row = (String, f64);

/// A field of what the system tells of this process \[MiB\]; zero where it does not tell.
fn memory(field: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with(field));
    let kibibytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok());
    kibibytes.unwrap_or(0.0) / 1024.0
}

/// Runs the scenes and prints their rows.
fn tell(rows: fn() -> Vec<Row>) {
    let start = memory("VmRSS:");
    for (what, value) in rows() {
        println!("{what}\t{value:e}");
    }
    println!("most memory for a scene [MiB]\t{:e}", memory("VmHWM:") - start);
}

/// The rows that a child process printed.
fn run(precision: &str) -> Result<Vec<Row>, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let output = Command::new(program).arg(precision).output().map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let row = |line: &str| {
        let (what, value) = line.split_once('\t')?;
        Some((what.to_owned(), value.parse().ok()?))
    };
    Ok(text.lines().filter_map(row).collect())
}

fn table() -> Result<String, String> {
    let (single, double) = (run("f32")?, run("f64")?);
    let mut table = String::from("| what | f32 | f64 |\n|---|---|---|\n");
    for ((what, one), (_, two)) in single.iter().zip(&double) {
        let _infallible = writeln!(table, "| {what} | {} | {} |", short(*one), short(*two));
    }
    Ok(table)
}

/// Three digits.
fn short(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-2..1e4).contains(&value.abs()) {
        let digits = 2 - (value.abs().log10().floor() as i32).min(2);
        format!("{value:.*}", digits as usize)
    } else {
        format!("{value:.1e}")
    }
}

fn main() -> ExitCode {
    match std::env::args().nth(1).as_deref() {
        Some("f32") => tell(single::scenes::rows),
        Some("f64") => tell(double::scenes::rows),
        _ => match table() {
            Ok(table) => print!("{table}"),
            Err(error) => {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        },
    }
    ExitCode::SUCCESS
}
