//! What clients did and what the farm did, as they wrote it down, checked afterwards as a queue:
//! what was acknowledged is there, once, and nothing else is. Who got no answer does not know: that
//! it was taken and that it was not are both in order.

use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Display;
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a client heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Heard {
    Ok,
    /// It is certain that nothing came of it.
    Fail,
    /// Nothing, or half of it.
    Info,
}

/// Something that a client wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Act {
    pub(crate) verb: String,
    /// What was handed in.
    pub(crate) key: String,
    /// The run that it is about or that it made.
    pub(crate) run: Option<u64>,
    pub(crate) heard: Heard,
}

/// The clients' side, a line a word: what is wanted before it is asked for, what is heard after.
pub(crate) struct Diary {
    file: Mutex<File>,
    count: AtomicU64,
}

impl Diary {
    pub(crate) fn begin(path: &Path) -> Self {
        let file = Mutex::new(File::create(path).expect("a diary"));
        Self { file, count: AtomicU64::new(0) }
    }

    fn write(&self, line: &Value) {
        let mut file = self.file.lock().expect("a diary");
        writeln!(file, "{line}").expect("a diary");
    }

    /// The number of what is wanted now.
    pub(crate) fn invoke(&self, verb: &str, key: &str, run: Option<u64>) -> u64 {
        let id = self.count.fetch_add(1, Ordering::SeqCst);
        self.write(&json!({"id": id, "invoke": verb, "key": key, "run": run}));
        id
    }

    pub(crate) fn heard(&self, id: u64, heard: Heard, run: Option<u64>) {
        let word = match heard {
            Heard::Ok => "ok",
            Heard::Fail => "fail",
            Heard::Info => "info",
        };
        self.write(&json!({"id": id, "heard": word, "run": run}));
    }
}

/// Reads what a diary says. What has no end is `Info`.
pub(crate) fn acts(path: &Path) -> Vec<Act> {
    let mut all: BTreeMap<u64, Act> = BTreeMap::new();
    for line in lines(path) {
        let id = line["id"].as_u64().expect("a number");
        let run = line["run"].as_u64();
        if let Some(verb) = line["invoke"].as_str() {
            let key = line["key"].as_str().unwrap_or_default().to_owned();
            all.insert(id, Act { verb: verb.to_owned(), key, run, heard: Heard::Info });
        } else if let Some(act) = all.get_mut(&id) {
            act.run = run.or(act.run);
            act.heard = match line["heard"].as_str() {
                Some("ok") => Heard::Ok,
                Some("fail") => Heard::Fail,
                _ => Heard::Info,
            };
        }
    }
    all.into_values().collect()
}

/// When a line of a log was written \[s since 1970\].
pub(crate) fn moment(line: &Value) -> Option<f64> {
    let (day, time) = line["timestamp"].as_str()?.trim_end_matches('Z').split_once('T')?;
    let numbers = |text: &str, mark: char| -> Option<[f64; 3]> {
        let all: Option<Vec<f64>> = text.split(mark).map(|one| one.parse().ok()).collect();
        all?.try_into().ok()
    };
    let ([year, month, day], [hours, minutes, seconds]) = (numbers(day, '-')?, numbers(time, ':')?);
    // Years that begin in March, so that the day that not all have is the last one.
    let (year, month) = if month > 2.0 { (year, month) } else { (year - 1.0, month + 12.0) };
    let leap = (year / 4.0).floor() - (year / 100.0).floor() + (year / 400.0).floor();
    let days = 365.0 * year + leap + ((153.0 * month - 457.0) / 5.0).floor() + day - 719_469.0;
    Some(((days * 24.0 + hours) * 60.0 + minutes) * 60.0 + seconds)
}

/// Lines of JSON; words between them, and a last line that a crash tore, are left out.
pub(crate) fn lines(path: &Path) -> Vec<Value> {
    let text = String::from_utf8_lossy(&std::fs::read(path).expect("a file")).into_owned();
    text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}

