//! Roles at a router, tried by peers that keep to nothing: each has a sound certificate and does
//! what it may and what it may not.

use cullet_pool::router::{Router, config};
use cullet_proto::keys::{self, UserVerb, WorkerVerb};
use cullet_proto::security::{Names, Roles, Rules, identity};
use cullet_proto::transport::{self, Patience};
use cullet_proto::{SessionId, WorkerId};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use zenoh::Wait;

/// Longest wait for an answer: one that is denied comes at once or never.
const ANSWER: Duration = Duration::from_millis(700);

type Anything = Result<(), zenoh::Error>;

fn name(text: &str) -> WorkerId {
    WorkerId::new(text).expect("a name")
}

/// Certificates of these names, made by the script that is shipped.
fn certificates(folder: &Path, names: &[&str], set: &[(&str, String)]) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy/certs.sh");
    let made = Command::new(script).arg(folder).args(names).envs(set.iter().cloned()).status();
    assert!(made.is_ok_and(|status| status.success()), "openssl makes certificates");
}

/// A router of ours, or one of Zenoh's own.
type Either = Result<Router, zenoh::Session>;

/// A router with roles; who answers, and everybody's certificates.
struct Stage {
    folder: tempfile::TempDir,
    endpoint: String,
    coordinator: zenoh::Session,
    /// The router, of one kind or the other.
    _router: Either,
}

impl Stage {
    fn set() -> Result<Self, zenoh::Error> {
        Self::around(|_, rules| {
            let router = Router::start("tls/127.0.0.1:0", rules)?;
            let endpoint = router.endpoint().to_owned();
            Ok((Ok(router), endpoint))
        })
    }

    /// Around a router of Zenoh's own, from the file that `cullet router --print-config` prints.
    fn printed() -> Result<Self, zenoh::Error> {
        Self::around(|folder, rules| {
            let port = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
            let (file, endpoint) = (folder.join("zenohd.json5"), format!("tls/127.0.0.1:{port}"));
            std::fs::write(&file, config(&endpoint, rules)?)?;
            let router = zenoh::open(zenoh::Config::from_file(file)?).wait()?;
            Ok((Err(router), endpoint))
        })
    }

    fn around(
        start: impl FnOnce(&Path, &Rules) -> Result<(Either, String), zenoh::Error>,
    ) -> Result<Self, zenoh::Error> {
        let folder = tempfile::tempdir()?;
        let all = ["router", "coordinator", "w-1", "w-2", "ann", "bob", "mallory"];
        certificates(folder.path(), &all, &[]);
        let list = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let names = Names {
            workers: list(&["w-1", "w-2", "brief"]),
            users: list(&["ann", "bob"]),
            operators: Vec::new(),
            ..Names::default()
        };
        let mut rules = identity(&folder.path().join("router"));
        rules.extend(Roles::new(&names)?.access());
        let (router, endpoint) = start(folder.path(), &rules)?;
        let place = folder.path().join("coordinator");
        let coordinator = session(&endpoint, &place, false)?;
        for key in [keys::worker_rpcs(&name("main")), keys::user_rpcs(&name("main"))] {
            answering(&coordinator, &key, "coordinator")?;
        }
        Ok(Self { folder, endpoint, coordinator, _router: router })
    }

    /// A session with that certificate.
    fn with(&self, certificate: &str) -> Result<zenoh::Session, zenoh::Error> {
        session(&self.endpoint, &self.folder.path().join(certificate), false)
    }
}

fn session(
    endpoint: &str,
    certificate: &Path,
    patient: bool,
) -> Result<zenoh::Session, zenoh::Error> {
    let endpoints = [endpoint.to_owned()];
    let timeout = if patient { 10_000 } else { 3_000 };
    let mut config = zenoh::Config::default();
    for (path, value) in transport::client(&endpoints, Patience::test(), timeout) {
        config.insert_json5(path, &value)?;
    }
    for (path, value) in identity(certificate) {
        // What the other side does about it is what is looked at here.
        let value = if path.ends_with("on_expiration") { "false".to_owned() } else { value };
        config.insert_json5(path, &value)?;
    }
    zenoh::open(config).wait()
}

