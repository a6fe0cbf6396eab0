//! How the process ends.

use cullet_proto::service::codes;
use std::fmt;
use std::io::Write;
use std::process::ExitCode;

/// Every way to end, with its exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Done.
    Done,
    /// The run failed: the world broke down.
    Failed,
    /// The run is complete, and an expectation of the scene does not hold.
    Unmet,
    /// The run is complete, and a picture of it could not be drawn.
    Unpictured,
    /// The run was cancelled.
    Cancelled,
    /// The run stalled: the pool gave up a job of it.
    Stalled,
    /// Refused: arguments, scene or meshes are wrong, or the coordinator says no.
    Usage,
    /// What was named is not there: a run, a worker, a file of a run.
    Unknown,
    /// No coordinator answers, or it left before the run began.
    Unreachable,
    /// A file could not be read or written.
    File,
    /// Not now: the queue is full, or a run is not over yet.
    Later,
    /// Interrupted; the recording is finished.
    Interrupted,
}

const CODES: [(Exit, u8); 12] = [
    (Exit::Done, codes::DONE),
    (Exit::Failed, codes::FAILED),
    (Exit::Unmet, codes::UNMET),
    (Exit::Unpictured, codes::UNPICTURED),
    (Exit::Cancelled, codes::CANCELLED),
    (Exit::Stalled, codes::STALLED),
    (Exit::Usage, codes::USAGE),
    (Exit::Unknown, codes::UNKNOWN),
    (Exit::Unreachable, codes::UNREACHABLE),
    (Exit::File, codes::FILE),
    (Exit::Later, codes::LATER),
    (Exit::Interrupted, codes::INTERRUPTED),
];

impl Exit {
    /// Its exit code.
    pub(crate) fn code(self) -> u8 {
        CODES.iter().find(|(exit, _)| *exit == self).map_or(2, |(_, code)| *code)
    }

    /// Of two ways to end, the one with the higher code.
    pub(crate) fn worse(self, other: Self) -> Self {
        if other.code() > self.code() { other } else { self }
    }

    /// The way to end that has this code; an unknown code is a failure.
    pub(crate) fn of_code(code: u8) -> Self {
        CODES.iter().find(|(_, known)| *known == code).map_or(Self::Failed, |(exit, _)| *exit)
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.code())
    }
}

/// Why a command could not do its work.
#[derive(Debug)]
pub(crate) struct Trouble {
    /// How the process ends because of it.
    pub(crate) exit: Exit,
    text: String,
}

impl Trouble {
    /// Trouble of that kind, in words.
    pub(crate) fn new(exit: Exit, text: impl fmt::Display) -> Self {
        Self { exit, text: text.to_string() }
    }

    /// A file or folder that could not be read or written.
    pub(crate) fn file(path: &std::path::Path, error: impl fmt::Display) -> Self {
        Self::new(Exit::File, format!("{}: {error}", path.display()))
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Writes to standard output. A reader that has seen enough, as `head` has, is no trouble.
pub(crate) fn print(text: impl fmt::Display) -> Result<(), Trouble> {
    let mut out = std::io::stdout().lock();
    match write!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Trouble::new(Exit::File, format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::{CODES, Exit};
    use crate::args::EXIT_CODES;
    use std::collections::BTreeSet;

    /// The numbers at the beginning of these pieces of a text.
    fn numbers<'a>(pieces: impl Iterator<Item = &'a str>) -> BTreeSet<u8> {
        pieces.filter_map(|piece| piece.trim().split(' ').next()?.parse().ok()).collect()
    }

    #[test]
    fn each_code_is_one_end_and_the_page_and_the_help_have_them_all() {
        let all: BTreeSet<u8> = CODES.iter().map(|(_, code)| *code).collect();
        assert_eq!(all.len(), CODES.len(), "two ends have one code");
        for (exit, code) in CODES {
            assert_eq!((exit.code(), Exit::of_code(code)), (code, exit));
        }
        let text = EXIT_CODES.trim_start_matches("Exit codes:");
        assert_eq!(numbers(text.split('\u{b7}')), all, "cullet --help");
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/operations.md");
        let page = std::fs::read_to_string(path).expect("a page");
        let table = page.split("## Exit codes").nth(1).expect("a table");
        let table = table.split("\n## ").next().unwrap_or_default();
        let rows = table.lines().filter_map(|line| line.strip_prefix('|'));
        assert_eq!(numbers(rows), all, "docs/operations.md");
    }
}
