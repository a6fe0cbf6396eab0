//! How the process ends.

use crate::shown;
use cullet_pool::LinkError;
use cullet_proto::service::codes;
use serde::Serialize;
use std::fmt;
use std::io::Write;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Every way to end, with its exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Done.
    Done,
    /// The run failed: the world broke down.
    Failed,
    /// Something that was looked at is not well.
    Unwell,
    /// The run is complete, and an expectation of the scene does not hold.
    Unmet,
    /// The run is complete, and a picture of it could not be drawn.
    Unpictured,
    /// The run was cancelled.
    Cancelled,
    /// The run stalled: the pool gave up a job of it.
    Stalled,
    /// The run failed: its scene is wrong, as the coordinator found.
    Unfit,
    /// The run failed: a file of it could not be read or written, or may not be.
    Unkept,
    /// Arguments, a scene or a mesh are wrong.
    Usage,
    /// What was named is not there: a run, a worker, a file of a run.
    Unknown,
    /// No coordinator answers, or it leaves.
    Unreachable,
    /// The machine gives no thread, process or address, or there is a defect.
    Broken,
    /// A file of the command could not be read or written.
    File,
    /// Not now: the queue or the disk is full, or a run is not over yet.
    Later,
    /// What the coordinator sends is not sound.
    Garbled,
    /// The coordinator says no.
    Refused,
    /// Interrupted; the recording is finished.
    Interrupted,
}

const CODES: [(Exit, u8, &str); 18] = [
    (Exit::Done, codes::DONE, "done"),
    (Exit::Unwell, codes::UNWELL, "unwell"),
    (Exit::Failed, codes::FAILED, "failed"),
    (Exit::Unmet, codes::UNMET, "unmet"),
    (Exit::Unpictured, codes::UNPICTURED, "unpictured"),
    (Exit::Cancelled, codes::CANCELLED, "cancelled"),
    (Exit::Stalled, codes::STALLED, "stalled"),
    (Exit::Unfit, codes::UNFIT, "unfit"),
    (Exit::Unkept, codes::UNKEPT, "unkept"),
    (Exit::Usage, codes::USAGE, "usage"),
    (Exit::Unknown, codes::UNKNOWN, "unknown"),
    (Exit::Unreachable, codes::UNREACHABLE, "unreachable"),
    (Exit::Broken, codes::BROKEN, "broken"),
    (Exit::File, codes::FILE, "file"),
    (Exit::Later, codes::LATER, "later"),
    (Exit::Garbled, codes::GARBLED, "garbled"),
    (Exit::Refused, codes::REFUSED, "refused"),
    (Exit::Interrupted, codes::INTERRUPTED, "interrupted"),
];

impl Exit {
    /// Its exit code.
    pub(crate) fn code(self) -> u8 {
        CODES.iter().find(|(exit, ..)| *exit == self).map_or(codes::BROKEN, |(_, code, _)| *code)
    }

    /// Its name, as errors have it that are written as JSON.
    pub(crate) fn word(self) -> &'static str {
        CODES.iter().find(|(exit, ..)| *exit == self).map_or("broken", |(.., word)| word)
    }

    /// Of two ways to end, the one with the higher code.
    pub(crate) fn worse(self, other: Self) -> Self {
        if other.code() > self.code() { other } else { self }
    }

    /// How a run ended that has this code. The others are those of commands, some of which runs
    /// have in old journals.
    pub(crate) fn of_run(code: u8) -> Option<Self> {
        let known = CODES.iter().find(|(_, known, _)| *known == code);
        known.filter(|(_, code, _)| *code <= codes::UNKEPT).map(|(exit, ..)| *exit)
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.code())
    }
}

/// Why a command could not do its work.
#[derive(Debug)]
pub(crate) struct CommandError {
    /// How the process ends because of it.
    pub(crate) exit: Exit,
    text: String,
    place: Option<String>,
    cause: Option<&'static str>,
}