fn answering(session: &zenoh::Session, key: &str, word: &'static str) -> Anything {
    let answer = move |query: zenoh::query::Query| {
        let _denied = query.reply(query.key_expr().clone(), word).wait();
    };
    session.declare_queryable(key).complete(true).callback(answer).background().wait()?;
    Ok(())
}

/// Every word that is answered, in order.
fn answers(session: &zenoh::Session, key: &str) -> Vec<String> {
    let get = session.get(key).target(zenoh::query::QueryTarget::All);
    let get = get.consolidation(zenoh::query::ConsolidationMode::None).timeout(ANSWER);
    let Ok(replies) = get.wait() else {
        return Vec::new();
    };
    let until = Instant::now() + ANSWER;
    let mut said = Vec::new();
    while let Ok(Some(reply)) = replies.recv_deadline(until) {
        if let Ok(sample) = reply.into_result() {
            said.push(String::from_utf8_lossy(&sample.payload().to_bytes()).into_owned());
        }
    }
    said.sort();
    said
}

fn asks_user(who: &str) -> String {
    keys::user_rpc(&name("main"), &name(who), UserVerb::Runs)
}

fn asks_worker(who: &str) -> String {
    keys::worker_rpc(&name("main"), &name(who), WorkerVerb::Poll)
}

#[test]
fn each_asks_as_itself_alone() -> Anything {
    each_asks_alone(&Stage::set()?)
}

#[test]
fn zenohs_own_router_keeps_to_the_printed_settings_as_ours_does() -> Anything {
    let stage = Stage::printed()?;
    each_asks_alone(&stage)?;
    nobody_else_answers(&stage)?;
    nobody_else_is_a_coordinator(&stage)
}

fn each_asks_alone(stage: &Stage) -> Anything {
    let heard = vec!["coordinator".to_owned()];
    // The certificate, and whom it may ask as of all these.
    let keys: Vec<String> =
        ["w-1", "w-2", "coordinator-w7"].iter().map(|w| asks_worker(w)).collect();
    let keys: Vec<String> = keys.into_iter().chain(["ann", "bob"].map(asks_user)).collect();
    let may = [
        ("w-1", vec![asks_worker("w-1")]),
        ("w-2", vec![asks_worker("w-2")]),
        ("ann", vec![asks_user("ann")]),
        ("bob", vec![asks_user("bob")]),
        ("coordinator", vec![asks_worker("coordinator-w7")]),
        ("mallory", vec![]),
        ("router", vec![]),
    ];
    for (certificate, allowed) in may {
        let session = stage.with(certificate)?;
        for key in &keys {
            let want = if allowed.contains(key) { heard.clone() } else { Vec::new() };
            let mut found = answers(&session, key);
            // A session that has just opened may not know yet who answers.
            let until = Instant::now() + 10 * ANSWER;
            while found != want && found.is_empty() && Instant::now() < until {
                found = answers(&session, key);
            }
            assert_eq!(found, want, "{certificate} asks {key}");
        }
    }
    Ok(())
}

#[test]
fn nobody_else_answers_and_nobody_else_sees_who_lives() -> Anything {
    nobody_else_answers(&Stage::set()?)
}

fn nobody_else_answers(stage: &Stage) -> Anything {
    let main = name("main");
    let rogues: Vec<zenoh::Session> = ["w-2", "bob", "mallory"]
        .iter()
        .map(|rogue| stage.with(rogue))
        .collect::<Result<_, _>>()?;
    let mut overheard = Vec::new();
    for rogue in &rogues {
        for key in [keys::worker_rpcs(&main), keys::user_rpcs(&main), "**".to_owned()] {
            answering(rogue, &key, "rogue")?;
        }
        let live = rogue.liveliness().declare_subscriber(keys::workers_live(&main)).wait()?;
        overheard.push(live);
        overheard.push(rogue.liveliness().declare_subscriber("**").history(true).wait()?);
    }
    // Not even to itself.
    answering(&rogues[0], &asks_worker("w-2"), "rogue")?;
    answering(&rogues[1], &asks_user("bob"), "rogue")?;
    assert_eq!(answers(&stage.with("w-2")?, &asks_worker("w-2")), ["coordinator"]);
    assert_eq!(answers(&stage.with("bob")?, &asks_user("bob")), ["coordinator"]);
    let seen = stage.coordinator.liveliness().declare_subscriber(keys::workers_live(&main));
    let seen = seen.history(true).wait()?;
    let worker = stage.with("w-1")?;
    let mine = keys::worker_live(&main, &name("w-1"), SessionId(7));
    let token = worker.liveliness().declare_token(mine.clone()).wait()?;
    // A sign of life under another's name is none.
    let forged = keys::worker_live(&main, &name("w-2"), SessionId(8));
    let _forged = worker.liveliness().declare_token(forged).wait()?;
    let first = seen.recv_timeout(Duration::from_secs(3))?.ok_or("no sign of life")?;
    assert_eq!(first.key_expr().as_str(), mine);
    assert!(seen.recv_timeout(ANSWER)?.is_none(), "a forged sign of life is seen");
    assert_eq!(answers(&worker, &asks_worker("w-1")), ["coordinator"]);
    assert_eq!(answers(&stage.with("ann")?, &asks_user("ann")), ["coordinator"]);
    drop(token);
    for subscriber in &overheard {
        assert!(subscriber.try_recv()?.is_none(), "signs of life are seen by others");
    }
    Ok(())
}

