//! The page of a farm: what watchers get of real runs, and who may watch.
#![cfg(target_os = "linux")]

use crate::common;

use common::{Cullet, Going, corpus, free_endpoint, free_port, unique, until};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for anything here.
const LIMIT: Duration = Duration::from_secs(120);
/// What is set for the runs here.
const SET: &str = "world.seed=3";

struct Farm {
    endpoint: String,
    port: u16,
    coordinator: Going,
    _worker: Going,
}

impl Farm {
    fn start() -> Self {
        let (endpoint, port) = (free_endpoint(), free_port());
        let web = format!("127.0.0.1:{port}");
        let call = Cullet::new(&["coordinator", "--listen", &endpoint, "--web", &web, "--state"]);
        let coordinator = call.path(&unique("web")).spawn();
        until("it answers", LIMIT, || get(port, "/healthz").starts_with("HTTP/1.1 200"));
        let worker = Cullet::new(&["worker", "--connect", &endpoint, "--name", "w1"]).spawn();
        Self { endpoint, port, coordinator, _worker: worker }
    }

    fn submit(&self, more: &[&str]) -> String {
        let call = ["submit", &corpus("drop.toml"), "--detach", "--connect", &self.endpoint];
        let said = Cullet::new(&call).args(more).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        said.stdout.trim().to_owned()
    }
}

/// All that comes back.
fn bytes(port: u16, path: &str) -> Vec<u8> {
    let mut all = Vec::new();
    if let Ok(mut stream) = TcpStream::connect(("127.0.0.1", port)) {
        stream.set_read_timeout(Some(LIMIT)).expect("a limit");
        let ask = format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n");
        let _may_be_reset =
            stream.write_all(ask.as_bytes()).and_then(|()| stream.read_to_end(&mut all));
    }
    all
}

fn get(port: u16, path: &str) -> String {
    String::from_utf8_lossy(&bytes(port, path)).into_owned()
}

/// The JSON of an answer.
fn json(port: u16, path: &str) -> Value {
    let all = get(port, path);
    let (head, body) = all.split_once("\r\n\r\n").expect("an answer");
    assert!(head.starts_with("HTTP/1.1 200"), "{path}: {all}");
    serde_json::from_str(body).expect("JSON")
}

/// Events, as they come.
fn events(port: u16) -> impl Iterator<Item = Value> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("a connection");
    stream.set_read_timeout(Some(LIMIT)).expect("a limit");
    write!(stream, "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n").expect("sent");
    let lines = BufReader::new(stream).lines().map_while(Result::ok);
    lines.filter_map(|line| serde_json::from_str(line.strip_prefix("data: ")?).ok())
}

#[test]
fn a_watcher_sees_a_run_begin_get_on_and_end() {
    let mut farm = Farm::start();
    let mut all = events(farm.port);
    let first = all.next().expect("the state");
    assert_eq!((&first["name"], &first["runs"]), (&"main".into(), &serde_json::json!([])));
    let run = farm.submit(&["--set", SET, "--set", "world.duration=3"]);
    let (mut states, mut steps, mut picture, mut solving) = (Vec::new(), Vec::new(), false, false);
    let since = Instant::now();
    let last = loop {
        let news = all.next().expect("it goes on");
        assert!(since.elapsed() < LIMIT, "it does not end: {states:?} {steps:?}");
        let busy = |worker: &Value| worker["jobs"].as_array().is_some_and(|jobs| !jobs.is_empty());
        solving |= news["workers"].as_array().is_some_and(|all| all.iter().any(busy));
        let Some(told) = news["runs"].as_array().and_then(|runs| runs.last()).cloned() else {
            continue;
        };
        assert_eq!(told["overrides"][0], SET);
        states.push(told["state"].as_str().unwrap_or_default().to_owned());
        if told["state"] == "running" {
            steps.extend(told["position"]["step"].as_u64());
            picture |= told["picture"].is_string();
        }
        if told["state"] == "done" && told["figures"]["digest"].is_string() {
            break told;
        }
    };
    states.dedup();
    assert!(states.ends_with(&["running".into(), "done".into()]), "{states:?}");
    assert!(steps.is_sorted() && steps.iter().any(|step| *step > 0), "{steps:?}");
    println!("{} looks at steps, a picture: {picture}, a worker solving: {solving}", steps.len());
    let said = Cullet::new(&["show", &run, "--json", "--connect", &farm.endpoint]).output();
    let shown: Value = serde_json::from_str(&said.stdout).expect("JSON");
    assert_eq!(last["jobs"], shown["jobs"]);
    let whole = json(farm.port, &format!("/api/runs/{run}"));
    assert_eq!(whole["products"], shown["files"]);
    assert_eq!(json(farm.port, "/api/workers")[0]["name"], "w1");
    let png = bytes(farm.port, &format!("/runs/{run}/picture"));
    let body = png.windows(4).position(|four| four == b"\r\n\r\n").expect("a head") + 4;
    assert!(png[body..].starts_with(b"\x89PNG"), "it is a picture");
    let page = get(farm.port, &format!("/runs/{run}/report"));
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("id=\"report\""), "{page:.300}");
    common::signal(farm.coordinator.id(), "TERM");
    assert!(all.any(|news| news["leaving"] == true), "it says that it leaves");
    assert_eq!(farm.coordinator.wait(LIMIT), Some(0), "{}", farm.coordinator.stderr());
}

