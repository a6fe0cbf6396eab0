//! What everybody wrote down, checked: first the checker itself, which must see a planted loss,
//! double and phantom; then a coordinator that is killed at random points of its runs.
//!
//! `CULLET_POINTS=20 cargo test --release -p cullet --test farm history:: -- --nocapture` kills
//! twenty times; `CULLET_SEED` names when.

use crate::common;

use common::desk::Desk;
use common::farm::{Draw, Farm, Role};
use common::figures::number;
use common::history::{Act, Heard, Listed, Step, check_jobs, check_runs, lines};
use common::{Cullet, DONE, corpus, fetched, quiet_digest, signal, unique, until};
use std::io::{PipeWriter, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

fn act(verb: &str, key: &str, run: Option<u64>, heard: Heard) -> Act {
    Act { verb: verb.into(), key: key.into(), run, heard }
}

fn listed(run: u64, key: &str, state: &str) -> Listed {
    Listed { run, key: key.into(), state: state.into() }
}

/// Two that are known, one of which nobody heard, one that is cancelled, one that is deleted.
fn runs() -> (Vec<Act>, Vec<Listed>) {
    let acts = vec![
        act("submit", "a", Some(1), Heard::Ok),
        act("submit", "b", None, Heard::Info),
        act("submit", "c", None, Heard::Info),
        act("submit", "d", Some(3), Heard::Ok),
        act("cancel", "", Some(3), Heard::Info),
        act("submit", "e", Some(4), Heard::Ok),
        act("delete", "", Some(4), Heard::Ok),
    ];
    let there = vec![listed(1, "a", "done"), listed(2, "b", "done"), listed(3, "d", "cancelled")];
    (acts, there)
}

fn only(said: &[String], kind: &str) {
    assert!(said.len() == 1 && said[0].starts_with(kind), "{kind}: {said:#?}");
}

#[test]
fn a_checker_of_runs_sees_what_is_lost_doubled_and_made_up() {
    let _left = common::left::NobodyLeft::watch();
    let (acts, there) = runs();
    assert_eq!(check_runs(&acts, &there), Vec::<String>::new());
    only(&check_runs(&acts, &there[1..]), "lost");
    let with = |more: Listed| [&there[..], &[more]].concat();
    only(&check_runs(&acts, &with(listed(9, "z", "done"))), "phantom");
    // Handed in once by somebody who did not hear of it, and there twice.
    only(&check_runs(&acts, &with(listed(9, "b", "done"))), "phantom");
    only(&check_runs(&acts, &with(listed(4, "e", "done"))), "doubled");
    let again = [&acts[..], &[act("submit", "a", Some(1), Heard::Ok)]].concat();
    only(&check_runs(&again, &there), "doubled");
    for state in ["running", "failed", "stalled", "cancelled"] {
        let other = [&[listed(1, "a", state)], &there[1..]].concat();
        only(&check_runs(&acts, &other), "lost");
    }
    let other = [&[listed(1, "b", "done")], &there[2..]].concat();
    only(&check_runs(&acts, &other), "phantom");
}

fn granted(job: &str, epoch: u64, worker: &str) -> Step {
    Step::Granted { job: job.into(), worker: worker.into(), epoch }
}

/// A run whose coordinator dies with one of two jobs settled, and with a result of the other on its
/// way, which counts in the next life.
fn jobs() -> Vec<Step> {
    let opened = |job: &str, kept| Step::Opened { run: 1, job: job.into(), kept };
    let taken = |job: &str, epoch| Step::Taken { job: job.into(), worker: "w".into(), epoch };
    let settled = |job: &str, kept| {
        let (job, ending) = (job.into(), "solved".into());
        Step::Settled { run: 1, job, kept, ending }
    };
    let solved = |job: &str| Step::Solved { job: job.into() };
    vec![
        Step::Life,
        Step::Started { run: 1 },
        opened("a", false),
        granted("a", 1, "w"),
        taken("a", 1),
        settled("a", false),
        opened("b", false),
        granted("b", 2, "w"),
        Step::Life,
        Step::Started { run: 1 },
        opened("a", true),
        settled("a", true),
        opened("b", false),
        granted("b", 3, "w"),
        taken("b", 2),
        settled("b", false),
        Step::Ended { run: 1, how: "Done".into() },
        solved("a"),
        solved("b"),
    ]
}

#[test]
fn a_checker_of_jobs_sees_what_is_lost_doubled_and_made_up() {
    let _left = common::left::NobodyLeft::watch();
    let sound = jobs();
    assert_eq!(check_jobs(&sound), Vec::<String>::new());
    let without = |index: usize| {
        let mut steps = sound.clone();
        steps.remove(index);
        check_jobs(&steps)
    };
    let twice = |index: usize| {
        let mut steps = sound.clone();
        steps.insert(index, steps[index].clone());
        check_jobs(&steps)
    };
    only(&without(15), "lost");
    // Granted to nobody; solved by nobody, which three places tell.
    only(&without(7), "phantom");
    assert!(without(17).iter().all(|said| said.starts_with("phantom")), "{:?}", without(17));
    assert_eq!(without(17).len(), 4);
    assert_eq!(twice(7), Vec::<String>::new(), "who asks again gets the same answer");
    let mut steps = sound.clone();
    steps[13] = granted("b", 2, "v");
    assert!(check_jobs(&steps).iter().any(|said| said.starts_with("doubled")));
    for index in [14, 15] {
        let said = twice(index);
        assert!(said.iter().any(|said| said.starts_with("doubled")), "{index}: {said:?}");
    }
    // Worked out again in the second life, though it had settled in the first.
    let mut steps = sound.clone();
    for step in &mut steps[10..12] {
        if let Step::Opened { kept, .. } | Step::Settled { kept, .. } = step {
            *kept = false;
        }
    }
    only(&check_jobs(&steps), "doubled");
    let alarm = [&sound[..], &[Step::Alarm("job a".into())]].concat();
    only(&check_jobs(&alarm), "alarm");
}

/// The run is in the journal, and the answer is lost with the link: who asks again hears of the
/// same run.
#[test]
fn a_submission_whose_answer_is_lost_is_one_run() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("unheard");
    let mut farm = Farm::start(folder.clone(), 1);
    let desk = Desk::open(&farm.door.1, &folder);
    let weather = farm.door.0.clone();
    let log = farm.log_of(Role::Coordinator, 0);
    let taken = || lines(&log).iter().filter(|line| line["message"] == "run handed in").count();
    // Once the answer may have come before the link was cut.
    let cut = (1..=5).any(|seed| {
        weather.delay.store(400, Ordering::SeqCst);
        let before = taken();
        let (run, links) = std::thread::scope(|all| {
            let client = all.spawn(|| desk.submit(seed, None));
            until("it is handed in", Duration::from_secs(60), || taken() > before);
            let links = weather.cut();
            weather.clear();
            (client.join().expect("a client"), links)
        });
        assert!(desk.finish(run.expect("it is told in the end")), "it is done");
        links > 0
    });
    assert!(cut, "there is a link to cut");
    desk.healed();
    let listed = desk.listed();
    let (mut said, acts) = desk.close();
    said.extend(check_runs(&acts, &listed));
    farm.leave();
    assert!(said.is_empty(), "{said:#?}\nin {}", folder.display());
    std::fs::remove_dir_all(folder).ok();
}

