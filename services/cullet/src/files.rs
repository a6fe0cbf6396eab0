//! How many files a process may have open. With too few, runtimes of the transport do not start and
//! links do not come about, which it does not say but panics or waits: it is found out before.

use crate::args::Command;
use crate::exit::{CommandError, Exit};

/// What the transport, its links and the program itself have open, with some room. A run here of
/// two workers has 38, a coordinator of two workers and one run 45, a worker 31.
const BASE: u64 = 48;
/// The same for a client, which has 24 while it fetches.
const CLIENT: u64 = 32;
/// For each worker of one's own: its standard input, its link, and what is open as it starts.
const WORKER: u64 = 4;
/// For each run at once: its recording and what else it writes.
const RUN: u64 = 4;
/// Connections of those who ask for metrics.
const METRICS: u64 = 66;
/// Connections of those who watch a page and of strangers there, and what is read for them.
const PAGE: u64 = 140;
/// Connections of viewers, and of strangers there.
const VIEWERS: u64 = 36;
/// More than this is not asked for.
#[cfg(unix)]
const MOST: u64 = 1 << 16;

fn needed(command: &Command) -> Option<u64> {
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get() as u64);
    let workers = |asked: Option<u16>| WORKER * asked.map_or(cores, u64::from);
    Some(match command {
        Command::Run(args) => {
            let page = args.live.map_or(0, |_| PAGE);
            let viewers = args.foxglove.map_or(0, |_| VIEWERS);
            BASE + workers(args.workers) + RUN + page + viewers
        }
        Command::Coordinator(args) => {
            let page = args.web.map_or(0, |_| PAGE);
            let metrics = args.metrics.map_or(0, |_| METRICS) + page;
            BASE + workers(Some(args.workers)) + RUN * u64::from(args.runs) + metrics
        }
        Command::Worker(_) | Command::Router(_) => BASE,
        Command::Bench(args) => BASE + workers(args.workers),
        Command::Frontier(args) => BASE + workers(Some(args.workers)),
        command if command.is_client() => CLIENT,
        _ => return None,
    })
}

/// Takes as many as this process is let have, and says so where they are too few for a command.
pub(crate) fn enough(command: &Command) -> Result<(), CommandError> {
    match needed(command).zip(allowed()) {
        Some((needed, allowed)) if allowed < needed => Err(CommandError::new(
            Exit::Broken,
            format!(
                "this process may have {allowed} files and connections open, and needs at least \
                 {needed}: ulimit -n {needed}, or LimitNOFILE={needed} in a unit of systemd"
            ),
        )),
        _ => Ok(()),
    }
}

/// How many it may have open, once it has asked for as many as there are; `None`: no bound.
#[cfg(unix)]
fn allowed() -> Option<u64> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let wanted = maximum.map_or(MOST, |maximum| maximum.min(MOST));
    let more = Rlimit { current: Some(wanted), maximum };
    match current? < wanted && setrlimit(Resource::Nofile, more).is_ok() {
        true => Some(wanted),
        false => current,
    }
}

#[cfg(not(unix))]
fn allowed() -> Option<u64> {
    None
}