#[test]
fn a_page_for_other_machines_needs_certificates() {
    for (web, more, why) in [
        ("0.0.0.0:0", &[][..], "other machines can reach this address"),
        ("0.0.0.0:0", &["--insecure"][..], "other machines can reach this address"),
        ("tls/127.0.0.1:0", &[][..], "needs --tls DIR and --roles FILE"),
    ] {
        let call = ["coordinator", "--listen", &free_endpoint(), "--web", web];
        let mut process = Cullet::new(&call).args(more).spawn();
        assert_eq!(process.wait(LIMIT), Some(64), "{web}: {}", process.stderr());
        assert!(process.stderr().contains(why), "{web}: {}", process.stderr());
    }
}

/// What the page answers to somebody with a certificate, or without.
fn ask_with_tls(port: u16, certs: &Path, name: Option<&str>) -> String {
    let mut call = Command::new("openssl");
    call.args(["s_client", "-quiet", "-connect", &format!("127.0.0.1:{port}")]);
    let folder = certs.join(name.unwrap_or("ann"));
    call.arg("-CAfile").arg(folder.join("ca.pem"));
    if name.is_some() {
        call.arg("-cert").arg(folder.join("cert.pem")).arg("-key").arg(folder.join("key.pem"));
    }
    let call = call.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = call.spawn().expect("openssl");
    let mut stdin = child.stdin.take().expect("a pipe");
    let _refused = stdin.write_all(b"GET /api/farm HTTP/1.1\r\nHost: farm\r\n\r\n");
    let mut text = String::new();
    child.stdout.take().expect("a pipe").read_to_string(&mut text).expect("text");
    drop(stdin);
    child.wait().expect("it ends");
    text
}

#[test]
fn with_certificates_users_and_operators_watch_and_nobody_else() {
    let certs = unique("certs");
    fs::create_dir_all(&certs).expect("a folder");
    let names = ["coordinator", "ann", "olga", "w1", "mallory"];
    common::certificates(&certs, &names, &[]);
    // Of the same names, from another authority.
    let others = unique("others");
    fs::create_dir_all(&others).expect("a folder");
    common::certificates(&others, &["ann"], &[]);
    let roles = certs.join("roles.toml");
    let text = "workers = [\"w1\"]\nusers = [\"ann\"]\noperators = [\"olga\"]\n";
    fs::write(&roles, text).expect("roles");
    let (endpoint, port) = (free_endpoint().replace("tcp/", "tls/"), free_port());
    let web = format!("tls/127.0.0.1:{port}");
    let call = Cullet::new(&["coordinator", "--listen", &endpoint, "--web", &web, "--tls"]);
    let _coordinator =
        call.path(&certs.join("coordinator")).args(&["--roles"]).path(&roles).spawn();
    until("it answers", LIMIT, || ask_with_tls(port, &certs, Some("ann")).contains(" 200 "));
    let told = ask_with_tls(port, &certs, Some("olga"));
    assert!(told.starts_with("HTTP/1.1 200") && told.contains("\"name\":\"main\""), "{told}");
    for nobody in ["mallory", "w1"] {
        let told = ask_with_tls(port, &certs, Some(nobody));
        assert!(told.starts_with("HTTP/1.1 403") && told.contains(nobody), "{told}");
        assert!(!told.contains("\"name\""), "{told}");
    }
    assert_eq!(ask_with_tls(port, &certs, None), "");
    assert_eq!(ask_with_tls(port, &others, Some("ann")), "");
    assert!(!get(port, "/api/farm").contains("HTTP/"), "plain HTTP is not spoken there");
}

#[test]
fn a_page_is_announced_where_it_answers() {
    let (log, endpoint) = (unique("announced"), free_endpoint());
    let call = Cullet::new(&["coordinator", "--listen", &endpoint, "--web", "127.0.0.1:0"]);
    let said = fs::File::create(&log).expect("a file");
    let out = unique("announced-runs");
    let _coordinator = call.args(&["--out"]).path(&out).errors(said).spawn();
    // The system chose the port.
    let port = || {
        let text = fs::read_to_string(&log).ok()?;
        let (_, rest) = text.split_once("the farm's page is at http://127.0.0.1:")?;
        rest.split_once("/\n")?.0.parse().ok()
    };
    until("it is announced", LIMIT, || port().is_some());
    let answer = get(port().expect("a port"), "/healthz");
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}

#[test]
fn a_run_on_this_machine_is_shown_while_it_goes_on() {
    let (out, port) = (unique("live"), free_port());
    let live = format!("--live=127.0.0.1:{port}");
    let set = ["--set", "world.duration=3", "--set", SET];
    let call = Cullet::new(&["run", &corpus("drop.toml"), &live, "--workers", "1", "--out"]);
    let mut run = call.path(&out).args(&set).spawn();
    until("it answers", LIMIT, || get(port, "/healthz").starts_with("HTTP/1.1 200"));
    let all: Vec<Value> = events(port).collect();
    let states = all.iter().filter_map(|news| news["runs"].get(0)?["state"].as_str());
    let states: Vec<&str> = states.collect();
    assert!(states.contains(&"running") && states.ends_with(&["done"]), "{states:?}");
    assert_eq!(all.last().map(|news| &news["leaving"]), Some(&true.into()));
    let code = run.wait(LIMIT).expect("it ends");
    assert!(common::DONE.contains(&code), "{code}: {}", run.stderr());
    // Nobody who watches changes what comes of it.
    let want = common::quiet_digest(&set);
    assert_eq!(common::summary(&out)["digest"], want);
}
