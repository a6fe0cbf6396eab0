//! A farm around a router: the router killed and stopped in the middle, and who may do what when
//! certificates say who somebody is.

use crate::common;

use common::{Cullet, Going, LONGER, Said, corpus, quiet_digest, signal, unique};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest a test waits for a run.
const LONG: Duration = Duration::from_secs(300);
/// Longest that a command may take to say that it is not let in.
const BOUND: Duration = Duration::from_secs(20);

/// A worker that nobody answers has said so by then.
const TOLD: Duration = Duration::from_secs(13);

/// A router, a coordinator and two workers.
struct Farm {
    endpoint: String,
    /// Certificates, if any.
    folder: Option<PathBuf>,
    router: Going,
    workers: Vec<Going>,
    coordinator: Going,
}

impl Farm {
    fn open() -> Self {
        let endpoint = common::free_endpoint();
        let router = Self::router(&endpoint, None);
        Self::around(endpoint, router, None)
    }

    /// With certificates and roles: olga operates, ann and bob use, mallory is nobody.
    fn closed() -> Self {
        let folder = unique("roles");
        fs::create_dir_all(&folder).expect("a folder");
        let names = ["router", "coordinator", "w1", "w2", "ann", "bob", "olga", "mallory"];
        common::certificates(&folder, &names, &[]);
        let roles =
            "workers = [\"w1\", \"w2\"]\nusers = [\"ann\", \"bob\"]\noperators = [\"olga\"]\n";
        fs::write(folder.join("roles.toml"), roles).expect("roles");
        let endpoint = common::free_endpoint().replace("tcp/", "tls/");
        let router = Self::router(&endpoint, Some(&folder));
        Self::around(endpoint, router, Some(folder))
    }

    fn router(endpoint: &str, folder: Option<&Path>) -> Going {
        guarded(Cullet::new(&["router", "--listen", endpoint]), folder, "router").spawn()
    }

    fn around(endpoint: String, router: Going, folder: Option<PathBuf>) -> Self {
        let call = Cullet::new(&["coordinator", "--router", &endpoint, "--state"]);
        let coordinator =
            guarded(call.path(&unique("state")), folder.as_deref(), "coordinator").spawn();
        let worker = |name: &&str| {
            let call = Cullet::new(&["worker", "--threads", "1", "--connect", &endpoint]);
            let call = call.args(&["--name", name]);
            shown(call, folder.as_deref(), name).spawn()
        };
        let workers = ["w1", "w2"].iter().map(worker).collect();
        Self { endpoint, folder, router, workers, coordinator }
    }

    /// Asks as somebody, with the certificate of that name if there are any.
    fn ask(&self, who: &str, args: &[&str]) -> Said {
        let call = Cullet::new(args).args(&["--connect", &self.endpoint, "--patience", "4"]);
        shown(call, self.folder.as_deref(), who).output()
    }

    fn json(&self, who: &str, args: &[&str]) -> Value {
        // Nobody is reached through a router that is not there: asked until it is.
        let begun = Instant::now();
        loop {
            let said = self.ask(who, &[args, &["--json"]].concat());
            if said.code == 0 {
                return serde_json::from_str(&said.stdout).expect("JSON");
            }
            assert!(begun.elapsed() < LONG, "{args:?}: {}", said.stderr);
        }
    }

    fn submit(&self, who: &str, args: &[&str]) -> String {
        let scene = corpus("drop.toml");
        let call = [&["submit", &scene, "--detach"], args].concat();
        self.json(who, &call)["run"].to_string()
    }

    fn busy(&self, who: &str) {
        common::until("a worker has a job", LONG, || {
            self.json(who, &["workers"]).to_string().contains("\"jobs\":[\"")
        });
    }

    fn ends(&self, who: &str, run: &str) -> Value {
        let mut shown = Value::Null;
        common::until("the run ends", LONG, || {
            shown = self.json(who, &["show", run]);
            !["queued", "running"].contains(&shown["state"].as_str().unwrap_or_default())
        });
        shown
    }
}

