//! Many runs, many who ask, and some who take nothing: what waits for each of them has a bound.

use super::{Place, STALL, farm, place, run, until};
use crate::events::PAGE;
use crate::{FarmNews, Feed, Illustrator, WebConfig, Website};
use cullet_proto::service::{FileInfo, State};
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Runs whose texts are all control characters, which have six times as many bytes as JSON.
fn crowd(count: u64, line: &str) -> FarmNews {
    let some = (1..=count).map(|k| {
        let mut news = run(k, if k % 100 == 0 { State::Running } else { State::Done }, "x");
        news.info.overrides = vec!["\u{1}".repeat(140); 12];
        news.info.sweep = "\u{1}".repeat(64);
        news.line = line.to_owned();
        news
    });
    farm(some.collect())
}

#[test]
fn runs_come_in_pages_to_watchers_and_readers() {
    let place = place();
    place.feed.publish(crowd(1_000, ""));
    let most = PAGE + (16 << 10);
    let (mut seen, mut path) = (Vec::new(), "/api/runs".to_owned());
    loop {
        let (status, head, body) = place.get(&path);
        assert!(status.contains(" 200 ") && body.len() < most, "{status}: {} bytes", body.len());
        let page: Vec<Value> = serde_json::from_slice(&body).expect("JSON");
        seen.extend(page.iter().filter_map(|run| run["run"].as_u64()));
        let next = head.lines().find_map(|line| line.strip_prefix("link: <"));
        let Some(next) = next.and_then(|rest| rest.split('>').next()) else { break };
        path = next.to_owned();
    }
    assert_eq!(seen, (1..=1_000).collect::<Vec<_>>());
    assert!(place.get("/api/runs?after=x").0.contains(" 400 "));
    assert_eq!(place.json("/api/runs?after=1000"), serde_json::json!([]));
    let mut watch = place.watch();
    let (mut told, mut events) = (BTreeSet::new(), 0);
    while told.len() < 1_000 {
        let (name, news) = watch.next().expect("an event");
        assert_eq!(name, if events == 0 { "farm" } else { "change" });
        assert!(news.to_string().len() < most, "{} bytes", news.to_string().len());
        let runs = news["runs"].as_array().expect("runs");
        told.extend(runs.iter().filter_map(|run| run["run"].as_u64()));
        if events == 0 {
            let going = runs.iter().filter(|run| run["state"] == "running").count();
            assert_eq!(going, 10, "what goes on comes first");
            assert!(told.contains(&999) && !told.contains(&1), "then what is new");
        }
        events += 1;
    }
    assert!(events > 4, "{events} events");
}

#[test]
fn a_reader_that_takes_hardly_anything_is_sent_away() {
    let place = place();
    place.feed.publish(crowd(2_000, ""));
    let mut slow = place.connect();
    slow.write_all(b"GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n").expect("sent");
    until("it watches", || place.feed.watchers() == 1);
    until("it is sent away", || {
        let mut few = [0; 64];
        let _taken = slow.read(&mut few);
        place.feed.publish(crowd(2_000, &format!("{:?}", Instant::now())));
        std::thread::sleep(Duration::from_millis(100));
        place.feed.watchers() == 0
    });
}

/// The maker of the report waits until it is allowed to go on.
#[derive(Debug, Default)]
struct Ponderer(AtomicBool);

impl Illustrator for Ponderer {
    fn still(&self, _: &Path, _: &Path, _: &AtomicBool) -> Result<Duration, String> {
        Err("nothing is drawn here".to_owned())
    }

    fn report(&self, _: &Path, file: &Path, stop: &AtomicBool) -> Result<(), String> {
        while !self.0.load(Ordering::SeqCst) && !stop.load(Ordering::SeqCst) {
            std::thread::sleep(Duration::from_millis(10));
        }
        std::fs::write(file, "<p>a report</p>").map_err(|error| error.to_string())
    }
}

#[test]
fn a_report_that_takes_long_holds_up_no_other_answer() {
    let (feed, ponderer) = (Feed::default(), Arc::new(Ponderer::default()));
    let address = SocketAddr::from(([127, 0, 0, 1], 0));
    let illustrator = Arc::clone(&ponderer) as Arc<dyn Illustrator>;
    let config = WebConfig { address, identity: None, illustrator };
    let site = Website::start(config, feed.clone(), STALL).expect("a page");
    let (address, scribe) = (site.address().expect("an address"), Arc::default());
    let place = Place { feed, site, scribe, address };
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["run.mcap", "preview.png"] {
        std::fs::write(folder.path().join(name), "recorded").expect("a file");
    }
    let ended = |number: u64| {
        let mut news = run(number, State::Done, "pot");
        news.folder = Some(folder.path().to_owned());
        let file = |name: &str| FileInfo { name: name.into(), length: 1, digest: String::new() };
        news.info.files = ["run.mcap", "preview.png"].map(file).to_vec();
        news
    };
    place.feed.publish(farm((1..=60).map(ended).collect()));
    // More than may wait: one is made, 32 wait, the others are told to come later.
    let ask = |number: u64| {
        let mut stream = place.connect();
        let text = format!("GET /runs/{number}/report HTTP/1.1\r\nHost: localhost\r\n\r\n");
        stream.write_all(text.as_bytes()).expect("sent");
        stream
    };
    let mut asked: Vec<TcpStream> = (1..=40).map(ask).collect();
    std::thread::sleep(Duration::from_millis(300));
    let since = Instant::now();
    assert_eq!(place.get("/runs/7/picture").2, b"recorded");
    assert!(place.get("/api/runs").0.contains(" 200 "));
    assert!(since.elapsed() < Duration::from_secs(5), "{:?}", since.elapsed());
    ponderer.0.store(true, Ordering::SeqCst);
    let answers: Vec<String> = asked
        .iter_mut()
        .map(|stream| {
            let mut text = String::new();
            stream.read_to_string(&mut text).expect("an answer");
            text
        })
        .collect();
    let with = |word: &str| answers.iter().filter(|answer| answer.contains(word)).count();
    let (made, refused) = (with(" 200 "), with(" 503 "));
    assert!((32..=33).contains(&made) && made + refused == 40, "{made} and {refused}");
}
