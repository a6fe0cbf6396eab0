//! What happened to runs, on disk: a line an event, each with its checksum, written through before
//! anybody is told of it. A crash can tear the last line, and that alone is forgiven.

use super::ServiceError;
use super::board::{Board, Event};
use cullet_proto::chunks::sum;
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// The first line: what it is, and its generation.
const TITLE: &str = "cullet journal 1";
/// Most bytes of a journal: that many mean that something writes without end.
const MAX_BYTES: u64 = 1 << 30;

/// An open journal.
#[derive(Debug)]
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    length: u64,
    /// Whether more than `length` may be there: a write that failed in the middle.
    torn: bool,
    /// Lines of what happened and could not be kept; they come before any other.
    owed: String,
}

impl Journal {
    /// Reads a journal, or begins one, writes it anew with what still counts, and says what a crash
    /// tore, if it did.
    pub(super) fn open(path: &Path) -> Result<(Self, Board, Option<String>), ServiceError> {
        let (board, torn) = read(path)?;
        let mut text = format!("{TITLE}\n");
        text.extend(board.told().iter().map(line));
        let file_error = ServiceError::file(path);
        super::store::put(path, text.as_bytes()).map_err(&file_error)?;
        let file = OpenOptions::new().append(true).open(path).map_err(&file_error)?;
        let (path, length) = (path.to_owned(), text.len() as u64);
        let journal = Self { path, file, length, torn: false, owed: String::new() };
        Ok((journal, board, torn))
    }

    /// Writes events through, all or none.
    pub(super) fn append(&mut self, events: &[Event]) -> Result<(), ServiceError> {
        let new: String = events.iter().map(line).collect();
        let text = std::mem::take(&mut self.owed) + &new;
        let written = self.write(&text);
        if written.is_err() {
            self.owed = text[..text.len() - new.len()].to_owned();
            // What was refused must not be there after a crash; where that fails too, later.
            self.torn = self.file.set_len(self.length).is_err();
        }
        written.map_err(ServiceError::file(&self.path))
    }

    /// Something happened, and must be kept as soon as that goes.
    pub(super) fn owe(&mut self, event: &Event) {
        self.owed += &line(event);
    }

    /// Keeps what is owed.
    pub(super) fn settle(&mut self) -> Result<(), ServiceError> {
        if self.owed.is_empty() { Ok(()) } else { self.append(&[]) }
    }

    fn write(&mut self, text: &str) -> std::io::Result<()> {
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

fn line(event: &Event) -> String {
    let json = serde_json::to_string(event).unwrap_or_default();
    format!("{:08x} {json}\n", sum(json.as_bytes()))
}

fn read(path: &Path) -> Result<(Board, Option<String>), ServiceError> {
    let mut text = Vec::new();
    match File::open(path) {
        Ok(file) => {
            file.take(MAX_BYTES).read_to_end(&mut text).map_err(ServiceError::file(path))?;
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Ok((Board::default(), None));
        }
        Err(error) => return Err(ServiceError::file(path)(error)),
    }
    let bad = |number: usize, why: String| {
        let path = path.to_owned();
        ServiceError::Journal { path, line: number, why }
    };
    let mut lines = text.split_inclusive(|byte| *byte == b'\n').enumerate();
    if lines.next().is_none_or(|(_, first)| first != format!("{TITLE}\n").as_bytes()) {
        return Err(bad(1, format!("it does not begin with `{TITLE}`")));
    }
    let mut board = Board::default();
    let mut torn: Option<(usize, String)> = None;
    for (index, bytes) in lines {
        if let Some((at, why)) = torn {
            return Err(bad(at, why));
        }
        match parse(bytes) {
            Ok(event) => board.apply(&event).map_err(|no| bad(index + 1, no.to_string()))?,
            Err(why) => torn = Some((index + 1, why.to_owned())),
        }
    }
    let told = torn.map(|(at, why)| format!("{}: line {at}, the last: {why}", path.display()));
    Ok((board, told))
}

fn parse(bytes: &[u8]) -> Result<Event, &'static str> {
    let text = std::str::from_utf8(bytes).map_err(|_| "it is no text")?;
    let line = text.strip_suffix('\n').ok_or("it has no end")?;
    let (told, json) = line.split_once(' ').ok_or("it has no checksum")?;
    if u32::from_str_radix(told, 16) != Ok(sum(json.as_bytes())) {
        return Err("its checksum is wrong");
    }
    serde_json::from_str(json).map_err(|_| "it is no event that is known here")
}

#[cfg(test)]
mod tests {
    use super::{Journal, ServiceError};
    use crate::service::board::{Event, Order};
    use cullet_proto::service::State;
    use std::path::{Path, PathBuf};