/// Shows a certificate, where there are any.
fn shown(call: Cullet, folder: Option<&Path>, name: &str) -> Cullet {
    match folder {
        Some(folder) => call.args(&["--tls"]).path(&folder.join(name)),
        None => call,
    }
}

/// Shows one and asks for those of others.
fn guarded(call: Cullet, folder: Option<&Path>, name: &str) -> Cullet {
    match folder {
        Some(place) => shown(call, folder, name).args(&["--roles"]).path(&place.join("roles.toml")),
        None => call,
    }
}

/// Killed, and away for longer than anybody waits for a link; then stopped for longer than a link
/// that is silent is held.
#[test]
fn a_router_that_is_killed_and_one_that_sleeps_cost_time_only() {
    let _left = common::left::NobodyLeft::watch();
    let mut farm = Farm::open();
    let run = farm.submit("ann", &LONGER);
    farm.busy("ann");
    signal(farm.router.id(), "KILL");
    farm.router.wait(Duration::from_secs(5));
    sleep(Duration::from_secs(7));
    farm.router = Farm::router(&farm.endpoint, None);
    let second = farm.submit("ann", &[&LONGER[..], &["--set", "world.seed=9"]].concat());
    farm.busy("ann");
    signal(farm.router.id(), "STOP");
    sleep(Duration::from_secs(8));
    signal(farm.router.id(), "CONT");
    for run in [&run, &second] {
        let shown = farm.ends("ann", run);
        assert_eq!(shown["state"], "done", "{shown:#}");
        assert_eq!(shown["attempt"], 1, "the coordinator began anew: {shown:#}");
        assert_eq!(shown["jobs"]["opened"], shown["jobs"]["settled"], "{shown:#}");
    }
    let who = ["--connect", &farm.endpoint];
    assert_eq!(common::fetched(&run, &who), quiet_digest(&LONGER));
    let seeded = quiet_digest(&[&LONGER[..], &["--set", "world.seed=9"]].concat());
    assert_eq!(common::fetched(&second, &who), seeded);
    // Nobody left, and all leave when they are told to.
    for process in farm.workers.iter_mut().chain([&mut farm.coordinator, &mut farm.router]) {
        assert!(common::is_alive(process.id()), "{}", process.stderr());
        signal(process.id(), "TERM");
        assert_eq!(process.wait(Duration::from_secs(20)), Some(0), "{}", process.stderr());
    }
}

#[test]
fn what_is_anothers_is_controlled_by_its_owner_and_by_operators() {
    let _left = common::left::NobodyLeft::watch();
    let mut farm = Farm::closed();
    let run = farm.submit("ann", &["--set", "world.duration=600"]);
    assert_eq!(farm.json("bob", &["show", &run])["user"], "ann", "all may look");
    for verb in ["cancel", "pause", "resume", "retry", "delete"] {
        let said = farm.ask("bob", &[verb, &run]);
        assert_eq!(said.code, 77, "{verb}: {}", said.stderr);
        assert!(said.stderr.contains("is of ann"), "{verb}: {}", said.stderr);
    }
    assert_eq!(farm.ask("ann", &["pause", &run]).code, 0);
    common::until("it is paused", LONG, || farm.json("ann", &["show", &run])["state"] == "paused");
    assert_eq!(farm.ask("olga", &["cancel", &run]).code, 0);
    assert_eq!(farm.ends("ann", &run)["state"], "cancelled");
    for who in ["bob", "w1"] {
        assert_ne!(farm.ask(who, &["delete", &run]).code, 0, "{who} may delete what is ann's");
    }
    assert_eq!(farm.ask("ann", &["delete", &run]).code, 0);
    let said = farm.ask("ann", &["drain", "w1"]);
    assert_eq!(said.code, 77, "{}", said.stderr);
    assert!(said.stderr.contains("only an operator"), "{}", said.stderr);
    assert_eq!(farm.ask("olga", &["drain", "w1"]).code, 0);
    // The ticket of one is none of another's, and who is nobody hears nothing.
    for (certificate, user) in [("w1", "w1"), ("w1", "ann"), ("ann", "olga"), ("mallory", "ann")] {
        let begun = Instant::now();
        let said = farm.ask(certificate, &["ps", "--user", user]);
        assert_eq!(said.code, 69, "{certificate} as {user}: {}{}", said.stdout, said.stderr);
        assert!(said.stderr.contains("roles must name it"), "{}", said.stderr);
        assert!(begun.elapsed() < BOUND, "it takes {:?}", begun.elapsed());
    }
    // A user's certificate lets nobody work.
    let call = ["worker", "--connect", &farm.endpoint, "--name", "w2"];
    let begun = Instant::now();
    let mut rogue = shown(Cullet::new(&call), farm.folder.as_deref(), "bob").spawn();
    let next = farm.submit("ann", &[]);
    assert_eq!(farm.ends("ann", &next)["state"], "done");
    let seen = farm.json("ann", &["workers"])["workers"].as_array().map_or(0, Vec::len);
    assert!(seen <= 2, "{seen} lives of two workers are seen");
    assert_eq!(rogue.wait(Duration::from_millis(10)), None, "it waits to be let in");
    sleep(TOLD.saturating_sub(begun.elapsed()));
    let said = rogue.stderr();
    let why = "nobody answers: no coordinator is there, or w2 may not work here: its certificate \
               is of \"bob\", and roles must name it among workers";
    assert!(said.contains(why), "{said}");
    assert!(farm.workers.iter_mut().all(|worker| !worker.stderr().contains("nobody answers")));
    let said = farm.ask("mallory", &["doctor"]);
    assert_eq!(said.code, 69, "{}", said.stdout);
    let why = "the certificate is of \"mallory\", and roles must name it among users or operators";
    assert!(said.stdout.contains(why), "{}", said.stdout);
}

