//! How runs go from a coordinator, and that none goes by half, whenever it is killed.

use crate::common;

use common::{Cullet, Going, corpus, free_endpoint, quiet_digest, signal, summary, unique};
use cullet_proto::chunks::sum;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A run that is over in a moment.
const QUICK: [&str; 2] = ["--set", "world.duration=0.02"];
const BOUND: Duration = Duration::from_secs(30);

struct Farm {
    endpoint: String,
    state: PathBuf,
    process: Going,
}

impl Farm {
    fn start(state: PathBuf, args: &[&str]) -> Self {
        let endpoint = free_endpoint();
        let call = ["coordinator", "--listen", &endpoint, "--workers", "1", "--state"];
        let process = Cullet::new(&call).path(&state).args(args).spawn();
        let farm = Self { endpoint, state, process };
        common::until("it is there", BOUND, || farm.ask(&["ps"]).code == 0);
        farm
    }

    /// Ends it as a crash would.
    fn crash(mut self) -> PathBuf {
        signal(self.process.id(), "KILL");
        self.process.wait(BOUND);
        self.state
    }

    fn ask(&self, args: &[&str]) -> common::Said {
        Cullet::new(args).args(&["--connect", &self.endpoint]).output()
    }

    fn quick(&self) -> String {
        let scene = corpus("drop.toml");
        let call = [&["submit", &scene, "--detach"], &QUICK[..]].concat();
        let said = self.ask(&call);
        assert_eq!(said.code, 0, "{}", said.stderr);
        let run = said.stdout.trim().to_owned();
        assert_eq!(self.ask(&["wait", &run]).code, 0);
        run
    }

    fn runs(&self) -> Vec<u64> {
        let said = self.ask(&["ps", "--json"]);
        let all: Value = serde_json::from_str(&said.stdout).expect("JSON");
        let all = all["runs"].as_array().expect("runs").clone();
        all.iter().filter_map(|run| run["run"].as_u64()).collect()
    }

    /// The digest of what is fetched of a run, or why nothing is.
    fn fetch(&self, run: &str) -> Result<Value, String> {
        let out = unique("fetch");
        let said = Cullet::new(&["fetch", run, "--connect", &self.endpoint, "--out"]).path(&out);
        let said = said.output();
        match said.code {
            0 => {
                assert!(out.join("run.mcap").is_file());
                Ok(summary(&out)["digest"].clone())
            }
            66 => Err(said.stderr),
            code => panic!("{code}: {}", said.stderr),
        }
    }
}

fn names(folder: &Path) -> Vec<String> {
    let all = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        all.map(|file| file.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_deleted_run_is_gone_from_the_list_and_the_disk_and_its_number_does_not_come_again() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("deleted"), &[]);
    let (first, second) = (farm.quick(), farm.quick());
    assert_eq!(names(&farm.state.join("recordings")), ["drop-1", "drop-2"]);
    let endless = ["submit", &corpus("drop.toml"), "--detach", "--set", "world.duration=600"];
    let endless = farm.ask(&endless).stdout.trim().to_owned();
    // One that goes on does not go, one that never was is not known; the others go all the same.
    let said = farm.ask(&["delete", &endless, "99", &second]);
    // Of the two codes, 66 and 77, the highest.
    assert_eq!(said.code, 77, "{}", said.stderr);
    assert!(said.stderr.contains("run 3 is ") && said.stderr.contains("cancelled"));
    assert!(said.stderr.contains("there is no run 99"), "{}", said.stderr);
    assert_eq!(said.stdout, "run 2 is deleted\n");
    let why = farm.fetch(&second).expect_err("it is gone");
    assert!(why.contains("run 2 is not here any more: it was deleted"), "{why}");
    assert!(!farm.state.join("recordings/drop-2").exists());
    assert_eq!(farm.runs(), [1, 3]);
    assert_eq!(names(&farm.state.join("runs")), ["1", "3"]);
    assert_eq!(farm.ask(&["delete", &second]).code, 0, "asked again it is as it was");
    assert_eq!(farm.ask(&["cancel", &endless]).code, 0);
    let said = farm.ask(&["delete", &endless, &first, "--json"]);
    assert_eq!((said.code, said.stdout.as_str()), (0, "{\"run\":3}\n{\"run\":1}\n"));
    assert_eq!((farm.runs(), names(&farm.state.join("runs")).len()), (vec![], 0));
    // The first start writes the journal anew, the second reads that.
    let farm = Farm::start(Farm::start(farm.crash(), &[]).crash(), &[]);
    assert_eq!(names(&farm.state.join("recordings")), [""; 0]);
    let journal = fs::read_to_string(farm.state.join("journal")).expect("a journal");
    assert!(journal.lines().count() <= 2, "it keeps what is gone: {journal}");
    assert_eq!(farm.quick(), "4", "a number comes again");
}