/// A run that the coordinator knows in the end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Listed {
    pub(crate) run: u64,
    pub(crate) key: String,
    pub(crate) state: String,
}

/// What a log says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// A coordinator begins its life.
    Life,
    Started {
        run: u64,
    },
    Opened {
        run: u64,
        job: String,
        kept: bool,
    },
    Granted {
        job: String,
        worker: String,
        epoch: u64,
    },
    /// A result counts, and that is acknowledged.
    Taken {
        job: String,
        worker: String,
        epoch: u64,
    },
    Settled {
        run: u64,
        job: String,
        kept: bool,
        ending: String,
    },
    Ended {
        run: u64,
        how: String,
    },
    /// A worker has a result.
    Solved {
        job: String,
    },
    /// Two results of a job differ.
    Alarm(String),
}

/// Reads the log of one life of a coordinator or of a worker.
pub(crate) fn steps(path: &Path) -> Vec<Step> {
    lines(path).iter().filter_map(step).collect()
}

fn step(line: &Value) -> Option<Step> {
    let text = |name: &str| line[name].as_str().unwrap_or_default().to_owned();
    let run = line["span"]["run"].as_u64().or(line["run"].as_u64()).unwrap_or_default();
    let (job, worker, kept) = (text("job"), text("worker"), line["kept"].as_bool() == Some(true));
    let epoch = line["epoch"].as_u64().unwrap_or_default();
    let message = line["message"].as_str()?;
    Some(match message {
        "run started" => Step::Started { run },
        "job opened" => Step::Opened { run, job, kept },
        "job granted" => Step::Granted { job, worker, epoch },
        "result taken" => Step::Taken { job, worker, epoch },
        "job settled" => Step::Settled { run, job, kept, ending: text("ending") },
        "run ended" => Step::Ended { run, how: text("how") },
        "job solved" => Step::Solved { job },
        _ if message.contains("is not deterministic") => Step::Alarm(message.to_owned()),
        _ => return None,
    })
}

/// Complaints about runs: those that were acknowledged and are not there, are there twice, or that
/// nobody handed in. All is quiet, so that none goes on.
pub(crate) fn check_runs(acts: &[Act], listed: &[Listed]) -> Vec<String> {
    let mut said = Vec::new();
    let of = |verb: &'static str| acts.iter().filter(move |act| act.verb == verb);
    let asked = |verb: &'static str, run: u64| {
        of(verb).any(|act| act.run == Some(run) && act.heard != Heard::Fail)
    };
    let known: BTreeMap<u64, &Listed> = listed.iter().map(|run| (run.run, run)).collect();
    let mut numbers = BTreeSet::new();
    for act in of("submit").filter(|act| act.heard == Heard::Ok) {
        let run = act.run.expect("an acknowledgement has a number");
        if !numbers.insert(run) {
            said.push(format!("doubled: run {run} was acknowledged twice"));
        }
        match known.get(&run) {
            Some(listed) if listed.key != act.key => {
                said.push(format!("phantom: run {run} is {}, not {}", listed.key, act.key));
            }
            None if !asked("delete", run) => {
                said.push(format!("lost: run {run} ({}) was acknowledged", act.key));
            }
            _ => {}
        }
    }
    let mut open: BTreeMap<&str, usize> = BTreeMap::new();
    for act in of("submit").filter(|act| act.heard == Heard::Info) {
        *open.entry(act.key.as_str()).or_default() += 1;
    }
    for run in listed {
        if !numbers.contains(&run.run) {
            match open.get_mut(run.key.as_str()).filter(|left| **left > 0) {
                Some(left) => *left -= 1,
                None => {
                    said.push(format!("phantom: nobody handed run {} ({}) in", run.run, run.key));
                }
            }
        }
        let may = match run.state.as_str() {
            "done" => true,
            "cancelled" => asked("cancel", run.run),
            _ => false,
        };
        if !may {
            said.push(format!("lost: run {} is {} in the end", run.run, run.state));
        }
    }
    for act in of("delete").filter(|act| act.heard == Heard::Ok) {
        if act.run.is_some_and(|run| known.contains_key(&run)) {
            said.push(format!("doubled: run {:?} is there after it was deleted", act.run));
        }
    }
    said
}

