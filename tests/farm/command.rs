//! The binary as a person or a script meets it: outcomes, exit codes, what is left behind.

use crate::common;

use common::{Cullet, children_of, corpus, is_alive, summary, unique};
use cullet_record::Recording;
use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::thread::sleep;
use std::time::{Duration, Instant};

#[test]
fn a_run_leaves_a_recording_that_says_the_same_as_its_summary() {
    let _left = common::left::NobodyLeft::watch();
    let out = unique("run");
    let run = Cullet::new(&["run", &corpus("drop.toml"), "--json", "--out"]).path(&out).output();
    assert_eq!(run.code, 0, "{}", run.stderr);
    let names: Vec<_> = ["run.mcap", "summary.json", "preview.png", "preview.gif"]
        .iter()
        .filter(|name| !out.join(name).is_file())
        .collect();
    assert!(names.is_empty(), "missing {names:?}");
    let mode = |name| fs::metadata(out.join(name)).expect("a file").permissions().mode();
    assert_eq!(mode("summary.json"), mode("run.mcap"), "who may read one may read the other");
    let partial = fs::read_dir(&out).expect("the folder is there").flatten().any(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        name.ends_with(".partial") || name.starts_with('.')
    });
    assert!(!partial, "something unfinished was left");

    let printed: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON on stdout");
    assert_eq!(printed, summary(&out));
    let inspect = Cullet::new(&["inspect", "--json"]).path(&out.join("run.mcap")).output();
    assert_eq!(inspect.code, 0, "{}", inspect.stderr);
    let inspected: serde_json::Value = serde_json::from_str(&inspect.stdout).expect("JSON");
    assert_eq!(inspected, printed, "the recording alone tells the same");

    assert!(printed["fractures"].as_u64() >= Some(2), "{printed:#}");
    assert_eq!(printed["open_fragments"], 0);
    let ledger = &printed["ledger"];
    for (key, bound) in [
        ("mass_rel_error", 1e-9),
        ("volume_rel_error", 1e-9),
        ("momentum_rel_error", 1e-9),
        ("angular_momentum_rel_error", 1e-9),
        ("energy_gain_rel", 1e-9),
    ] {
        let value = ledger[key].as_f64().expect("a number");
        assert!(value.abs() <= bound, "{key} is {value}");
    }
}

#[test]
fn the_digest_is_the_same_for_any_number_of_workers_and_threads() {
    let _left = common::left::NobodyLeft::watch();
    let mut digests = Vec::new();
    for (workers, threads) in [("1", "1"), ("2", "1"), ("4", "1"), ("1", "2"), ("2", "2")] {
        let out = unique("digest");
        let run = Cullet::new(&["run", &corpus("drop.toml"), "-q", "--no-pictures"])
            .args(&["--workers", workers, "--threads", threads, "--out"])
            .path(&out)
            .output();
        assert_eq!(run.code, 0, "{}", run.stderr);
        digests.push(summary(&out)["digest"].clone());
    }
    assert!(digests.iter().all(|digest| *digest == digests[0]), "{digests:?}");
}

/// Runs the drop scene with that latency, and says what it came to.
fn late(steps: u32, workers: &str) -> (i32, serde_json::Value, std::path::PathBuf) {
    let out = unique("late");
    let set = format!("world.latency_steps={steps}");
    let run = Cullet::new(&["run", &corpus("drop.toml"), "-q", "--no-pictures", "--set", &set])
        .args(&["--workers", workers, "--out"])
        .path(&out)
        .output();
    assert!([0, 3].contains(&run.code), "{}", run.stderr);
    (run.code, summary(&out), out)
}