/// Fills a pipe: who writes there now waits.
fn full_pipe(mut writer: PipeWriter) {
    let (page, filled) = (vec![b'\n'; 4096], Arc::new(AtomicU64::new(0)));
    let count = Arc::clone(&filled);
    std::thread::spawn(move || {
        while writer.write_all(&page).is_ok() {
            count.fetch_add(1, Ordering::SeqCst);
        }
    });
    let mut last = 0;
    until("the pipe is full", Duration::from_secs(20), || {
        sleep(Duration::from_millis(200));
        let now = filled.load(Ordering::SeqCst);
        std::mem::replace(&mut last, now) == now && now > 0
    });
}

/// The run is in the journal, and the coordinator dies before it has answered: who asks again hears
/// of the same run. It is stopped there by a line of its log, which nobody takes from it.
#[test]
fn a_coordinator_that_dies_between_its_journal_and_its_answer_has_the_run_once() {
    let _left = common::left::NobodyLeft::watch();
    let (endpoint, state) = (common::free_endpoint(), unique("unanswered"));
    let start = |workers: &str| {
        let call = ["coordinator", "--log", "json", "--listen", &endpoint, "--workers", workers];
        Cullet::new(&call).args(&["--state"]).path(&state)
    };
    let ask = |args: &[&str]| Cullet::new(args).args(&["--connect", &endpoint]).output();
    let (reader, writer) = std::io::pipe().expect("a pipe");
    let mut coordinator = start("0").errors(writer.try_clone().expect("a pipe")).spawn();
    until("it is there", Duration::from_secs(30), || ask(&["ps"]).code == 0);
    full_pipe(writer);
    let scene = corpus("drop.toml");
    let call = ["submit", &scene, "--detach", "--patience", "120", "--connect", &endpoint];
    let mut client = Cullet::new(&call).spawn();
    let journal = || std::fs::read_to_string(state.join("journal")).unwrap_or_default();
    let kept = || journal().contains("\"submitted\"");
    until("it is in the journal", Duration::from_secs(60), kept);
    assert_eq!(client.wait(Duration::from_secs(1)), None, "it has been answered: {}", journal());
    signal(coordinator.id(), "KILL");
    coordinator.wait(Duration::from_secs(10));
    drop(reader);
    let log = std::fs::File::create(state.join("second.log")).expect("a log");
    let _again = start("1").errors(log).spawn();
    assert_eq!(client.wait(Duration::from_secs(100)), Some(0), "{}", client.stderr());
    assert_eq!(client.stdout().trim(), "1");
    let said = ask(&["wait", "1"]);
    assert!(DONE.contains(&said.code), "{}", said.stderr);
    let all = ask(&["ps", "--json"]).stdout;
    let all: serde_json::Value = serde_json::from_str(&all).expect("JSON");
    assert_eq!(all["runs"].as_array().map(Vec::len), Some(1), "{all:#}");
    assert_eq!(fetched("1", &["--connect", &endpoint]), quiet_digest(&[]));
}