    fn place(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("cullet-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("journal");
        std::fs::remove_file(&path).ok();
        path
    }

    fn submitted(run: u64) -> Event {
        Event::Submitted { run, order: Order { name: format!("scene-{run}"), ..Order::default() } }
    }

    fn filled(path: &Path) -> Vec<u8> {
        let (mut journal, _, torn) = Journal::open(path).expect("it opens");
        assert_eq!(torn, None);
        journal.append(&[submitted(1), submitted(2)]).expect("it is written");
        journal.append(&[Event::Paused { run: 1 }]).expect("it is written");
        std::fs::read(path).expect("a journal")
    }

    #[test]
    fn a_journal_cut_anywhere_is_read_up_to_there_and_goes_on() {
        let path = place("cut");
        let whole = filled(&path);
        let ends: Vec<usize> =
            (0..whole.len()).filter(|at| whole[*at] == b'\n').map(|at| at + 1).collect();
        for cut in ends[0]..=whole.len() {
            std::fs::write(&path, &whole[..cut]).expect("a journal");
            let (mut journal, board, torn) = Journal::open(&path).expect("it opens");
            let lines = ends.iter().filter(|end| **end <= cut).count() - 1;
            assert_eq!(board.entries().count(), lines.min(2), "cut at {cut}");
            assert_eq!(torn.is_some(), !ends.contains(&cut), "cut at {cut}");
            journal.append(&[submitted(3)]).expect("it is written");
            let (_, board, torn) = Journal::open(&path).expect("it opens");
            assert_eq!((board.entries().count(), torn), (lines.min(2) + 1, None), "cut at {cut}");
        }
    }

    #[test]
    fn a_journal_damaged_in_the_middle_is_refused_with_the_line() {
        let path = place("damaged");
        let whole = filled(&path);
        let second = whole.iter().position(|byte| *byte == b'\n').expect("lines") + 15;
        let mut bad = whole.clone();
        bad[second] ^= 1;
        std::fs::write(&path, &bad).expect("a journal");
        let said = Journal::open(&path).expect_err("it is damaged");
        assert!(matches!(said, ServiceError::Journal { line: 2, .. }), "{said}");
        assert!(said.to_string().contains("checksum"), "{said}");
        assert_eq!(std::fs::read(&path).expect("a journal"), bad, "it is left as it was");
        for (text, line) in [("", 1), ("something else\n", 1)] {
            std::fs::write(&path, text).expect("a file");
            let said = Journal::open(&path).expect_err("it is none");
            assert!(matches!(said, ServiceError::Journal { line: at, .. } if at == line));
        }
        // Sound lines that cannot have happened.
        let event = super::line(&Event::Paused { run: 9 });
        std::fs::write(&path, format!("{}\n{event}", super::TITLE)).expect("a file");
        let said = Journal::open(&path).expect_err("nobody is run 9");
        assert!(matches!(said, ServiceError::Journal { line: 2, .. }), "{said}");
    }

    #[test]
    fn a_run_that_is_there_twice_is_refused_with_the_line() {
        let path = place("twice");
        let whole = filled(&path);
        for again in [1, 2] {
            let mut twice = whole.clone();
            twice.extend(super::line(&submitted(again)).bytes());
            std::fs::write(&path, &twice).expect("a journal");
            let said = Journal::open(&path).expect_err("it is there twice");
            assert!(matches!(said, ServiceError::Journal { line: 5, .. }), "{said}");
            assert!(said.to_string().contains(&format!("run {again} is ")), "{said}");
            assert_eq!(std::fs::read(&path).expect("a journal"), twice, "it is left as it was");
        }
    }

    /// On a disk that is full, which `/dev/full` always is.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_is_not_kept_is_an_error_and_what_is_owed_comes_before_the_rest() {
        use cullet_proto::service::State;
        let path = place("full");
        let (mut journal, _, _) = Journal::open(&path).expect("it opens");
        let started = Event::Started { run: 1, folder: "f".into(), at: 1 };
        journal.append(&[submitted(1), started]).expect("it is written");
        let before = std::fs::read(&path).expect("a journal");
        let full = std::fs::OpenOptions::new().append(true).open("/dev/full").expect("a device");
        let sound = std::mem::replace(&mut journal.file, full);
        let said = journal.append(&[submitted(2)]).expect_err("there is no room");
        assert!(said.to_string().contains("No space left"), "{said}");
        let (how, end) = (crate::service::board::How::Failed, Default::default());
        journal.owe(&Event::Ended { run: 1, how, end, at: 2 });
        assert!(journal.settle().is_err() && journal.append(&[submitted(2)]).is_err());
        assert_eq!(std::fs::read(&path).expect("a journal"), before);
        journal.file = sound;
        // Half of what did not fit.
        std::fs::write(&path, [&before[..], b"01234567 {\"event"].concat()).expect("it is torn");
        journal.append(&[Event::Queued { run: 1 }, submitted(2)]).expect("there is room");
        let length = journal.length;
        journal.settle().expect("nothing is owed");
        assert_eq!(journal.length, length);
        let (_, board, torn) = Journal::open(&path).expect("what was owed comes first");
        assert_eq!((board.entries().count(), torn), (2, None));
        assert_eq!(board.get(1).expect("known").state, State::Queued);
    }

