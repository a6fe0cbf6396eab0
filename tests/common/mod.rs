//! What the suites over the binary share.
#![allow(dead_code, reason = "each suite uses its own part")]

pub(crate) mod desk;
pub(crate) mod farm;
pub(crate) mod figures;
pub(crate) mod history;
pub(crate) mod left;
pub(crate) mod proxy;

use std::fs::OpenOptions;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant, UNIX_EPOCH};

/// A call of the binary under test.
pub(crate) struct Cullet(Command);

/// What a finished call said.
pub(crate) struct Said {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// A call that goes on; it is killed when dropped.
pub(crate) struct Going(Child);

impl Cullet {
    pub(crate) fn new(args: &[&str]) -> Self {
        Self::of(Path::new(env!("CARGO_BIN_EXE_cullet")), args)
    }

    /// A call of a copy of the binary.
    pub(crate) fn of(program: &Path, args: &[&str]) -> Self {
        let mut command = Command::new(program);
        command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        left::mark(&mut command);
        Self(command)
    }

    pub(crate) fn args(mut self, args: &[&str]) -> Self {
        self.0.args(args);
        self
    }

    pub(crate) fn path(mut self, path: &Path) -> Self {
        self.0.arg(path);
        self
    }

    /// It is started in that folder.
    pub(crate) fn within(mut self, folder: &Path) -> Self {
        self.0.current_dir(folder);
        self
    }

    pub(crate) fn env(mut self, name: &str, value: &str) -> Self {
        self.0.env(name, value);
        self
    }

    /// What it says goes to the end of a file, as JSON, with all that is said of jobs.
    pub(crate) fn log(mut self, path: &Path) -> Self {
        let file = OpenOptions::new().append(true).create(true).open(path).expect("a log");
        let levels = "warn,cullet=debug,zenoh=error";
        self.0.args(["--log", "json"]).env("CULLET_LOG", levels).stderr(file);
        self
    }

    /// What it says goes there.
    pub(crate) fn errors(mut self, place: impl Into<Stdio>) -> Self {
        self.0.stderr(place);
        self
    }

    /// What it prints goes there.
    pub(crate) fn prints(mut self, place: impl Into<Stdio>) -> Self {
        self.0.stdout(place);
        self
    }

