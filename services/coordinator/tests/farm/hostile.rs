//! A submitter that means harm: whatever it sends is refused with a reason or ends as a run that
//! failed, the coordinator goes on, and nothing is read or written outside its folders.

use cullet_coordinator::{ServiceConfig, Store, serve};
use cullet_pool::{Pool, PoolConfig};
use cullet_proto::WorkerId;
use cullet_proto::keys::{self, UserVerb};
use cullet_proto::service::{
    BundleFile, BundleTable, RunInfo, State, Submit, SubmitAnswer, codes, seal,
};
use cullet_proto::transport::{self, Patience};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zenoh::Wait;

/// Longest wait for anything.
pub(crate) const BOUND: Duration = Duration::from_secs(20);
/// Most memory of the whole process after all of it \[KiB\].
const MOST: u64 = 2 << 20;

/// A coordinator in this process, and a client that keeps to nothing.
pub(crate) struct Farm {
    folder: Option<tempfile::TempDir>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    session: zenoh::Session,
}

impl Farm {
    fn start() -> Self {
        Self::bounded(None)
    }

    /// With a bound on what a user's runs hold \[bytes\].
    fn bounded(quota: Option<u64>) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        Self::at(folder, ServiceConfig { runs: 2, quota, ..ServiceConfig::default() })
    }

    /// In a folder that may have had another.
    pub(crate) fn at(folder: tempfile::TempDir, config: ServiceConfig) -> Self {
        let place = folder.path().join("inner/state");
        Self::open(folder, Some(&place), config)
    }

    /// `place`: the state folder; without one the folder has only the recordings.
    pub(crate) fn open(
        folder: tempfile::TempDir,
        place: Option<&Path>,
        config: ServiceConfig,
    ) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let store = Store::open(place).expect("a state folder");
        let pool = Pool::start(PoolConfig::default()).expect("a pool on loopback");
        let endpoint = [pool.endpoint().to_owned()];
        let told = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            serve(store, &Arc::new(pool), &config, &told, &mut |_| {}).expect("it serves");
        });
        let mut settings = zenoh::Config::default();
        for (path, value) in transport::client(&endpoint, Patience::production(), 5_000) {
            settings.insert_json5(path, &value).expect("a setting");
        }
        let session = zenoh::open(settings).wait().expect("a session");
        Self { folder: Some(folder), stop, thread: Some(thread), session }
    }

    /// Ends it, and leaves its folder.
    pub(crate) fn end(mut self) -> tempfile::TempDir {
        self.folder.take().expect("a folder")
    }

    /// Asks it to stop, and does not wait for it.
    pub(crate) fn ask_to_stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether it has ended.
    pub(crate) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    pub(crate) fn place(&self) -> &Path {
        self.folder.as_ref().expect("a folder").path()
    }

    /// The answer, or why there is none.
    pub(crate) fn ask(&self, verb: UserVerb, bytes: &[u8]) -> Result<Vec<u8>, String> {
        self.ask_as("mallory", verb, bytes)
    }

    fn ask_as(&self, user: &str, verb: UserVerb, bytes: &[u8]) -> Result<Vec<u8>, String> {
        let name = |text| WorkerId::new(text).expect("a name");
        let key = keys::user_rpc(&name("main"), &name(user), verb);
        let begun = Instant::now();
        loop {
            let get = self.session.get(&key).payload(bytes).timeout(Duration::from_secs(5));
            if let Some(reply) = get.wait().ok().and_then(|replies| replies.recv().ok()) {
                return match reply.into_result() {
                    Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
                    Err(error) => {
                        let bytes = error.payload().to_bytes();
                        let said: Value = serde_json::from_slice(&bytes).unwrap_or_default();
                        Err(said["error"].as_str().unwrap_or("no words").to_owned())
                    }
                };
            }
            assert!(begun.elapsed() < BOUND, "the coordinator is silent");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// How a run of these files ends.
    fn run(&self, ticket: &str, files: &[(&str, &[u8])]) -> RunInfo {
        let said = self.ask(UserVerb::Submit, &submission(ticket, "pot", files)).expect("taken");
        let SubmitAnswer::Accepted { run } = serde_json::from_slice(&said).expect("an answer")
        else {
            panic!("{}", String::from_utf8_lossy(&said));
        };
        let begun = Instant::now();
        loop {
            let said = self.ask(UserVerb::Run, json!({"run": run}).to_string().as_bytes());
            let info: RunInfo = serde_json::from_slice(&said.expect("a run")).expect("a run");
            if info.state.is_over() {
                // Nobody waits for us in the end.
                let bye = self.ask(UserVerb::Bye, json!({"run": run}).to_string().as_bytes());
                assert!(bye.is_ok(), "{bye:?}");
                return info;
            }
            assert!(begun.elapsed() < BOUND, "{ticket}: it never ends");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Farm {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

fn bundle(name: &str, files: &[(&str, &[u8])]) -> Vec<u8> {
    let row = |(key, bytes): &(&str, &[u8])| BundleFile {
        key: (*key).to_owned(),
        length: bytes.len() as u64,
    };
    let main = files.first().map_or("", |file| file.0).to_owned();
    let table = BundleTable { name: name.to_owned(), main, files: files.iter().map(row).collect() };
    let bulk: Vec<u8> = files.iter().flat_map(|file| file.1).copied().collect();
    seal(&table, &bulk).expect("a bundle")
}

pub(crate) fn submission(ticket: &str, name: &str, files: &[(&str, &[u8])]) -> Vec<u8> {
    let submit = Submit { ticket: ticket.to_owned(), ..Submit::default() };
    seal(&submit, &bundle(name, files)).expect("a submission")
}

pub(crate) const SCENE: &str = "scene/scene.toml";
const PLAIN: &[u8] = b"[world]\nduration = 0.1\n";
/// One that comes to its end without breaking anything.
const FALLING: &[u8] =
    b"[world]\nduration = 0.05\n[[body]]\nname = \"a\"\nmaterial = \"plaster\"\n\
    position = [0, 0, 5]\nshape = { kind = \"box\", size = [0.1, 0.1, 0.1] }\n";

fn questions() -> Vec<(UserVerb, Vec<u8>, &'static str)> {
    let many: Vec<String> = (0..513).map(|k| format!("scene/{k}")).collect();
    let many: Vec<(&str, &[u8])> = many.iter().map(|key| (key.as_str(), &b""[..])).collect();
    let text = |value: Value| value.to_string().into_bytes();
    let submit = |bundle: &str| format!("{{\"ticket\":\"t\"}}\n{bundle}").into_bytes();
    let (deep, ticket) = ("[".repeat(1 << 20), "t".repeat(65));
    let all = vec![
        (UserVerb::Submit, submit(&deep), "does not decode"),
        (UserVerb::Submit, deep.into_bytes(), "does not decode"),
        (UserVerb::Submit, vec![b' '; 5 << 20], "the limit is"),
        (UserVerb::Submit, vec![0xff; 100], "does not decode"),
        (UserVerb::Submit, submission("a", "../evil", &[(SCENE, PLAIN)]), "'..'"),
        (UserVerb::Submit, submission("b", "/tmp/evil", &[(SCENE, PLAIN)]), "absolute"),
        (UserVerb::Submit, submission("c", "a/b", &[(SCENE, PLAIN)]), "slash"),
        (UserVerb::Submit, submission("d", "many", &many), "the limit is 512"),
        (UserVerb::Submit, submission("e", "twice", &[(SCENE, PLAIN), (SCENE, PLAIN)]), "twice"),
        (UserVerb::Submit, submission(&ticket, "pot", &[(SCENE, PLAIN)]), "the limit is 64"),
        (UserVerb::Submit, submission("", "pot", &[(SCENE, PLAIN)]), "a ticket"),
        (
            UserVerb::Submit,
            submit(
                r#"{"name":"a","main":"b","files":[{"key":"b","length":18446744073709551615}]}"#,
            ),
            "the limit is 268435456",
        ),
        (
            UserVerb::Submit,
            submit(r#"{"name":"a","main":"b","files":[{"key":"b","length":99}]}"#),
            "0 bytes of 99",
        ),
        (
            UserVerb::Submit,
            text(json!({"ticket": "f", "digest": "0".repeat(64), "length": u64::MAX})),
            "the limit is",
        ),
        (UserVerb::Submit, text(json!({"ticket": "g", "digest": "zz"})), "64 hex digits"),
        (UserVerb::Submit, text(json!({"ticket": "h", "evil": 1})), "unknown field"),
        (
            UserVerb::Submit,
            text(json!({"ticket": "i", "overrides": vec!["a=1"; 1025]})),
            "the limit is 1024",
        ),
        (
            UserVerb::Submit,
            text(json!({"ticket": "j", "overrides": ["a".repeat(4097)]})),
            "the limit is 4096",
        ),
        (
            UserVerb::Submit,
            text(json!({"ticket": "k", "overrides": vec!["a".repeat(4096); 17]})),
            "the limit is 65536",
        ),
        (
            UserVerb::Piece,
            text(json!({"digest": "0".repeat(64), "length": 1u64 << 40, "index": 0})),
            "the limit is",
        ),
        (
            UserVerb::Piece,
            text(json!({"digest": "1".repeat(64), "length": 10, "index": u32::MAX})),
            "",
        ),
        (UserVerb::Follow, text(json!({"run": u64::MAX, "from": u64::MAX})), "no run"),
        (UserVerb::Drain, text(json!({"worker": "../evil"})), "no worker"),
    ];
    all
}

#[test]
fn questions_that_mean_harm_are_refused_in_words() {
    let farm = Farm::start();
    for (verb, bytes, words) in questions() {
        let start = String::from_utf8_lossy(&bytes[..bytes.len().min(90)]).into_owned();
        let why = farm.ask(verb, &bytes).map(|said| String::from_utf8_lossy(&said).into_owned());
        let why = why.expect_err(&start);
        assert!(why.contains(words), "{start}: {words:?} is not in {why:?}");
        assert!(why.len() < 2_000, "{start}: {} bytes of words", why.len());
    }
    let sound = farm.run("sound", &[(SCENE, FALLING)]);
    assert!(sound.files.len() > 1, "{sound:?}");
    for file in ["../../../journal", "../../cullet-state", "/etc/passwd", "run.mcap\0", "bundle"] {
        let ask = json!({"run": sound.run, "file": file, "index": 0}).to_string();
        let why = farm.ask(UserVerb::Fetch, ask.as_bytes()).expect_err(file);
        assert!(why.contains("has no file"), "{file}: {why}");
    }
    // Beyond its end a file has nothing, and that is no error.
    let long = sound.files.iter().find(|file| file.name == "run.mcap").expect("a recording");
    for index in [long.length.div_ceil(1 << 20), u64::from(u32::MAX)] {
        let ask = json!({"run": sound.run, "file": "run.mcap", "index": index}).to_string();
        let said = farm.ask(UserVerb::Fetch, ask.as_bytes()).expect("an answer");
        assert_eq!(String::from_utf8_lossy(&said), r#"{"sum":0}"#);
    }
    let bye = json!({"run": sound.run}).to_string();
    assert!(farm.ask(UserVerb::Bye, bye.as_bytes()).is_ok());
    only_its_own(farm.place());
}

/// A body that is made of a file.
fn meshed(path: &str) -> Vec<u8> {
    let text = "[world]\nduration = 0.1\n[[body]]\nname = \"a\"\nmaterial = \"plaster\"\n";
    format!("{text}mesh = {path:?}\n").into_bytes()
}

/// A file's name and what it holds.
type NamedFile = (&'static str, Vec<u8>);

fn scenes() -> Vec<(&'static str, Vec<u8>, Vec<NamedFile>)> {
    let ply = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n\
               property float x\nproperty float y\nproperty float z\n\
               element face 4000000000\nproperty list uchar int vertex_indices\nend_header\n";
    let stl = [&[0; 80][..], &u32::MAX.to_le_bytes(), &[0; 50]].concat();
    let number = |set: &str| format!("[world]\n{set}\n").into_bytes();
    let gltf = "[".repeat(200_000);
    let glb = [b"glTF\x02\0\0\0\xff\xff\xff\xff\xff\xff\xff\xffJSON".as_slice(), &[0; 20]].concat();
    let accessor = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4000000000,"uri":
        "/etc/passwd"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]}"#;
    let sized = |size: &str| {
        let text = "[[body]]\nname = \"a\"\nmaterial = \"plaster\"\nposition = [0, 0, 5]\n";
        let shape = format!("shape = {{ kind = \"box\", size = {size} }}\n");
        format!("[world]\nduration = 0.1\n{text}{shape}").into_bytes()
    };
    let fan = |next: &str| format!("include = [{}]\n", vec![format!("{next:?}"); 64].join(", "));
    let layers = ["1", "2", "3", "4", "5", "6", "7", "8"];
    let keys = ["scene/1", "scene/2", "scene/3", "scene/4", "scene/5", "scene/6", "scene/7"];
    let mut fans: Vec<NamedFile> =
        keys.iter().zip(&layers[1..]).map(|(key, next)| (*key, fan(next).into_bytes())).collect();
    fans.push(("scene/8", b"# the end\n".to_vec()));
    let typos: String =
        (0..20_000).map(|n| format!("[[body]]\nname = \"b{n}\"\nmateriel = 1\n")).collect();
    vec![
        ("fans", fan("1").into_bytes(), fans),
        ("typos", typos.into_bytes(), vec![]),
        ("outside", meshed("../../../../../../etc/passwd"), vec![]),
        ("absolute", meshed("/etc/passwd"), vec![]),
        ("device", meshed("/dev/zero"), vec![]),
        ("include", b"include = [\"/etc/passwd\"]\n".to_vec(), vec![]),
        ("itself", b"include = [\"scene.toml\"]\n".to_vec(), vec![]),
        ("ply", meshed("a.ply"), vec![("scene/a.ply", ply.as_bytes().to_vec())]),
        ("stl", meshed("a.stl"), vec![("scene/a.stl", stl)]),
        ("gltf", meshed("a.gltf"), vec![("scene/a.gltf", gltf.into_bytes())]),
        ("accessor", meshed("a.gltf"), vec![("scene/a.gltf", accessor.as_bytes().to_vec())]),
        ("glb", meshed("a.glb"), vec![("scene/a.glb", glb)]),
        ("long", number("duration = 1e300"), vec![]),
        ("infinite", number("duration = inf"), vec![]),
        ("negative", number("seed = -9223372036854775808"), vec![]),
        ("particles", b"[fracture]\nmax_particles = 9223372036854775807\n".to_vec(), vec![]),
        ("large", sized("[1e308, 1e308, 1e308]"), vec![]),
        ("small", sized("[1e-308, 1e-308, 1e-308]"), vec![]),
        ("arrays", format!("a = {}", "[".repeat(500_000)).into_bytes(), vec![]),
        ("tables", format!("a = {}", "{b=".repeat(200_000)).into_bytes(), vec![]),
        ("dots", format!("[{}a]", "a.".repeat(200_000)).into_bytes(), vec![]),
        ("keys", format!("{}a = 1", "a.".repeat(200_000)).into_bytes(), vec![]),
        ("bytes", vec![0xff; 1000], vec![]),
    ]
}

#[test]
fn scenes_that_mean_harm_fail_in_words_and_the_coordinator_goes_on() {
    let farm = Farm::start();
    for (name, scene, more) in scenes() {
        let mut files: Vec<(&str, &[u8])> = vec![(SCENE, &scene)];
        files.extend(more.iter().map(|(key, bytes)| (*key, bytes.as_slice())));
        let begun = Instant::now();
        let info = farm.run(name, &files);
        assert_eq!(
            (info.state, info.code),
            (State::Failed, Some(codes::UNFIT)),
            "{name}: {info:?}"
        );
        assert!(!info.text.contains("root:"), "{name} is told what a file holds: {}", info.text);
        assert!(!info.text.is_empty() && info.text.len() < 10_000, "{name}: {}", info.text);
        assert!(begun.elapsed() < BOUND, "{name} takes {:?}", begun.elapsed());
    }
    assert!(farm.ask(UserVerb::About, b"{}").is_ok());
    only_its_own(farm.place());
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let most = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let most = most.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
    assert!(most.is_none_or(|most| most < MOST), "{most:?} KiB of memory were held");
}

/// Nothing is beside the state folder, and nothing in it that is not its own.
fn only_its_own(folder: &Path) {
    let names = |folder: &Path| -> Vec<String> {
        let all = std::fs::read_dir(folder).expect("a folder").flatten();
        let mut names: Vec<String> =
            all.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    assert_eq!(names(folder), ["inner"]);
    assert_eq!(names(&folder.join("inner")), ["state"]);
    let known = ["cullet-state", "incarnation", "journal", "lock", "numbers", "recordings", "runs"];
    assert_eq!(names(&folder.join("inner/state")), known);
}

#[test]
fn a_user_who_holds_as_much_disk_as_one_may_hands_in_no_more_and_others_do() {
    let farm = Farm::bounded(Some(2 << 20));
    let ballast = vec![7; 700 << 10];
    let files = [(SCENE, FALLING), ("scene/ballast", &ballast[..])];
    for ticket in ["one", "two"] {
        let info = farm.run(ticket, &files);
        assert_eq!(info.state, State::Done, "{info:?}");
    }
    let third = submission("three", "pot", &files);
    let said = farm.ask(UserVerb::Submit, &third).expect_err("it is too much");
    let (used, rest) = said
        .strip_prefix("the runs of mallory hold ")
        .and_then(|rest| rest.split_once(" bytes"))
        .unwrap_or_else(|| panic!("{said}"));
    let used: u64 = used.parse().expect("a number");
    assert!(((2 * 700) << 10..2 << 20).contains(&used), "{said}");
    assert!(rest.ends_with(&format!("a user may hold {}", 2 << 20)), "{said}");
    // What is deleted makes room at once.
    let gone = json!({"run": 1}).to_string();
    assert!(farm.ask(UserVerb::Delete, gone.as_bytes()).is_ok());
    let again = farm.ask(UserVerb::Submit, &third).expect("there is room");
    let answer: Value = serde_json::from_slice(&again).expect("JSON");
    assert_eq!(answer["run"], 3, "{answer}");
    // What is small has room still, and what is another's too.
    assert_eq!(farm.run("small", &[(SCENE, FALLING)]).state, State::Done);
    assert!(farm.ask_as("ann", UserVerb::Submit, &third).is_ok());
}

#[test]
fn a_run_that_records_more_than_its_user_may_hold_fails_and_says_so() {
    let farm = Farm::bounded(Some(60 << 10));
    let body = |k: usize| {
        format!(
            "[[body]]\nname = \"b{k}\"\nmaterial = \"plaster\"\nposition = [{k}, 0, 5]\n\
             shape = {{ kind = \"box\", size = [0.1, 0.1, 0.1] }}\n"
        )
    };
    let bodies: String = (0..100).map(body).collect();
    let long = format!("[world]\nduration = 600.0\n{bodies}");
    let info = farm.run("long", &[(SCENE, long.as_bytes())]);
    assert_eq!((info.state, info.code), (State::Failed, Some(codes::UNKEPT)), "{info:?}");
    let words = "more than the 61440 that a user may hold";
    assert!(info.text.contains("mallory") && info.text.ends_with(words), "{info:?}");
    // What there is of it can be fetched.
    assert!(info.files.iter().any(|file| file.name == "run.mcap"), "{info:?}");
}

/// Whoever fills the room for bundles that come in pieces keeps nobody else out: with pieces that
/// nobody asked for, and with the ends of bundles that are asked for and never come.
#[test]
fn pieces_of_one_user_keep_the_bundle_of_another_out_at_no_time() {
    let farm = Farm::start();
    let hex = |k: u64| format!("{k:064x}");
    let end = |k: u64| {
        let piece = json!({"digest": hex(k), "length": 512 << 20, "index": 511}).to_string();
        [piece.as_bytes(), b"\n", &vec![7; 1 << 20]].concat()
    };
    for k in 0..8 {
        farm.ask(UserVerb::Piece, &end(k)).expect("an answer");
    }
    for k in 8..72 {
        let submit = json!({"ticket": hex(k), "digest": hex(k), "length": 512 << 20});
        let said = farm.ask(UserVerb::Submit, submit.to_string().as_bytes()).expect("an answer");
        assert!(String::from_utf8_lossy(&said).contains("missing"));
        if k < 16 {
            farm.ask(UserVerb::Piece, &end(k)).expect("an answer");
        }
    }
    let filler = vec![b'#'; (2 << 20) + 5];
    let blob = bundle("pot", &[(SCENE, FALLING), ("scene/filler", &filler)]);
    let name = cullet_proto::service::hex_of(&cullet_proto::ids::digest(&blob));
    let submit = json!({"ticket": "t", "digest": name, "length": blob.len()}).to_string();
    let hand_in = || {
        let said = farm.ask_as("ann", UserVerb::Submit, submit.as_bytes()).expect("an answer");
        serde_json::from_slice::<SubmitAnswer>(&said).expect("an answer")
    };
    assert_eq!(hand_in(), SubmitAnswer::Missing { pieces: vec![0, 1, 2] });
    for (index, bytes) in blob.chunks(1 << 20).enumerate() {
        let piece = json!({"digest": name, "length": blob.len(), "index": index}).to_string();
        let piece = [piece.as_bytes(), b"\n", bytes].concat();
        let said = farm.ask_as("ann", UserVerb::Piece, &piece).expect("an answer");
        assert_eq!(String::from_utf8_lossy(&said).trim(), r#"{"piece":"have"}"#, "{index}");
    }
    assert_eq!(hand_in(), SubmitAnswer::Accepted { run: 1 });
}

/// A journal that is as long as it may be takes no run, says so, and has lost none when the
/// coordinator is back; what is deleted makes room.
#[test]
fn a_journal_that_is_full_takes_no_run_and_forgets_none() {
    let config = || ServiceConfig { runs: 1, journal: Some(400_000), ..ServiceConfig::default() };
    let farm = Farm::at(tempfile::tempdir().expect("a folder"), config());
    // Each takes six times as much room in JSON.
    let set = vec![format!("world.gravity={}", "\u{1}".repeat(4_000)); 8];
    let hand_in = |farm: &Farm, ticket: &str| {
        let submit = json!({"ticket": ticket, "overrides": set}).to_string();
        let blob = bundle("pot", &[(SCENE, PLAIN)]);
        farm.ask(UserVerb::Submit, &[submit.as_bytes(), b"\n", &blob].concat())
    };
    let mut accepted = 0;
    let said = loop {
        match hand_in(&farm, &accepted.to_string()) {
            Ok(_) => accepted += 1,
            Err(said) => break said,
        }
        assert!(accepted < 10, "it has no bound");
    };
    assert!(accepted >= 1 && said.contains("it takes at most 400000"), "{accepted}: {said}");
    let runs = |farm: &Farm| {
        let said = farm.ask(UserVerb::Runs, b"{}").expect("runs");
        let said: Value = serde_json::from_slice(&said).expect("JSON");
        said["runs"].as_array().expect("runs").len()
    };
    let farm = Farm::at(farm.end(), config());
    assert_eq!(runs(&farm), accepted);
    assert!(hand_in(&farm, "again").is_err(), "there is room without cause");
    for run in 1..=accepted {
        let gone = json!({"run": run}).to_string();
        let begun = Instant::now();
        while farm.ask(UserVerb::Delete, gone.as_bytes()).is_err() {
            assert!(begun.elapsed() < BOUND, "the run does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
    hand_in(&farm, "again").expect("there is room");
    assert_eq!(runs(&farm), 1);
}
