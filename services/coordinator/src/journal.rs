//! What happened to runs, on disk: a line an event, each with its checksum, written through before
//! anybody hears of it.
//!
//! **Torn.** A crash can leave a last line without its end: nobody has heard of it, and it is
//! dropped, aloud, and a copy kept. A line that has its end and a wrong checksum is damaged,
//! wherever it is, the last one too: somebody may have heard of it. Then nothing is changed,
//! and the coordinator does not start: what it could go on from would lack a run that it had
//! accepted.
//!
//! **Long.** Events of runs that are gone make a journal long. Once it is twice as long as what
//! still counts it is written anew: beside its place, written through, renamed, the folder written
//! through. A crash anywhere in between leaves the one or the other, each with all that happened.
//! What still counts has a bound, too: beyond it nobody hands a run in until others are deleted;
//! what happens to the runs that are there is written all the same. A journal is read to its end
//! however long it is.

use super::board::{Board, BoardEvent};
use super::error::ServiceError;
use cullet_files::{regular, set_aside, state};
use cullet_proto::chunks::sum;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// The first line: what it is, and its generation. Fields that came later are read as empty where
/// they are not, so that it is still the first one.
const TITLE: &str = "cullet journal 1";
/// Bytes of a journal beyond which no run is handed in: what as many runs take as are remembered,
/// each with as many overrides as it may have (4096 of 64 KiB).
pub(super) const MAX_BYTES: u64 = 256 << 20;
/// Most bytes of a line: far more than a run with all its overrides takes (64 KiB, each byte of
/// which JSON may write as six).
const MAX_LINE: u64 = 16 << 20;
/// A journal is not written anew for less than this.
const LEAST: u64 = 1 << 20;
/// Nor left for more than this, however long it is.
const MOST: u64 = 64 << 20;

/// An open journal.
#[derive(Debug)]
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    length: u64,
    /// Whether more than `length` may be there: a write that failed in the middle.
    torn: bool,
    /// Whether a crash of the machine may bring back the one that was here before this: its name
    /// is not written through.
    unnamed: bool,
    /// Lines of what happened and could not be kept; they come before any other.
    owed: String,
    sizes: Sizes,
    /// How long it was when it was written anew.
    base: u64,
    /// Beyond this it is written anew.
    long: u64,
    bound: u64,
}

/// Bytes of the lines of each run.
#[derive(Debug, Default, PartialEq, Eq)]
struct Sizes {
    of: BTreeMap<u64, u64>,
    /// Of runs that are gone.
    gone: u64,
}

impl Sizes {
    fn count(&mut self, event: &BoardEvent, bytes: usize) {
        let Some(run) = event.run() else { return };
        *self.of.entry(run).or_default() += bytes as u64;
        if let BoardEvent::Removed { run } = event {
            self.gone += self.of.remove(run).unwrap_or(0);
        }
    }
}

/// A step of writing a journal anew; a test stops at each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RewriteStep {
    /// Nothing is there yet.
    Begin,
    /// A line more.
    Line,
    /// All lines are there, and not written through.
    Written,
    /// They are.
    Through,
    /// It has the name, which is not written through.
    Named,
}

/// A journal that was written anew.
struct Fresh {
    file: File,
    length: u64,
    sizes: Sizes,
    named: io::Result<()>,
}

impl Journal {
    /// Reads a journal, or begins one, writes it anew with what still counts, and says what a crash
    /// tore, if it did. `bound`: beyond so many bytes no run is handed in.
    pub(super) fn open(
        path: &Path,
        bound: u64,
    ) -> Result<(Self, Board, Option<String>), ServiceError> {
        let (board, torn) = read(path)?;
        if torn.is_some() {
            // Before the line that is dropped goes with the file.
            let kept = set_aside::copy(path).map_err(ServiceError::file(path))?;
            tracing::warn!("{} is set aside as {}", path.display(), kept.display());
        }
        let file_error = ServiceError::file(path);
        let Fresh { file, length, sizes, named } =
            anew(path, &board, &mut |_| Ok(())).map_err(&file_error)?;
        named.map_err(&file_error)?;
        let (path, owed, torn_off) = (path.to_owned(), String::new(), false);
        let (unnamed, long) = (false, next(length));
        let base = length;
        let journal =
            Self { path, file, length, torn: torn_off, unnamed, owed, sizes, base, long, bound };
        Ok((journal, board, torn))
    }

