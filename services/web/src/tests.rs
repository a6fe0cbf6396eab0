//! The page over real sockets: what is answered, what is refused, what watchers get.

mod load;

use crate::{FarmNews, Feed, Illustrator, RunNews, WebConfig, WebError, Website};
use cullet_proto::service::{FileInfo, JobCounts, Position, RunInfo, State, WorkerInfo};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Longest wait for anything.
const LIMIT: Duration = Duration::from_secs(20);
/// In these tests a reader may take nothing for so long.
const STALL: Duration = Duration::from_secs(2);
/// A name as somebody could give it who means harm.
const HOSTILE: &str = "</script><img src=x onerror=alert(1)>";

/// Draws what can be told from what it is given, and counts.
#[derive(Debug, Default)]
struct Scribe {
    stills: AtomicUsize,
    reports: AtomicUsize,
}

impl Illustrator for Scribe {
    fn still(&self, folder: &Path, file: &Path, _: &AtomicBool) -> Result<Duration, String> {
        let count = self.stills.fetch_add(1, Ordering::SeqCst) + 1;
        let length = std::fs::metadata(folder.join("run.mcap.partial")).map_or(0, |it| it.len());
        let written = std::fs::write(file, format!("picture {count} of {length} bytes"));
        written.map(|()| Duration::from_millis(1)).map_err(|e| e.to_string())
    }

    fn report(&self, folder: &Path, file: &Path, _: &AtomicBool) -> Result<(), String> {
        self.reports.fetch_add(1, Ordering::SeqCst);
        let bytes = std::fs::read(folder.join("run.mcap")).map_err(|e| e.to_string())?;
        std::fs::write(file, format!("<p>{} bytes</p>", bytes.len())).map_err(|e| e.to_string())
    }
}

struct Place {
    feed: Feed,
    site: Website,
    scribe: Arc<Scribe>,
    address: SocketAddr,
}

fn place() -> Place {
    let (feed, scribe) = (Feed::default(), Arc::new(Scribe::default()));
    let address = SocketAddr::from(([127, 0, 0, 1], 0));
    let illustrator = Arc::clone(&scribe) as Arc<dyn Illustrator>;
    let config = WebConfig { address, identity: None, illustrator };
    let site = Website::start(config, feed.clone(), STALL).expect("a page");
    let address = site.address().expect("an address");
    Place { feed, site, scribe, address }
}

/// A run, as it is published.
pub(crate) fn run(number: u64, state: State, name: &str) -> RunNews {
    let info = RunInfo {
        run: number,
        name: name.to_owned(),
        user: "ann".to_owned(),
        sweep: String::new(),
        ticket: "secret".to_owned(),
        overrides: Vec::new(),
        state,
        priority: 0,
        attempt: 1,
        code: state.is_over().then_some(0),
        text: String::new(),
        submitted_ms: 1,
        started_ms: Some(2),
        ended_ms: state.is_over().then_some(3),
        files: Vec::new(),
        position: None,
        jobs: JobCounts::default(),
    };
    RunNews { info, folder: None, line: String::new() }
}

fn farm(runs: Vec<RunNews>) -> FarmNews {
    FarmNews { name: "main".to_owned(), now_ms: 1_000, runs, ..FarmNews::default() }
}

impl Place {
    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect_timeout(&self.address, LIMIT).expect("a connection");
        stream.set_read_timeout(Some(LIMIT)).expect("a limit");
        stream
    }

    /// Status line, headers and body of what comes back.
    fn ask(&self, line: &str, headers: &str) -> (String, String, Vec<u8>) {
        let mut stream = self.connect();
        write!(stream, "{line} HTTP/1.1\r\n{headers}\r\n").expect("sent");
        let mut all = Vec::new();
        stream.read_to_end(&mut all).expect("an answer");
        let end = all.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        let head = String::from_utf8(all[..end].to_vec()).expect("text");
        let (status, rest) = head.split_once("\r\n").unwrap_or((&head, ""));
        (status.to_owned(), rest.to_lowercase(), all.split_off(end + 4))
    }

    fn get(&self, path: &str) -> (String, String, Vec<u8>) {
        self.ask(&format!("GET {path}"), "Host: localhost:1\r\n")
    }

    fn json(&self, path: &str) -> Value {
        let (status, head, body) = self.get(path);
        assert!(status.contains(" 200 ") && head.contains("application/json"), "{path}: {status}");
        serde_json::from_slice(&body).expect("JSON")
    }

    fn watch(&self) -> Watch {
        let mut stream = self.connect();
        write!(stream, "GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n").expect("sent");
        Watch(BufReader::new(stream))
    }
}

