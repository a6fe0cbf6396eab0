//! Processes that solve: one for each run, several at once.

use super::Point;
use cullet_proto::specimen::{Ending, SpecimenJob, SpecimenResult};
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// How often a process is looked at.
const LOOK: Duration = Duration::from_millis(5);

/// Longest last words of a process that are told \[characters\].
const WORDS: usize = 200;

/// How runs are run.
#[derive(Clone, Debug)]
pub struct Limits {
    /// The program and its arguments: it reads a job on standard input, and writes the result.
    pub program: (PathBuf, Vec<String>),
    /// How many at once.
    pub workers: usize,
    /// Longest wall time of a run.
    pub time: Duration,
}

/// Runs every point; `done` is told each result, in the order of the points.
pub fn run_all(points: &[Point], limits: &Limits, done: &mut dyn FnMut(usize, SpecimenResult)) {
    let (next, (send, receive)) = (AtomicUsize::new(0), channel());
    std::thread::scope(|scope| {
        for _ in 0..limits.workers.clamp(1, points.len().max(1)) {
            let (send, next) = (send.clone(), &next);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(point) = points.get(index) else { break };
                    let result = one(&point.specimen.job, limits);
                    if send.send((index, result)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut waiting = std::collections::BTreeMap::new();
        let mut due = 0;
        for (index, result) in receive {
            waiting.insert(index, result);
            while let Some(result) = waiting.remove(&due) {
                done(due, result);
                due += 1;
            }
        }
    });
}

/// Solves one job in a process of its own.
fn one(job: &SpecimenJob, limits: &Limits) -> SpecimenResult {
    let bytes = match job.encode() {
        Ok(bytes) => bytes,
        Err(error) => return SpecimenResult::ended(Ending::Refused(error.to_string())),
    };
    let (program, arguments) = &limits.program;
    let spawned = Command::new(program)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    match spawned {
        Ok(child) => talk(child, &bytes, limits.time),
        Err(error) => {
            SpecimenResult::ended(Ending::Crashed(format!("{}: {error}", program.display())))
        }
    }
}

fn talk(mut child: Child, bytes: &[u8], limit: Duration) -> SpecimenResult {
    let (input, output, errors) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
    let start = Instant::now();
    let (out, words) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    let mut late = false;
    std::thread::scope(|scope| {
        scope.spawn(|| read(output, &out));
        scope.spawn(|| read(errors, &words));
        // A process that ended early is told by its status, not by the pipe.
        scope.spawn(move || input.is_some_and(|mut pipe| pipe.write_all(bytes).is_ok()));
        while matches!(child.try_wait(), Ok(None)) {
            if start.elapsed() > limit {
                late = true;
                let _ended_already = child.kill();
                break;
            }
            std::thread::sleep(LOOK);
        }
        let _reaped_already = child.wait();
    });
    if late {
        let text = format!("ended after {:.0} s, the limit", limit.as_secs_f64());
        return SpecimenResult::ended(Ending::Timeout(text));
    }
    let out = out.into_inner().unwrap_or_default();
    SpecimenResult::decode(&out).unwrap_or_else(|error| {
        let words = words.into_inner().unwrap_or_default();
        let words = String::from_utf8_lossy(&words);
        let last: String = words.trim().chars().take(WORDS).collect();
        let text = if last.is_empty() { error.to_string() } else { last };
        SpecimenResult::ended(Ending::Crashed(format!("the process ended early: {text}")))
    })
}

fn read(pipe: Option<impl Read>, into: &Mutex<Vec<u8>>) {
    if let (Some(mut pipe), Ok(mut into)) = (pipe, into.lock()) {
        let _what_there_was = pipe.read_to_end(&mut into);
    }
}

/// The other side: a job from `input`, its result to `output`.
///
/// # Errors
/// What is wrong with the bytes or the streams.
pub fn answer(
    mut input: impl Read,
    mut output: impl Write,
    solve: impl FnOnce(&SpecimenJob) -> SpecimenResult,
) -> Result<(), String> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    let job = SpecimenJob::decode(&bytes).map_err(|error| error.to_string())?;
    let result = solve(&job).encode().map_err(|error| error.to_string())?;
    output.write_all(&result).and_then(|()| output.flush()).map_err(|error| error.to_string())
}