#[test]
fn late_fragments_break_the_same_bodies_and_keep_the_ledger() {
    let _left = common::left::NobodyLeft::watch();
    for steps in [5, 20] {
        // Exit code 0: both bodies broke, as the scene expects.
        let (code, told, _) = late(steps, "1");
        assert_eq!(code, 0, "{steps} steps late: {told:#}");
        assert_eq!(told["jobs"]["opened"], told["jobs"]["settled"], "{told:#}");
        for key in ["mass_rel_error", "momentum_rel_error", "energy_gain_rel"] {
            let value = told["ledger"][key].as_f64().expect("a number");
            assert!(value <= 1e-9, "{steps} steps late: {key} is {value}");
        }
        let sum = |key: &str| told["ledger"][key].as_f64().expect("a number");
        let spent = sum("energy_after") + sum("fracture_energy");
        assert!(sum("fracture_energy") > 0.0 && spent <= sum("energy_before"), "{told:#}");
        let (_, again, _) = late(steps, "2");
        assert_eq!(told["digest"], again["digest"], "{steps} steps late");
    }
}

#[test]
fn a_job_that_the_end_of_the_run_overtakes_settles_too() {
    let _left = common::left::NobodyLeft::watch();
    let (code, told, out) = late(1000, "1");
    assert_eq!((code, &told["fractures"]), (3, &0.into()), "{told:#}");
    assert_eq!(told["jobs"]["opened"], 2, "{told:#}");
    assert_eq!(told["jobs"]["settled"], 2, "{told:#}");
    let inspect = Cullet::new(&["inspect"]).path(&out.join("run.mcap")).output();
    let told_so = inspect.stdout.matches("before its fragments were due").count();
    assert_eq!(told_so, 2, "{}", inspect.stdout);
    assert_eq!(told["digest"], late(1000, "2").1["digest"]);
}

/// What fragments are made of was not known more finely than the solve that made them.
#[test]
fn fragments_keep_the_spacing_of_the_solve_that_made_them() {
    let _left = common::left::NobodyLeft::watch();
    let out = unique("spacing");
    let finer = ["--set", "fracture.max_particles=20000", "--set", "world.duration=0.08"];
    let run = Cullet::new(&["run", &corpus("drop.toml"), "-q", "--no-pictures"]).args(&finer);
    let run = run.args(&["--out"]).path(&out).output();
    assert_eq!(run.code, 0, "{}", run.stderr);
    let recording = Recording::open(&out.join("run.mcap")).expect("a recording");
    let parent = |body: u64| recording.bodies.iter().find(|b| b.id == body)?.parent;
    let spacing = |body: u64| {
        let solved = recording.reports.iter().find(|r| r.body == body && r.spacing > 0.0)?;
        Some(solved.spacing)
    };
    let pairs: Vec<(f64, f64)> = recording
        .reports
        .iter()
        .filter(|report| report.spacing > 0.0)
        .filter_map(|report| Some((report.spacing, spacing(parent(report.body)?)?)))
        .collect();
    assert!(!pairs.is_empty(), "no fragment was solved on a grid");
    assert!(pairs.iter().all(|(own, from)| own == from), "{pairs:?}");
}

#[test]
fn another_seed_is_another_run() {
    let _left = common::left::NobodyLeft::watch();
    let digest = |seed: &str| {
        let out = unique("seed");
        let set = format!("world.seed={seed}");
        let run = Cullet::new(&["run", &corpus("drop.toml"), "-q", "--no-pictures"])
            .args(&["--set", &set, "--out"])
            .path(&out)
            .output();
        assert_eq!(run.code, 0, "{}", run.stderr);
        summary(&out)["digest"].clone()
    };
    assert_ne!(digest("5"), digest("6"));
}