/// One who watches.
struct Watch(BufReader<TcpStream>);

impl Watch {
    /// The next event, if there is one before the end.
    fn next(&mut self) -> Option<(String, Value)> {
        let mut name = String::new();
        loop {
            let mut line = String::new();
            if self.0.read_line(&mut line).expect("in time") == 0 {
                return None;
            }
            let line = line.trim_end();
            if let Some(event) = line.strip_prefix("event: ") {
                name = event.to_owned();
            } else if let Some(data) = line.strip_prefix("data: ") {
                return Some((name, serde_json::from_str(data).expect("JSON")));
            }
        }
    }

    /// The first event that fits.
    fn until(&mut self, fits: impl Fn(&Value) -> bool) -> Value {
        let since = Instant::now();
        loop {
            let (_, data) = self.next().expect("it goes on");
            if fits(&data) {
                return data;
            }
            assert!(since.elapsed() < LIMIT, "it never came");
        }
    }
}

fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let since = Instant::now();
    while !holds() {
        assert!(since.elapsed() < LIMIT, "{what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn only_reading_is_answered_and_only_on_this_machine() {
    let place = place();
    place.feed.publish(farm(vec![run(7, State::Running, HOSTILE)]));
    for method in ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"] {
        let (status, head, _) = place.ask(&format!("{method} /api/runs"), "Host: localhost\r\n");
        assert!(
            status.contains(" 405 ") && head.contains("allow: get, head"),
            "{method}: {status}"
        );
    }
    let (status, ..) = place.ask("GET /", "Host: localhost\r\nContent-Length: 3\r\n");
    assert!(status.contains(" 413 "), "{status}");
    for host in ["Host: evil.example\r\n", "Host: 192.168.1.10:80\r\n", ""] {
        for path in ["/", "/events", "/api/runs", "/runs/7/picture"] {
            let (status, ..) = place.ask(&format!("GET {path}"), host);
            assert!(status.contains(" 421 "), "{host} {path}: {status}");
        }
    }
    for (path, kind) in [
        ("/", "text/html; charset=utf-8"),
        ("/page.css", "text/css; charset=utf-8"),
        ("/page.js", "text/javascript; charset=utf-8"),
        ("/healthz", "text/plain; version=0.0.4; charset=utf-8"),
    ] {
        let (status, head, body) = place.get(path);
        assert!(status.contains(" 200 ") && !body.is_empty(), "{path}: {status}");
        assert!(head.contains(&format!("content-type: {kind}")), "{path}: {head}");
        for guard in ["default-src 'none'", "x-content-type-options: nosniff", "cache-control: no"]
        {
            assert!(head.contains(guard), "{path}: {head}");
        }
        assert!(!head.contains("unsafe"), "{path}: {head}");
        let (_, head, body) = place.ask(&format!("HEAD {path}"), "Host: localhost\r\n");
        assert!(body.is_empty() && head.contains("content-length"), "{path}");
    }
    for path in ["/other", "/runs/8/report", "/runs/x/report", "/runs/7/secret", "/api/runs/8"] {
        assert!(place.get(path).0.contains(" 404 "), "{path}");
    }
    for path in ["/runs/7/../../etc/passwd", "/runs/..%2f..%2fetc/picture", "//", "/runs/7/report"]
    {
        assert!(place.get(path).0.contains(" 404 "), "{path}");
    }
    let all = place.json("/api/runs");
    assert_eq!((&all[0]["name"], &all[0]["ticket"]), (&HOSTILE.into(), &"".into()));
    assert_eq!(place.json("/api/runs/7")["name"], HOSTILE);
    assert_eq!(place.json("/api/farm")["name"], "main");
    assert_eq!(place.json("/api/workers"), serde_json::json!([]));
}

