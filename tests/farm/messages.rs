//! Messages that are not as they should be, at separate processes: a stranger on the link of a farm
//! without certificates asks, answers and publishes what it likes, and nothing that counts changes.

use crate::common;

use common::farm::Draw;
use common::{Cullet, Going, LONGER, corpus, unique, until};
use cullet_proto::keys::{self, UserVerb, WorkerVerb};
use cullet_proto::pool::{self, Poll};
use cullet_proto::transport::{self, Patience};
use cullet_proto::{SessionId, WorkerId, chunks};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use zenoh::Wait;
use zenoh::query::ConsolidationMode;

const LONG: Duration = Duration::from_secs(150);
/// Messages of each kind in the storm.
const EACH: u64 = 60;
/// Answers of the stranger's own to what the worker asks: each may cost an attempt, of which a job
/// has eight.
const LIES: u64 = 6;
const ALL_WORKERS: &str = "cullet/v1/c/main/rpc/w/**";
const ALL_USERS: &str = "cullet/v1/c/main/rpc/u/**";

const WORKER: [WorkerVerb; 9] = [
    WorkerVerb::Hello,
    WorkerVerb::Poll,
    WorkerVerb::Renew,
    WorkerVerb::Heed,
    WorkerVerb::Fetch,
    WorkerVerb::Chunk,
    WorkerVerb::Commit,
    WorkerVerb::Fail,
    WorkerVerb::Bye,
];
const USER: [UserVerb; 15] = [
    UserVerb::About,
    UserVerb::Piece,
    UserVerb::Submit,
    UserVerb::Runs,
    UserVerb::Run,
    UserVerb::Follow,
    UserVerb::Cancel,
    UserVerb::Pause,
    UserVerb::Resume,
    UserVerb::Retry,
    UserVerb::Delete,
    UserVerb::Fetch,
    UserVerb::Bye,
    UserVerb::Workers,
    UserVerb::Drain,
];

/// A coordinator as a process, and its log.
struct Farm {
    endpoint: String,
    metrics: String,
    log: PathBuf,
    coordinator: Going,
}

impl Farm {
    fn start() -> Self {
        let (endpoint, state) = (common::free_endpoint(), unique("messages"));
        let metrics = common::free_endpoint().replace("tcp/", "");
        let log = unique("messages-log");
        // What repeats is solved again.
        let call = ["coordinator", "--listen", &endpoint, "--cache", "0", "--metrics", &metrics];
        let coordinator = Cullet::new(&call).log(&log).args(&["--state"]).path(&state).spawn();
        let farm = Self { endpoint, metrics, log, coordinator };
        until("it is there", LONG, || farm.ask(&["ps"]).code == 0);
        farm
    }

    fn worker(&self) -> Going {
        let call = ["worker", "--connect", &self.endpoint, "--name", "w"];
        Cullet::new(&call).log(&unique("messages-worker")).spawn()
    }

    /// A run ends with the digest of a quiet machine.
    fn ends_well(&self, run: &str, args: &[&str]) {
        let said = self.ask(&["wait", run]);
        assert_eq!(said.code, 0, "{}", said.stderr);
        let who = ["--connect", self.endpoint.as_str()];
        assert_eq!(common::fetched(run, &who), common::quiet_digest(args));
    }

    fn ask(&self, args: &[&str]) -> common::Said {
        Cullet::new(args).args(&["--connect", &self.endpoint]).output()
    }

    fn submit(&self, args: &[&str]) -> String {
        let said = self.ask(&[&["submit", &corpus("drop.toml"), "--detach"], args].concat());
        assert_eq!(said.code, 0, "{}", said.stderr);
        said.stdout.trim().to_owned()
    }