/// One run, in which the coordinator is killed: as it is handed in, in the middle, or at its end.
fn point(farm: &mut Farm, desk: &Desk, draw: &mut Draw, (index, quiet): (u64, Duration)) {
    let seed = 100 + index;
    let quiet = quiet.as_millis() as u64;
    let (what, run, begun) = if index % 4 == 0 {
        let wait = draw.millis(0, 150);
        let run = std::thread::scope(|all| {
            let client = all.spawn(|| desk.submit(seed, None));
            sleep(wait);
            farm.kill(Role::Coordinator);
            farm.tend();
            client.join().expect("a client")
        });
        (format!("{} ms after its client was started", wait.as_millis()), run, Instant::now())
    } else {
        let run = desk.submit(seed, None);
        let wait = match index % 4 {
            3 => draw.millis(quiet * 4 / 5, quiet * 11 / 10),
            _ => draw.millis(0, quiet * 4 / 5),
        };
        sleep(wait);
        farm.kill(Role::Coordinator);
        farm.tend();
        (format!("{} ms after it was taken", wait.as_millis()), run, Instant::now())
    };
    if let Some(run) = run {
        assert!(desk.finish(run), "run {run} is not done");
        desk.compare(run, seed);
    }
    println!("killed {what}: over {:.2} s later", begun.elapsed().as_secs_f64());
}

#[test]
#[ignore = "long"]
fn a_coordinator_killed_at_random_points_loses_and_doubles_nothing() {
    let _left = common::left::NobodyLeft::watch();
    let points = number("CULLET_POINTS", 4);
    let time = std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.as_nanos() as u64);
    let seed = number("CULLET_SEED", time);
    println!("CULLET_POINTS={points} CULLET_SEED={seed}");
    let folder = unique("points");
    let mut farm = Farm::start(folder.clone(), 1);
    let desk = Desk::open(&farm.door.1, &folder);
    let mut quiet = Duration::MAX;
    // The first one waits for the farm too.
    for seed in [98, 99] {
        let begun = Instant::now();
        let run = desk.submit(seed, None).expect("it is taken");
        assert!(desk.finish(run), "it is done");
        quiet = begun.elapsed();
        desk.compare(run, seed);
    }
    let mut draw = Draw(seed);
    (0..points).for_each(|index| point(&mut farm, &desk, &mut draw, (index, quiet)));
    desk.healed();
    let listed = desk.listed();
    let (mut said, acts) = desk.close();
    farm.leave();
    assert_eq!(farm.left(), Vec::<u32>::new(), "processes are left behind");
    let steps = farm.steps();
    said.extend(check_runs(&acts, &listed));
    said.extend(check_jobs(&steps));
    let count = |what: fn(&Step) -> bool| steps.iter().filter(|step| what(step)).count();
    println!(
        "{} lives, {} runs, {} compared; {} grants, {} results taken, {} settlements",
        count(|step| *step == Step::Life),
        listed.len(),
        desk.compared(),
        count(|step| matches!(step, Step::Granted { .. })),
        count(|step| matches!(step, Step::Taken { .. })),
        count(|step| matches!(step, Step::Settled { .. })),
    );
    assert!(said.is_empty(), "{said:#?}\nin {}", folder.display());
    assert!(desk.compared() >= points, "{} of {points} were compared", desk.compared());
    std::fs::remove_dir_all(folder).ok();
}
