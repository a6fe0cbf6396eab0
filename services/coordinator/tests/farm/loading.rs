//! Scenes that take long to load: the coordinator ends without waiting for them.

use crate::hostile::{BOUND, Farm, SCENE, submission};
use cullet_coordinator::ServiceConfig;
use cullet_proto::keys::UserVerb;
use cullet_proto::service::{RunInfo, State};
use serde_json::json;
use std::fs::File;
use std::path::Path;
use std::time::{Duration, Instant};

/// A body whose parts take half a minute to become one: none of that looks whether it is to stop.
fn slow_scene() -> Vec<u8> {
    body("a", 0.1, 200).into_bytes()
}

/// A body of so many rods.
fn body(name: &str, radius: f64, parts: u32) -> String {
    let part = |n: u32| {
        let place = [n % 6, n / 6 % 6, n / 36].map(|k| f64::from(k) * 0.05);
        let shape = "kind = \"cylinder\", height = 3, segments = 128";
        format!("{{ shape = {{ {shape}, radius = {radius} }}, position = {place:?} }}")
    };
    let parts: Vec<String> = (0..parts).map(part).collect();
    let body = "material = \"plaster\"\nposition = [0, 0, 9]\n";
    format!("[[body]]\nname = \"{name}\"\n{body}parts = [{}]\n", parts.join(", "))
}

/// What an attempt has recorded, as if it had: one that loads leaves it alone.
fn record(out: &Path) {
    let folder = std::fs::read_dir(out).expect("recordings").next().expect("one").expect("it");
    std::fs::write(folder.path().join("run.mcap.partial"), "so far").expect("it records");
}

fn has_recording(info: &RunInfo) -> bool {
    info.files.iter().any(|file| file.name == "run.mcap.partial" && file.length == 6)
}

/// The first run of a coordinator.
fn first(farm: &Farm) -> RunInfo {
    let said = farm.ask(UserVerb::Run, json!({"run": 1}).to_string().as_bytes());
    serde_json::from_slice(&said.expect("a run")).expect("a run")
}

fn wait_until(farm: &Farm, holds: impl Fn(&RunInfo) -> bool) -> RunInfo {
    let begun = Instant::now();
    loop {
        let info = first(farm);
        if holds(&info) {
            return info;
        }
        assert!(begun.elapsed() < BOUND, "{info:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn running(farm: &Farm) -> RunInfo {
    wait_until(farm, |info| info.state == State::Running)
}

#[test]
fn a_scene_that_takes_long_to_load_does_not_keep_the_coordinator() {
    let config = || ServiceConfig { runs: 2, ..ServiceConfig::default() };
    let end = |farm: Farm| {
        let begun = Instant::now();
        let folder = farm.end();
        assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
        // Where its run still loads, the lock would have gone with its process.
        let lock = folder.path().join("inner/state/lock");
        if File::open(&lock).expect("a lock").try_lock().is_err() {
            std::fs::remove_file(lock).expect("it goes");
        }
        folder
    };
    let farm = Farm::at(tempfile::tempdir().expect("a folder"), config());
    let scene = slow_scene();
    let submission = submission("slow", "slow", &[(SCENE, &scene)]);
    assert!(farm.ask(UserVerb::Submit, &submission).is_ok());
    running(&farm);
    // By then it is past where it looks.
    std::thread::sleep(Duration::from_millis(300));
    // The next life takes it up again, and does not take it for what the last one died of.
    let farm = Farm::at(end(farm), config());
    assert_eq!(running(&farm).attempt, 2);
    assert!(farm.ask(UserVerb::Cancel, json!({"run": 1}).to_string().as_bytes()).is_ok());
    let farm = Farm::at(end(farm), config());
    assert_eq!(first(&farm).state, State::Cancelled);
}

#[test]
fn a_run_that_is_cut_off_where_nothing_is_kept_has_what_it_recorded() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let config = ServiceConfig { runs: 1, out: Some(out.clone()), ..ServiceConfig::default() };
    let farm = Farm::open(folder, None, config);
    let scene = slow_scene();
    let submission = submission("slow", "slow", &[(SCENE, &scene)]);
    assert!(farm.ask(UserVerb::Submit, &submission).is_ok());
    running(&farm);
    record(&out);
    let begun = Instant::now();
    farm.ask_to_stop();
    let info = wait_until(&farm, |info| info.state.is_over());
    assert_eq!(info.state, State::Cancelled);
    assert!(has_recording(&info), "{info:?}");
    drop(farm);
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
}

#[test]
fn a_run_that_is_cancelled_as_it_loads_again_has_what_it_recorded_before() {
    let config = ServiceConfig { runs: 1, ..ServiceConfig::default() };
    let farm = Farm::at(tempfile::tempdir().expect("a folder"), config);
    // Many bodies, each of which takes a while.
    let one = |n: u32| body(&format!("b{n}"), 0.1 + f64::from(n) * 1e-4, 12);
    let scene: String = (0..500).map(one).collect();
    let submission = submission("long", "long", &[(SCENE, scene.as_bytes())]);
    assert!(farm.ask(UserVerb::Submit, &submission).is_ok());
    running(&farm);
    record(&farm.place().join("inner/state/recordings"));
    assert!(farm.ask(UserVerb::Cancel, json!({"run": 1}).to_string().as_bytes()).is_ok());
    let info = wait_until(&farm, |info| info.state.is_over());
    assert_eq!(info.state, State::Cancelled);
    assert!(has_recording(&info), "{info:?}");
}

/// Nobody asked it to stop: it is as patient as its clients.
#[test]
fn a_coordinator_that_has_done_its_runs_waits_for_clients_until_it_is_asked_to_stop() {
    let config = ServiceConfig { runs: 1, stop_after: Some(1), ..ServiceConfig::default() };
    let farm = Farm::at(tempfile::tempdir().expect("a folder"), config);
    let submission = submission("bad", "bad", &[(SCENE, b"no scene")]);
    assert!(farm.ask(UserVerb::Submit, &submission).is_ok());
    wait_until(&farm, |info| info.state.is_over());
    // A recording may take a while to be fetched.
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(9) {
        assert!(!farm.has_ended(), "after {:?}", begun.elapsed());
        let fetch = json!({"run": 1, "file": "run.mcap", "index": 0});
        assert!(farm.ask(UserVerb::Fetch, fetch.to_string().as_bytes()).is_err());
        std::thread::sleep(Duration::from_millis(500));
    }
    let begun = Instant::now();
    drop(farm);
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
}