    /// Writes events through, all or none.
    pub(super) fn append(&mut self, events: &[BoardEvent]) -> Result<(), ServiceError> {
        let lines: Vec<String> = events.iter().map(line).collect();
        let new = lines.concat();
        let text = std::mem::take(&mut self.owed) + &new;
        let written = self.write(&text);
        match &written {
            Ok(()) => {
                for (event, line) in events.iter().zip(&lines) {
                    self.sizes.count(event, line.len());
                }
            }
            Err(_) => {
                self.owed = text[..text.len() - new.len()].to_owned();
                // What was refused must not be there after a crash; where that fails too, later.
                self.torn = self.file.set_len(self.length).is_err();
            }
        }
        written.map_err(ServiceError::file(&self.path))
    }

    /// Something happened, and must be kept as soon as that goes.
    pub(super) fn owe(&mut self, event: &BoardEvent) {
        let line = line(event);
        self.sizes.count(event, line.len());
        self.owed += &line;
    }

    /// Keeps what is owed.
    pub(super) fn settle(&mut self) -> Result<(), ServiceError> {
        if self.owed.is_empty() { Ok(()) } else { self.append(&[]) }
    }

    /// Bytes of the disk that it holds.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Bytes that it holds of a run.
    pub(super) fn of(&self, run: u64) -> u64 {
        self.sizes.of.get(&run).copied().unwrap_or(0)
    }

    /// Whether a run may be handed in that takes so many bytes more. `board`: what it tells.
    ///
    /// # Errors
    /// [`ServiceError::Long`].
    pub(super) fn room(&mut self, more: u64, board: &Board) -> Result<(), ServiceError> {
        let over = |length: u64| length.saturating_add(more) > self.bound;
        let old = self.length.saturating_sub(self.base) >= self.bound / 8;
        if over(self.length) && (old || !over(self.length - self.sizes.gone.min(self.length))) {
            self.rewrite(board);
        }
        match self.length.saturating_add(more) > self.bound {
            false => Ok(()),
            true => {
                let (path, length, bound) = (self.path.clone(), self.length, self.bound);
                Err(ServiceError::Long { path, length, more, bound })
            }
        }
    }

    /// Writes it anew if it has become long. `board`: what it tells, and what is owed.
    pub(super) fn tidy(&mut self, board: &Board) {
        if self.length > self.long {
            self.rewrite(board);
        }
    }

    fn rewrite(&mut self, board: &Board) {
        if let Err(error) = self.try_rewrite(board, &mut |_| Ok(())) {
            let path = self.path.display();
            tracing::error!("{path}: it is not written anew, and goes on as it is: {error}");
            self.long = self.length + LEAST;
        }
    }

    fn try_rewrite(
        &mut self,
        board: &Board,
        step: &mut dyn FnMut(RewriteStep) -> io::Result<()>,
    ) -> io::Result<()> {
        let Fresh { file, length, sizes, named } = anew(&self.path, board, step)?;
        let before = self.length;
        // From here on the other one has no name, and what is owed is in this one.
        (self.file, self.length, self.sizes, self.torn) = (file, length, sizes, false);
        self.owed.clear();
        (self.base, self.long, self.unnamed) = (length, next(length), named.is_err());
        tracing::info!(before, after = length, "the journal is written anew");
        named
    }

    fn write(&mut self, text: &str) -> io::Result<()> {
        if self.unnamed {
            state::sync(self.path.parent().unwrap_or(Path::new(".")))?;
            self.unnamed = false;
        }
        // What was written in part must not stand before what comes later.
        if self.torn {
            self.file.set_len(self.length)?;
        }
        self.torn = true;
        self.file.write_all(text.as_bytes())?;
        self.file.sync_data()?;
        self.torn = false;
        self.length += text.len() as u64;
        Ok(())
    }
}

/// How long a journal of that length gets before it is written anew.
fn next(length: u64) -> u64 {
    length + length.clamp(LEAST, MOST)
}

/// Bytes that these events take.
pub(super) fn size(events: &[BoardEvent]) -> u64 {
    events.iter().map(|event| line(event).len() as u64).sum()
}

fn line(event: &BoardEvent) -> String {
    let json = serde_json::to_string(event).unwrap_or_default();
    format!("{:08x} {json}\n", sum(json.as_bytes()))
}

