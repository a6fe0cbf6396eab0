//! How the process is asked to stop.

use crate::exit::{CommandError, Exit};
use crate::logs;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tokio::runtime::{Builder, Runtime};

/// A flag that the first SIGINT, SIGTERM or SIGHUP sets, with a line that says what is `left` to
/// do.
///
/// A second SIGINT ends the process at once. A second SIGTERM does not: supervisors send one to the
/// process and one to its group. A terminal that goes away sends SIGHUP; to who was started with
/// `nohup`, which has it ignored, it means nothing.
pub(crate) fn stop_when_told(left: &'static str) -> Result<Arc<AtomicBool>, CommandError> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let (runtime, mut signals) = listened()?;
    std::thread::spawn(move || {
        runtime.block_on(async {
            loop {
                let interrupt = signals.next().await;
                if !flag.swap(true, Ordering::Relaxed) {
                    let text = format!("stopping: {left}");
                    logs::say(text + "; interrupt again to quit at once");
                } else if interrupt {
                    std::process::exit(i32::from(Exit::Interrupted.code()));
                }
            }
        });
    });
    Ok(stop)
}

/// The first of these signals ends the process with the code of one that was interrupted: for
/// commands that have nothing to finish. What they wait for goes on at the coordinator.
pub(crate) fn end_when_told() -> Result<(), CommandError> {
    let (runtime, mut signals) = listened()?;
    std::thread::spawn(move || {
        runtime.block_on(signals.next());
        std::process::exit(i32::from(Exit::Interrupted.code()));
    });
    Ok(())
}

fn listened() -> Result<(Runtime, Signals), CommandError> {
    let listen = || -> io::Result<(Runtime, Signals)> {
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let signals = runtime.block_on(async { Signals::listen() })?;
        Ok((runtime, signals))
    };
    listen().map_err(|error| CommandError::new(Exit::Broken, error))
}

/// A file that grows beyond what the process may write (`ulimit -f`) is an error of that write, as
/// on a disk that is full, and not the end of the process without a word. Who listens to the signal
/// is not ended by it, however short that is.
#[cfg(unix)]
pub(crate) fn survive_file_limit() -> io::Result<()> {
    let number = rustix::process::Signal::XFSZ.as_raw();
    let kind = tokio::signal::unix::SignalKind::from_raw(number);
    let runtime = Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(async { tokio::signal::unix::signal(kind) }).map(drop)
}

#[cfg(not(unix))]
pub(crate) fn survive_file_limit() -> io::Result<()> {
    Ok(())
}

/// The signals that ask the process to stop, as far as the system has them.
struct Signals {
    #[cfg(unix)]
    interrupt: tokio::signal::unix::Signal,
    #[cfg(unix)]
    terminate: tokio::signal::unix::Signal,
    /// Nothing where it was ignored at the start.
    #[cfg(unix)]
    hangup: Option<tokio::signal::unix::Signal>,
}

#[cfg(unix)]
impl Signals {
    fn listen() -> io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        let (interrupt, terminate) = (SignalKind::interrupt(), SignalKind::terminate());
        let (interrupt, terminate) = (signal(interrupt)?, signal(terminate)?);
        let hangup = (!hangup_is_ignored()).then(|| signal(SignalKind::hangup())).transpose()?;
        Ok(Self { interrupt, terminate, hangup })
    }

    /// Whether the next signal is an interrupt.
    async fn next(&mut self) -> bool {
        tokio::select! {
            _ = self.interrupt.recv() => true,
            _ = self.terminate.recv() => false,
            Some(_) = async { self.hangup.as_mut()?.recv().await } => false,
        }
    }
}

/// Whether SIGHUP does nothing to this process, as `nohup` sees to: listening would undo that.
#[cfg(unix)]
fn hangup_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // Its number is 1, the lowest bit.
    mask.is_some_and(|mask| mask & 1 == 1)
}

#[cfg(not(unix))]
impl Signals {
    fn listen() -> io::Result<Self> {
        Ok(Self {})
    }

    async fn next(&mut self) -> bool {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
        true
    }
}