/// A hand that cuts a damaged journal loses runs; their numbers stay theirs, of those that were
/// deleted too.
#[test]
fn the_numbers_of_runs_that_a_cut_journal_has_lost_do_not_come_again() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("cut"), &[]);
    for _ in 0..4 {
        farm.quick();
    }
    assert_eq!(farm.ask(&["delete", "4"]).code, 0);
    let state = farm.crash();
    let journal = state.join("journal");
    let cut = || {
        let text = fs::read_to_string(&journal).expect("a journal");
        let lost = text.lines().position(|line| line.contains(r#""run":2"#)).expect("run 2");
        let left: String = text.split_inclusive('\n').take(lost).collect();
        fs::write(&journal, left).expect("a journal");
    };
    cut();
    let farm = Farm::start(state.clone(), &[]);
    assert_eq!((farm.runs(), farm.quick().as_str()), (vec![1], "5"));
    assert_eq!([farm.fetch("1"), farm.fetch("5")], [(); 2].map(|()| Ok(quiet_digest(&QUICK))));
    assert!(farm.fetch("3").expect_err("it is lost").contains("run 3 is not here any more"));
    assert_eq!(names(&state.join("runs")), ["1", "5"]);
    // Nor, of runs that were deleted, where there is no journal left at all, nor run.
    drop(farm.crash());
    fs::remove_file(&journal).expect("it goes");
    fs::rename(state.join("runs"), state.join("set-aside/runs")).expect("they go");
    let farm = Farm::start(state, &[]);
    assert_eq!((farm.runs(), farm.quick().as_str()), (vec![], "5"));
}

#[test]
fn the_oldest_run_makes_room_where_more_than_are_kept_come_and_takes_its_recording_with_it() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("kept"), &["--keep", "2"]);
    let [first, second, third] = [farm.quick(), farm.quick(), farm.quick()];
    assert_eq!(farm.runs(), [2, 3]);
    // The third has the folder that the first had.
    assert_eq!(names(&farm.state.join("recordings")), ["drop-1", "drop-2"]);
    assert_eq!(names(&farm.state.join("runs")), [second, third]);
    let why = farm.fetch(&first).expect_err("it is gone");
    assert!(why.contains("made room for others"), "{why}");
    assert_eq!(farm.quick(), "4");
    assert_eq!(names(&farm.state.join("recordings")), ["drop-1", "drop-2"]);
    let quiet = quiet_digest(&QUICK);
    assert_eq!([farm.fetch("3"), farm.fetch("4")], [Ok(quiet.clone()), Ok(quiet)]);
}

/// A copy of a folder.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for name in names(from) {
        match from.join(&name).is_dir() {
            true => copy(&from.join(&name), &to.join(&name)),
            false => drop(fs::copy(from.join(&name), to.join(&name)).expect("a copy")),
        }
    }
}