    /// Counters of refused messages, by who was refused and why.
    fn counted(&self) -> BTreeMap<String, u64> {
        let mut stream = std::net::TcpStream::connect(&self.metrics).expect("metrics");
        stream.write_all(b"GET /metrics HTTP/1.0\r\n\r\n").expect("a question");
        let mut text = String::new();
        stream.read_to_string(&mut text).expect("an answer");
        let lines = text.lines().filter_map(|l| l.strip_prefix("cullet_messages_refused_total{"));
        let row = |line: &str| {
            let (label, value) = line.split_once("} ")?;
            let label = label.replace("of=", "").replace("reason=", "").replace('"', "");
            Some((label, value.parse().ok()?))
        };
        lines.filter_map(row).filter(|(_, value)| *value > 0).collect()
    }

    /// The same, by the coordinator's log.
    fn logged(&self) -> BTreeMap<String, u64> {
        let mut all = BTreeMap::new();
        for line in common::history::lines(&self.log) {
            let (reason, text) = (line["reason"].as_str(), line["message"].as_str());
            let (Some(reason), Some(text)) = (reason, text) else { continue };
            let of = if text.contains("/rpc/w/") { "worker" } else { "client" };
            *all.entry(format!("{of},{reason}")).or_default() += 1;
        }
        all
    }
}

/// Somebody on the link who keeps to nothing.
struct Stranger {
    link: zenoh::Session,
    draw: Draw,
    /// Refusals that it was given, by whose question it was and why.
    told: BTreeMap<String, u64>,
}

impl Stranger {
    fn new(endpoint: &str, seed: u64) -> Self {
        let mut settings = zenoh::Config::default();
        for (path, value) in transport::worker(&[endpoint.to_owned()], Patience::production()) {
            settings.insert_json5(path, &value).expect("a setting");
        }
        let link = zenoh::open(settings).wait().expect("a session");
        Self { link, draw: Draw(seed), told: BTreeMap::new() }
    }

    fn key(&mut self) -> String {
        let name = |text| WorkerId::new(text).expect("a name");
        let verbs = (WORKER.len() + USER.len()) as u64;
        let (main, at) = (name("main"), self.draw.below(verbs) as usize);
        match WORKER.get(at) {
            Some(verb) => keys::worker_rpc(&main, &name("w"), *verb),
            None => keys::user_rpc(&main, &name("user"), USER[at - WORKER.len()]),
        }
    }

    fn noise(&mut self, longest: u64) -> Vec<u8> {
        let length = 1 + self.draw.below(longest);
        (0..length).map(|_| self.draw.below(256) as u8).collect()
    }

    /// Asks, and notes how it is refused, if it is; whether there was an answer of any kind.
    fn ask(&mut self, key: &str, bytes: &[u8], patience: Duration) -> bool {
        let get = self.link.get(key).payload(bytes).consolidation(ConsolidationMode::None);
        let replies = get.timeout(patience).wait().expect("it is sent");
        let Ok(reply) = replies.recv() else { return false };
        let Err(error) = reply.into_result() else { return true };
        let bytes = error.payload().to_bytes().into_owned();
        let reason = match (pool::read_refusal(&bytes), serde_json::from_slice::<Value>(&bytes)) {
            (Ok(refusal), _) => format!("worker,{}", refusal.name()),
            (Err(_), Ok(told)) => {
                let text = told["error"].as_str().unwrap_or_default();
                // A question that was understood, and to which the answer is no, is not counted.
                match (text.starts_with("the message was not under"), text.contains("limit is")) {
                    (true, _) => "client,malformed".to_owned(),
                    (false, true) => "client,too_large".to_owned(),
                    (false, false) => return true,
                }
            }
            // Zenoh's own: nobody has answered in time.
            (Err(_), Err(_)) => return false,
        };
        *self.told.entry(reason).or_default() += 1;
        true
    }
}

/// What was asked while the farm was left alone: each key with its bytes.
type Record = Arc<Mutex<Vec<(String, Vec<u8>)>>>;

