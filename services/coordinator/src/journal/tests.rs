use super::{Journal, LEAST, MAX_BYTES, RewriteStep, ServiceError, line, size};
use crate::board::{AttemptEnd, Board, BoardEvent, Reached, RunEnd, Submission, Wish};
use cullet_proto::service::State;
use std::path::{Path, PathBuf};

/// The journal's place in a new state folder.
fn place(name: &str) -> PathBuf {
    // Thousands of journals are written through here: in memory, where there is such a place.
    let memory = Path::new("/dev/shm");
    let base = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    let folder = base.join(format!("cullet-{name}-{}", std::process::id()));
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).expect("a folder");
    folder.join("journal")
}

/// The steps of writing a journal anew, in their order.
const ALL_STEPS: [RewriteStep; 5] = [
    RewriteStep::Begin,
    RewriteStep::Line,
    RewriteStep::Written,
    RewriteStep::Through,
    RewriteStep::Named,
];

fn submitted(run: u64) -> BoardEvent {
    BoardEvent::Submitted {
        run,
        order: Submission { name: format!("scene-{run}"), ..Submission::default() },
    }
}

fn filled(path: &Path) -> Vec<u8> {
    let (mut journal, _, torn) = Journal::open(path, MAX_BYTES).expect("it opens");
    assert_eq!(torn, None);
    journal.append(&[submitted(1), submitted(2)]).expect("it is written");
    journal.append(&[BoardEvent::Paused { run: 1 }]).expect("it is written");
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
        let (mut journal, board, torn) = Journal::open(&path, MAX_BYTES).expect("it opens");
        // Of a line that lacks its end alone all is there.
        let whole = |end: &&usize| **end <= cut + 1;
        let lines = ends.iter().skip(1).filter(whole).count();
        assert_eq!(board.entries().count(), lines.min(2), "cut at {cut}");
        let dropped = !ends.contains(&cut) && !ends[1..].contains(&(cut + 1));
        assert_eq!(torn.is_some(), dropped, "cut at {cut}");
        journal.append(&[submitted(3)]).expect("it is written");
        let (_, board, torn) = Journal::open(&path, MAX_BYTES).expect("it opens");
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
    let said = Journal::open(&path, MAX_BYTES).expect_err("it is damaged");
    assert!(matches!(said, ServiceError::Journal { line: 2, .. }), "{said}");
    assert!(said.to_string().contains("checksum"), "{said}");
    assert_eq!(std::fs::read(&path).expect("a journal"), bad, "it is left as it was");
    for (text, line) in [("", 1), ("something else\n", 1)] {
        std::fs::write(&path, text).expect("a file");
        let said = Journal::open(&path, MAX_BYTES).expect_err("it is none");
        assert!(matches!(said, ServiceError::Journal { line: at, .. } if at == line));
    }
    // Sound lines that cannot have happened.
    let event = super::line(&BoardEvent::Paused { run: 9 });
    std::fs::write(&path, format!("{}\n{event}", super::TITLE)).expect("a file");
    let said = Journal::open(&path, MAX_BYTES).expect_err("nobody is run 9");
    assert!(matches!(said, ServiceError::Journal { line: 2, .. }), "{said}");
}

