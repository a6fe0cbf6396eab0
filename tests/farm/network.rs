//! Bad links, for real: a worker and a client behind a proxy that is slow, goes silent, cuts
//! connections and turns bits over. Whatever it does, the run ends with the bits that it has on a
//! quiet machine.

use crate::common;

use common::proxy::{Weather, proxy};
use common::{Cullet, Going, LONGER, corpus, fetched, quiet_digest, signal, unique};
use serde_json::Value;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

/// Longest a test waits for a run.
const LONG: Duration = Duration::from_secs(150);

/// A coordinator, workers behind a proxy, and a run that was submitted straight.
struct Stage {
    endpoint: String,
    weather: Arc<Weather>,
    workers: Vec<Going>,
    run: String,
    begun: Instant,
    metrics: String,
    // Dropped last.
    _coordinator: Going,
}

impl Stage {
    fn set(workers: usize) -> Self {
        let endpoint = common::free_endpoint();
        let metrics = common::free_endpoint().replace("tcp/", "");
        let call = ["coordinator", "--listen", &endpoint, "--metrics", &metrics, "--state"];
        let coordinator = Cullet::new(&call).path(&unique("network")).spawn();
        let (weather, behind) = proxy(&endpoint);
        let call = ["worker", "--threads", "1", "--connect", &behind, "--name"];
        let worker = |k: usize| Cullet::new(&call).args(&[&format!("w{k}")]).spawn();
        let workers = (0..workers).map(worker).collect();
        let submit = ["submit", &corpus("drop.toml"), "--detach", "--connect", &endpoint];
        let said = Cullet::new(&submit).args(&LONGER).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        let (run, begun) = (said.stdout.trim().to_owned(), Instant::now());
        Self { endpoint, weather, workers, run, begun, metrics, _coordinator: coordinator }
    }

    fn show(&self) -> Value {
        let said =
            Cullet::new(&["show", &self.run, "--json", "--connect", &self.endpoint]).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        serde_json::from_str(&said.stdout).expect("JSON")
    }

    /// A number among the coordinator's metrics, which are a second old at most.
    fn metric(&self, name: &str) -> u64 {
        sleep(Duration::from_millis(1_500));
        let mut stream = TcpStream::connect(&self.metrics).expect("metrics");
        stream.write_all(b"GET /metrics HTTP/1.0\r\n\r\n").expect("a question");
        let mut text = String::new();
        stream.read_to_string(&mut text).expect("an answer");
        // Of all labels together.
        let rest = text.lines().filter_map(|line| line.strip_prefix(name));
        let values: Vec<u64> = rest
            .filter(|rest| rest.starts_with([' ', '{']))
            .filter_map(|rest| rest.rsplit(' ').next()?.parse().ok())
            .collect();
        assert!(!values.is_empty(), "no {name}: {text}");
        values.iter().sum()
    }

    /// Waits until a worker has taken up a job: most of its bytes have passed.
    fn at_work(&self) {
        while self.weather.passed.load(Ordering::SeqCst) < 10_000 {
            assert!(self.begun.elapsed() < LONG, "no job passes: {:#}", self.show());
            sleep(Duration::from_millis(10));
        }
    }

    /// The worker that has a job, once one has.
    fn busy(&self) -> &Going {
        loop {
            let call = ["workers", "--json", "--connect", &self.endpoint];
            let told: Value =
                serde_json::from_str(&Cullet::new(&call).output().stdout).expect("JSON");
            let all = told["workers"].as_array().expect("a list").iter();
            let busy =
                all.filter(|worker| worker["jobs"].as_array().is_some_and(|j| !j.is_empty()));
            let mut names = busy.filter_map(|worker| worker["name"].as_str());
            if let Some(k) = names.next().and_then(|name| name[1..].parse::<usize>().ok()) {
                return &self.workers[k];
            }
            assert!(self.begun.elapsed() < LONG, "nobody is busy: {told:#}");
            sleep(Duration::from_millis(10));
        }
    }

    /// Waits for the end, which must be that of a quiet machine; returns what is told of the run.
    fn ends_well(&self) -> Value {
        loop {
            let shown = self.show();
            let state = shown["state"].as_str().unwrap_or_default().to_owned();
            if state != "queued" && state != "running" {
                assert_eq!(state, "done", "{shown:#}");
                break;
            }
            assert!(self.begun.elapsed() < LONG, "never: {shown:#}");
            sleep(Duration::from_millis(50));
        }
        assert_eq!(fetched(&self.run, &["--connect", &self.endpoint]), quiet_digest(&LONGER));
        let shown = self.show();
        assert_eq!(shown["jobs"]["opened"], shown["jobs"]["settled"], "{shown:#}");
        shown
    }
}