#[test]
fn a_page_from_elsewhere_gets_no_file_of_a_run() {
    let place = place();
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["run.mcap", "preview.png"] {
        std::fs::write(folder.path().join(name), "recorded").expect("a file");
    }
    let mut news = run(4, State::Done, "pot");
    news.folder = Some(folder.path().to_owned());
    let file = |name: &str| FileInfo { name: name.to_owned(), length: 1, digest: String::new() };
    news.info.files = ["run.mcap", "preview.png"].map(file).to_vec();
    place.feed.publish(farm(vec![news]));
    for path in ["/runs/4/report", "/runs/4/picture"] {
        let ask = |site: &str| {
            let headers = format!("Host: localhost\r\nSec-Fetch-Site: {site}\r\n");
            place.ask(&format!("GET {path}"), &headers).0
        };
        assert!(ask("cross-site").contains(" 403 "), "{path}");
        assert_eq!(place.scribe.reports.load(Ordering::SeqCst), 0, "it is made for nobody");
        for site in ["same-origin", "none"] {
            assert!(ask(site).contains(" 200 "), "{path}: {site}");
        }
        place.scribe.reports.store(0, Ordering::SeqCst);
    }
}

#[test]
fn long_texts_are_cut_and_say_so() {
    let place = place();
    let mut news = run(7, State::Failed, "pot");
    news.info.text = "é".repeat(400);
    news.info.overrides = (0..13).map(|k| format!("a=\"{}\"", "x".repeat(200 * k))).collect();
    let mut short = run(8, State::Failed, "pot");
    short.info.text = "x".repeat(600);
    short.info.overrides = vec!["a=1".to_owned(); 12];
    place.feed.publish(farm(vec![news, short.clone()]));
    for told in [place.json("/api/runs")[0].clone(), place.json("/api/runs/7")] {
        let text = told["text"].as_str().expect("a text");
        assert!(text.len() <= 600 && text.ends_with("é…"), "{text}");
        let overrides = told["overrides"].as_array().expect("a list");
        assert_eq!((overrides.len(), &overrides[11]), (12, &"…".into()));
        assert_eq!(overrides[0], "a=\"\"");
        let long = overrides[1].as_str().expect("a text");
        assert!(long.len() <= 150 && long.ends_with("x…"), "{long}");
    }
    let whole = place.json("/api/runs/8");
    assert_eq!((&whole["text"], &whole["overrides"][11]), (&short.info.text.into(), &"a=1".into()));
}

#[test]
fn a_page_beyond_this_machine_needs_tls() {
    let illustrator = Arc::new(Scribe::default());
    for address in ["0.0.0.0:0", "[::]:0"] {
        let address: SocketAddr = address.parse().expect("an address");
        let config =
            WebConfig { address, identity: None, illustrator: Arc::clone(&illustrator) as _ };
        let no = Website::serve(config, Feed::default()).expect_err("it is refused");
        assert!(matches!(no, WebError::Open { .. }) && no.to_string().contains("TLS"), "{no}");
    }
}