#[test]
fn a_run_that_is_there_twice_is_refused_with_the_line() {
    let path = place("twice");
    let whole = filled(&path);
    for again in [1, 2] {
        let mut twice = whole.clone();
        twice.extend(line(&submitted(again)).bytes());
        std::fs::write(&path, &twice).expect("a journal");
        let said = Journal::open(&path, MAX_BYTES).expect_err("it is there twice");
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
    let (mut journal, _, _) = Journal::open(&path, MAX_BYTES).expect("it opens");
    let started = BoardEvent::Started { run: 1, folder: "f".into(), at: 1 };
    journal.append(&[submitted(1), started]).expect("it is written");
    let before = std::fs::read(&path).expect("a journal");
    let full = std::fs::OpenOptions::new().append(true).open("/dev/full").expect("a device");
    let sound = std::mem::replace(&mut journal.file, full);
    let said = journal.append(&[submitted(2)]).expect_err("there is no room");
    assert!(said.to_string().contains("No space left"), "{said}");
    let (how, end) = (crate::board::AttemptEnd::Failed, Default::default());
    journal.owe(&BoardEvent::Ended { run: 1, how, end, at: 2 });
    assert!(journal.settle().is_err() && journal.append(&[submitted(2)]).is_err());
    assert_eq!(std::fs::read(&path).expect("a journal"), before);
    journal.file = sound;
    // Half of what did not fit.
    std::fs::write(&path, [&before[..], b"01234567 {\"event"].concat()).expect("it is torn");
    journal.append(&[BoardEvent::Queued { run: 1 }, submitted(2)]).expect("there is room");
    let length = journal.length;
    journal.settle().expect("nothing is owed");
    assert_eq!(journal.length, length);
    let (_, board, torn) = Journal::open(&path, MAX_BYTES).expect("what was owed comes first");
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
        let name = "journal::tests::what_was_written_in_part_is_cut_off_at_once";
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
    let (mut journal, _, _) = Journal::open(&path, MAX_BYTES).expect("it opens");
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
    let (_, first, _) = Journal::open(&path, MAX_BYTES).expect("it opens");
    let (_, second, _) = Journal::open(&path, MAX_BYTES).expect("it opens");
    assert_eq!(first, second);
    assert_eq!(first.get(1).expect("known").state, State::Paused);
}

/// Runs in all states, one that is leaving, and numbers that are gone.
fn varied() -> Vec<BoardEvent> {
    let started = |run| BoardEvent::Started { run, folder: format!("pot-{run}"), at: 2 };
    let end = |text: &str| RunEnd { code: Some(0), text: text.into(), ..RunEnd::default() };
    let ended = |run, how| BoardEvent::Ended { run, how, end: end("so it ended"), at: 3 };
    let reached = Reached { time: 4, settled: 5 };
    let mut all: Vec<BoardEvent> = (1..=7).map(submitted).collect();
    all.extend((1..=4).map(started));
    all.push(BoardEvent::Wished { run: 3, wish: Wish::Pause });
    all.push(ended(1, AttemptEnd::Done));
    all.push(ended(2, AttemptEnd::Failed));
    all.push(BoardEvent::Died { run: 4, reached });
    all.push(BoardEvent::Returned { at: 6 });
    all.push(BoardEvent::Paused { run: 5 });
    all.push(BoardEvent::Cancelled { run: 6, end: end("no more"), at: 7 });
    all.extend([1, 2].map(|run| BoardEvent::Forgotten { run }));
    all.push(BoardEvent::Removed { run: 1 });
    all.push(BoardEvent::Queued { run: 6 });
    all.push(BoardEvent::Numbered { last: 9 });
    all.push(submitted(10));
    all
}

/// What the first events come to, for each number of them.
fn boards(events: &[BoardEvent]) -> Vec<Board> {
    let mut boards = vec![Board::default()];
    for event in events {
        let mut next = boards.last().expect("one").clone();
        next.apply(event).unwrap_or_else(|no| panic!("{event:?}: {no}"));
        boards.push(next);
    }
    boards
}

/// A journal of all of it as it was written, event by event.
fn written(events: &[BoardEvent]) -> Vec<u8> {
    let lines: String = events.iter().map(line).collect();
    format!("{}\n{lines}", super::TITLE).into_bytes()
}

/// Each bit of each byte, turned: the journal is refused, as it is, with a copy of it set aside.
#[test]
fn a_journal_in_which_any_bit_turned_is_refused_and_nothing_of_it_is_changed() {
    let path = place("bits");
    let whole = written(&varied());
    for at in 0..8 * whole.len() {
        let mut bad = whole.clone();
        bad[at / 8] ^= 1 << (at % 8);
        std::fs::write(&path, &bad).expect("a journal");
        let said = match Journal::open(&path, MAX_BYTES) {
            Err(said @ ServiceError::Journal { .. }) => said,
            other => panic!("bit {at}: {other:?}"),
        };
        let lines = whole[..at / 8].iter().filter(|byte| **byte == b'\n').count();
        let ServiceError::Journal { line, kept, .. } = said else { unreachable!() };
        // An end that turned makes one line of two.
        assert_eq!(line, lines + 1, "bit {at}");
        assert_eq!(std::fs::read(&path).expect("a journal"), bad, "bit {at}: it is changed");
        let kept = kept.expect("a copy");
        assert_eq!(std::fs::read(&kept).expect("a copy"), bad, "bit {at}");
        std::fs::remove_file(kept).expect("it goes");
    }
}

/// Cut off anywhere: what is there is what happened up to there, what is dropped of a line is told
/// and kept.
#[test]
fn a_journal_cut_anywhere_tells_all_that_it_has_and_a_copy_is_kept_of_what_it_has_not() {
    let path = place("cuts");
    let events = varied();
    let (whole, boards) = (written(&events), boards(&events));
    let first = super::TITLE.len() + 1;
    for cut in 0..whole.len() {
        std::fs::write(&path, &whole[..cut]).expect("a journal");
        let opened = Journal::open(&path, MAX_BYTES);
        if cut < first {
            assert!(matches!(opened, Err(ServiceError::Journal { line: 1, .. })), "cut at {cut}");
            continue;
        }
        let (_, board, torn) = opened.unwrap_or_else(|why| panic!("cut at {cut}: {why}"));
        let there = whole[..cut].iter().filter(|byte| **byte == b'\n').count() - 1;
        let all_but_its_end = whole[cut] == b'\n';
        assert_eq!(board, boards[there + usize::from(all_but_its_end)], "cut at {cut}");
        let dropped = whole[cut - 1] != b'\n' && !all_but_its_end;
        assert_eq!(torn.is_some(), dropped, "cut at {cut}");
        let aside = path.with_file_name("set-aside");
        let copies: Vec<_> = std::fs::read_dir(&aside).into_iter().flatten().flatten().collect();
        if dropped {
            let copy = |file: &std::fs::DirEntry| std::fs::read(file.path()).expect("a copy");
            assert!(copies.iter().any(|file| copy(file) == whole[..cut]), "cut at {cut}");
            std::fs::remove_dir_all(aside).expect("it goes");
        }
    }
}

/// Whatever befalls a journal: it is refused as it is, or tells of what happened up to some moment,
/// and says so where that is not the end of a line.
#[test]
fn a_journal_that_was_mangled_is_refused_or_tells_what_happened_up_to_some_moment() {
    let path = place("mangled");
    let events = varied();
    let (whole, boards) = (written(&events), boards(&events));
    let mut state = 1_u64;
    let mut draw = |most: usize| {
        state = cullet_geometry::math::scramble(state.wrapping_add(0x9e37_79b9_7f4a_7c15));
        (state % most as u64) as usize
    };
    let (mut refused, mut told) = (0, 0);
    for case in 0..3_000 {
        let mut bad = whole.clone();
        for _ in 0..=draw(2) {
            let at = draw(bad.len());
            match draw(4) {
                0 => bad.truncate(at.max(1)),
                1 => bad[at] = draw(256) as u8,
                2 => drop(bad.drain(at..(at + 1 + draw(40)).min(bad.len()))),
                _ => bad[at..].iter_mut().take(1 + draw(64)).for_each(|byte| *byte = 0),
            }
        }
        std::fs::write(&path, &bad).expect("a journal");
        match Journal::open(&path, MAX_BYTES) {
            Err(ServiceError::Journal { .. }) => {
                refused += 1;
                assert_eq!(std::fs::read(&path).expect("a journal"), bad, "case {case}");
            }
            Err(other) => panic!("case {case}: {other}"),
            Ok((_, board, torn)) => {
                told += 1;
                let there = boards.iter().rposition(|then| *then == board);
                let there = there.unwrap_or_else(|| panic!("case {case}: it never was so"));
                let ends = bad.ends_with(b"\n") || torn.is_some();
                assert!(ends || there > 0, "case {case}: a line is dropped in silence");
            }
        }
        std::fs::remove_dir_all(path.with_file_name("set-aside")).ok();
    }
    assert!(refused > 500 && told > 200, "{refused} refused, {told} told");
}

/// Killed at each step of writing it anew, and with each half of the file that was not written
/// through: the one that is there tells all that happened.
#[test]
fn a_crash_while_it_is_written_anew_loses_nothing() {
    let path = place("steps");
    let folder = path.parent().expect("a folder").to_owned();
    let events = varied();
    let board = boards(&events).pop().expect("the last");
    std::fs::write(&path, written(&events)).expect("a journal");
    let (mut journal, ..) = Journal::open(&path, MAX_BYTES).expect("it opens");
    let mut seen = Vec::new();
    let mut crashed = |step: RewriteStep| {
        let files = std::fs::read_dir(&folder).expect("a folder").flatten();
        let files: Vec<_> = files
            .map(|file| (file.file_name(), std::fs::read(file.path()).expect("a file")))
            .collect();
        for half in [false, true] {
            let copy = place("steps-crashed");
            for (name, bytes) in &files {
                let unsure = half && name != "journal" && step != RewriteStep::Through;
                let bytes = &bytes[..if unsure { bytes.len() / 2 } else { bytes.len() }];
                std::fs::write(copy.with_file_name(name), bytes).expect("a file");
            }
            let (_, found, torn) = Journal::open(&copy, MAX_BYTES).expect("it opens");
            assert!(found == board && torn.is_none(), "{step:?}, {half}");
        }
        seen.push(step);
        Ok(())
    };
    journal.try_rewrite(&board, &mut crashed).expect("it is written anew");
    seen.dedup();
    assert_eq!(seen, ALL_STEPS);
}

/// A disk that fails at each step: the one that is there stays, takes what comes, and is whole.
#[test]
fn a_disk_that_fails_while_it_is_written_anew_loses_nothing() {
    for fails in ALL_STEPS {
        let path = place("fails");
        let events = varied();
        let mut board = boards(&events).pop().expect("the last");
        std::fs::write(&path, written(&events)).expect("a journal");
        let (mut journal, ..) = Journal::open(&path, MAX_BYTES).expect("it opens");
        let mut step = |step: RewriteStep| match step == fails {
            true => Err(std::io::Error::other("the disk fails")),
            false => Ok(()),
        };
        assert!(journal.try_rewrite(&board, &mut step).is_err(), "{fails:?}");
        assert_eq!(journal.unnamed, fails == RewriteStep::Named);
        let more = [submitted(11), BoardEvent::Paused { run: 11 }];
        journal.append(&more).expect("it goes on");
        assert!(!journal.unnamed, "{fails:?}: its name is not written through");
        more.iter().for_each(|event| board.apply(event).expect("it fits"));
        let (_, found, torn) = Journal::open(&path, MAX_BYTES).expect("it opens");
        assert!(found == board && torn.is_none(), "{fails:?}");
        let left = std::fs::read_dir(path.parent().expect("a folder")).expect("a folder").count();
        assert_eq!(left, 1, "{fails:?}");
    }
}

/// A run that came, was done and went, over and over.
fn gone(run: u64) -> [BoardEvent; 5] {
    let (how, end) = (AttemptEnd::Done, RunEnd::default());
    let start = BoardEvent::Started { run, folder: "pot-1".into(), at: 1 };
    let ended = BoardEvent::Ended { run, how, end, at: 2 };
    [submitted(run), start, ended, BoardEvent::Forgotten { run }, BoardEvent::Removed { run }]
}

#[test]
fn a_journal_stays_short_while_runs_come_and_go() {
    let path = place("short");
    let (mut journal, mut board, _) = Journal::open(&path, MAX_BYTES).expect("it opens");
    journal.append(&[submitted(1)]).expect("it is written");
    board.apply(&submitted(1)).expect("it fits");
    let (mut longest, mut all) = (0, 0);
    for run in 2..12_000 {
        let events = gone(run);
        journal.append(&events).expect("it is written");
        events.iter().for_each(|event| board.apply(event).expect("it fits"));
        journal.tidy(&board);
        all += size(&events);
        longest = journal.length().max(longest);
        assert_eq!(journal.of(run), 0);
    }
    assert!(all > 4 * LEAST && longest < 2 * LEAST, "{longest} of {all} bytes");
    assert_eq!(std::fs::metadata(&path).expect("a journal").len(), journal.length());
    assert_eq!(journal.of(1), size(&[submitted(1)]));
    let (_, found, _) = Journal::open(&path, MAX_BYTES).expect("it opens");
    assert_eq!(found, board);
}

#[test]
fn a_journal_that_is_as_long_as_it_may_be_takes_no_run_until_others_go_and_forgets_none() {
    let path = place("bound");
    let bound = 4_000;
    let (mut journal, mut board, _) = Journal::open(&path, bound).expect("it opens");
    let hand_in = |journal: &mut Journal, board: &mut Board, run| {
        journal.room(size(&[submitted(run)]), board)?;
        journal.append(&[submitted(run)])?;
        board.apply(&submitted(run)).expect("it fits");
        Ok::<(), ServiceError>(())
    };
    let mut run = 1;
    let said = loop {
        match hand_in(&mut journal, &mut board, run) {
            Ok(()) => run += 1,
            Err(said) => break said,
        }
    };
    assert!(matches!(said, ServiceError::Long { bound: 4_000, .. }) && run > 10, "{said}");
    assert!(journal.length() <= bound);
    // What happens to those that are there is kept all the same.
    let over = |run| BoardEvent::Cancelled { run, end: RunEnd::default(), at: 1 };
    for event in (1..run).map(over) {
        journal.append(std::slice::from_ref(&event)).expect("it is written");
        board.apply(&event).expect("it fits");
    }
    assert!(journal.length() > bound);
    // All of it is read, however long.
    let (mut journal, found, torn) = Journal::open(&path, bound).expect("it opens");
    assert!(found == board && torn.is_none());
    assert!(hand_in(&mut journal, &mut board, run).is_err());
    for event in
        (1..run).flat_map(|run| [BoardEvent::Forgotten { run }, BoardEvent::Removed { run }])
    {
        journal.append(std::slice::from_ref(&event)).expect("it is written");
        board.apply(&event).expect("it fits");
    }
    hand_in(&mut journal, &mut board, run).expect("there is room");
    let (_, found, _) = Journal::open(&path, bound).expect("it opens");
    assert_eq!(found, board);
}

#[test]
fn what_is_owed_is_in_a_journal_that_is_written_anew() {
    let path = place("owed");
    let (mut journal, mut board, _) = Journal::open(&path, MAX_BYTES).expect("it opens");
    for event in [submitted(1), BoardEvent::Started { run: 1, folder: "f".into(), at: 1 }] {
        journal.append(std::slice::from_ref(&event)).expect("it is written");
        board.apply(&event).expect("it fits");
    }
    let ended = BoardEvent::Ended { run: 1, how: AttemptEnd::Done, end: RunEnd::default(), at: 2 };
    journal.owe(&ended);
    board.apply(&ended).expect("it fits");
    journal.rewrite(&board);
    journal.settle().expect("nothing is owed");
    let (_, found, _) = Journal::open(&path, MAX_BYTES).expect("it opens");
    assert_eq!(found, board);
}

#[test]
fn runs_without_a_journal_are_no_new_folder() {
    let path = place("missing");
    let runs = path.with_file_name("runs");
    std::fs::create_dir_all(runs.join("7")).expect("a folder");
    let said = Journal::open(&path, MAX_BYTES).expect_err("it is missing");
    assert!(matches!(said, ServiceError::NoJournal { lie: 1, .. }), "{said}");
    assert!(!path.exists(), "one is begun");
    std::fs::remove_dir(runs.join("7")).expect("it goes");
    assert!(Journal::open(&path, MAX_BYTES).is_ok(), "nothing is lost where there is nothing");
}

/// A line of before there were digests of bundles.
#[test]
fn a_journal_of_before_this_version_is_read() {
    let path = place("older");
    let json = r#"{"event":"submitted","run":1,"order":{"ticket":"t","user":"u","name":"pot",
        "sweep":"","priority":0,"overrides":[],"at":5}}"#;
    let json = json.replace("\n        ", "");
    let sum = cullet_proto::chunks::sum(json.as_bytes());
    std::fs::write(&path, format!("{}\n{sum:08x} {json}\n", super::TITLE)).expect("a journal");
    let (_, board, torn) = Journal::open(&path, MAX_BYTES).expect("it opens");
    assert_eq!((board.get(1).expect("known").order.bundle.as_str(), torn), ("", None));
}
