//! Faults for real: processes are killed and interrupted while they work, and nothing that counts
//! is lost.

mod common;

use common::{Cullet, children_of, corpus, signal, summary, unique};
use std::fs;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The drop scene, finer, so that a job lasts long enough to be hit.
const LONGER: [&str; 2] = ["--set", "fracture.max_particles=12000"];

fn quiet_digest() -> serde_json::Value {
    let out = unique("quiet");
    let run = Cullet::new(&["run", &corpus("drop.toml"), "-q", "--out"])
        .path(&out)
        .args(&LONGER)
        .output();
    assert_eq!(run.code, 0, "{}", run.stderr);
    summary(&out)["digest"].clone()
}

/// Waits until the run has worker processes, and returns them.
fn workers_of(parent: u32) -> Vec<u32> {
    let until = Instant::now() + Duration::from_secs(20);
    while Instant::now() < until {
        let children = children_of(parent);
        if !children.is_empty() {
            return children;
        }
        sleep(Duration::from_millis(20));
    }
    panic!("no worker process appeared");
}

#[test]
fn a_worker_killed_in_the_middle_of_a_job_costs_time_and_no_result() {
    let out = unique("killed");
    let mut run = Cullet::new(&["run", &corpus("drop.toml"), "-v", "--workers", "2", "--out"])
        .path(&out)
        .args(&LONGER)
        .spawn();
    let mut resent = 0;
    for _ in 0..3 {
        sleep(Duration::from_millis(900));
        if let Some(worker) = children_of(run.id()).first() {
            signal(*worker, "KILL");
            resent += 1;
        }
    }
    assert!(resent > 0, "nobody was killed: the run was too quick for this test");
    assert_eq!(run.wait(Duration::from_secs(120)), Some(0), "{}", run.stderr());
    let summary = summary(&out);
    assert!(summary["jobs"]["resent"].as_u64() >= Some(1), "{summary:#}");
    assert_eq!(summary["digest"], quiet_digest());
}

#[test]
fn an_interrupted_run_finishes_its_recording() {
    let out = unique("interrupted");
    let mut run = Cullet::new(&["run", &corpus("drop.toml"), "--out"])
        .path(&out)
        .args(&LONGER)
        .args(&["--set", "world.duration=30"])
        .spawn();
    workers_of(run.id());
    sleep(Duration::from_millis(500));
    signal(run.id(), "INT");
    assert_eq!(run.wait(Duration::from_secs(30)), Some(130), "{}", run.stderr());
    let inspect = Cullet::new(&["inspect", "--json"]).path(&out.join("run.mcap")).output();
    assert_eq!(inspect.code, 0, "{}", inspect.stderr);
    let told: serde_json::Value = serde_json::from_str(&inspect.stdout).expect("JSON");
    assert_eq!(told, summary(&out));
}

#[test]
fn a_killed_parent_leaves_no_worker_and_a_recording_that_can_be_recovered() {
    let out = unique("orphans");
    let mut run = Cullet::new(&["run", &corpus("drop.toml"), "--workers", "2", "--out"])
        .path(&out)
        .args(&LONGER)
        .args(&["--set", "world.duration=30"])
        .spawn();
    let workers = workers_of(run.id());
    sleep(Duration::from_secs(3));
    signal(run.id(), "KILL");
    run.wait(Duration::from_secs(5));
    let until = Instant::now() + Duration::from_secs(10);
    let alive = || workers.iter().any(|id| common::is_alive(*id));
    while alive() && Instant::now() < until {
        sleep(Duration::from_millis(50));
    }
    assert!(!alive(), "workers outlive their parent");
    let partial = out.join("run.mcap.partial");
    assert!(partial.is_file() && !out.join("run.mcap").exists());
    let recovered = out.join("saved.mcap");
    let recover = Cullet::new(&["recover"]).path(&partial).args(&["-o"]).path(&recovered).output();
    assert_eq!(recover.code, 0, "{}", recover.stderr);
    let inspect = Cullet::new(&["inspect", "--json"]).path(&recovered).output();
    assert_eq!(inspect.code, 0, "{}", inspect.stderr);
    let told: serde_json::Value = serde_json::from_str(&inspect.stdout).expect("JSON");
    assert!(told["steps"].as_u64() > Some(0), "{told:#}");
    assert!(fs::metadata(&recovered).expect("a file").len() > 0);
}
