//! A scene run by a process of its own: how it ended, and what it cost.

use cullet_files::process_memory::of_process;
use cullet_proto::service::{causes, codes};
use cullet_proto::specimen::Price;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How often a run is looked at.
const LOOK: Duration = Duration::from_millis(10);

/// Longest piece of what a process said that is reported \[letters\].
const SAID: usize = 400;

/// How a process ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProcessEnd {
    /// The run is complete, whatever its scene expected.
    Complete,
    /// Refused before it began.
    Refused,
    /// It took too long and was ended.
    Late,
    /// A motion of its world is not a number any more (F76).
    NotFinite,
    /// Anything else.
    Broken,
}

/// What became of a process.
#[derive(Clone, Debug)]
pub(super) struct Ran {
    pub(super) end: ProcessEnd,
    pub(super) price: Price,
    /// The last of what it had to say.
    pub(super) said: String,
}

/// A process that runs a scene: its command line and its time limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneCommand<'a> {
    /// The program whose `run` command runs it.
    pub(super) exe: &'a Path,
    /// The file of the scene.
    pub(super) scene: &'a Path,
    pub(super) overrides: &'a [String],
    /// The folder of the run; it does not exist.
    pub(super) out: &'a Path,
    pub(super) limit: Duration,
}

/// Runs a scene with one worker of one thread.
pub(super) fn run(order: SceneCommand<'_>) -> Ran {
    let mut command = Command::new(order.exe);
    command.arg("run").arg(order.scene).arg("--out").arg(order.out);
    command.args(["--quiet", "--no-pictures", "--json", "--workers", "1", "--threads", "1"]);
    for setting in order.overrides {
        command.arg("--set").arg(setting);
    }
    let log = PathBuf::from(format!("{}.log", order.out.display()));
    let started = std::fs::File::create(&log)
        .and_then(|file| command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file).spawn());
    let start = Instant::now();
    let (end, mut price, failed) = match started {
        Ok(child) => watch(child, order.limit),
        Err(why) => (ProcessEnd::Broken, Price::default(), format!("it did not start: {why}")),
    };
    price.wall = start.elapsed().as_secs_f64();
    if end == ProcessEnd::Late {
        // A run that was ended has cost what it was given.
        price.cpu = price.cpu.max(order.limit.as_secs_f64());
    }
    let text = std::fs::read_to_string(&log).unwrap_or_default();
    let (last, cause) = last_words(&text);
    let lost = end == ProcessEnd::Broken && cause.as_deref() == Some(causes::NOT_FINITE);
    let end = if lost { ProcessEnd::NotFinite } else { end };
    Ran { end, price, said: if last.is_empty() { failed } else { last } }
}

/// The error of a process as it writes one for programs.
#[derive(Deserialize)]
struct ReportedError {
    message: String,
    cause: Option<String>,
}

/// The last that a process had to say, and the cause of the error that this is, if it has one.
fn last_words(text: &str) -> (String, Option<String>) {
    let last_line = |text: &str| {
        let line = text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default();
        line.chars().take(SAID).collect::<String>()
    };
    let line = text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default();
    match serde_json::from_str::<ReportedError>(line) {
        Ok(error) => (last_line(&format!("error: {}", error.message)), error.cause),
        Err(_) => (last_line(text), None),
    }
}

/// Waits for the end of a process; what it cost is read before it is let go.
fn watch(mut child: Child, limit: Duration) -> (ProcessEnd, Price, String) {
    let (start, mut price) = (Instant::now(), Price::default());
    let late = loop {
        let most = of_process(&child.id().to_string(), "VmHWM:");
        price.peak = price.peak.max(most.unwrap_or(0));
        if ended(&mut child) {
            break false;
        }
        if start.elapsed() > limit {
            let _ended_already = child.kill();
            break true;
        }
        std::thread::sleep(LOOK);
    };
    price.cpu = spent(child.id());
    let status = child.wait();
    let code = status.as_ref().ok().and_then(std::process::ExitStatus::code);
    let end = match code.and_then(|code| u8::try_from(code).ok()) {
        _ if late => ProcessEnd::Late,
        Some(codes::DONE | codes::UNMET) => ProcessEnd::Complete,
        Some(codes::USAGE) => ProcessEnd::Refused,
        _ => ProcessEnd::Broken,
    };
    (end, price, status.map_or_else(|why| why.to_string(), |status| status.to_string()))
}

/// Whether a process is over; what it cost is still there to be read.
#[cfg(unix)]
fn ended(child: &mut Child) -> bool {
    use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT | WaitIdOptions::NOHANG;
    let found = waitid(WaitId::Pid(Pid::from_child(child)), options);
    found.map_or(true, |status| status.is_some())
}

#[cfg(not(unix))]
fn ended(child: &mut Child) -> bool {
    child.try_wait().map_or(true, |status| status.is_some())
}

/// Processor time of a process and all that it has waited for \[s\]; 0 where the system does not
/// tell.
fn spent(id: u32) -> f64 {
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    let rest = text.rsplit(')').next().unwrap_or_default();
    let fields: Vec<f64> = rest.split_whitespace().map(|f| f.parse().unwrap_or(0.0)).collect();
    // After the name: the state, ten more, then user and system time, its own and its children's,
    // in 1/100 s.
    fields.get(11..15).map_or(0.0, |times| times.iter().sum::<f64>() / 100.0)
}

#[cfg(test)]
mod tests {
    use super::{SAID, last_words};

    #[test]
    fn an_error_is_told_as_people_read_it_and_has_its_cause() {
        let line = |more: &str| {
            format!(
                "a warning\n{{\"code\":2,\"message\":\"it\\nis lost\",\"place\":null{more}}}\n\n"
            )
        };
        let lost = last_words(&line(",\"cause\":\"not-finite\""));
        assert_eq!(lost, ("is lost".to_owned(), Some("not-finite".to_owned())));
        assert_eq!(last_words(&line("")), ("is lost".to_owned(), None));
        let one = "{\"message\":\"no file\"}";
        assert_eq!(last_words(one), ("error: no file".to_owned(), None));
        let panic = format!("thread 'main' panicked\n{}\n \n", "x".repeat(2 * SAID));
        assert_eq!(last_words(&panic), ("x".repeat(SAID), None));
        assert_eq!(last_words(""), (String::new(), None));
    }
}
