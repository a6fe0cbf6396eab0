//! `cullet coordinator` and `cullet worker`: the same run across terminals and machines.

use crate::args;
use crate::client::identity;
use crate::exit::{Exit, Trouble};
use crate::run::{no_link, say_logs};
use crate::signals::stop_when_told;
use cullet_coordinator::link::{LinkError, Pool, PoolConfig, SpawnConfig};
use cullet_coordinator::service::{ServiceConfig, ServiceError, Store, serve};
use cullet_proto::WorkerId;
use cullet_proto::keys::DEFAULT_COORDINATOR;
use cullet_proto::security::{Roles, Rules};
use cullet_worker::{WorkerConfig, WorkerError};
use serde::Deserialize;
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
    let rules = rules(args)?;
    let store = Store::open(args.state.as_deref()).map_err(|error| trouble(&error))?;
    let settings = PoolConfig { listen, spawn, rules, ..PoolConfig::default() };
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

/// Identity and roles; refuses to be open to others without them.
fn rules(args: &args::Coordinator) -> Result<Rules, Trouble> {
    let usage = |text: &str| Err(Trouble::new(Exit::Usage, text));
    let mut rules = identity(args.tls.as_deref(), &args.listen)?;
    let Some(path) = &args.roles else {
        if !is_loopback(&args.listen) && !args.insecure {
            return usage(
                "beyond this machine a coordinator listens with --tls and --roles; without them, \
                 on a network where everybody may do everything, say --insecure",
            );
        }
        return Ok(rules);
    };
    if args.workers > 0 {
        return usage("with --tls each worker has a certificate of its own: start them apart");
    }
    let text = std::fs::read_to_string(path).map_err(|error| Trouble::file(path, error))?;
    let wrong = |error: &dyn std::fmt::Display| {
        Trouble::new(Exit::Usage, format!("{}: {error}", path.display()))
    };
    let names: Names = toml::from_str(&text).map_err(|error| wrong(&error))?;
    let roles = Roles::new(&names.workers, &names.users).map_err(|error| wrong(&error))?;
    let coordinator = WorkerId::new(DEFAULT_COORDINATOR).map_err(|error| wrong(&error))?;
    rules.extend(roles.access(&coordinator));
    Ok(rules)
}

/// The file of `--roles`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Names {
    #[serde(default)]
    workers: Vec<String>,
    #[serde(default)]
    users: Vec<String>,
}

/// Whether an endpoint can only be reached from this machine.
fn is_loopback(endpoint: &str) -> bool {
    let place = endpoint.split_once('/').map_or(endpoint, |(_, place)| place);
    let host = place.rsplit_once(':').map_or(place, |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || host.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback())
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
    let first = args.connect.first().map(String::as_str).unwrap_or_default();
    let rules = identity(args.tls.as_deref(), first)?;
    let config = WorkerConfig {
        rules,
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