/// A command's error as a line of JSON.
#[derive(Debug, Serialize)]
struct ErrorLine<'a> {
    code: u8,
    kind: &'a str,
    message: &'a str,
    place: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cause: Option<&'a str>,
}

impl CommandError {
    /// Trouble of that kind, in words.
    pub(crate) fn new(exit: Exit, text: impl fmt::Display) -> Self {
        Self { exit, text: plain(&text.to_string()), place: None, cause: None }
    }

    /// It has to do with this file, folder, endpoint or program.
    pub(crate) fn at(self, place: impl fmt::Display) -> Self {
        Self { place: Some(place.to_string()), ..self }
    }

    /// It has this cause, one of [`cullet_proto::service::causes`].
    pub(crate) fn by(self, cause: &'static str) -> Self {
        Self { cause: Some(cause), ..self }
    }

    /// What it comes from, where programs go by that.
    pub(crate) fn cause(&self) -> Option<&'static str> {
        self.cause
    }

    /// The same trouble in other words.
    pub(crate) fn said(self, text: impl fmt::Display) -> Self {
        Self { text: text.to_string(), ..self }
    }

    /// What it has to do with.
    pub(crate) fn place(&self) -> Option<&str> {
        self.place.as_deref()
    }

    /// As one JSON object: code, kind, message and place, and its cause where programs go by it.
    pub(crate) fn json(&self) -> String {
        let (code, kind) = (self.exit.code(), self.exit.word());
        let told =
            ErrorLine { code, kind, message: &self.text, place: self.place(), cause: self.cause };
        serde_json::to_string(&told).unwrap_or_default()
    }

    /// A file or folder that could not be read or written.
    pub(crate) fn file(path: &std::path::Path, error: impl fmt::Display) -> Self {
        let name = path.display().to_string();
        Self::new(Exit::File, format!("{}: {error}", shown::shown(&name))).at(name)
    }
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// A text without the numbers of the system's errors, and with its words for folders in ours.
fn plain(text: &str) -> String {
    let mut plain = text.replace("Is a directory", "it is a folder");
    while let Some(start) = plain.find(" (os error ") {
        let end = plain[start..].find(')').map_or(plain.len(), |end| start + end + 1);
        plain.replace_range(start..end, "");
    }
    plain
}

/// What trouble with a link is, and where.
pub(crate) fn refused(error: &LinkError) -> CommandError {
    let exit = match error {
        LinkError::Silent { .. } | LinkError::Connect { .. } | LinkError::Left { .. } => {
            Exit::Unreachable
        }
        LinkError::File { .. } => Exit::File,
        LinkError::Unknown(_) => Exit::Unknown,
        LinkError::Busy { .. } | LinkError::Later(_) | LinkError::Conflict(_) => Exit::Later,
        LinkError::Refused(_) => Exit::Refused,
        LinkError::Garbled(_) => Exit::Garbled,
        // Of one's own: a scene, a name, a question.
        LinkError::Wire(_) | LinkError::Path { .. } | LinkError::Occupied { .. } => Exit::Usage,
        LinkError::Listen { .. } | LinkError::Spawn { .. } | LinkError::Thread(_) => Exit::Broken,
    };
    let trouble = CommandError::new(exit, shown::lines(&error.to_string()));
    match error {
        LinkError::Silent { endpoint, .. }
        | LinkError::Connect { endpoint, .. }
        | LinkError::Left { endpoint, .. }
        | LinkError::Busy { endpoint, .. }
        | LinkError::Listen { endpoint, .. } => trouble.at(endpoint),
        LinkError::File { path, .. } | LinkError::Spawn { exe: path, .. } => {
            trouble.at(path.display())
        }
        LinkError::Path { path, .. } => trouble.at(path),
        LinkError::Occupied { folder, .. } => trouble.at(folder.display()),
        LinkError::Unknown(_)
        | LinkError::Later(_)
        | LinkError::Refused(_)
        | LinkError::Garbled(_)
        | LinkError::Wire(_)
        | LinkError::Conflict(_)
        | LinkError::Thread(_) => trouble,
    }
}