#[test]
fn coordinators_find_each_other_and_nobody_else_is_taken_for_one() -> Anything {
    nobody_else_is_a_coordinator(&Stage::set()?)
}

/// The signs of life of coordinators that a session sees.
fn coordinators(session: &zenoh::Session) -> Result<Vec<String>, zenoh::Error> {
    let get = session.liveliness().get(keys::coordinators_live(&name("main"))).timeout(ANSWER);
    let replies = get.wait()?;
    let samples = std::iter::from_fn(|| replies.recv().ok()).filter_map(|r| r.into_result().ok());
    Ok(samples.map(|sample| sample.key_expr().to_string()).collect())
}

fn nobody_else_is_a_coordinator(stage: &Stage) -> Anything {
    let live = |life| keys::coordinator_live(&name("main"), SessionId(life));
    let claim = keys::claim(&name("main"), SessionId(1));
    answering(&stage.coordinator, &claim, "the first")?;
    let _sign = stage.coordinator.liveliness().declare_token(live(1)).wait()?;
    let second = stage.with("coordinator")?;
    let mut kept = Vec::new();
    for rogue in ["w-1", "ann", "mallory"] {
        let session = stage.with(rogue)?;
        assert_eq!(coordinators(&session)?, Vec::<String>::new(), "{rogue} sees coordinators");
        assert_eq!(answers(&session, &claim), Vec::<String>::new(), "{rogue} asks one");
        answering(&session, &claim, "a rogue")?;
        kept.push(session.liveliness().declare_token(live(2)).wait()?);
        assert_eq!(coordinators(&second)?, [live(1)], "beside {rogue}");
        assert_eq!(answers(&second, &claim), ["the first"], "beside {rogue}");
    }
    Ok(())
}

/// Now and `seconds` from now, as openssl writes times.
fn moment(seconds: i64) -> String {
    let when = format!("{seconds} seconds");
    let said = Command::new("date").args(["-u", "-d", &when, "+%Y%m%d%H%M%SZ"]).output();
    let said = said.expect("a date");
    String::from_utf8_lossy(&said.stdout).trim().to_owned()
}

/// What happens when a certificate ends while its link is up, though the one that shows it does not
/// care: the router ends the link, and takes no other.
#[test]
fn a_link_ends_when_its_certificate_does() -> Anything {
    let stage = Stage::set()?;
    let until = [("CULLET_UNTIL", moment(4))];
    let begun = Instant::now();
    certificates(stage.folder.path(), &["brief"], &until);
    let brief = stage.with("brief")?;
    assert_eq!(answers(&brief, &asks_worker("brief")), ["coordinator"], "as long as it is good");
    let place: PathBuf = stage.folder.path().join("brief");
    while !answers(&brief, &asks_worker("brief")).is_empty() {
        assert!(begun.elapsed() < Duration::from_secs(15), "the link outlives its certificate");
        std::thread::sleep(Duration::from_millis(100));
    }
    assert!(begun.elapsed() > Duration::from_secs(2), "it ended early: {:?}", begun.elapsed());
    assert!(session(&stage.endpoint, &place, false).is_err(), "an expired one is taken");
    assert_eq!(answers(&stage.with("w-1")?, &asks_worker("w-1")), ["coordinator"]);
    Ok(())
}
