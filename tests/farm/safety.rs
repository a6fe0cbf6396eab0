//! What must not harm: certificates that are not good, and a disk that is full.

use crate::common;

use common::{Cullet, Going, LONGER, Said, corpus, quiet_digest, unique, until};
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest a test waits for a run.
const LONG: Duration = Duration::from_secs(300);
/// Longest that a command may take to say that it is not let in.
const BOUND: Duration = Duration::from_secs(20);

/// Says that a test was not made, also where what tests print is not shown.
fn skip(why: &str) {
    let mut aloud = std::io::stderr();
    writeln!(aloud, "SKIPPED, and nothing is shown: {why}").ok();
}

/// A server that shows a certificate, good or not; it is ended when dropped.
struct Server(Child);

impl Server {
    fn start(place: &str, folder: &Path) -> Self {
        let [ca, cert, key] = ["ca.pem", "cert.pem", "key.pem"].map(|name| folder.join(name));
        let mut call = Command::new("openssl");
        call.args(["s_server", "-quiet", "-accept", place, "-Verify", "1", "-CAfile"]).arg(ca);
        call.arg("-cert").arg(cert).arg("-key").arg(key);
        let silent = call.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        let server = Self(silent.spawn().expect("openssl"));
        until("it listens", BOUND, || std::net::TcpStream::connect(place).is_ok());
        server
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// Asks with a certificate; the answer must come in time.
fn ask(endpoint: &str, certificate: &Path) -> Said {
    let begun = Instant::now();
    let call = ["ps", "--patience", "3", "--connect", endpoint, "--tls"];
    let said = Cullet::new(&call).path(certificate).output();
    assert!(begun.elapsed() < BOUND, "it takes {:?}", begun.elapsed());
    said
}

fn says(said: &Said, code: i32, words: &str) {
    assert_eq!(said.code, code, "{}{}", said.stdout, said.stderr);
    assert!(said.stderr.contains(words), "{words:?} is not in: {}", said.stderr);
}

/// Certificates of two authorities.
fn authorities(name: &str) -> [PathBuf; 2] {
    ["ours", "theirs"].map(|which| {
        let folder = unique(name).join(which);
        fs::create_dir_all(&folder).expect("a folder");
        common::certificates(&folder, &["coordinator", "w1", "ann"], &[]);
        fs::write(folder.join("roles.toml"), "workers = [\"w1\"]\nusers = [\"ann\"]\n")
            .expect("roles");
        folder
    })
}

fn coordinator(endpoint: &str, folder: &Path) -> Going {
    let call = Cullet::new(&["coordinator", "--listen", endpoint, "--tls"]);
    call.path(&folder.join("coordinator"))
        .args(&["--roles"])
        .path(&folder.join("roles.toml"))
        .spawn()
}

#[test]
fn a_certificate_that_is_not_good_is_told_in_time_and_in_words() {
    let _left = common::left::NobodyLeft::watch();
    let [ours, theirs] = authorities("certificates");
    let old = [("CULLET_FROM", "20200101000000Z"), ("CULLET_UNTIL", "20200201000000Z")];
    let early = [("CULLET_FROM", "20900101000000Z"), ("CULLET_UNTIL", "20900201000000Z")];
    common::certificates(&ours, &["old"], &old);
    common::certificates(&ours, &["early"], &early);
    // One's own, before anything is sent; nobody need be there.
    let nobody = common::free_endpoint().replace("tcp/", "tls/");
    says(&ask(&nobody, &ours.join("old")), 64, "expired on Feb  1 00:00:00 2020");
    says(&ask(&nobody, &ours.join("early")), 64, "not valid before Jan  1 00:00:00 2090");
    says(&ask(&nobody, &ours.join("none")), 74, "ca.pem");
    says(&ask(&nobody, &ours.join("ann")), 69, "cannot connect");
    // The other side's.
    for (name, words) in [("old", "its certificate has expired"), ("early", "is not valid yet")] {
        let endpoint = common::free_endpoint().replace("tcp/", "tls/");
        let _server = Server::start(endpoint.trim_start_matches("tls/"), &ours.join(name));
        says(&ask(&endpoint, &ours.join("ann")), 69, words);
    }
    let endpoint = common::free_endpoint().replace("tcp/", "tls/");
    let _coordinator = coordinator(&endpoint, &ours);
    until("it answers", LONG, || ask(&endpoint, &ours.join("ann")).code == 0);
    says(&ask(&endpoint, &theirs.join("ann")), 69, "not of the authority in");
    // One that knows whom to trust, and is not trusted.
    fs::copy(ours.join("ann/ca.pem"), theirs.join("ann/ca.pem")).expect("a copy");
    says(&ask(&endpoint, &theirs.join("ann")), 69, "our certificate is not of its authority");
    let worker = |certificate: &Path| {
        let call = Cullet::new(&["worker", "--connect", &endpoint, "--tls"]).path(certificate);
        let mut going = call.spawn();
        (going.wait(BOUND), going.stderr())
    };
    fs::copy(ours.join("w1/ca.pem"), theirs.join("w1/ca.pem")).expect("a copy");
    let (code, text) = worker(&theirs.join("w1"));
    assert_eq!(code, Some(69), "{text}");
    assert!(text.contains("not of its authority"), "{text}");
    assert_eq!(worker(&ours.join("old")).0, Some(64));
    // Another host than the certificates are for.
    let elsewhere = common::free_endpoint().replace("tcp/127.0.0.1", "tls/127.0.0.2");
    let _other = coordinator(&elsewhere, &ours);
    until("it listens", BOUND, || {
        std::net::TcpStream::connect(elsewhere.trim_start_matches("tls/")).is_ok()
    });
    says(&ask(&elsewhere, &ours.join("ann")), 69, "not good for the host \"127.0.0.2\"");
}

/// What it does at the other end of the link is in the suite `roles` of the coordinator.
#[test]
fn a_worker_whose_certificate_ends_leaves_and_says_so() {
    let _left = common::left::NobodyLeft::watch();
    let [ours, _] = authorities("ending");
    let endpoint = common::free_endpoint().replace("tcp/", "tls/");
    let _coordinator = coordinator(&endpoint, &ours);
    until("it answers", LONG, || ask(&endpoint, &ours.join("ann")).code == 0);
    let soon = Command::new("date").args(["-u", "-d", "6 seconds", "+%Y%m%d%H%M%SZ"]).output();
    let soon = String::from_utf8(soon.expect("a date").stdout).expect("text");
    fs::remove_dir_all(ours.join("w1")).expect("it goes");
    common::certificates(&ours, &["w1"], &[("CULLET_UNTIL", soon.trim())]);
    let call = Cullet::new(&["worker", "--connect", &endpoint, "--tls"]).path(&ours.join("w1"));
    let mut worker = call.spawn();
    let listed = || {
        let call = ["workers", "--json", "--connect", &endpoint, "--tls"];
        Cullet::new(&call).path(&ours.join("ann")).output().stdout
    };
    until("it is let in", BOUND, || listed().contains("\"name\":\"w1\""));
    assert_eq!(worker.wait(BOUND), Some(69), "{}", worker.stderr());
    assert!(worker.stderr().contains("has expired"), "{}", worker.stderr());
}

/// A coordinator that is started by a shell, after some words of it.
fn limited(words: &str, endpoint: &str, state: &Path, more: &[&str]) -> Going {
    let call = "exec \"$@\"";
    let program = env!("CARGO_BIN_EXE_cullet");
    let coordinator = ["coordinator", "--workers", "1", "--cache", "0", "--listen", endpoint];
    let shell = if words.contains("mount") { "unshare" } else { "sh" };
    let before: &[&str] = if shell == "unshare" { &["-Urm", "sh"] } else { &[] };
    let script = format!("{words}; {call}");
    let call = Cullet::of(Path::new(shell), before).args(&["-c", &script, "sh", program]);
    call.args(&coordinator).args(more).args(&["--state"]).path(state).spawn()
}

/// Commands to a coordinator.
struct Asks(String);

impl Asks {
    fn say(&self, args: &[&str]) -> Said {
        Cullet::new(args).args(&["--connect", &self.0]).output()
    }

    fn submit(&self, args: &[&str]) -> Said {
        let scene = corpus("drop.toml");
        self.say(&[&["submit", &scene, "--detach"], args].concat())
    }

    fn runs(&self) -> Vec<Value> {
        let said = self.say(&["ps", "--json"]);
        let all: Value = serde_json::from_str(&said.stdout).expect("JSON");
        all["runs"].as_array().expect("a list").clone()
    }
}

/// Fills a disk to the last byte; the file that does it.
fn fill(folder: &Path) -> PathBuf {
    let path = folder.join("filler");
    let mut file = fs::File::create(&path).expect("a file");
    let mut size = 1 << 20;
    while size > 0 {
        if file.write_all(&vec![0; size]).is_err() {
            size /= 2;
        }
    }
    path
}

#[test]
fn a_full_disk_refuses_runs_and_fails_runs_and_after_it_they_go_on() {
    let _left = common::left::NobodyLeft::watch();
    let may = ["-Urm", "mount", "-t", "tmpfs", "none", "/tmp"];
    let may = Command::new("unshare").args(may).status();
    if !may.is_ok_and(|status| status.success()) {
        return skip("a full disk: this machine lets nobody make a small one (unshare -Urm)");
    }
    let (endpoint, state) = (common::free_endpoint(), unique("tiny"));
    fs::create_dir_all(&state).expect("a folder");
    let words = format!("mount -t tmpfs -o size=48m none '{}'", state.display());
    let coordinator = limited(&words, &endpoint, &state, &[]);
    let asks = Asks(endpoint.clone());
    until("it is there", LONG, || asks.say(&["ps"]).code == 0);
    // The disk is the coordinator's alone.
    let inside = format!("/proc/{}/root{}", coordinator.id(), state.display());
    let inside = Path::new(&inside);
    let filler = fill(inside);
    let said = asks.submit(&[]);
    assert_eq!(said.code, 75, "{}", said.stderr);
    assert!(said.stderr.contains("bytes of the disk are free"), "{}", said.stderr);
    assert_eq!(asks.runs(), Vec::<Value>::new());
    assert_eq!(fs::read_dir(inside.join("runs")).expect("a folder").count(), 0);
    fs::remove_file(&filler).expect("room");
    let run = asks.submit(&LONGER);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = run.stdout.trim().to_owned();
    until("it goes on", LONG, || asks.runs()[0]["position"]["time"].as_f64() > Some(0.0));
    let filler = fill(inside);
    let said = asks.say(&["wait", &run]);
    assert_eq!(said.code, 8, "{}", said.stderr);
    assert!(said.stderr.contains("No space left"), "{}", said.stderr);
    assert_eq!(asks.say(&["fetch", &run]).code, 8, "half of it can be fetched");
    assert!(!inside.join("recordings/drop-1/run.mcap").exists(), "half of it looks whole");
    fs::remove_file(&filler).expect("room");
    assert_eq!(asks.say(&["retry", &run]).code, 0);
    assert_eq!(asks.say(&["wait", &run]).code, 0);
    assert_eq!(common::fetched(&run, &["--connect", &endpoint]), quiet_digest(&LONGER));
}

/// A journal that takes no more bytes, in the middle of a line. What was not written is not
/// acknowledged, and what was acknowledged is there after a crash.
#[test]
fn what_the_journal_does_not_take_is_not_acknowledged() {
    let _left = common::left::NobodyLeft::watch();
    let (endpoint, state) = (common::free_endpoint(), unique("short"));
    fs::create_dir_all(&state).expect("a folder");
    let quick = ["--set", "world.duration=0.02"];
    let words = "trap '' XFSZ; ulimit -f 18";
    let mut coordinator = limited(words, &endpoint, &state, &["--runs", "1"]);
    let asks = Asks(endpoint.clone());
    until("it is there", LONG, || asks.say(&["ps"]).code == 0);
    let mut accepted = 0;
    let refused = loop {
        let said = asks.submit(&quick);
        if said.code != 0 {
            break said;
        }
        accepted += 1;
        assert_eq!(said.stdout.trim(), accepted.to_string());
        assert!(accepted < 100, "there is no end");
    };
    assert_eq!(refused.code, 77, "{}", refused.stderr);
    assert!(refused.stderr.contains("journal: File too large"), "{}", refused.stderr);
    assert_eq!(asks.runs().len(), accepted);
    assert!(!state.join("runs").join((accepted + 1).to_string()).exists(), "half of it is there");
    // Nor is a deletion, once there is no room for the shortest line: the run is there still.
    // One that does not begin before that, and that nobody waits for.
    let late = (accepted - 1).to_string();
    let verbs = ["pause", "resume"].iter().cycle().take(400);
    let no = |verb: &str| asks.say(&[verb, &late]).stderr.contains("File too large");
    assert!({ verbs }.any(|verb| no(verb)), "there is no end");
    let over = || asks.runs().into_iter().find(|run| run["state"] == "failed");
    until("a recording did not fit", LONG, || over().is_some());
    let over = over().expect("it is there")["run"].to_string();
    says(&asks.say(&["delete", &over]), 77, "journal: File too large");
    assert!(state.join("runs").join(&over).exists(), "its files went");
    assert_eq!(asks.runs().len(), accepted);
    common::signal(coordinator.id(), "KILL");
    coordinator.wait(BOUND);
    let mut coordinator = limited(":", &endpoint, &state, &["--runs", "2"]);
    until("it is there", LONG, || asks.say(&["ps"]).code == 0);
    assert_eq!(asks.runs().len(), accepted, "{}", coordinator.stderr());
    // Those whose recording did not fit go on, those that were told to have failed are tried again.
    let want = quiet_digest(&quick);
    for run in [1, accepted] {
        let run = run.to_string();
        if asks.say(&["wait", &run]).code == 8 {
            assert_eq!(asks.say(&["retry", &run]).code, 0);
        }
        assert_eq!(asks.say(&["wait", &run]).code, 0);
        assert_eq!(common::fetched(&run, &["--connect", &endpoint]), want);
    }
}

/// A run that needs more memory than there is takes the coordinator with it, and whoever goes on
/// beside it. It ends as stalled; the other run comes to its end.
#[test]
#[ignore = "long"]
fn a_run_that_the_coordinator_dies_of_ends_as_stalled_and_the_others_end() {
    let _left = common::left::NobodyLeft::watch();
    let (endpoint, state) = (common::free_endpoint(), unique("deadly"));
    fs::create_dir_all(&state).expect("a folder");
    let begin = || limited("ulimit -c 0; ulimit -d 300000", &endpoint, &state, &["--runs", "2"]);
    let asks = Asks(endpoint.clone());
    let mut coordinator = begin();
    until("it is there", LONG, || asks.say(&["ps"]).code == 0);
    let innocent = asks.submit(&LONGER).stdout.trim().to_owned();
    let said = asks.say(&["submit", &corpus("dense.toml"), "--detach"]);
    assert_eq!(said.code, 0, "{}", said.stderr);
    let guilty = said.stdout.trim().to_owned();
    let state_of = |run: &str| {
        let said = asks.say(&["ps", "--json"]).stdout;
        let all: Value = serde_json::from_str(&said).unwrap_or_default();
        let runs = all["runs"].as_array().cloned().unwrap_or_default();
        let found = runs.iter().find(|one| one["run"].as_u64() == run.parse().ok());
        found.and_then(|one| one["state"].as_str().map(str::to_owned)).unwrap_or_default()
    };
    let mut deaths = 0;
    until("both are over", LONG, || {
        if coordinator.ended() {
            deaths += 1;
            coordinator = begin();
        }
        state_of(&innocent) == "done" && state_of(&guilty) == "stalled"
    });
    assert!((4..=8).contains(&deaths), "{deaths} deaths");
    assert_eq!(common::fetched(&innocent, &["--connect", &endpoint]), quiet_digest(&LONGER));
    let said = asks.say(&["wait", &guilty]);
    assert_eq!(said.code, 6, "{}", said.stderr);
    assert!(said.stderr.contains("is stalled: the coordinator died"), "{}", said.stderr);
    assert!(asks.say(&["logs", &guilty]).stdout.contains("it goes on alone"));
    let next = asks.say(&["submit", &corpus("drop.toml"), "--set", "world.duration=0.02"]);
    assert_eq!(next.code, 0, "{}", next.stderr);
}

/// A coordinator that comes to hold more than it may stops the largest run, and goes on.
#[test]
fn a_run_that_holds_too_much_memory_is_stopped_and_the_coordinator_lives() {
    let _left = common::left::NobodyLeft::watch();
    let (endpoint, state) = (common::free_endpoint(), unique("heavy"));
    fs::create_dir_all(&state).expect("a folder");
    let bound = ["--world-memory", "192"];
    let mut coordinator = limited("true", &endpoint, &state, &bound);
    let asks = Asks(endpoint.clone());
    until("it is there", LONG, || asks.say(&["ps"]).code == 0);
    let small = asks.submit(&LONGER).stdout.trim().to_owned();
    let large = asks.say(&["submit", &corpus("dense.toml")]);
    assert_eq!(large.code, 2, "{}", large.stderr);
    assert!(large.stderr.contains("--world-memory"), "{}", large.stderr);
    assert_eq!(asks.say(&["wait", &small]).code, 0);
    assert!(!coordinator.ended());
}

/// With what a worker says of a job that takes too much, with what its run says, and with the limit
/// that it has where nobody says.
#[test]
fn a_job_over_the_limit_of_memory_ends_by_that_name_and_the_default_lets_it_live() {
    let _left = common::left::NobodyLeft::watch();
    let (endpoint, state) = (common::free_endpoint(), unique("memory"));
    let call = ["coordinator", "--listen", &endpoint, "--state"];
    let _coordinator = Cullet::new(&call).path(&state).spawn();
    let asks = Asks(endpoint.clone());
    until("it is there", LONG, || asks.say(&["ps"]).code == 0);
    let worker = |name: &str, more: &[&str]| {
        let call = ["worker", "--connect", &endpoint, "--name", name];
        Cullet::new(&call).args(more).spawn()
    };
    // A job process holds some 13 MiB before it has a job, and 57 with this one.
    let mut tight = worker("tight", &["--memory", "24"]);
    let run = asks.submit(&LONGER).stdout.trim().to_owned();
    assert_eq!(asks.say(&["wait", &run]).code, 6);
    let shown = asks.say(&["show", &run]).stdout;
    assert!(shown.contains("over the limit of memory: it held "), "{shown}");
    assert!(shown.contains("the limit is 24 MiB"), "{shown}");
    let out = unique("over");
    let fetch = Cullet::new(&["fetch", &run, "--connect", &endpoint, "--out"]).path(&out).output();
    assert_eq!(fetch.code, 6, "{}", fetch.stderr);
    let attempts = fs::read_to_string(out.join("attempts.txt")).expect("attempts");
    assert!(attempts.contains("over the limit of memory"), "{attempts}");
    // The supervisor lived through it.
    assert!(common::is_alive(tight.id()), "{}", tight.stderr());
    let _usual = worker("usual", &[]);
    let _free = worker("free", &["--memory", "none"]);
    let listed = || -> Vec<Value> {
        let told: Value =
            serde_json::from_str(&asks.say(&["workers", "--json"]).stdout).expect("JSON");
        told["workers"].as_array().expect("a list").clone()
    };
    until("all are there", LONG, || listed().len() == 3);
    let memory = |name: &str| {
        let all = listed();
        all.iter().find(|one| one["name"] == name).expect("it is there")["memory"].as_u64()
    };
    assert_eq!((memory("tight"), memory("free")), (Some(24 << 20), None));
    let usual = memory("usual").expect("a limit, though nobody said one");
    assert!(usual > 24 << 20, "{usual}");
    let table = asks.say(&["workers"]).stdout;
    let mib = (usual >> 20).to_string();
    for (name, word) in [("tight", "24"), ("usual", mib.as_str()), ("free", "any")] {
        let row = table.lines().find(|line| line.starts_with(name)).expect("a row");
        assert!(row.split_whitespace().any(|text| text == word), "{table}");
    }
    let doctor = asks.say(&["doctor", "--disk", "/"]).stdout;
    assert!(doctor.contains(&format!("{mib} MiB a job")), "{doctor}");
    for name in ["tight", "free"] {
        assert_eq!(asks.say(&["drain", name]).code, 0);
    }
    assert_eq!(tight.wait(BOUND), Some(0), "{}", tight.stderr());
    let said = tight.stderr();
    assert!(said.contains("a job may use 24 MiB"), "{said}");
    assert_eq!(asks.say(&["retry", &run]).code, 0);
    assert_eq!(asks.say(&["wait", &run]).code, 0);
    assert_eq!(common::fetched(&run, &["--connect", &endpoint]), quiet_digest(&LONGER));
    let bad = Cullet::new(&["worker", "--connect", &endpoint, "--memory", "3"]).output();
    says(&bad, 64, "at least 16");
}

/// Each of two users is within a quota of half of the disk, and together they leave less than what
/// is kept for runs that go on: no run is taken, none begins, and the one that goes on ends well.
#[test]
fn users_who_fill_the_disk_together_leave_room_for_the_run_that_goes_on() {
    let _left = common::left::NobodyLeft::watch();
    let may = ["-Urm", "mount", "-t", "tmpfs", "none", "/tmp"];
    let may = Command::new("unshare").args(may).status();
    if !may.is_ok_and(|status| status.success()) {
        return skip("a shared disk: this machine lets nobody make a small one (unshare -Urm)");
    }
    let (endpoint, state) = (common::free_endpoint(), unique("shared"));
    fs::create_dir_all(&state).expect("a folder");
    let words = format!("mount -t tmpfs -o size=128m none '{}'", state.display());
    let coordinator = limited(&words, &endpoint, &state, &["--runs", "1", "--reserve", "0.07"]);
    let asks = Asks(endpoint.clone());
    until("it is there", LONG, || asks.say(&["ps"]).code == 0);
    let inside = format!("/proc/{}/root{}", coordinator.id(), state.display());
    let inside = Path::new(&inside);
    let first = asks.submit(&[&LONGER[..], &["--user", "ann"]].concat());
    assert_eq!(first.code, 0, "{}", first.stderr);
    until("it goes on", LONG, || asks.runs()[0]["position"]["time"].as_f64() > Some(0.0));
    let quick = ["--set", "world.duration=0.02", "--user", "bob"];
    assert_eq!(asks.submit(&quick).code, 0);
    // 35 MiB each, of the 64 MiB that each may hold.
    for run in ["1", "2"] {
        fs::write(inside.join("runs").join(run).join("filler"), vec![1; 35 << 20]).expect("room");
    }
    for user in ["ann", "bob", "carol"] {
        let said = asks.submit(&["--user", user]);
        says(&said, 75, "are kept for runs that go on (cullet coordinator --reserve)");
        assert!(said.stderr.contains(&format!("{}: ", state.display())), "{}", said.stderr);
        // What was asked for, and the journal, which is a few hundred bytes long.
        let kept = said.stderr.split(" are kept").next().and_then(|text| text.rsplit(' ').next());
        let kept: u64 = kept.and_then(|kept| kept.parse().ok()).expect("a number");
        assert!((70_000_001..70_010_000).contains(&kept), "{}", said.stderr);
    }
    assert_eq!(asks.say(&["wait", "1"]).code, 0, "the run that went on");
    let runs = asks.runs();
    assert_eq!((runs.len(), &runs[1]["state"]), (2, &"queued".into()), "{runs:?}");
    assert_eq!(fs::read_dir(inside.join("runs")).expect("a folder").count(), 2);
    let said = asks.say(&["logs", "2"]).stdout;
    assert!(said.contains("waits for room on the coordinator's disk: "), "{said}");
    assert_eq!(common::fetched("1", &["--connect", &endpoint]), quiet_digest(&LONGER));
    // Room is made by the one who deletes, and the other's run begins.
    assert_eq!(asks.say(&["delete", "1", "--user", "ann"]).code, 0);
    assert_eq!(asks.say(&["wait", "2"]).code, 0);
    assert_eq!(common::fetched("2", &["--connect", &endpoint]), quiet_digest(&quick[..2]));
}

/// Each of them could keep a handshake for ten seconds.
#[test]
fn idle_connections_keep_nobody_out_of_a_port_with_certificates() {
    let folder = unique("safety-idle");
    std::fs::create_dir_all(&folder).expect("a folder");
    let roles = "workers = [\"w1\"]\nusers = [\"ann\"]\n";
    fs::write(folder.join("roles.toml"), roles).expect("a file");
    common::certificates(&folder, &["coordinator", "ann"], &[]);
    let endpoint = common::free_endpoint().replace("tcp/", "tls/");
    let _coordinator = coordinator(&endpoint, &folder);
    until("it is there", LONG, || ask(&endpoint, &folder.join("ann")).code == 0);
    let place = endpoint.trim_start_matches("tls/");
    let connect = |_| std::net::TcpStream::connect(place).expect("a connection");
    let idle: Vec<_> = (0..600).map(connect).collect();
    let said = ask(&endpoint, &folder.join("ann"));
    assert_eq!(said.code, 0, "{}", said.stderr);
    drop(idle);
}