/// Whether whoever read standard output has gone.
static GONE: AtomicBool = AtomicBool::new(false);

/// Writes to standard output. A reader that has seen enough, as `head` has, is no trouble.
pub(crate) fn print(text: impl fmt::Display) -> Result<(), CommandError> {
    let text = text.to_string();
    let mut out = std::io::stdout().lock();
    let done = out.write_all(shown::output(&text).as_bytes()).and_then(|()| out.flush());
    unprinted(done)
}

/// What it is that standard output was not written.
pub(crate) fn unprinted(done: std::io::Result<()>) -> Result<(), CommandError> {
    match done {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => {
            GONE.store(true, Ordering::Relaxed);
            Ok(())
        }
        done => {
            done.map_err(|error| CommandError::new(Exit::File, format!("standard output: {error}")))
        }
    }
}

/// Whether nobody reads what is printed any more: who prints on and on can leave.
pub(crate) fn unread() -> bool {
    GONE.load(Ordering::Relaxed)
}

#[cfg(test)]
mod tests {
    use super::{CODES, Exit};
    use crate::args::EXIT_CODES;
    use crate::exit::CommandError;
    use cullet_proto::service::causes::NOT_FINITE;
    use serde_json::json;
    use std::collections::BTreeSet;

    /// The numbers at the beginning of these pieces of a text.
    fn numbers<'a>(pieces: impl Iterator<Item = &'a str>) -> BTreeSet<u8> {
        pieces.filter_map(|piece| piece.trim().split(' ').next()?.parse().ok()).collect()
    }

    #[test]
    fn each_code_is_one_end_and_the_page_and_the_help_have_them_all() {
        let all: BTreeSet<u8> = CODES.iter().map(|(_, code, _)| *code).collect();
        assert_eq!(all.len(), CODES.len(), "two ends have one code");
        let words: BTreeSet<&str> = CODES.iter().map(|(.., word)| *word).collect();
        assert_eq!(words.len(), CODES.len(), "two ends have one name");
        for (exit, code, word) in CODES {
            assert_eq!((exit.code(), exit.word()), (code, word));
            let run = (code <= 8).then_some(exit);
            assert_eq!(Exit::of_run(code), run, "a command's end is none of a run");
        }
        let text = EXIT_CODES.trim_start_matches("Exit codes:");
        assert_eq!(numbers(text.split('\u{b7}')), all, "cullet --help");
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/farm-reference.md");
        let page = std::fs::read_to_string(path).expect("a page");
        let table = page.split("## Exit codes").nth(1).expect("a table");
        let table = table.split("\n## ").next().unwrap_or_default();
        let rows = table.lines().filter_map(|line| line.strip_prefix('|'));
        assert_eq!(numbers(rows), all, "docs/farm-reference.md");
    }

    #[test]
    fn trouble_is_one_object_of_one_line() {
        let file = std::path::Path::new("a \"b\"");
        let told = CommandError::file(file, "no\nsuch file").json();
        assert!(!told.contains('\n'), "{told}");
        let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
        let message = "a \"b\": no\nsuch file";
        let want = json!({"code": 74, "kind": "file", "message": message, "place": "a \"b\""});
        assert_eq!(told, want);
        let told: serde_json::Value =
            serde_json::from_str(&CommandError::new(Exit::Usage, "no").json()).expect("JSON");
        assert_eq!(told, json!({"code": 64, "kind": "usage", "message": "no", "place": null}));
        let lost = CommandError::new(Exit::Failed, "no").by(NOT_FINITE).said("run 3: no").json();
        let lost: serde_json::Value = serde_json::from_str(&lost).expect("JSON");
        assert_eq!((&lost["cause"], &lost["code"]), (&json!("not-finite"), &json!(2)));
    }
}
