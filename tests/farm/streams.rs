//! What a process is given by whoever starts it: standard streams that cannot be written, few
//! files, signals of a terminal that goes away; and what it shows there of text from others.
#![cfg(target_os = "linux")]

use crate::common;

use common::{Cullet, DONE, Going, Said, corpus, free_endpoint, signal, unique, until};
use cullet_pool::client::{Client, Terms};
use cullet_scene::load;
use serde_json::Value;
use std::fs::{self, File};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(300);
/// Longest that a process may take to end, or to say why it does not begin.
const SOON: Duration = Duration::from_secs(20);

/// A stream that takes nothing, and what it is called.
type Nowhere = (&'static str, fn() -> Stdio);

/// A full disk, and a pipe that nobody reads.
const NOWHERE: [Nowhere; 2] = [("a full disk", full), ("a closed pipe", closed)];

fn full() -> Stdio {
    File::options().write(true).open("/dev/full").expect("Linux has it").into()
}

fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

fn ask(endpoint: &str, args: &[&str]) -> Said {
    Cullet::new(args).args(&["--connect", endpoint]).output()
}

fn answers(endpoint: &str) {
    until("it answers", LONG, || ask(endpoint, &["ps", "--patience", "3"]).code == 0);
}

fn digest(out: &Path) -> Value {
    common::summary(out)["digest"].clone()
}

#[test]
fn a_run_ends_well_where_nobody_hears_what_it_says() {
    let _left = common::left::NobodyLeft::watch();
    let want = common::quiet_digest(&[]);
    for (what, nowhere) in NOWHERE {
        for more in [&["-v"][..], &["--log", "json"]] {
            let out = unique("unheard");
            let call = ["run", &corpus("drop.toml"), "--workers", "1", "--no-pictures", "--out"];
            let call = Cullet::new(&call).path(&out).args(more);
            let code = call.errors(nowhere()).spawn().wait(LONG);
            assert!(code.is_some_and(|code| DONE.contains(&code)), "{what}: {more:?}: {code:?}");
            assert_eq!(digest(&out), want, "{what}");
        }
    }
}

#[test]
fn a_farm_works_where_nobody_hears_what_it_says() {
    let _left = common::left::NobodyLeft::watch();
    let want = common::quiet_digest(&[]);
    for (what, nowhere) in NOWHERE {
        let endpoint = free_endpoint();
        let deaf = |args: &[&str]| Cullet::new(args).errors(nowhere()).prints(nowhere()).spawn();
        let mut coordinator = deaf(&["coordinator", "--listen", &endpoint, "-v"]);
        let mut worker = deaf(&["worker", "--connect", &endpoint, "-v"]);
        answers(&endpoint);
        for more in [&[][..], &["--watch"]] {
            let out = unique("unheard");
            let call = ["submit", &corpus("drop.toml"), "--connect", &endpoint, "--out"];
            let call = Cullet::new(&call).path(&out).args(more);
            let code = call.errors(nowhere()).spawn().wait(LONG);
            assert!(code.is_some_and(|code| DONE.contains(&code)), "{what}: {more:?}: {code:?}");
            assert_eq!(digest(&out), want, "{what}: it is not fetched");
        }
        let code = deaf(&["show", "77", "--connect", &endpoint]).wait(LONG);
        assert_eq!(code, Some(66), "{what}: an error is what it is, heard or not");
        assert_eq!(deaf(&["no-command"]).wait(SOON), Some(64), "{what}");
        for process in [&mut worker, &mut coordinator] {
            assert!(!process.ended(), "{what}: it ended");
            signal(process.id(), "TERM");
            assert_eq!(process.wait(SOON), Some(0), "{what}");
        }
    }
}

#[test]
fn a_result_that_is_not_written_is_told_and_a_reader_who_leaves_is_not() {
    let out = unique("printed");
    let call = ["run", &corpus("drop.toml"), "-q", "--no-pictures", "--out"];
    assert!(DONE.contains(&Cullet::new(&call).path(&out).output().code));
    let recording = out.join("run.mcap").to_string_lossy().into_owned();
    let scene = corpus("drop.toml");
    let calls: [&[&str]; 8] = [
        &["inspect", &recording],
        &["inspect", "--json", &recording],
        &["inspect", "--masses", &recording],
        &["check", &scene],
        &["schema"],
        &["materials"],
        &["--help"],
        &["--version"],
    ];
    for call in calls {
        let said = Cullet::new(call).prints(full()).output();
        assert_eq!(said.code, 74, "{call:?}: {}", said.stderr);
        assert!(said.stderr.contains("standard output: No space left"), "{}", said.stderr);
        assert!(!said.stderr.contains("panicked"), "{call:?}: {}", said.stderr);
        let deaf = Cullet::new(call).prints(full()).errors(full()).output();
        assert_eq!(deaf.code, 74, "{call:?}");
        let said = Cullet::new(call).prints(closed()).output();
        assert_eq!((said.code, said.stderr.as_str()), (0, ""), "{call:?}");
    }
}

/// Asks a terminal for a title, clears it, goes back, turns what follows around.
const EVIL: &str = "\u{1b}]0;title\u{7}\u{9b}2J\r\u{202e}x\nrun 9: done";

fn is_tame(what: &str, text: &str) {
    let acts = |c: char| (c.is_control() && c != '\n') || ('\u{202a}'..='\u{202e}').contains(&c);
    assert!(!text.contains(acts), "{what}: {text:?}");
    assert!(!text.lines().any(|line| line == "run 9: done"), "{what}: a line of theirs: {text}");
}

/// Hands in runs whose sweep, name and overrides mean harm.
fn hand_in(endpoint: &str) {
    let client = Client::connect(endpoint).expect("a link");
    let set = vec!["world.duration=0.02".to_owned()];
    let scene = load(Path::new(&corpus("drop.toml")), &set).expect("a scene");
    let mut bundle = scene.bundle();
    bundle.name = format!("po\u{202e}t{}", "-and-on".repeat(20));
    for ticket in ["one", "two"] {
        let terms = Terms { ticket: ticket.into(), sweep: EVIL.into(), ..Terms::default() };
        client.submit(&bundle, &terms).expect("it is taken");
        bundle.overrides.push(format!("\"{EVIL}\"=1"));
    }
}

#[test]
fn text_of_others_does_nothing_to_a_terminal() {
    let endpoint = free_endpoint();
    let call = ["coordinator", "--listen", &endpoint, "--workers", "1", "-v"];
    let mut coordinator = Cullet::new(&call).spawn();
    answers(&endpoint);
    hand_in(&endpoint);
    for run in ["1", "2"] {
        for verb in ["wait", "watch", "show", "logs", "fetch", "cancel"] {
            let out = unique("tame").to_string_lossy().into_owned();
            let to = if verb == "fetch" { &["--out", &out][..] } else { &[] };
            let said = ask(&endpoint, &[&[verb, run], to].concat());
            is_tame(verb, &said.stdout);
            is_tame(verb, &said.stderr);
        }
    }
    let shown = ask(&endpoint, &["show", "2"]).stdout;
    assert!(shown.contains(r"--set "), "{shown}");
    assert!(shown.contains(r#""\u001b]0;title\u0007\u009b2J\r\u202ex\nrun 9: done"=1"#), "{shown}");
    let listed = ask(&endpoint, &["ps"]).stdout;
    is_tame("ps", &listed);
    assert_eq!(listed.lines().count(), 3, "{listed}");
    let row = listed.lines().nth(1).expect("a row");
    assert!(row.contains('…') && row.chars().count() < 200, "a long name fills the row: {row}");
    // Programs have it to the letter.
    let json = ask(&endpoint, &["show", "2", "--json"]).stdout;
    is_tame("JSON", &json);
    let run: Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(run["sweep"], EVIL);
    assert!(run["overrides"][1].as_str().is_some_and(|set| set.contains(EVIL)), "{run}");
    signal(coordinator.id(), "TERM");
    assert_eq!(coordinator.wait(SOON), Some(0));
    let told = coordinator.stderr();
    assert!(told.contains("title"), "it said nothing of it: {told}");
    is_tame("the coordinator", &told);
    let folder = unique("named");
    fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join(format!("{EVIL}.toml").replace('/', "-"));
    fs::write(&file, "[world]\nduration = \"long\"\n").expect("a scene");
    for verb in ["check", "inspect", "recover"] {
        let said = Cullet::new(&[verb]).path(&file).output();
        assert_ne!(said.code, 0, "{verb}");
        is_tame(verb, &said.stderr);
        is_tame(verb, &said.stdout);
    }
    let wrong = format!("--no{EVIL}");
    is_tame("an argument", &Cullet::new(&["check", &wrong]).output().stderr);
}

/// A call of the program in a shell, after some words of it.
fn after(words: &str, args: &[&str]) -> Cullet {
    let script = format!("{words}; exec \"$@\"");
    let program = env!("CARGO_BIN_EXE_cullet");
    Cullet::of(Path::new("sh"), &["-c", &script, "sh", program]).args(args)
}

/// It says how many files it needs, or does what it was asked to.
fn works_or_says_why(files: u32, mut process: Going, works: impl FnOnce(&mut Going)) -> bool {
    // Who fails does so at the start.
    let Some(code) = process.wait(Duration::from_secs(2)) else {
        works(&mut process);
        signal(process.id(), "TERM");
        assert_eq!(process.wait(SOON), Some(0), "{files} files: {}", process.stderr());
        return true;
    };
    let said = process.stderr();
    assert_eq!(code, 70, "{files} files: {said}");
    let words = format!("may have {files} files and connections open, and needs at least");
    assert!(said.contains(&words), "{said}");
    false
}

#[test]
fn with_few_files_a_process_works_or_says_why_it_does_not() {
    let _left = common::left::NobodyLeft::watch();
    let drop = corpus("drop.toml");
    for files in [12, 16, 20, 24, 28, 32, 64] {
        let words = format!("ulimit -n {files}");
        let endpoint = free_endpoint();
        let call = ["coordinator", "--listen", &endpoint, "--workers", "1"];
        let coordinator = after(&words, &call).spawn();
        let works = [
            works_or_says_why(files, coordinator, |_| answers(&endpoint)),
            works_or_says_why(
                files,
                after(&words, &["router", "--listen", &endpoint]).spawn(),
                |_| {
                    let place = endpoint.trim_start_matches("tcp/");
                    until("it listens", SOON, || std::net::TcpStream::connect(place).is_ok());
                },
            ),
            works_or_says_why(
                files,
                after(&words, &["worker", "--connect", &endpoint]).spawn(),
                |_| {},
            ),
        ];
        assert_eq!(works, [files >= 64; 3], "{files} files");
        let out = unique("few");
        let call = ["run", &drop, "--workers", "1", "-q", "--no-pictures", "--out"];
        let mut run = after(&words, &call).path(&out).spawn();
        let code = run.wait(LONG).expect("it ends");
        let said = run.stderr();
        let good = DONE.contains(&code) || (code == 70 && said.contains("ulimit -n"));
        assert!(good, "{files} files: {code}: {said}");
        let call = ["ps", "--connect", &endpoint, "--patience", "0.2"];
        let said = after(&words, &call).output();
        assert_eq!(said.code, if files < 32 { 70 } else { 69 }, "{files} files: {}", said.stderr);
        assert!(!said.stderr.contains("panicked"), "{}", said.stderr);
    }
    // A bound that is not the last word is raised.
    let (words, out) = ("ulimit -Sn 20", unique("soft"));
    let call = ["run", &drop, "--workers", "1", "-q", "--no-pictures", "--out"];
    let said = after(words, &call).path(&out).output();
    assert!(DONE.contains(&said.code), "{}", said.stderr);
}

#[test]
fn a_terminal_that_goes_away_ends_a_process_in_order_unless_it_was_told_to_stay() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = free_endpoint();
    let listens = ["coordinator", "--listen", &endpoint, "--workers", "1"];
    let mut coordinator = Cullet::new(&listens).spawn();
    let mut worker = Cullet::new(&["worker", "--connect", &endpoint]).spawn();
    let mut router = Cullet::new(&["router", "--listen", &free_endpoint()]).spawn();
    answers(&endpoint);
    let out = unique("hangup");
    let call = ["run", &corpus("drop.toml"), "--workers", "1", "--no-pictures", "--out"];
    let mut run = Cullet::new(&call).path(&out).args(&common::LONGER).spawn();
    until("it records", LONG, || out.join("run.mcap.partial").exists());
    signal(run.id(), "HUP");
    assert_eq!(run.wait(LONG), Some(130), "{}", run.stderr());
    assert!(out.join("run.mcap").is_file(), "the recording is not finished");
    assert!(!out.join("run.mcap.partial").exists());
    for process in [&mut worker, &mut router, &mut coordinator] {
        signal(process.id(), "HUP");
        assert_eq!(process.wait(SOON), Some(0), "{}", process.stderr());
        assert!(process.stderr().contains("stopping"));
    }
    // As `nohup` starts it.
    let mut stays = after("trap '' HUP", &listens).spawn();
    answers(&endpoint);
    signal(stays.id(), "HUP");
    answers(&endpoint);
    assert!(!stays.ended());
    signal(stays.id(), "TERM");
    assert_eq!(stays.wait(SOON), Some(0), "{}", stays.stderr());
}

/// A way to spoil a file.
type Spoil = fn(&Path);

fn empty(path: &Path) {
    fs::write(path, "").expect("a file");
}

fn text(path: &Path) {
    fs::write(path, "no PEM\n").expect("a file");
}

fn half(path: &Path) {
    let whole = fs::read(path).expect("PEM");
    fs::write(path, &whole[..whole.len() / 2]).expect("a file");
}

fn gone(path: &Path) {
    fs::remove_file(path).expect("it goes");
}

fn folder(path: &Path) {
    gone(path);
    fs::create_dir(path).expect("a folder");
}

/// That of another, from the folder beside.
fn others(path: &Path) {
    let beside = path.parent().and_then(Path::parent).expect("a folder").join("olga");
    fs::copy(beside.join(path.file_name().expect("a name")), path).expect("a copy");
}

/// Which file is spoilt how, the exit code, and what is said of it.
const SPOILT: [(&str, Spoil, i32, &str); 12] = [
    ("key.pem", empty, 64, "it is empty; there must be a private key"),
    ("key.pem", text, 64, "there is no private key in PEM in it"),
    ("key.pem", half, 64, "private key in PEM"),
    ("key.pem", folder, 64, "it is a folder, not a file with a private key"),
    ("key.pem", gone, 74, "No such file"),
    ("key.pem", others, 64, "it is no key of cert.pem beside it"),
    ("ca.pem", empty, 64, "it is empty; there must be a certificate"),
    ("ca.pem", text, 64, "there is no certificate in PEM in it"),
    ("ca.pem", folder, 64, "it is a folder, not a file with a certificate"),
    ("cert.pem", empty, 64, "it is empty; there must be a certificate"),
    ("cert.pem", folder, 64, "it is a folder, not a file with a certificate"),
    ("cert.pem", half, 64, "certificate in PEM"),
];

#[test]
fn a_file_of_an_identity_that_is_not_one_is_named() {
    let base = unique("identities");
    fs::create_dir_all(&base).expect("a folder");
    common::certificates(&base, &["coordinator", "ann", "olga"], &[]);
    fs::write(base.join("roles.toml"), "users = [\"ann\"]\n").expect("roles");
    let tls = free_endpoint().replace("tcp/", "tls/");
    let roles = base.join("roles.toml").to_string_lossy().into_owned();
    let names = ["ca.pem", "cert.pem", "key.pem"];
    for (index, (file, spoil, code, words)) in SPOILT.into_iter().enumerate() {
        let identity = base.join(format!("spoilt-{index}"));
        fs::create_dir(&identity).expect("a folder");
        for name in names {
            fs::copy(base.join("coordinator").join(name), identity.join(name)).expect("a copy");
        }
        spoil(&identity.join(file));
        let place = identity.join(file).to_string_lossy().into_owned();
        let identity = identity.to_string_lossy().into_owned();
        let calls: [&[&str]; 3] = [
            &["coordinator", "--listen", &tls, "--roles", &roles, "--tls", &identity],
            &["worker", "--connect", &tls, "--tls", &identity],
            &["ps", "--connect", &tls, "--patience", "1", "--tls", &identity],
        ];
        for call in calls {
            let mut process = Cullet::new(call).spawn();
            let ended = process.wait(SOON);
            let said = process.stderr();
            assert_eq!(ended, Some(code), "{}: {file}: {said}", call[0]);
            assert!(said.contains(words) && said.contains(&place), "{file}: {words}: {said}");
        }
    }
    let file = base.join("ann/cert.pem").to_string_lossy().into_owned();
    let said = Cullet::new(&["ps", "--connect", &tls, "--tls", &file]).output();
    assert_eq!(said.code, 64, "{}", said.stderr);
    assert!(
        said.stderr.contains("it is a file; --tls takes a folder with ca.pem"),
        "{}",
        said.stderr
    );
}
