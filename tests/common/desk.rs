//! Clients of a farm who write down what they do.

use super::history::{self, Act, Diary, Heard, Listed};
use super::{Cullet, DONE, corpus};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest that anything may take once all is healed.
const HEALED: Duration = Duration::from_secs(300);

/// What clients share.
pub(crate) struct Desk {
    endpoint: String,
    folder: PathBuf,
    diary: Diary,
    /// Past this, nothing is tried again.
    until: Mutex<Option<Instant>>,
    quiet: Mutex<BTreeMap<u64, Value>>,
    complaints: Mutex<Vec<String>>,
    compared: AtomicU64,
}

impl Desk {
    pub(crate) fn open(endpoint: &str, folder: &Path) -> Self {
        Self {
            endpoint: endpoint.to_owned(),
            folder: folder.to_owned(),
            diary: Diary::begin(&folder.join("clients.log")),
            until: Mutex::default(),
            quiet: Mutex::default(),
            complaints: Mutex::default(),
            compared: AtomicU64::new(0),
        }
    }

    /// From now on all is well, so that nothing takes long.
    pub(crate) fn healed(&self) {
        *self.until.lock().expect("a time") = Some(Instant::now() + HEALED);
    }

    /// How many recordings were compared.
    pub(crate) fn compared(&self) -> u64 {
        self.compared.load(Ordering::SeqCst)
    }

    /// What was wrong on the way, and what clients wrote down.
    pub(crate) fn close(&self) -> (Vec<String>, Vec<Act>) {
        let said = std::mem::take(&mut *self.complaints.lock().expect("a list"));
        (said, history::acts(&self.folder.join("clients.log")))
    }

    pub(crate) fn complain(&self, text: String) {
        eprintln!("COMPLAINT {text}");
        self.complaints.lock().expect("a list").push(text);
    }

    fn late(&self) -> bool {
        self.until.lock().expect("a time").is_some_and(|until| Instant::now() > until)
    }

    /// A command at the end of a bad link; `None`: it was given up.
    fn say(&self, args: &[&str], limit: Duration) -> Option<(i32, String, String)> {
        let call = Cullet::new(args).args(&["--connect", &self.endpoint, "--patience", "20"]);
        let mut going = call.spawn();
        let code = going.wait(limit)?;
        Some((code, going.stdout(), going.stderr()))
    }

    /// Asks until there is an answer, which is one of these codes.
    fn insist(&self, args: &[&str], good: &[i32]) -> Option<i32> {
        while !self.late() {
            match self.say(args, Duration::from_secs(90)) {
                Some((69 | 76, ..)) | None => sleep(Duration::from_millis(200)),
                Some((code, ..)) if good.contains(&code) => return Some(code),
                Some((code, _, stderr)) => {
                    self.complain(format!("{args:?}: {code}: {stderr}"));
                    return None;
                }
            }
        }
        self.complain(format!("{args:?}: never"));
        None
    }

    /// Wants something of a run, once; what came of it is written down.
    pub(crate) fn order(&self, verb: &str, run: u64) -> Heard {
        let id = self.diary.invoke(verb, "", Some(run));
        let heard = match self.say(&[verb, &run.to_string()], Duration::from_secs(60)) {
            Some((0, ..)) => Heard::Ok,
            Some((64 | 66 | 77, ..)) => Heard::Fail,
            _ => Heard::Info,
        };
        self.diary.heard(id, heard, None);
        heard
    }

    /// Hands a run of a seed in, by a client that is killed after a while, if that is given; its
    /// number, if that is heard.
    pub(crate) fn submit(&self, seed: u64, killed: Option<Duration>) -> Option<u64> {
        let key = format!("world.seed={seed}");
        let id = self.diary.invoke("submit", &key, None);
        let scene = corpus("drop.toml");
        let call = ["submit", &scene, "--detach", "--set", &key];
        if let Some(life) = killed {
            let mut going = Cullet::new(&call).args(&["--connect", &self.endpoint]).spawn();
            sleep(life);
            going.kill();
            self.diary.heard(id, Heard::Info, None);
            return None;
        }
        match self.say(&call, Duration::from_secs(60)) {
            Some((0, stdout, _)) => {
                let run = stdout.trim().parse().expect("a number");
                self.diary.heard(id, Heard::Ok, Some(run));
                return Some(run);
            }
            Some((69 | 76, ..)) | None => self.diary.heard(id, Heard::Info, None),
            Some((code, _, stderr)) => {
                self.diary.heard(id, Heard::Fail, None);
                self.complain(format!("a submission is refused: {code}: {stderr}"));
            }
        }
        None
    }

    /// Follows a run for a while.
    pub(crate) fn watch(&self, run: u64) {
        let _given_up = self.say(&["watch", &run.to_string()], Duration::from_secs(30));
    }

    /// Waits for the end of a run; whether it is done. One that stalls is tried again.
    pub(crate) fn finish(&self, run: u64) -> bool {
        let name = run.to_string();
        while let Some(code) = self.insist(&["wait", &name], &[0, 3, 5, 6]) {
            if code != 6 {
                return DONE.contains(&code);
            }
            self.order("retry", run);
        }
        false
    }

    /// Fetches what a run recorded: it is what a quiet machine records.
    pub(crate) fn compare(&self, run: u64, seed: u64) {
        let out = self.folder.join(format!("fetched-{run}"));
        let call = ["fetch", &run.to_string(), "--out", &out.to_string_lossy()];
        if self.insist(&call, &DONE).is_none() {
            return;
        }
        let kept = self.quiet.lock().expect("a list").get(&seed).cloned();
        let want =
            kept.unwrap_or_else(|| super::quiet_digest(&["--set", &format!("world.seed={seed}")]));
        self.quiet.lock().expect("a list").insert(seed, want.clone());
        let got = super::summary(&out)["digest"].clone();
        if got != want {
            self.complain(format!("run {run}, seed {seed}: {got} in place of {want}"));
        }
        self.compared.fetch_add(1, Ordering::SeqCst);
        std::fs::remove_dir_all(out).ok();
    }

    /// The runs that there are, each over.
    pub(crate) fn listed(&self) -> Vec<Listed> {
        let ask = |args: &[&str]| -> Value {
            let said = Cullet::new(args).args(&["--json", "--connect", &self.endpoint]).output();
            assert_eq!(said.code, 0, "{args:?}: {}", said.stderr);
            serde_json::from_str(&said.stdout).expect("JSON")
        };
        let all = ask(&["ps"]);
        let all = all["runs"].as_array().expect("a list").iter();
        let numbers: Vec<u64> = all.filter_map(|run| run["run"].as_u64()).collect();
        let of = |run: u64| {
            self.finish(run);
            let shown = ask(&["show", &run.to_string()]);
            let word = |value: &Value| value.as_str().unwrap_or_default().to_owned();
            let (key, state) = (word(&shown["overrides"][0]), word(&shown["state"]));
            Listed { run, key, state }
        };
        numbers.into_iter().map(of).collect()
    }
}