#[test]
fn a_slow_link_costs_time_only() {
    let _left = common::left::NobodyLeft::watch();
    let stage = Stage::set(1);
    stage.weather.delay.store(20, Ordering::SeqCst);
    stage.weather.rate.store(500_000, Ordering::SeqCst);
    let shown = stage.ends_well();
    assert_eq!(shown["jobs"]["resent"], 0, "a link that is only slow was given up: {shown:#}");
    let flaps = ["cullet_links_lost_total", "cullet_links_back_total"];
    assert_eq!(flaps.map(|name| stage.metric(name)), [0, 0], "a link that is only slow flapped");
}

#[test]
fn connections_that_are_cut_lose_nothing() {
    let _left = common::left::NobodyLeft::watch();
    let stage = Stage::set(2);
    stage.at_work();
    let mut cut = 0;
    for _ in 0..6 {
        cut += stage.weather.cut();
        sleep(Duration::from_millis(400));
    }
    assert!(cut >= 6, "{cut} connections were cut");
    stage.ends_well();
    let back = stage.metric("cullet_links_back_total");
    assert!(back >= 2, "two links were cut and came back, and {back} were counted");
}

/// As far away as over two satellites: a link with certificates takes four ways there and back, and
/// it is made at the first try. `CULLET_RTT_MS` is another way.
#[test]
fn a_link_on_which_an_answer_takes_a_second_is_made() {
    let _left = common::left::NobodyLeft::watch();
    let way = std::env::var("CULLET_RTT_MS").ok().and_then(|ms| ms.parse().ok()).unwrap_or(1_000);
    let folder = unique("far");
    fs::create_dir_all(&folder).expect("a folder");
    common::certificates(&folder, &["coordinator", "w-1", "ann"], &[]);
    let roles = folder.join("roles.toml");
    fs::write(&roles, "workers = [\"w-1\"]\nusers = [\"ann\"]\n").expect("roles");
    let endpoint = common::free_endpoint().replace("tcp/", "tls/");
    let call = Cullet::new(&["coordinator", "--listen", &endpoint, "--roles"]).path(&roles);
    let _coordinator = call.args(&["--tls"]).path(&folder.join("coordinator")).spawn();
    let ask = |endpoint: &str| {
        let call = ["workers", "--json", "--patience", "30", "--connect", endpoint, "--tls"];
        Cullet::new(&call).path(&folder.join("ann")).output()
    };
    assert_eq!(ask(&endpoint).code, 0, "the coordinator is there");
    let (weather, behind) = proxy(&endpoint);
    weather.lag.store(way / 2, Ordering::SeqCst);
    let call = Cullet::new(&["worker", "--connect", &behind, "--name", "w-1", "--tls"]);
    let begun = Instant::now();
    let _worker = call.path(&folder.join("w-1")).spawn();
    let (far, place) = (folder.join("ann"), behind.clone());
    let client = spawn(move || {
        let call = ["ps", "--patience", "30", "--connect", &place, "--tls"];
        let said = Cullet::new(&call).path(&far).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        begun.elapsed()
    });
    let wait = Duration::from_secs(30);
    common::until("the far worker is there", wait, || ask(&endpoint).stdout.contains("\"w-1\""));
    let (worker, client) = (begun.elapsed(), client.join().expect("it is answered"));
    println!(
        "answers take {way} ms: a worker is there after {worker:?}, a client after {client:?}"
    );
    // Before its link a worker looks at certificates; after it a client has two questions.
    let bound = Duration::from_millis(way) * 7 + Duration::from_secs(6);
    assert!(worker < bound && client < bound, "not at the first try: {worker:?}, {client:?}");
}

/// The transport gives a silent link up after 5 s, and with the link the pool gives up the worker:
/// so leases (15 s) are not what is seen here, nor where a worker is stopped. They are what is left
/// where the link is up and the worker silent, as in the worker's own `door` tests.
#[test]
fn a_link_that_goes_silent_and_heals_loses_nothing() {
    let _left = common::left::NobodyLeft::watch();
    let stage = Stage::set(1);
    stage.at_work();
    stage.weather.silent.store(true, Ordering::SeqCst);
    sleep(Duration::from_secs(8));
    stage.weather.silent.store(false, Ordering::SeqCst);
    stage.ends_well();
}

/// Pieces have checksums, whole jobs and results have digests: here either would do, as long as
/// something is noticed. What each finds alone is in the worker's own `door` tests.
#[test]
fn bits_that_turn_over_are_noticed_and_change_nothing() {
    let _left = common::left::NobodyLeft::watch();
    let mut stage = Stage::set(1);
    stage.weather.flips.store(8, Ordering::SeqCst);
    stage.ends_well();
    let flipped = stage.weather.flipped.load(Ordering::SeqCst);
    assert!(flipped >= 3, "{flipped} bits were turned over");
    let refused = stage.metric("cullet_messages_refused_total");
    let damaged = stage.metric("cullet_pieces_damaged_total");
    let at_worker = stage.workers[0].stderr().matches("damaged").count() as u64;
    let noticed = refused + damaged + at_worker;
    assert!(noticed >= 1, "{flipped} bits were turned over, and nobody noticed");
}

