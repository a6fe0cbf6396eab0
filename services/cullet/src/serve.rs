//! `cullet coordinator` and `cullet worker`: the same run across terminals and machines.

use crate::args;
use crate::exit::{Exit, Trouble};
use crate::run::{no_link, say_logs};
use crate::signals::stop_when_told;
use cullet_coordinator::link::{LinkError, Pool, PoolConfig, SpawnConfig};
use cullet_coordinator::service::{ServiceConfig, ServiceError, Store, serve};
use cullet_worker::{WorkerConfig, WorkerError};
use std::path::PathBuf;
use std::sync::Arc;

/// Folder for recordings, where there is no state folder.
const RUNS: &str = "runs";

pub(crate) fn coordinator(args: &args::Coordinator) -> Result<Exit, Trouble> {
    say_logs(&args.voice);
    let stop = stop_when_told("clients are told first")?;
    let exe = std::env::current_exe().map_err(|error| Trouble::new(Exit::File, error))?;
    let spawn = (args.workers > 0)
        .then(|| SpawnConfig::new(exe, usize::from(args.workers), usize::from(args.threads)));
    let listen = Some(args.listen.clone());
    let store = Store::open(args.state.as_deref()).map_err(|error| trouble(&error))?;
    let settings = PoolConfig { listen, spawn, ..PoolConfig::default() };
    let pool = Pool::start(store.pool(settings, (args.cache * 1e9) as u64))
        .map_err(|error| no_link(&error))?;
    if !args.voice.quiet {
        eprintln!("listening on {}", pool.endpoint());
    }
    let ephemeral = args.state.is_none().then(|| PathBuf::from(RUNS));
    let config = ServiceConfig {
        out: args.out.clone().or(ephemeral),
        runs: usize::from(args.runs),
        stop_after: args.stop_after,
        metrics: args.metrics,
    };
    let quiet = args.voice.quiet;
    let served = serve(store, &Arc::new(pool), &config, &stop, &mut |line| {
        if !quiet {
            eprintln!("{line}");
        }
    });
    served.map_err(|error| trouble(&error))?;
    Ok(Exit::Done)
}

fn trouble(error: &ServiceError) -> Trouble {
    let exit = match error {
        ServiceError::File { .. } | ServiceError::Taken { .. } => Exit::File,
        ServiceError::Foreign { .. } | ServiceError::Journal { .. } => Exit::Usage,
        ServiceError::Link(LinkError::Thread(_)) => Exit::Failed,
        ServiceError::Link(_) | ServiceError::Metrics { .. } => Exit::Unreachable,
    };
    Trouble::new(exit, error)
}

pub(crate) fn worker(args: &args::Worker) -> Result<Exit, Trouble> {
    say_logs(&args.voice);
    let name = args.name.clone().unwrap_or_else(|| format!("worker-{}", std::process::id()));
    if !args.voice.quiet && !args.parent_watch {
        eprintln!("{name} asks {} for jobs, as soon as it is there", args.connect.join(", "));
    }
    let config = WorkerConfig {
        connect: args.connect.clone(),
        name,
        threads: usize::from(args.threads),
        parent_watch: args.parent_watch,
        job: Some(crate::job::command(args.threads, args.memory)?),
        stop: stop_when_told("the job at hand is given back")?,
        ..WorkerConfig::default()
    };
    let exit = |error: &WorkerError| match error {
        WorkerError::Connect { .. } => Exit::Unreachable,
        WorkerError::Threads { .. } => Exit::Failed,
        WorkerError::NoEndpoint | WorkerError::Wire(_) => Exit::Usage,
    };
    cullet_worker::run(config).map_err(|error| Trouble::new(exit(&error), error))?;
    Ok(Exit::Done)
}