#[test]
fn a_watcher_sees_a_run_begin_get_on_and_end() {
    let place = place();
    place.feed.publish(farm(vec![run(1, State::Paused, "old")]));
    let mut watch = place.watch();
    let (name, all) = watch.next().expect("an event");
    assert_eq!((name.as_str(), &all["runs"][0]["name"]), ("farm", &"old".into()));
    let publish = |state: State, step: u64| {
        let mut news = run(2, state, HOSTILE);
        news.info.position = (step > 0).then(|| Position { step, ..Position::default() });
        place.feed.publish(farm(vec![run(1, State::Paused, "old"), news]));
    };
    for (state, step) in [(State::Queued, 0), (State::Running, 3), (State::Done, 0)] {
        publish(state, step);
        let news = watch.until(|news| news["runs"][0]["state"] == state.word());
        let runs = news["runs"].as_array().expect("runs");
        assert_eq!((runs.len(), &runs[0]["name"]), (1, &HOSTILE.into()), "only what changed");
        assert_eq!(runs[0]["position"]["step"].as_u64().unwrap_or(0), step);
    }
    place.feed.publish(farm(vec![run(2, State::Done, HOSTILE)]));
    assert_eq!(watch.until(|news| news["gone"][0] == 1)["gone"], serde_json::json!([1]));
    // One who comes later has it all.
    let (name, all) = place.watch().next().expect("an event");
    assert_eq!((name.as_str(), &all["runs"][0]["state"]), ("farm", &"done".into()));
    assert_eq!(all["runs"].as_array().map(Vec::len), Some(1));
    drop(place.site);
    assert_eq!(watch.until(|news| news["leaving"] == true)["leaving"], true);
    assert_eq!(watch.next(), None, "and nothing more");
}

#[test]
fn workers_that_are_gone_are_told_with_the_time() {
    let place = place();
    let worker = |up| WorkerInfo { name: HOSTILE.to_owned(), up, ..WorkerInfo::default() };
    let news = |now_ms, up| FarmNews { now_ms, workers: vec![worker(up)], ..farm(Vec::new()) };
    let mut watch = place.watch();
    place.feed.publish(news(5, true));
    let told = watch.until(|news| news["workers"][0]["up"] == true);
    assert_eq!(told["workers"][0]["gone_ms"], Value::Null);
    place.feed.publish(news(9, false));
    place.feed.publish(news(12, false));
    let told = watch.until(|news| news["workers"][0]["up"] == false);
    assert_eq!(told["workers"][0]["gone_ms"], 9);
}

#[test]
fn a_watcher_that_reads_nothing_holds_nothing_up_and_is_sent_away() {
    let place = place();
    let large = |round: u64| {
        let some = (1..=4_000).map(|k| {
            let mut news = run(k, State::Queued, "x");
            news.line = format!("round {round} {}", "y".repeat(500));
            news
        });
        farm(some.collect())
    };
    place.feed.publish(large(0));
    // They ask and read no further; what is sent to them is much more than sockets hold.
    let idle: Vec<Watch> = (0..8).map(|_| place.watch()).collect();
    until("all watch", || place.feed.watchers() == idle.len());
    let mut longest = Duration::ZERO;
    for round in 1..=30 {
        let news = large(round);
        let since = Instant::now();
        place.feed.publish(news);
        longest = longest.max(since.elapsed());
        std::thread::sleep(Duration::from_millis(5));
    }
    println!("longest publication of 4000 runs: {longest:?}");
    // On this thread: nobody else could hold it up but by a lock.
    assert!(longest < Duration::from_secs(1), "{longest:?}");
    let mut reads = place.watch();
    let (_, all) = reads.next().expect("who reads is answered");
    assert!(all["runs"][0]["line"].as_str().is_some_and(|line| line.starts_with("round 30")));
    until("those who read nothing are sent away", || place.feed.watchers() == 1);
    place.feed.publish(large(31));
    reads.until(|news| news["runs"][0]["line"].as_str().is_some_and(|l| l.contains("31")));
    drop(idle);
}

#[test]
fn strangers_who_hold_connections_keep_no_watcher_out() {
    let place = place();
    place.feed.publish(farm(Vec::new()));
    let mut watch = place.watch();
    watch.next().expect("an event");
    let idle: Vec<TcpStream> = (0..300).map(|_| place.connect()).collect();
    assert!(place.get("/healthz").0.contains(" 200 "));
    place.feed.publish(farm(vec![run(1, State::Queued, "new")]));
    watch.until(|news| news["runs"][0]["name"] == "new");
    drop(idle);
    let more: Vec<Watch> = (0..63).map(|_| place.watch()).collect();
    until("as many watch as may", || place.feed.watchers() == 64);
    let (status, _, body) = place.get("/events");
    assert!(status.contains(" 503 ") && !body.is_empty(), "{status}");
    drop(more);
    until("there is room again", || {
        place.feed.publish(farm(vec![run(1, State::Queued, &format!("{:?}", Instant::now()))]));
        place.feed.watchers() == 1
    });
}