/// Hears what others ask, as anybody may where there are no roles, and says nothing to it.
fn listen(stranger: &Stranger) -> (Record, Vec<zenoh::query::Queryable<()>>) {
    let record = Record::default();
    let hear = |key: &str| {
        let seen = Arc::clone(&record);
        let hear = move |query: zenoh::query::Query| {
            let bytes = query.payload().map(|payload| payload.to_bytes().into_owned());
            let key = query.key_expr().as_str().to_owned();
            seen.lock().expect("a record").push((key, bytes.unwrap_or_default()));
        };
        stranger.link.declare_queryable(key).callback(hear).wait().expect("it is declared")
    };
    let ears = vec![hear(ALL_WORKERS), hear(ALL_USERS)];
    (record, ears)
}

/// Kinds of messages, with how many were sent.
type Sent = BTreeMap<&'static str, u64>;

/// One of each kind, many times; each is answered, refused, or heard by nobody.
fn storm(stranger: &mut Stranger, record: &[(String, Vec<u8>)]) -> Sent {
    let (mut sent, soon) = (Sent::new(), Duration::from_secs(5));
    let mut count = |kind| *sent.entry(kind).or_default() += 1;
    // Such a question may be held for long: who asks in another's name need not wait for it.
    let brief = Duration::from_millis(300);
    let is_held = |key: &str| key.ends_with("/poll") || key.ends_with("/heed");
    let held = |key: &str| if is_held(key) { brief } else { soon };
    for _ in 0..EACH {
        let (key, noise) = (stranger.key(), stranger.noise(2_000));
        assert!(stranger.ask(&key, &noise, soon), "{key}: noise is not answered");
        count("noise");
        stranger.link.put(&key, noise).wait().expect("it is published");
        stranger.link.delete(&key).wait().expect("it is published");
        count("published");
        let at = stranger.draw.below(record.len() as u64) as usize;
        let (key, mut bytes) = record[at].clone();
        if !bytes.is_empty() {
            for _ in 0..=stranger.draw.below(4) {
                let bit = stranger.draw.below(8 * bytes.len() as u64);
                bytes[(bit / 8) as usize] ^= 1 << (bit % 8);
            }
        }
        stranger.ask(&key, &bytes, held(&key));
        count("flipped");
        let (key, bytes) = &record[stranger.draw.below(record.len() as u64) as usize];
        stranger.ask(key, bytes, held(key));
        count("again");
    }
    let workers: Vec<_> = record.iter().filter(|(key, _)| key.contains("/rpc/w/")).collect();
    for _ in 0..EACH {
        let (key, mut bytes) = workers[stranger.draw.below(workers.len() as u64) as usize].clone();
        bytes[4] = stranger.draw.below(2) as u8 * 2;
        assert!(stranger.ask(&key, &bytes, soon), "{key}: an old message is not answered");
        count("old");
    }
    for _ in 0..8 {
        // The generation before this one had keys of its own: nobody is there.
        let key = stranger.key().replace("/v1/", "/v0/");
        assert!(!stranger.ask(&key, b"{}", brief), "{key} is answered");
        count("old key");
        let (key, length) = (stranger.key(), 6 * chunks::CHUNK);
        assert!(stranger.ask(&key, &vec![7; length], soon), "{key}: it is not answered");
        count("oversized");
        let session = SessionId(stranger.draw.below(u64::MAX));
        let poll = Poll { session, seq: 1, slots: 1, threads: 1 };
        let poll = pool::ask(&poll, &[]).expect("a question");
        assert!(stranger.ask("cullet/v1/c/main/rpc/w/x/poll", &poll, soon), "a stranger's");
        count("unknown worker");
    }
    sent
}