/// A coordinator's own workers show its certificate, also through a router.
#[test]
fn a_coordinators_own_workers_are_let_in() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("own");
    fs::create_dir_all(&folder).expect("a folder");
    common::certificates(&folder, &["coordinator", "router", "ann"], &[]);
    fs::write(folder.join("roles.toml"), "users = [\"ann\"]\n").expect("roles");
    let want = quiet_digest(&[]);
    for routed in [false, true] {
        let endpoint = common::free_endpoint().replace("tcp/", "tls/");
        let place = if routed { "--router" } else { "--listen" };
        let _router = routed.then(|| Farm::router(&endpoint, Some(&folder)));
        if routed {
            let call = Cullet::new(&["coordinator", place, &endpoint, "--state"]);
            let said = guarded(call.path(&unique("false-state")), Some(&folder), "ann").output();
            let why = "of \"ann\", and the roles have \"coordinator\" for coordinator";
            assert!(said.code == 64 && said.stderr.contains(why), "{}", said.stderr);
            let call = ["coordinator", place, &endpoint, "--name", "night", "--state"];
            let call = Cullet::new(&call).path(&unique("unnamed-state"));
            let said = guarded(call, Some(&folder), "coordinator").output();
            let why = "the roles have no coordinator of that name";
            assert!(said.code == 64 && said.stderr.contains(why), "{}", said.stderr);
        }
        let call = Cullet::new(&["coordinator", place, &endpoint, "--workers", "1", "--state"]);
        let call = call.path(&unique("own-state"));
        let _coordinator = guarded(call, Some(&folder), "coordinator").spawn();
        let ask = |args: &[&str]| {
            let call = Cullet::new(args).args(&["--connect", &endpoint]);
            shown(call, Some(&folder), "ann").output()
        };
        common::until("the coordinator is there", LONG, || ask(&["ps"]).code == 0);
        let run = ask(&["submit", &corpus("drop.toml"), "--detach"]);
        assert_eq!(run.code, 0, "routed {routed}: {}", run.stderr);
        let run = run.stdout.trim();
        common::until("a worker of its own is let in", Duration::from_secs(40), || {
            ask(&["show", run]).stdout.contains(" done")
        });
        let place = folder.join("ann").to_string_lossy().into_owned();
        let who = ["--connect", &endpoint, "--tls", &place];
        assert_eq!(common::fetched(run, &who), want, "routed {routed}");
    }
}
