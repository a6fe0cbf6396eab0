//! Coordinators of one name on one network: one of them serves, whatever happens.

use crate::common;

use common::proxy::proxy;
use common::{Cullet, DONE, Going, Said, corpus, quiet_digest, signal, unique};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::thread::sleep;
use std::time::Duration;

/// Longest a test waits for anything.
const LONG: Duration = Duration::from_secs(60);
/// Not now.
const LATER: i32 = 75;

fn router(endpoint: &str) -> Going {
    let router = Cullet::new(&["router", "--listen", endpoint]).spawn();
    let place = endpoint.trim_start_matches("tcp/");
    common::until("a router", LONG, || std::net::TcpStream::connect(place).is_ok());
    router
}

fn coordinator(router: &str, state: &Path) -> Going {
    Cullet::new(&["coordinator", "--router", router, "--state"]).path(state).spawn()
}

fn ask(endpoint: &str, args: &[&str]) -> Said {
    Cullet::new(args).args(&["--connect", endpoint, "--patience", "4"]).output()
}

fn answers(endpoint: &str) {
    common::until("a coordinator answers", LONG, || ask(endpoint, &["ps"]).code == 0);
}

/// The number of a run that was handed in and is done by nobody yet.
fn submit(endpoint: &str) -> String {
    let said = ask(endpoint, &["submit", &corpus("drop.toml"), "--detach"]);
    assert_eq!(said.code, 0, "{}", said.stderr);
    said.stdout.trim().to_owned()
}

/// It was refused, and named who it was that has the name.
fn refused(process: &mut Going, by: u32, why: &str) {
    assert_eq!(process.wait(LONG), Some(LATER), "{}", process.stderr());
    let said = process.stderr();
    assert!(said.contains(&format!("called main on this network: process {by} on ")), "{said}");
    assert!(said.contains("there since 2") && said.contains(why), "{said}");
}

#[test]
fn a_second_coordinator_is_refused_and_one_that_was_killed_is_followed_by_the_next() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let _router = router(&endpoint);
    let (first, second) = (unique("first"), unique("second"));
    let mut one = coordinator(&endpoint, &first);
    answers(&endpoint);
    let run = submit(&endpoint);
    let begun = "end that one, or give this one a name (--name) or a router of its own";
    refused(&mut coordinator(&endpoint, &second), one.id(), begun);
    // The same folder has a lock of its own.
    let mut same = coordinator(&endpoint, &first);
    assert_eq!(same.wait(LONG), Some(74), "{}", same.stderr());
    let _worker = Cullet::new(&["worker", "--connect", &endpoint]).spawn();
    assert!(DONE.contains(&ask(&endpoint, &["wait", &run]).code));
    let who = ["--connect", &endpoint];
    assert_eq!(common::fetched(&run, &who), quiet_digest(&[]));
    // Killed and started again at once, and again by somebody else.
    for (state, runs) in [(&first, true), (&second, false)] {
        signal(one.id(), "KILL");
        one = coordinator(&endpoint, state);
        answers(&endpoint);
        assert_eq!(ask(&endpoint, &["show", &run]).code == 0, runs);
    }
    signal(one.id(), "TERM");
    assert_eq!(one.wait(LONG), Some(0), "{}", one.stderr());
}

/// Two behind one router, each with workers and runs of its own.
#[test]
fn coordinators_of_two_names_do_not_see_each_other() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let _router = router(&endpoint);
    let [_day, _night] = ["main", "night"].map(|name| {
        let call = ["coordinator", "--router", &endpoint, "--workers", "1", "--name", name];
        Cullet::new(&call).args(&["--state"]).path(&unique(name)).spawn()
    });
    let at = |name: &str, args: &[&str]| {
        let said = ask(&endpoint, &[args, &["--coordinator", name]].concat());
        (said.code, said.stdout, said.stderr)
    };
    for name in ["main", "night"] {
        common::until("it answers", LONG, || at(name, &["ps"]).0 == 0);
    }
    let scene = corpus("drop.toml");
    for name in ["night", "main"] {
        let (code, run, stderr) = at(name, &["submit", &scene, "--detach"]);
        assert_eq!((code, run.as_str()), (0, "1\n"), "{name}: {stderr}");
        assert!(DONE.contains(&at(name, &["wait", "1"]).0));
        let who = ["--connect", endpoint.as_str(), "--coordinator", name];
        assert_eq!(common::fetched("1", &who), quiet_digest(&[]), "{name}");
        let workers = at(name, &["workers", "--json"]).1;
        assert_eq!(workers.matches("\"name\"").count(), 1, "{name}: {workers}");
    }
    let (code, _, stderr) = at("noon", &["ps"]);
    assert_eq!(code, 69, "{stderr}");
}

