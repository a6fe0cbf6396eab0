//! Draws for the page of a farm: in a process of its own, which takes what it needs with it when it
//! ends and lets all others go first.

use cullet_web::Illustrator;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Pixels of the picture of a run that goes on.
const SIZE: &str = "720x480";
/// Longest time that a picture may take, and a report.
const PICTURE: Duration = Duration::from_secs(60);
const REPORT: Duration = Duration::from_secs(150);
/// Between looks whether it is done.
const LOOK: Duration = Duration::from_millis(20);
/// A tick of the system's accounts of processor time \[ms\].
const TICK_MS: u64 = 10;
/// Longest error that is passed on \[bytes\].
const MAX_ERROR: usize = 400;

/// Draws by means of this program.
#[derive(Debug)]
pub(crate) struct ProcessIllustrator {
    exe: PathBuf,
}

impl ProcessIllustrator {
    pub(crate) fn new() -> std::io::Result<Self> {
        Ok(Self { exe: std::env::current_exe()? })
    }

    fn run(
        &self,
        words: &[&str],
        (folder, file): (&Path, &Path),
        most: Duration,
        stop: &AtomicBool,
    ) -> Result<Duration, String> {
        let child = Command::new(&self.exe)
            .args(&words[..1])
            .arg(folder)
            .args(&words[1..])
            .arg("--background")
            .arg("--output")
            .arg(file)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = child.map_err(|error| error.to_string())?;
        let (since, mut took) = (Instant::now(), None);
        loop {
            // Also once it has ended: it is there until it is waited for.
            took = processor_time(child.id()).or(took);
            match child.try_wait() {
                Ok(Some(code)) if code.success() => {
                    return Ok(took.unwrap_or_else(|| since.elapsed()));
                }
                Ok(Some(_)) => return Err(said(&mut child)),
                Ok(None) if stop.load(Ordering::Relaxed) => {
                    end(&mut child);
                    return Err("it is not wanted any more".to_owned());
                }
                Ok(None) if since.elapsed() > most => {
                    end(&mut child);
                    return Err(format!("it took more than {} s", most.as_secs()));
                }
                Ok(None) => sleep(LOOK),
                Err(error) => {
                    end(&mut child);
                    return Err(error.to_string());
                }
            }
        }
    }
}

/// How much of a processor's time a process has had, where the system tells.
fn processor_time(id: u32) -> Option<Duration> {
    let text = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    // Its name may have blanks and ends with a bracket; then the state is the first.
    let (_, rest) = text.rsplit_once(')')?;
    let mut fields = rest.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some(Duration::from_millis((ticks()? + ticks()?) * TICK_MS))
}

fn end(child: &mut Child) {
    let _ended_already = child.kill();
    let _reaped = child.wait();
}

/// The last line of what it said.
fn said(child: &mut Child) -> String {
    let mut text = String::new();
    if let Some(stderr) = child.stderr.take() {
        let _as_far_as_it_goes =
            std::io::Read::read_to_string(&mut std::io::Read::take(stderr, 64 << 10), &mut text);
    }
    let last = text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("it failed");
    let last = last.strip_prefix("error: ").unwrap_or(last);
    last[..last.floor_char_boundary(MAX_ERROR)].to_owned()
}

impl Illustrator for ProcessIllustrator {
    fn still(&self, folder: &Path, file: &Path, stop: &AtomicBool) -> Result<Duration, String> {
        self.run(&["still", "--last", "--size", SIZE], (folder, file), PICTURE, stop)
    }

    fn report(&self, folder: &Path, file: &Path, stop: &AtomicBool) -> Result<(), String> {
        self.run(&["report"], (folder, file), REPORT, stop).map(drop)
    }
}
