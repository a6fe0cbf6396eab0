use super::RunResults;
use crate::replaying_pool::VerdictStore;
use cullet_pool::{Build, ResultFile};
use cullet_proto::service::JobCounts;
use cullet_proto::{JobId, Verdict};
use cullet_run::{RESULTS, RunAgain, RunError};
use std::fs;
use std::path::Path;

const BUILD: Build = Build([3; 32]);

fn verdict(text: &str) -> Verdict {
    Verdict::Refused { solver: "stub".into(), text: text.into() }
}

fn job(number: u8) -> JobId {
    JobId([number; 32])
}

fn opened<'a>(out: &Path, from: Option<&'a Path>, keep: u64) -> RunResults<'a> {
    let again = RunAgain { from, from_step: None, keep };
    RunResults::open(out, &again, BUILD).unwrap_or_else(|why| panic!("{why}"))
}

#[test]
fn a_later_run_takes_what_is_sound_and_of_its_build_and_keeps_it_too() {
    let base = tempfile::tempdir().expect("a folder");
    let out = |name: &str| {
        let path = base.path().join(name);
        fs::create_dir_all(&path).expect("a folder");
        path
    };
    let (first, second) = (out("first"), out("second"));
    let kept = opened(&first, None, 1 << 20);
    assert_eq!((kept.warning(), kept.get(job(1))), (None, None));
    for number in 1..=4 {
        kept.put(job(number), &verdict(&number.to_string())).expect("it is kept");
    }
    // One is damaged, and one is of another build.
    let results = first.join(RESULTS);
    let damaged = ResultFile::path(&results, job(2));
    let mut bytes = fs::read(&damaged).expect("a result");
    *bytes.last_mut().expect("bytes") ^= 1;
    fs::write(&damaged, bytes).expect("a file");
    let other = verdict("3").encode().expect("bytes");
    ResultFile::write(&results, job(3), &other, Build([4; 32])).expect("a file");
    let taken = opened(&second, Some(&first), 1 << 20);
    let got: Vec<_> = (1..=5).map(|number| taken.get(job(number))).collect();
    assert_eq!(got, [Some(verdict("1")), None, None, Some(verdict("4")), None]);
    let jobs = JobCounts { settled: 5, kept: 2, ..JobCounts::default() };
    let lines = taken.lines(&jobs).join("\n");
    for words in [
        "5 jobs: 2 taken from ",
        "first, 3 solved",
        "damaged results of the earlier run, whose jobs were solved again: 1",
        "results of another build of Cullet, whose jobs were solved again: 1",
    ] {
        assert!(lines.contains(words), "no {words:?} in {lines}");
    }
    // What was taken is there for the run after that, also once the first is gone.
    fs::remove_dir_all(&first).expect("it goes");
    let third = out("third");
    assert_eq!(opened(&third, Some(&second), 0).get(job(4)), Some(verdict("4")));
    assert!(!third.join(RESULTS).exists(), "it keeps nothing");
}

#[test]
fn no_more_is_kept_than_may_be() {
    let base = tempfile::tempdir().expect("a folder");
    let one = ResultFile::size_of(&verdict("1").encode().expect("bytes"));
    let kept = opened(base.path(), None, 2 * one);
    for number in [1, 1, 2, 3] {
        kept.put(job(number), &verdict(&number.to_string())).expect("it is kept, or not");
    }
    let files = fs::read_dir(base.path().join(RESULTS)).expect("results").count();
    assert_eq!(files, 2, "the same result twice is one file");
    let lines = kept.lines(&JobCounts::default());
    assert_eq!(lines, ["warning: results that are not kept, as 0 MiB are full: 1"]);
}

#[test]
fn what_is_no_earlier_run_is_refused() {
    let base = tempfile::tempdir().expect("a folder");
    let out = base.path().join("out");
    fs::create_dir_all(&out).expect("a folder");
    fs::write(out.join("run.mcap.partial"), "").expect("a file");
    let why = |from: &Path| {
        let again = RunAgain { from: Some(from), ..RunAgain::default() };
        match RunResults::open(&out, &again, BUILD) {
            Err(error @ RunError::From { .. }) => error.to_string(),
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("{} is no run", from.display()),
        }
    };
    assert!(why(&base.path().join("none")).ends_with("none: there is no such run"));
    assert!(why(base.path()).ends_with("no run was recorded in this folder"));
    assert!(why(&out).ends_with("a run cannot take up itself; name another folder for it"));
    assert!(why(&out.join("run.mcap.partial")).contains("cannot take up itself"));
    // A sweep is not a run.
    let sweep = base.path().join("sweep");
    fs::create_dir_all(sweep.join("1")).expect("a folder");
    fs::write(sweep.join("1/run.mcap"), "").expect("a file");
    assert!(why(&sweep).ends_with("that is a sweep; name one of its runs"));
    // One that kept nothing is a run all the same.
    let killed = base.path().join("killed");
    fs::create_dir_all(&killed).expect("a folder");
    fs::write(killed.join("run.mcap.partial"), "").expect("a file");
    let warning = opened(&out, Some(&killed), 0).warning().expect("a warning");
    assert!(warning.contains("kept no results"), "{warning}");
}

#[test]
fn what_is_stale_is_written_again_and_a_refused_run_takes_back_its_own_alone() {
    let base = tempfile::tempdir().expect("a folder");
    let results = base.path().join(RESULTS);
    fs::create_dir(&results).expect("a folder");
    let bytes = |text: &str| verdict(text).encode().expect("bytes");
    let one = ResultFile::size_of(&bytes("1"));
    // Of another build, of this one, damaged, of nobody, and half of one.
    ResultFile::write(&results, job(1), &bytes("0"), Build([4; 32])).expect("a file");
    ResultFile::write(&results, job(2), &bytes("2"), BUILD).expect("a file");
    fs::write(ResultFile::path(&results, job(3)), "damaged").expect("a file");
    fs::write(results.join("note"), "mine").expect("a file");
    fs::write(results.join(".cullet-half"), "half").expect("a file");
    let kept = opened(base.path(), None, 3 * one + 7);
    kept.discard();
    assert_eq!(fs::read_dir(&results).expect("results").count(), 5, "nothing was its own");
    for number in 1..=4 {
        kept.put(job(number), &verdict(&number.to_string())).expect("it is kept, or not");
    }
    let read = |number: u8| ResultFile::read(&results, job(number));
    let sound = |text: &str| ResultFile::Sound { verdict: bytes(text), build: Some(BUILD) };
    assert_eq!([1, 2, 3].map(read), ["1", "2", "3"].map(sound));
    assert_eq!(read(4), ResultFile::Missing, "what was there counts");
    assert!(!results.join(".cullet-half").exists());
    kept.discard();
    let left = [1, 2, 3].map(|number| read(number) != ResultFile::Missing);
    assert_eq!((left, results.join("note").exists()), ([false, true, false], true));
}