/// Writes a journal of what still counts in the place of the one that is there.
fn anew(
    path: &Path,
    board: &Board,
    step: &mut dyn FnMut(RewriteStep) -> io::Result<()>,
) -> io::Result<Fresh> {
    let folder = path.parent().unwrap_or(Path::new("."));
    step(RewriteStep::Begin)?;
    let mut beside = state::unfinished(folder)?;
    let (title, mut sizes) = (format!("{TITLE}\n"), Sizes::default());
    let mut length = title.len() as u64;
    let mut out = BufWriter::new(beside.as_file_mut());
    out.write_all(title.as_bytes())?;
    for event in board.to_events() {
        let line = line(&event);
        out.write_all(line.as_bytes())?;
        sizes.count(&event, line.len());
        length += line.len() as u64;
        step(RewriteStep::Line)?;
    }
    out.flush()?;
    drop(out);
    step(RewriteStep::Written)?;
    beside.as_file().sync_all()?;
    step(RewriteStep::Through)?;
    let file = beside.persist(path).map_err(|error| error.error)?;
    let named = step(RewriteStep::Named).and_then(|()| state::sync(folder));
    Ok(Fresh { file, length, sizes, named })
}

fn read(path: &Path) -> Result<(Board, Option<String>), ServiceError> {
    let file_error = ServiceError::file(path);
    let file = match regular::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return missing(path),
        Err(error) => return Err(file_error(error)),
    };
    let bad = |line: usize, why: &str| damaged(path, line, why.to_owned());
    let (mut file, mut bytes) = (BufReader::new(file), Vec::new());
    let mut read_line = |bytes: &mut Vec<u8>| {
        bytes.clear();
        (&mut file).take(MAX_LINE).read_until(b'\n', bytes).map_err(&file_error)
    };
    read_line(&mut bytes)?;
    if bytes != format!("{TITLE}\n").as_bytes() {
        return Err(bad(1, &format!("it does not begin with `{TITLE}`")));
    }
    let (mut board, mut number) = (Board::default(), 1);
    while read_line(&mut bytes)? > 0 {
        number += 1;
        let (event, torn) = match (bytes.split_last(), parse(&bytes)) {
            (Some((b'\n', text)), _) => (parse(text).map_err(|why| bad(number, why))?, false),
            (_, Ok(event)) => (event, true),
            // It had an end, and that is what turned.
            (Some((_, text)), _) if parse(text).is_ok() => {
                return Err(bad(number, "its end is damaged"));
            }
            _ if bytes.len() as u64 >= MAX_LINE => {
                return Err(bad(number, "it is longer than a line may be"));
            }
            (_, Err(why)) => {
                let path = path.display();
                let torn = format!("{path}: line {number}, the last, has no end ({why})");
                return Ok((board, Some(torn)));
            }
        };
        board.apply(&event).map_err(|no| bad(number, &no.to_string()))?;
        if torn {
            tracing::warn!("{}: line {number}, the last, lacks its end alone", path.display());
        }
    }
    Ok((board, None))
}

/// No journal: a folder that is new, or one that has lost it.
fn missing(path: &Path) -> Result<(Board, Option<String>), ServiceError> {
    let runs = path.with_file_name("runs");
    let lie = std::fs::read_dir(&runs).into_iter().flatten().flatten().count();
    match lie {
        0 => Ok((Board::default(), None)),
        _ => Err(ServiceError::NoJournal { path: path.to_owned(), runs, lie }),
    }
}

/// Keeps a copy of what is damaged, so that no hand that mends it can make it worse.
fn damaged(path: &Path, line: usize, why: String) -> ServiceError {
    let kept = set_aside::copy(path).inspect_err(|error| {
        tracing::error!("{}: no copy of it is set aside: {error}", path.display());
    });
    ServiceError::Journal { path: path.to_owned(), line, why, kept: kept.ok() }
}

/// The event of a line without its end.
fn parse(bytes: &[u8]) -> Result<BoardEvent, &'static str> {
    let line = std::str::from_utf8(bytes).map_err(|_| "it is no text")?;
    let (told, json) = line.split_once(' ').ok_or("it has no checksum")?;
    if told != format!("{:08x}", sum(json.as_bytes())) {
        return Err("its checksum is wrong");
    }
    serde_json::from_str(json).map_err(|_| "it is no event that is known here")
}

#[cfg(test)]
mod tests;