#[test]
fn of_coordinators_that_start_together_one_stays() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let _router = router(&endpoint);
    for _ in 0..4 {
        let mut all: Vec<Going> =
            (0..3).map(|k| coordinator(&endpoint, &unique(&format!("together-{k}")))).collect();
        let alive = |all: &[Going]| all.iter().filter(|one| common::is_alive(one.id())).count();
        common::until("all but one are gone", LONG, || alive(&all) <= 1);
        answers(&endpoint);
        let stays = all.iter().position(|one| common::is_alive(one.id())).expect("one stays");
        let mut one = all.remove(stays);
        for other in &mut all {
            assert_eq!(other.wait(LONG), Some(LATER), "{}", other.stderr());
            assert!(other.stderr().contains("another coordinator is called main"));
        }
        signal(one.id(), "TERM");
        assert_eq!(one.wait(LONG), Some(0), "{}", one.stderr());
    }
}

/// Its machine is gone: the router sees its sign of life until it gives the link up.
#[test]
fn a_sign_of_life_that_lingers_is_waited_for() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let _router = router(&endpoint);
    let (weather, door) = proxy(&endpoint);
    let state = unique("gone");
    let mut one = coordinator(&door, &state);
    answers(&endpoint);
    let run = submit(&endpoint);
    weather.silent.store(true, Ordering::SeqCst);
    // Until something waits in the hole each way: then its end is not seen either.
    sleep(Duration::from_secs(2));
    one.kill();
    let mut next = coordinator(&endpoint, &state);
    common::until("the next one answers", LONG, || ask(&endpoint, &["show", &run]).code == 0);
    assert_eq!(next.wait(Duration::from_millis(10)), None, "{}", next.stderr());
}

#[test]
fn of_two_that_find_each_other_again_the_younger_leaves_and_loses_nothing() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let _router = router(&endpoint);
    let (weather, door) = proxy(&endpoint);
    let (elder, younger) = (unique("elder"), unique("younger"));
    let mut first = coordinator(&door, &elder);
    answers(&endpoint);
    weather.silent.store(true, Ordering::SeqCst);
    let mut second = coordinator(&endpoint, &younger);
    answers(&endpoint);
    let run = submit(&endpoint);
    weather.silent.store(false, Ordering::SeqCst);
    refused(&mut second, first.id(), "it was there first, so this one leaves");
    common::until("the elder answers", LONG, || ask(&endpoint, &["ps"]).code == 0);
    assert_eq!(ask(&endpoint, &["show", &run]).code, 66, "the elder knows of its own runs alone");
    signal(first.id(), "TERM");
    assert_eq!(first.wait(LONG), Some(0), "{}", first.stderr());
    let _second = coordinator(&endpoint, &younger);
    let _worker = Cullet::new(&["worker", "--connect", &endpoint]).spawn();
    common::until("the run is done", LONG, || DONE.contains(&ask(&endpoint, &["wait", &run]).code));
    assert_eq!(common::fetched(&run, &["--connect", &endpoint]), quiet_digest(&[]));
}

/// Several places are ways to one coordinator, and the first that leads somewhere is taken.
#[test]
fn a_worker_takes_the_way_that_is_there() {
    let _left = common::left::NobodyLeft::watch();
    let (nobody, endpoint) = (common::free_endpoint(), common::free_endpoint());
    let _coordinator = Cullet::new(&["coordinator", "--listen", &endpoint]).spawn();
    answers(&endpoint);
    let call = ["worker", "--connect", &nobody, "--connect", &endpoint, "--name", "w"];
    let mut worker = Cullet::new(&call).spawn();
    common::until("the worker is there", LONG, || {
        ask(&endpoint, &["workers", "--json"]).stdout.contains("\"name\":\"w\"")
    });
    signal(worker.id(), "TERM");
    assert_eq!(worker.wait(LONG), Some(0));
    let said = worker.stderr();
    assert!(said.contains("all of them must lead to one coordinator"), "{said}");
}