/// Answers some of what the worker asks before the coordinator can, in a way that is no answer.
fn lie(stranger: &Stranger) -> (Arc<AtomicU64>, zenoh::query::Queryable<()>) {
    let told = Arc::<AtomicU64>::default();
    let (count, draw) = (Arc::clone(&told), Mutex::new(Draw(99)));
    let answer = move |query: zenoh::query::Query| {
        if count.fetch_add(1, Ordering::SeqCst) >= LIES {
            return;
        }
        let mut draw = draw.lock().expect("a draw");
        let noise: Vec<u8> = (0..draw.below(500)).map(|_| draw.below(256) as u8).collect();
        let key = query.key_expr().clone();
        // An old message, one that is nothing, one too large, an error that is none.
        match draw.below(4) {
            0 => query.reply(key, [b"CULT\0\0\0\0\x04\0\0\0".to_vec(), noise].concat()).wait(),
            1 => query.reply(key, noise).wait(),
            2 => query.reply(key, vec![3; 5 << 20]).wait(),
            _ => query.reply_err(noise).wait(),
        }
        .ok();
    };
    let ear = stranger.link.declare_queryable(ALL_WORKERS).callback(answer).wait();
    (told, ear.expect("it is declared"))
}

#[test]
fn messages_that_are_not_as_they_should_be_change_nothing_and_are_counted_by_name() {
    let _left = common::left::NobodyLeft::watch();
    let mut farm = Farm::start();
    let mut stranger = Stranger::new(&farm.endpoint, 20_261_123);
    // What real messages are.
    let (record, ears) = listen(&stranger);
    let mut worker = farm.worker();
    let first = farm.submit(&LONGER);
    farm.ends_well(&first, &LONGER);
    let record = record.lock().expect("a record").clone();
    drop(ears);
    let asked = ["hello", "poll", "heed", "fetch", "chunk", "commit"];
    for verb in asked.map(|verb| format!("w/w/{verb}")).into_iter().chain(["u/user/fetch".into()]) {
        let heard = record.iter().any(|(key, _)| key.ends_with(&format!("/rpc/{verb}")));
        assert!(heard, "no {verb} was heard");
    }
    // A run whose worker hears things that are no answers.
    let seeds = ["11", "12"].map(|seed| format!("world.seed={seed}"));
    let [second, third] = [0, 1].map(|k: usize| [&LONGER[..], &["--set", &seeds[k]]].concat());
    let (lies, ear) = lie(&stranger);
    let run = farm.submit(&second);
    until("the worker was lied to", LONG, || lies.load(Ordering::SeqCst) >= LIES);
    drop(ear);
    farm.ends_well(&run, &second);
    // A run under a storm.
    let run = farm.submit(&third);
    let sent = storm(&mut stranger, &record);
    farm.ends_well(&run, &third);
    // Late, when all epochs of it have ended: the answers of the first run once more.
    let late = |(key, _): &&(String, Vec<u8>)| key.ends_with("/commit") || key.ends_with("/chunk");
    let late: Vec<_> = record.iter().filter(late).collect();
    assert!(late.len() >= 2, "{} late answers", late.len());
    for (key, bytes) in &late {
        assert!(stranger.ask(key, bytes, Duration::from_secs(5)), "{key}: it is not answered");
    }
    println!("sent: {sent:?}, {} late, {LIES} lies; refused: {:?}", late.len(), stranger.told);
    // Each refusal is counted under its name, and logged.
    let told = &stranger.told;
    for reason in ["unsupported", "too_large", "malformed", "stranger"] {
        assert!(told.contains_key(&format!("worker,{reason}")), "{told:?}");
    }
    for reason in ["too_large", "malformed"] {
        assert!(told.contains_key(&format!("client,{reason}")), "{told:?}");
    }
    until("what was told is counted, and logged", LONG, || {
        let counted = farm.counted();
        let all = told.iter().all(|(name, count)| counted.get(name) >= Some(count));
        all && farm.logged() == counted
    });
    // Both live, and the first run is what it was.
    farm.ends_well(&first, &LONGER);
    for process in [&mut worker, &mut farm.coordinator] {
        assert!(common::is_alive(process.id()), "it has ended: {:?}", process.wait(LONG));
        common::signal(process.id(), "TERM");
        assert_eq!(process.wait(Duration::from_secs(30)), Some(0));
    }
}