#[test]
fn pictures_come_while_somebody_watches_and_not_otherwise() {
    let place = place();
    let folder = tempfile::tempdir().expect("a folder");
    let partial = folder.path().join("run.mcap.partial");
    std::fs::write(&partial, b"12345").expect("a recording");
    let going = || {
        let mut news = run(1, State::Running, "pot");
        news.folder = Some(folder.path().to_owned());
        news
    };
    place.feed.publish(farm(vec![going()]));
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(place.scribe.stills.load(Ordering::SeqCst), 0, "nobody watches");
    assert!(place.get("/runs/1/picture").0.contains(" 404 "));
    let mut watch = place.watch();
    until("it is drawn", || place.scribe.stills.load(Ordering::SeqCst) == 1);
    until("it is told", || {
        place.feed.publish(farm(vec![going()]));
        place.json("/api/runs/1")["picture"] != Value::Null
    });
    watch.until(|news| news["runs"][0]["picture"].is_string());
    let (_, head, body) = place.get("/runs/1/picture?1-1");
    assert!(head.contains("content-type: image/png"), "{head}");
    assert_eq!(body, b"picture 1 of 5 bytes");
    // Nothing is drawn again that has not changed.
    std::thread::sleep(Duration::from_millis(2_500));
    assert_eq!(place.scribe.stills.load(Ordering::SeqCst), 1);
    std::fs::write(&partial, b"1234567890").expect("a recording");
    until("it is drawn again", || place.scribe.stills.load(Ordering::SeqCst) == 2);
    until("it is shown", || place.get("/runs/1/picture").2 == b"picture 2 of 10 bytes");
}

#[test]
fn a_run_that_is_over_has_figures_files_and_a_report_that_is_made_once() {
    let place = place();
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text);
    write("run.mcap", "recorded").expect("a recording");
    write("preview.png", "sheet").expect("a picture");
    write("summary.json", r#"{"digest":"abc","fractures":3,"more":[]}"#).expect("a summary");
    write("job.bin", "not to be shown").expect("a file");
    let file = |name: &str| FileInfo { name: name.to_owned(), length: 1, digest: String::new() };
    let mut news = run(4, State::Done, "pot");
    news.folder = Some(folder.path().to_owned());
    news.info.files = ["run.mcap", "preview.png", "job.bin"].map(file).to_vec();
    until("its figures are told", || {
        place.feed.publish(farm(vec![news.clone()]));
        place.json("/api/runs/4")["figures"]["digest"] == "abc"
    });
    let told = place.json("/api/runs/4");
    assert_eq!((&told["figures"]["fractures"], &told["report"]), (&3.into(), &true.into()));
    assert_eq!(told["products"][2]["name"], "job.bin");
    assert_eq!(place.get("/runs/4/picture").2, b"sheet");
    assert!(place.get("/runs/4/film").0.contains(" 404 "), "it is not listed");
    assert!(place.get("/runs/4/job.bin").0.contains(" 404 "), "it is not shown");
    for _ in 0..3 {
        let (status, head, body) = place.get("/runs/4/report");
        assert!(status.contains(" 200 ") && body == b"<p>8 bytes</p>", "{status}");
        // Whatever is in it can ask for nothing here.
        let policy = "content-security-policy: sandbox allow-scripts";
        assert!(head.contains(policy) && !head.contains("allow-same-origin"), "{head}");
        assert_eq!(head.matches("content-security-policy").count(), 1, "{head}");
    }
    assert_eq!(place.scribe.reports.load(Ordering::SeqCst), 1);
    std::fs::remove_file(folder.path().join("run.mcap")).expect("it was there");
    news.info.attempt = 2;
    place.feed.publish(farm(vec![news]));
    let (status, _, body) = place.get("/runs/4/report");
    assert!(status.contains(" 422 "), "{status}");
    assert!(String::from_utf8_lossy(&body).contains("run 4 has no report"), "{body:?}");
}