/// What is known of jobs on the way through the lives of a coordinator.
#[derive(Default)]
struct Books {
    solved: BTreeSet<String>,
    grants: BTreeMap<u64, (String, String)>,
    taken: BTreeSet<String>,
    worked: BTreeSet<(u64, String)>,
    open: BTreeMap<u64, VecDeque<String>>,
    said: Vec<String>,
}

/// Complaints about jobs, from the logs of all lives of a coordinator in order, and of workers in
/// any. Results are kept on disk before they are acknowledged, so that none counts twice.
pub(crate) fn check_jobs(steps: &[Step]) -> Vec<String> {
    let solved = |step: &Step| match step {
        Step::Solved { job } => Some(job.clone()),
        _ => None,
    };
    let mut books = Books { solved: steps.iter().filter_map(solved).collect(), ..Books::default() };
    steps.iter().for_each(|step| books.enter(step));
    books.said
}

impl Books {
    fn say(&mut self, kind: &str, what: impl Display) {
        self.said.push(format!("{kind}: {what}"));
    }

    fn enter(&mut self, step: &Step) {
        match step {
            Step::Life => self.open.clear(),
            Step::Started { run } => {
                self.open.remove(run);
            }
            Step::Opened { run, job, kept } => {
                if *kept && !self.solved.contains(job) {
                    self.say("phantom", format!("job {job} is kept, and nobody solved it"));
                }
                self.open.entry(*run).or_default().push_back(job.clone());
            }
            Step::Granted { job, worker, epoch } => {
                // One that asks again gets the same answer.
                let grant = (job.clone(), worker.clone());
                let before = self.grants.insert(*epoch, grant.clone());
                if before.is_some_and(|before| before != grant) {
                    self.say("doubled", format!("grant {epoch} was of something else"));
                }
            }
            Step::Taken { job, worker, epoch } => self.take(job, worker, *epoch),
            Step::Settled { run, job, kept, ending } => self.settle(*run, job, *kept, ending),
            Step::Ended { run, how } => {
                let open = self.open.remove(run).unwrap_or_default();
                if how == "Done" && !open.is_empty() {
                    self.say("lost", format!("run {run} is done without {open:?}"));
                }
            }
            Step::Solved { .. } => {}
            Step::Alarm(text) => self.say("alarm", text),
        }
    }

    fn take(&mut self, job: &str, worker: &str, epoch: u64) {
        if self.grants.get(&epoch).is_none_or(|(what, who)| (&**what, &**who) != (job, worker)) {
            self.say("phantom", format!("{worker} has no grant {epoch} of job {job}"));
        }
        if !self.solved.contains(job) {
            self.say("phantom", format!("nobody solved job {job}, whose result counts"));
        }
        if !self.taken.insert(job.to_owned()) {
            self.say("doubled", format!("two results of job {job} were acknowledged"));
        }
    }

    fn settle(&mut self, run: u64, job: &str, kept: bool, ending: &str) {
        let first = self.open.get_mut(&run).and_then(VecDeque::pop_front);
        if first.as_deref() != Some(job) {
            self.say("doubled", format!("run {run} settles job {job}, and {first:?} is next"));
        }
        if ["abandoned", "cancelled"].contains(&ending) {
            return;
        }
        if !self.solved.contains(job) {
            self.say("phantom", format!("job {job} is settled, and nobody solved it"));
        }
        if !kept && !self.worked.insert((run, job.to_owned())) {
            self.say("doubled", format!("job {job} of run {run} was worked out twice"));
        }
    }
}