#[test]
fn a_run_whose_picture_cannot_be_drawn_is_kept_and_told() {
    let _left = common::left::NobodyLeft::watch();
    let out = unique("unpictured");
    fs::create_dir_all(out.join("preview.png/taken")).expect("a folder in the picture's place");
    let run = Cullet::new(&["run", &corpus("drop.toml"), "--json", "--out"]).path(&out).output();
    assert_eq!(run.code, 4, "{}", run.stderr);
    let warning = run.stderr.lines().find(|line| line.starts_with("warning: "));
    assert!(warning.is_some_and(|line| line.contains("preview.png: ")), "{}", run.stderr);
    assert!(run.stderr.contains("fractures"), "the run is reported: {}", run.stderr);
    let printed: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON on stdout");
    assert_eq!(printed, summary(&out));
    let inspect = Cullet::new(&["inspect", "--json"]).path(&out.join("run.mcap")).output();
    assert_eq!((inspect.code, inspect.stdout), (0, run.stdout), "{}", inspect.stderr);
    assert!(out.join("preview.gif").is_file(), "the other picture is drawn");
    assert!(!out.join("preview.png.partial").exists(), "something unfinished was left");
}

/// A reader that has seen enough is no reason to fail.
#[test]
fn a_closed_pipe_is_no_trouble() {
    let _left = common::left::NobodyLeft::watch();
    let cullet = env!("CARGO_BIN_EXE_cullet");
    let shell = format!("'{cullet}' schema | head -c 1 > /dev/null; echo ${{PIPESTATUS[0]}}");
    let said = std::process::Command::new("bash").args(["-c", &shell]).output().expect("bash");
    assert_eq!(String::from_utf8_lossy(&said.stdout).trim(), "0");
}

#[test]
fn bad_input_is_the_users_fault_and_leaves_nothing() {
    let _left = common::left::NobodyLeft::watch();
    let cases: &[(&[&str], &str)] = &[
        (&["--set", "world.duraton=2"], "duration"),
        (&["--set", "body.lefft.fit=0.2"], "left"),
        (&["--set", "body.left.mesh=\"missing.obj\""], "missing.obj"),
        (&["--set", "world.step=nan"], "world.step"),
        (&["--set", "body.left.position=[0.2, 0.0, 0.15]"], "overlap"),
        (&["--set", "body.left.velocity=[1e300, 0, 0]"], "it is 1e300 m/s"),
        (&["--set", "body.left.shape.size=[1e300, 1, 1]"], "1e300; it must lie in"),
        (&["--set", "world.gravity=[0, 0, -20000]"], "world.gravity"),
        (&["--set", "world.tiers.small=1"], "world.tiers.small: must be at most 0.98"),
        (&["--set", "world.max_bodies=2"], "must be at least 3"),
        (&["--set", "world.duration=1e30"], "must be at most 600 s"),
        (&["--set", "world.step=1e-30"], "must be at least 1e-6 s"),
        (&["--set", "world.step=1e-6", "--set", "world.duration=60"], "6e7 steps"),
        (&["--set", "expect.fragments.min=5", "--set", "expect.fragments.max=2"], "5 and 2"),
        (&["--workers", "0"], "--workers"),
    ];
    for (arguments, must_say) in cases {
        let out = unique("bad");
        let run = Cullet::new(&["run", &corpus("drop.toml"), "--out"])
            .path(&out)
            .args(arguments)
            .output();
        assert_eq!(run.code, 64, "{arguments:?}: {}", run.stderr);
        assert!(run.stderr.contains(must_say), "{arguments:?}: {}", run.stderr);
        assert!(!run.stderr.contains("panicked"), "{arguments:?}: {}", run.stderr);
        assert!(!out.exists(), "{arguments:?} left {}", out.display());
    }
    let fine = Cullet::new(&["check", &corpus("drop.toml")]).output();
    assert_eq!(fine.code, 0, "{}", fine.stderr);
    let missing = Cullet::new(&["run", "no-such-scene"]).output();
    assert_eq!(missing.code, 64, "{}", missing.stderr);
    assert!(missing.stderr.contains("no-such-scene"), "{}", missing.stderr);
}