    pub(crate) fn output(mut self) -> Said {
        let output = self.0.output().expect("the binary starts");
        if output.status.code().is_none() {
            let stderr = String::from_utf8_lossy(&output.stderr);
            eprintln!("{:?} ended by {}: {stderr}", self.0, output.status);
        }
        Said {
            code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    pub(crate) fn spawn(mut self) -> Going {
        Going(self.0.spawn().expect("the binary starts"))
    }
}

impl Going {
    pub(crate) fn id(&self) -> u32 {
        self.0.id()
    }

    /// The exit code, or nothing if it still runs after `limit` or was killed by a signal.
    pub(crate) fn wait(&mut self, limit: Duration) -> Option<i32> {
        let until = Instant::now() + limit;
        while Instant::now() < until {
            if let Some(status) = self.0.try_wait().expect("a child can be asked") {
                return status.code();
            }
            sleep(Duration::from_millis(20));
        }
        None
    }

    /// Whether it has ended, however.
    pub(crate) fn ended(&mut self) -> bool {
        self.0.try_wait().expect("a child can be asked").is_some()
    }

    /// What it said that was not read yet. It is ended first if it still runs.
    pub(crate) fn stderr(&mut self) -> String {
        self.kill();
        let mut text = String::new();
        if let Some(pipe) = self.0.stderr.as_mut() {
            let _read = pipe.read_to_string(&mut text);
        }
        text
    }

    /// What it printed; it has ended.
    pub(crate) fn stdout(&mut self) -> String {
        let mut text = String::new();
        if let Some(pipe) = self.0.stdout.as_mut() {
            let _read = pipe.read_to_string(&mut text);
        }
        text
    }

    pub(crate) fn kill(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

impl Drop for Going {
    fn drop(&mut self) {
        self.kill();
    }
}

/// A scene of the test corpus.
pub(crate) fn corpus(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/corpus");
    root.join(name).to_string_lossy().into_owned()
}

/// A path in the build's scratch folder that is not there yet.
pub(crate) fn unique(name: &str) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join(format!("{name}-{}-{number}", std::process::id()));
    std::fs::remove_dir_all(&path).ok();
    path
}

/// The summary that a run left.
pub(crate) fn summary(out: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(out.join("summary.json")).expect("a summary");
    serde_json::from_str(&text).expect("the summary is JSON")
}

/// A loopback endpoint at a free port.
pub(crate) fn free_endpoint() -> String {
    format!("tcp/127.0.0.1:{}", free_port())
}

/// A port that was free a moment ago and is given once. Not one of those from which connections are
/// made: a client that knocks at such a port while nobody listens may be given it as its own, reach
/// itself, and keep the listener out.
pub(crate) fn free_port() -> u16 {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    loop {
        let spread = std::process::id() * 97;
        let port = 12_000 + ((spread + NEXT.fetch_add(1, Ordering::Relaxed)) % 20_000) as u16;
        if std::net::TcpListener::bind(("127.0.0.1", port)).is_ok() {
            return port;
        }
    }
}

pub(crate) fn signal(id: u32, name: &str) {
    let status = Command::new("kill").arg(format!("-{name}")).arg(id.to_string()).status();
    assert!(status.is_ok_and(|status| status.success()), "kill -{name} {id}");
}

pub(crate) fn processes() -> impl Iterator<Item = u32> {
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok())
}

/// The fields of `/proc/ID/stat` after the name: state, parent, …
fn stat(id: u32) -> Option<Vec<String>> {
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    let rest = &text[text.rfind(')')? + 1..];
    Some(rest.split_whitespace().map(str::to_owned).collect())
}

/// Processor time of a process that has ended and was not waited for: its own, and that of those it
/// waited for, in ticks.
pub(crate) fn spent(id: u32, limit: Duration) -> Option<[u64; 2]> {
    let until = Instant::now() + limit;
    loop {
        let fields = stat(id)?;
        let sum =
            |at: usize| Some(fields[at].parse::<u64>().ok()? + fields[at + 1].parse::<u64>().ok()?);
        if fields[0] == "Z" {
            return Some([sum(11)?, sum(13)?]);
        }
        if Instant::now() > until {
            return None;
        }
        sleep(Duration::from_millis(20));
    }
}

pub(crate) fn is_alive(id: u32) -> bool {
    stat(id).is_some_and(|fields| fields[0] != "Z")
}

pub(crate) fn children_of(parent: u32) -> Vec<u32> {
    let wanted = parent.to_string();
    let is_child = |id: &u32| stat(*id).is_some_and(|f| f[1] == wanted && f[0] != "Z");
    processes().filter(is_child).collect()
}

/// The drop scene, finer, so that a job lasts long enough to be hit.
pub(crate) const LONGER: [&str; 2] = ["--set", "fracture.max_particles=12000"];

/// Waits until something holds.
pub(crate) fn until(what: &str, limit: Duration, mut holds: impl FnMut() -> bool) {
    let until = Instant::now() + limit;
    while !holds() {
        assert!(Instant::now() < until, "never: {what}");
        sleep(Duration::from_millis(30));
    }
}

/// A run is done: as its scene expects, or not, which a seed may decide.
pub(crate) const DONE: [i32; 2] = [0, 3];

/// The digest of the drop scene with these arguments on a quiet machine. It is run once for all
/// tests of a build, in whatever processes they are: the bits are the same each time, which
/// `command` holds.
pub(crate) fn quiet_digest(args: &[&str]) -> serde_json::Value {
    let program = std::fs::metadata(env!("CARGO_BIN_EXE_cullet")).expect("the binary is there");
    let made = program.modified().ok().and_then(|at| at.duration_since(UNIX_EPOCH).ok());
    let name = format!("{}-{made:?}-{}", program.len(), args.concat());
    let name: String = name.chars().filter(|c| c.is_alphanumeric() || "-.=".contains(*c)).collect();
    let known = Path::new(env!("CARGO_TARGET_TMPDIR")).join("quiet-digests").join(name);
    if let Ok(text) = std::fs::read_to_string(&known) {
        return text.into();
    }
    let digest = run_alone(args);
    // Whole at once, for another process may read it: both would write the same.
    let part = unique("quiet-digest");
    std::fs::create_dir_all(known.parent().expect("a folder")).expect("a folder");
    std::fs::write(&part, digest.as_str().expect("a digest is text")).expect("a file");
    std::fs::rename(&part, &known).expect("a file");
    digest
}

fn run_alone(args: &[&str]) -> serde_json::Value {
    let out = unique("quiet");
    let run = Cullet::new(&["run", &corpus("drop.toml"), "-q", "--no-pictures", "--out"])
        .path(&out)
        .args(args)
        .output();
    assert!(DONE.contains(&run.code), "{}", run.stderr);
    summary(&out)["digest"].clone()
}

/// The digest of a run, fetched by somebody (`--connect` and more).
pub(crate) fn fetched(run: &str, who: &[&str]) -> serde_json::Value {
    let out = unique("fetched");
    let said = Cullet::new(&["fetch", run]).args(who).args(&["--out"]).path(&out).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    summary(&out)["digest"].clone()
}

/// A file of the repository.
pub(crate) fn file_of(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// Certificates of these names in a folder, as the shipped script makes them with what is `set`.
pub(crate) fn certificates(folder: &Path, names: &[&str], set: &[(&str, &str)]) {
    let mut script = Command::new(file_of("deploy/certs.sh"));
    let made = script.arg(folder).args(names).envs(set.iter().copied()).output();
    let made = made.expect("the script starts");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
}