/// Killed after each of its steps: the line in the journal, each of the files, the folders, and
/// the line that says that they are gone.
#[test]
fn a_coordinator_that_was_killed_while_it_deleted_goes_on_with_it() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start(unique("halves"), &[]);
    let kept = farm.quick();
    assert_eq!((kept.as_str(), farm.quick().as_str()), ("1", "2"));
    let before = farm.crash();
    let mut steps: Vec<PathBuf> = vec![PathBuf::new()];
    for folder in ["runs/2", "recordings/drop-2"] {
        steps.extend(names(&before.join(folder)).iter().map(|name| Path::new(folder).join(name)));
        steps.push(folder.into());
    }
    assert!(steps.len() > 8, "{steps:?}");
    let quiet = quiet_digest(&QUICK);
    // Before the first step it is there, and whole.
    let line = |event: &str| format!("{:08x} {event}\n", sum(event.as_bytes()));
    for done in [0, 1, 3, steps.len() - 3, steps.len(), steps.len() + 1] {
        let state = unique("half");
        copy(&before, &state);
        let mut journal = fs::read_to_string(state.join("journal")).expect("a journal");
        if done > 0 {
            journal += &line(r#"{"event":"forgotten","run":2}"#);
        }
        for step in steps.iter().take(done).skip(1) {
            let path = state.join(step);
            let gone = if path.is_dir() { fs::remove_dir(&path) } else { fs::remove_file(&path) };
            gone.unwrap_or_else(|why| panic!("{step:?}: {why}"));
        }
        if done > steps.len() {
            journal += &line(r#"{"event":"removed","run":2}"#);
        }
        fs::write(state.join("journal"), journal).expect("a journal");
        // What a crash leaves of a run that was never accepted, or never began.
        for folder in ["runs/7", "recordings/drop-9"] {
            fs::create_dir(state.join(folder)).expect("a folder");
        }
        let farm = Farm::start(state, &[]);
        let there: Vec<&str> = if done == 0 { vec!["1", "2"] } else { vec!["1"] };
        assert_eq!(names(&farm.state.join("runs")), there, "after {done} steps");
        let recorded: Vec<String> = there.iter().map(|run| format!("drop-{run}")).collect();
        assert_eq!(names(&farm.state.join("recordings")), recorded, "after {done} steps");
        assert_eq!(farm.runs().len(), there.len(), "after {done} steps");
        let second = (done == 0).then_some(&quiet);
        assert_eq!(farm.fetch("2").ok().as_ref(), second, "after {done} steps");
        assert_eq!(farm.fetch("1").as_ref(), Ok(&quiet), "after {done} steps");
        // A number that a folder had is not given.
        assert_eq!(farm.quick(), "8", "after {done} steps");
    }
}

/// Killed for real, at moments that nobody chooses: each run is there and whole, or gone.
#[test]
fn runs_that_are_deleted_while_the_coordinator_is_killed_are_whole_or_gone() {
    let _left = common::left::NobodyLeft::watch();
    let mut farm = Farm::start(unique("race"), &["--runs", "4"]);
    for _ in 0..8 {
        farm.quick();
    }
    let (mut deleted, quiet) = (0, quiet_digest(&QUICK));
    for delay in [2, 9, 23] {
        let left: Vec<String> = farm.runs().iter().map(u64::to_string).collect();
        let call = ["delete", "--patience", "1", "--connect", &farm.endpoint];
        let asked: Vec<&str> = left.iter().map(String::as_str).collect();
        let mut asking = Cullet::new(&call).args(&asked).spawn();
        common::until("one is gone", BOUND, || !farm.state.join("runs").join(&left[0]).exists());
        std::thread::sleep(Duration::from_millis(delay));
        farm = {
            let state = farm.crash();
            asking.kill();
            Farm::start(state, &["--runs", "4"])
        };
        let mut there: Vec<String> = farm.runs().iter().map(u64::to_string).collect();
        // In the order of names, in which 10 comes before 9.
        there.sort_unstable();
        deleted += left.len() - there.len();
        assert_eq!(names(&farm.state.join("runs")), there);
        assert_eq!(names(&farm.state.join("recordings")).len(), there.len());
        for run in &there {
            assert_eq!(farm.fetch(run).as_ref(), Ok(&quiet), "run {run} is there by half");
        }
        while farm.runs().len() < 4 {
            farm.quick();
        }
    }
    assert!(deleted >= 3, "nothing was deleted");
}