#[test]
fn what_is_no_place_no_recording_and_no_endpoint_is_told() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("told");
    fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("file");
    fs::write(&file, "not a recording").expect("a file");
    let (below, new) = (file.join("below"), folder.join("new"));
    let drop = corpus("drop.toml");
    let says = |call: Cullet, code: i32, must_say: &str| {
        let said = call.output();
        assert_eq!(said.code, code, "{must_say}: {}", said.stderr);
        assert!(said.stderr.contains(must_say), "{must_say}: {}", said.stderr);
    };
    for out in [&file, &below] {
        let run = Cullet::new(&["run", &drop, "--out"]).path(out);
        says(run, 64, "file: it is a file, not a folder");
    }
    says(Cullet::new(&["inspect"]).path(&file), 64, "is not an MCAP file");
    says(Cullet::new(&["inspect"]).path(&new), 74, "new: ");
    says(Cullet::new(&["recover"]).path(&file), 64, "is not an MCAP file");
    says(Cullet::new(&["recover"]).path(&folder), 74, "it is a folder");
    let preview = Cullet::new(&["preview"]).path(&file).args(&["--out"]).path(&new);
    says(preview, 64, "is not an MCAP file");
    for endpoint in ["7447", "udp/127.0.0.1:7447", "tcp/:7447", "tcp/localhost", "tcp/a:70000"] {
        let ways: [&[&str]; 3] = [
            &["submit", &drop, "--connect", endpoint],
            &["worker", "--connect", endpoint],
            &["coordinator", "--listen", endpoint],
        ];
        for way in ways {
            says(Cullet::new(way), 64, "an endpoint is tcp/HOST:PORT");
        }
    }
    let worker = ["worker", "--connect", "tcp/127.0.0.1:1", "--name", "A B"];
    says(Cullet::new(&worker), 64, "is no name");
    let left: Vec<_> = fs::read_dir(&folder).expect("a folder").flatten().collect();
    assert!(left.len() == 1, "beside the file there are {left:?}");
}

#[test]
fn a_taken_port_is_told_without_places_in_others_source() {
    let _left = common::left::NobodyLeft::watch();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let endpoint = format!("tcp/{}", taken.local_addr().expect("an address"));
    let said = Cullet::new(&["coordinator", "--listen", &endpoint]).output();
    assert_eq!(said.code, 70, "{}", said.stderr);
    assert!(said.stderr.contains("in use") && !said.stderr.contains(".rs"), "{}", said.stderr);
}

#[test]
fn a_scene_goes_through_a_coordinator_to_workers_elsewhere() {
    let _left = common::left::NobodyLeft::watch();
    let runs = unique("served");
    let endpoint = common::free_endpoint();
    let mut coordinator = Cullet::new(&["coordinator", "--stop-after", "1", "--listen", &endpoint])
        .args(&["--out"])
        .path(&runs)
        .spawn();
    let mut worker = Cullet::new(&["worker", "--connect", &endpoint]).spawn();
    let out = unique("fetched");
    let submit = Cullet::new(&["submit", &corpus("drop.toml"), "--connect", &endpoint, "--out"])
        .path(&out)
        .output();
    assert_eq!(submit.code, 0, "{}", submit.stderr);
    let local = unique("local");
    let run = Cullet::new(&["run", &corpus("drop.toml"), "-q", "--out"]).path(&local).output();
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(summary(&out)["digest"], summary(&local)["digest"]);
    assert!(out.join("run.mcap").is_file());
    let stopped = coordinator.wait(Duration::from_secs(20));
    worker.kill();
    assert_eq!(stopped, Some(0), "the coordinator stops after its one run");
}