    /// Where no file grows beyond 1 KiB the system writes as much of a line as fits.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_was_written_in_part_is_cut_off_at_once() {
        const LIMITED: &str = "CULLET_TEST_LIMITED";
        if std::env::var_os(LIMITED).is_none() {
            // This test alone, in a process of its own with that limit.
            let name = "service::journal::tests::what_was_written_in_part_is_cut_off_at_once";
            let script = "trap '' XFSZ; ulimit -f 1; exec \"$0\" --exact \"$1\" --nocapture";
            let said = std::process::Command::new("bash")
                .args(["-c", script])
                .arg(std::env::current_exe().expect("a path"))
                .arg(name)
                .env(LIMITED, "1")
                .output()
                .expect("bash");
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            let (out, err) = (text(&said.stdout), text(&said.stderr));
            assert!(said.status.success() && out.contains("1 passed"), "{out}{err}");
            return;
        }
        let path = place("limited");
        let (mut journal, _, _) = Journal::open(&path).expect("it opens");
        let mut run = 1;
        let why = loop {
            match journal.append(&[submitted(run)]) {
                Ok(()) => run += 1,
                Err(error) => break error.to_string(),
            }
        };
        assert!(why.contains("File too large") && run > 3, "{why} at run {run}");
        // As it stands now, a crash would leave nothing of it.
        let there = std::fs::read(&path).expect("a journal");
        assert_eq!(there.len() as u64, journal.length, "a part of it is there");
        let (board, torn) = super::read(&path).expect("it is sound");
        assert_eq!((board.entries().count() as u64, torn), (run - 1, None));
    }

    #[test]
    fn a_journal_that_is_opened_again_says_the_same() {
        let path = place("again");
        filled(&path);
        let (_, first, _) = Journal::open(&path).expect("it opens");
        let (_, second, _) = Journal::open(&path).expect("it opens");
        assert_eq!(first, second);
        assert_eq!(first.get(1).expect("known").state, State::Paused);
    }
}
