//! A client hands a scene in, follows it and fetches what came of it, over a real link.

use crate::kit::config;
use cullet_coordinator::{ServiceConfig, Store, serve};
use cullet_document::files::{Bundle, SceneFile};
use cullet_pool::client::{Client, Terms};
use cullet_pool::{LinkError, Pool};
use cullet_proto::keys::UserVerb;
use cullet_proto::security::Rules;
use cullet_proto::service::{MAX_INLINE, Nothing, RunInfo, Runs, State, Which, codes};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const SCENE: &str = r#"
[world]
duration = 0.02
[[body]]
name = "ball"
shape = { kind = "sphere", radius = 0.1 }
position = [0.0, 0.0, 1.0]
material = "soda-lime-glass"
"#;

fn bundle(extra: usize) -> Bundle {
    let file = |key: &str, bytes: Vec<u8>| SceneFile { key: key.into(), bytes: bytes.into() };
    let ballast = (0..extra).map(|k| (k * 7 + k / 255) as u8).collect();
    let files = vec![file("scene/a.toml", SCENE.into()), file("scene/ballast", ballast)];
    let (name, main) = ("a".to_owned(), "scene/a.toml".to_owned());
    Bundle { name, main, overrides: vec!["world.seed=2".to_owned()], files }
}

fn terms(ticket: &str) -> Terms {
    Terms { ticket: ticket.into(), ..Terms::default() }
}

/// A coordinator on a thread of this process; it is told to stop when dropped.
struct Desk {
    endpoint: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Desk {
    fn open(state: &Path) -> Self {
        let store = Store::open(Some(state)).expect("a state folder");
        let pool = Arc::new(Pool::start(store.pool(config(), 0)).expect("a pool on loopback"));
        let (endpoint, stop) = (pool.endpoint().to_owned(), Arc::new(AtomicBool::new(false)));
        let config = ServiceConfig { runs: 2, ..ServiceConfig::default() };
        let told = Arc::clone(&stop);
        let work = move || serve(store, &pool, &config, &told, &mut |_| {}).expect("it serves");
        Self { endpoint, stop, thread: Some(std::thread::spawn(work)) }
    }

    fn client(&self) -> Client {
        Client::connect(&self.endpoint).expect("a client")
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            assert!(ended.is_ok() || std::thread::panicking(), "the service panicked");
        }
    }
}

#[test]
fn a_scene_goes_in_lines_come_back_files_are_fetched_and_a_restart_forgets_nothing() {
    let state = tempfile::tempdir().expect("a folder");
    let desk = Desk::open(state.path());
    let client = desk.client();
    // In one message, and in pieces.
    for (ticket, extra) in [("small", 10), ("large", 3 * MAX_INLINE)] {
        let run = client.submit(&bundle(extra), &terms(ticket)).expect("it is taken");
        let again = client.submit(&bundle(extra), &terms(ticket)).expect("it is taken");
        assert_eq!(again, run, "handed in again, it is the same one");
        let mut from = 0;
        let info = client.follow(run, 0, |news| from = news.next).expect("it ends");
        assert_eq!((info.state, info.code), (State::Done, Some(codes::DONE)), "{info:?}");
        assert_eq!((info.name.as_str(), info.overrides.len()), ("a", 1));
        let target = state.path().join(format!("fetched-{ticket}"));
        let written = client.fetch(&info, &target).expect("it is fetched");
        assert!(written.contains(&target.join("run.mcap")), "{written:?}");
        client.enough(run);
    }
    let before: Runs = client.question(UserVerb::Runs, &Nothing {}).expect("an answer");
    assert_eq!(before.runs.len(), 2);
    drop(client);
    drop(desk);
    let desk = Desk::open(state.path());
    let client = desk.client();
    let after: Runs = client.question(UserVerb::Runs, &Nothing {}).expect("an answer");
    let plain = |runs: &Runs| -> Vec<_> {
        let row = |run: &RunInfo| (run.run, run.state, run.files.clone(), run.ended_ms);
        runs.runs.iter().map(row).collect()
    };
    assert_eq!(plain(&after), plain(&before));
    let again = client.submit(&bundle(10), &terms("small")).expect("it is taken");
    assert_eq!(again, 1, "the same ticket is the same run after a restart too");
    client.enough(again);
}

#[test]
fn what_may_not_be_and_what_is_not_there_is_refused() {
    let state = tempfile::tempdir().expect("a folder");
    let desk = Desk::open(state.path());
    let client = desk.client();
    let evil = Bundle { name: "../evil".into(), ..bundle(1) };
    let said = client.submit(&evil, &terms("e"));
    assert!(matches!(said, Err(LinkError::Path { .. })), "{said:?}");
    let rude = Terms { priority: 1000, ..terms("p") };
    let said = client.submit(&bundle(1), &rude);
    assert!(matches!(&said, Err(LinkError::Refused(why)) if why.contains("priority")), "{said:?}");
    assert!(matches!(client.follow(99, 0, |_| {}), Err(LinkError::Unknown(_))));
    for verb in [UserVerb::Cancel, UserVerb::Pause, UserVerb::Resume, UserVerb::Retry] {
        let said = client.question::<_, RunInfo>(verb, &Which { run: 99 });
        assert!(matches!(&said, Err(LinkError::Unknown(why)) if why.contains("99")), "{said:?}");
    }
    // A scene that does not load fails, and says why; the next one runs.
    let mut bad = bundle(1);
    bad.overrides = vec!["world.seeed=2".into()];
    let run = client.submit(&bad, &terms("bad")).expect("it is taken");
    let info = client.follow(run, 0, |_| {}).expect("it ends");
    assert_eq!((info.state, info.code), (State::Failed, Some(codes::UNFIT)), "{info:?}");
    assert!(info.text.contains("seeed"), "{info:?}");
    client.enough(run);
}

#[test]
fn a_client_of_nobody_is_told_so() {
    let probe = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let endpoint = format!("tcp/{}", probe.local_addr().expect("an address"));
    drop(probe);
    let asked = Instant::now();
    let said = Client::connect_as(&endpoint, &Rules::new(), Duration::from_secs(1)).map(drop);
    let said = said.expect_err("nobody is there");
    assert!(matches!(said, LinkError::Connect { .. }), "{said:?}");
    let want = format!("cannot connect to {endpoint}: tried for 1 s; nobody listens there");
    assert_eq!(said.to_string(), want);
    assert!(asked.elapsed() < Duration::from_secs(4), "it took {:?}", asked.elapsed());
}