#[test]
fn submitting_to_nobody_says_so() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let asked = Instant::now();
    let call = ["submit", &corpus("drop.toml"), "--patience", "1", "--connect", &endpoint];
    let submit = Cullet::new(&call).output();
    assert_eq!(submit.code, 69, "{}", submit.stderr);
    assert!(asked.elapsed() < Duration::from_secs(4), "it took {:?}", asked.elapsed());
    let want = format!(
        "error: cannot connect to {endpoint}: tried for 1 s; nobody listens there\n\
         is the coordinator running? cullet doctor --connect {endpoint} checks; --connect or \
         CULLET_CONNECT \
         names another place, --patience tries longer\n"
    );
    assert_eq!(submit.stderr, want);
    // One that is no coordinator, and an address that is none.
    let other = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let place = format!("tcp/{}", other.local_addr().expect("an address"));
    for (place, words) in
        [(place.as_str(), "somebody listens there"), ("tcp/no.such.host.invalid:7", "not found")]
    {
        let said = Cullet::new(&["ps", "--patience", "0.5", "--connect", place]).output();
        assert_eq!(said.code, 69, "{}", said.stderr);
        assert!(said.stderr.contains(words), "{words:?} is not in {}", said.stderr);
        assert!(!said.stderr.contains("Unable to connect"), "{}", said.stderr);
    }
}

#[test]
fn a_coordinator_that_comes_late_is_found_by_who_is_patient() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let mut client = Cullet::new(&["ps", "--patience", "60", "--connect", &endpoint]).spawn();
    assert_eq!(client.wait(Duration::from_secs(8)), None, "it gave up: {}", client.stderr());
    let _coordinator = Cullet::new(&["coordinator", "--listen", &endpoint]).spawn();
    assert_eq!(client.wait(Duration::from_secs(20)), Some(0), "{}", client.stderr());
}

/// What a person has in the shell for commands about a farm is not for workers of one's own, and is
/// for one that is started by hand.
#[test]
fn the_environment_names_a_place_to_a_worker_and_not_to_those_of_a_run() {
    let _left = common::left::NobodyLeft::watch();
    let out = unique("exported");
    let missing = "/no/such/folder";
    let run =
        Cullet::new(&["run", &corpus("drop.toml"), "-q", "--no-pictures", "--out"]).path(&out);
    let run = run.env("CULLET_TLS", missing).env("CULLET_CONNECT", "tls/127.0.0.1:1");
    let said = run.env("CULLET_COORDINATOR", "night").output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let worker = Cullet::new(&["worker"]).env("CULLET_CONNECT", "tls/127.0.0.1:1");
    let said = worker.env("CULLET_TLS", missing).output();
    assert_eq!(said.code, 74, "{}", said.stderr);
    assert!(said.stderr.contains(missing), "{}", said.stderr);
    // Who has typed nothing of the kind is told where it comes from.
    let ps = ["ps", "--connect", "tcp/127.0.0.1:1"];
    let said = Cullet::new(&ps).env("CULLET_TLS", missing).output();
    assert_eq!(said.code, 64, "{}", said.stderr);
    assert!(said.stderr.contains("CULLET_TLS is set"), "{}", said.stderr);
    let said = Cullet::new(&ps).args(&["--tls", missing]).output();
    assert!(said.stderr.contains("--tls needs an endpoint tls/"), "{}", said.stderr);
}

#[test]
fn no_worker_is_left_behind() {
    let _left = common::left::NobodyLeft::watch();
    let out = unique("left");
    let mut run = Cullet::new(&["run", &corpus("drop.toml"), "-q", "--workers", "3", "--out"])
        .path(&out)
        .spawn();
    let mut seen = BTreeSet::new();
    let until = Instant::now() + Duration::from_secs(60);
    while is_alive(run.id()) && Instant::now() < until {
        seen.extend(children_of(run.id()));
        sleep(Duration::from_millis(10));
    }
    assert_eq!(run.wait(Duration::from_secs(1)), Some(0), "{}", run.stderr());
    assert_eq!(seen.len(), 3, "three workers were started");
    let left: Vec<_> = seen.into_iter().filter(|id| is_alive(*id)).collect();
    assert!(left.is_empty(), "{left:?} are left");
}
