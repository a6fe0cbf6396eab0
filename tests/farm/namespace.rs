//! A worker on a machine of its own, as far as the kernel goes: a network namespace, joined to ours
//! by a cable that is pulled. Where namespaces cannot be made (no root, no `ip`) it says so and
//! shows nothing.

use crate::common;

use common::history::{lines, moment};
use common::{Cullet, LONGER, corpus, fetched, quiet_digest, unique, until};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// Longest a test waits for anything.
const LONG: Duration = Duration::from_secs(150);

/// Longer than a link is held on which nothing comes.
const AWAY: Duration = Duration::from_secs(9);

/// A namespace and the cable to it; both go when it is dropped.
struct Place {
    name: String,
    net: String,
}

impl Place {
    fn new() -> Option<Self> {
        let id = std::process::id();
        let place = Self { name: format!("cu{id}"), net: format!("10.213.{}", id % 250 + 1) };
        let (ours, theirs) = (format!("{}.1/30", place.net), format!("{}.2/30", place.net));
        let (here, there) = (place.end("h"), place.end("t"));
        let cable = ["link", "add", &here, "type", "veth", "peer", "name", &there];
        let made = run("ip", &["netns", "add", &place.name])
            && run("ip", &[&cable[..], &["netns", &place.name]].concat())
            && run("ip", &["addr", "add", &ours, "dev", &here])
            && run("ip", &["link", "set", &here, "up"])
            && place.ip(&["addr", "add", &theirs, "dev", &there])
            && place.plug(true);
        made.then_some(place)
    }

    /// The name of an end of the cable, here or there.
    fn end(&self, which: &str) -> String {
        format!("{which}-{}", self.name)
    }

    fn ip(&self, args: &[&str]) -> bool {
        run("ip", &[&["-n", &self.name], args].concat())
    }

    fn plug(&self, is_in: bool) -> bool {
        self.ip(&["link", "set", &self.end("t"), if is_in { "up" } else { "down" }])
    }

    /// Seconds from now to the first word of a worker there, as a coordinator's log tells.
    fn back(&self, log: &Path) -> f64 {
        let now = std::time::SystemTime::UNIX_EPOCH.elapsed().expect("a clock").as_secs_f64();
        let mut heard = None;
        until("the far worker is heard", LONG, || {
            let lines = lines(log);
            let words = lines.iter().filter(|line| {
                line["message"] == "job granted" || line["message"] == "result taken"
            });
            heard = words.filter_map(moment).find(|at| *at > now);
            heard.is_some()
        });
        heard.expect("a time") - now
    }

    /// A call of the binary in there.
    fn call(&self, args: &[&str]) -> Cullet {
        let inside = ["netns", "exec", &self.name, env!("CARGO_BIN_EXE_cullet")];
        Cullet::of(Path::new("ip"), &[&inside, args].concat())
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        // The cable goes with it.
        run("ip", &["netns", "del", &self.name]);
    }
}

fn run(program: &str, args: &[&str]) -> bool {
    let mut call = Command::new(program);
    let said = call.args(args).stdin(Stdio::null()).stderr(Stdio::null()).status();
    said.is_ok_and(|status| status.success())
}

/// A cable is pulled for longer than a silent link is held, while the worker has a job, and is put
/// in again: the run ends with the bits of a quiet machine, and the worker that was away goes on as
/// it was.
#[test]
fn a_pulled_cable_costs_time_only() {
    let _left = common::left::NobodyLeft::watch();
    let Some(place) = Place::new() else {
        println!("SKIPPED, and nothing is shown: no network namespaces on this machine");
        return;
    };
    let endpoint = format!("tcp/{}.1:{}", place.net, common::free_port());
    let who = ["--connect", &endpoint];
    // Nobody else is on this network.
    let (state, log) = (unique("namespace"), unique("namespace-log"));
    let call = ["coordinator", "--listen", &endpoint, "--insecure", "--state"];
    let _coordinator = Cullet::new(&call).path(&state).log(&log).spawn();
    let mut worker = place.call(&["worker", "--threads", "1", "--name", "far"]).args(&who).spawn();
    let asked = |args: &[&str]| {
        let said = Cullet::new(args).args(&["--json"]).args(&who).output();
        serde_json::from_str::<Value>(&said.stdout).unwrap_or_default()
    };
    let submit = ["submit", &corpus("drop.toml"), "--detach"];
    let mut run = Value::Null;
    until("it is taken", LONG, || {
        run = asked(&[&submit[..], &LONGER].concat())["run"].clone();
        run.is_u64()
    });
    let run = run.to_string();
    let busy = || asked(&["workers"]).to_string().contains("\"jobs\":[\"");
    until("the far worker has a job", LONG, busy);
    assert!(place.plug(false), "the cable is pulled");
    sleep(AWAY);
    let shown = asked(&["show", &run]);
    assert_eq!(shown["state"], "running", "nobody else is there: {shown:#}");
    assert!(place.plug(true), "the cable is put in");
    let took = place.back(&log);
    println!("cable out for {AWAY:?}, in again: at work after {took:.3} s");
    common::figures::gate(took, 2.0);
    until("the run ends", LONG, || {
        !["queued", "running"]
            .contains(&asked(&["show", &run])["state"].as_str().unwrap_or("queued"))
    });
    let shown = asked(&["show", &run]);
    assert_eq!(shown["state"], "done", "{shown:#}");
    assert_eq!(shown["jobs"]["opened"], shown["jobs"]["settled"], "{shown:#}");
    assert_eq!(fetched(&run, &who), quiet_digest(&LONGER));
    assert!(!worker.ended(), "it is there still: {}", worker.stderr());
}