/// The link of a stopped worker is given up: what it held goes to another; what it hands in when it
/// goes on is no news.
#[test]
fn a_worker_that_sleeps_past_its_lease_is_overtaken() {
    let _left = common::left::NobodyLeft::watch();
    let stage = Stage::set(2);
    let asleep = stage.busy().id();
    signal(asleep, "STOP");
    let shown = stage.ends_well();
    assert!(shown["jobs"]["resent"].as_u64() >= Some(1), "it was waited for: {shown:#}");
    signal(asleep, "CONT");
    sleep(Duration::from_secs(2));
    assert_eq!(stage.show()["jobs"], shown["jobs"], "it was counted after the end");
    assert!(stage.workers.iter().all(|worker| common::is_alive(worker.id())), "a worker ended");
}

#[test]
fn a_client_behind_a_bad_link_gets_the_recording_whole() {
    let _left = common::left::NobodyLeft::watch();
    let stage = Stage::set(1);
    let (weather, behind) = proxy(&stage.endpoint);
    stage.ends_well();
    // First whole connections with bits turned over, then cuts.
    let fetch = |endpoint: &str| {
        let out = unique("whole");
        let call = Cullet::new(&["fetch", &stage.run, "--connect", endpoint, "--out"]).path(&out);
        let said = call.output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        std::fs::read(out.join("run.mcap")).expect("a recording")
    };
    let whole = fetch(&stage.endpoint);
    weather.flips.store(6, Ordering::SeqCst);
    assert!(fetch(&behind) == whole, "a recording came over damaged");
    let flipped = weather.flipped.load(Ordering::SeqCst);
    assert!(flipped >= 3, "{flipped} bits were turned over");
    weather.flips.store(0, Ordering::SeqCst);
    weather.rate.store(4_000_000, Ordering::SeqCst);
    let cuts = weather.clone();
    let over = Arc::new(AtomicBool::new(false));
    let ended = over.clone();
    let cutter = spawn(move || {
        let mut cut = 0;
        while !ended.load(Ordering::SeqCst) && cut < 4 {
            sleep(Duration::from_millis(150));
            cut += cuts.cut();
        }
        cut
    });
    assert!(fetch(&behind) == whole, "a recording came over damaged");
    over.store(true, Ordering::SeqCst);
    assert!(cutter.join().expect("it ends") > 0, "nothing was cut");
}

/// The coordinator, the worker and a client read and write the links with certificates whose
/// ciphertext is damaged. Each such link ends at once and is made anew; nobody dies of it.
#[test]
fn bits_of_ciphertext_that_turn_over_end_links_and_change_nothing() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("ciphertext");
    fs::create_dir_all(&folder).expect("a folder");
    common::certificates(&folder, &["coordinator", "w-1", "ann"], &[]);
    let roles = folder.join("roles.toml");
    fs::write(&roles, "workers = [\"w-1\"]\nusers = [\"ann\"]\n").expect("roles");
    let endpoint = common::free_endpoint().replace("tcp/", "tls/");
    let call = Cullet::new(&["coordinator", "--listen", &endpoint, "--roles"]).path(&roles);
    let call = call.args(&["--state"]).path(&folder.join("state"));
    let mut coordinator = call.args(&["--tls"]).path(&folder.join("coordinator")).spawn();
    let (weather, behind) = proxy(&endpoint);
    let call = Cullet::new(&["worker", "--threads", "1", "--connect", &behind, "--name", "w-1"]);
    let mut worker = call.args(&["--tls"]).path(&folder.join("w-1")).spawn();
    let ann = folder.join("ann").to_string_lossy().into_owned();
    let who = ["--connect", &behind, "--tls", &ann];
    let submit = Cullet::new(&["submit", &corpus("drop.toml"), "--detach"]).args(&who);
    let said = submit.args(&LONGER).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let run = said.stdout.trim().to_owned();
    weather.flips.store(5, Ordering::SeqCst);
    let said = Cullet::new(&["wait", &run]).args(&who).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    // The recording has enough large blocks for all the flips that are left, and more.
    weather.flips.fetch_add(5, Ordering::SeqCst);
    assert_eq!(fetched(&run, &who), quiet_digest(&LONGER));
    let flipped = weather.flipped.load(Ordering::SeqCst);
    assert!(flipped >= 5, "{flipped} bits were turned over");
    for (name, process) in [("coordinator", &mut coordinator), ("worker", &mut worker)] {
        assert!(!process.ended(), "the {name} died: {}", process.stderr());
    }
}
