//! `cullet coordinator`, `cullet worker` and `cullet router`: the same run across terminals and
//! machines.

use crate::exit::{CommandError, Exit, print, refused};
use crate::illustrator::ProcessIllustrator;
use crate::shown::lines;
use crate::signals::stop_when_told;
use crate::tls::{self, LinkConfig};
use crate::{args, logs};
use cullet_coordinator::{ServiceConfig, ServiceError, Store, serve, total};
use cullet_pool::router::{self, Router};
use cullet_pool::{LinkError, Pool, PoolConfig, SpawnConfig};
use cullet_proto::WorkerId;
use cullet_proto::security::{COORDINATOR, Names, Roles, Rules};
use cullet_web::{WebConfig, WebError, WebIdentity};
use cullet_worker::{WorkerConfig, WorkerError};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How often one that waits looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(50);
/// Before a router is looked for again.
const AGAIN: Duration = Duration::from_millis(500);
/// Folder for recordings, where there is no state folder.
const RUNS: &str = "runs";

pub(crate) fn coordinator(args: &args::Coordinator) -> Result<Exit, CommandError> {
    let stop = stop_when_told("clients are told first")?;
    let endpoint = args.router.as_ref().unwrap_or(&args.listen);
    let guard = guard(&args.guard, endpoint, args.router.is_none())?;
    guard.may_answer(&args.name, args.router.is_some())?;
    may_be_read(args)?;
    let web = web(args, &guard)?;
    let spawn = (args.workers > 0).then(|| own_workers(args, &guard)).transpose()?;
    let store = Store::open(args.state.as_deref()).map_err(|error| trouble(&error))?;
    let settings = PoolConfig {
        listen: Some(args.listen.clone()),
        router: args.router.clone(),
        name: Some(args.name.clone()),
        spawn,
        rules: guard.rules,
        ..PoolConfig::default()
    };
    let settings = store.pool(settings, (args.cache * 1e9) as u64);
    let Some(pool) = open(&settings, &guard.link, endpoint, &stop)? else {
        return Ok(Exit::Done);
    };
    if !args.voice.quiet {
        let how = if args.router.is_some() { "connected to" } else { "listening on" };
        logs::say(format!("{how} {}", pool.endpoint()));
    }
    let ephemeral = args.state.is_none().then(|| PathBuf::from(RUNS));
    let config = ServiceConfig {
        out: args.out.clone().or(ephemeral),
        runs: usize::from(args.runs),
        stop_after: args.stop_after,
        metrics: args.metrics,
        web,
        operators: guard.roles.map(|roles| roles.operators().clone()),
        quota: quota(args),
        memory: args.world_memory.bytes(1),
        reserve: args.reserve.map(|gigabytes| (gigabytes * 1e9) as u64),
        keep: Some(usize::from(args.keep)),
        journal: None,
    };
    let quiet = args.voice.quiet;
    let pool = Arc::new(pool);
    let served = serve(store, &pool, &config, &stop, &mut |line| {
        if !quiet {
            logs::say(lines(line));
        }
    });
    // A run that was cut off has the pool still, until the process ends.
    pool.shutdown();
    served.map_err(|error| trouble(&error))?;
    Ok(Exit::Done)
}

/// Where the farm's page is, and who may see it: users and operators, or whoever is on this
/// machine.
fn web(args: &args::Coordinator, guard: &ServerAccess) -> Result<Option<WebConfig>, CommandError> {
    let Some(web) = args.web else { return Ok(None) };
    let identity = match (web.tls, &args.guard.tls, &guard.roles) {
        (false, ..) => None,
        (true, Some(folder), Some(roles)) => {
            Some(WebIdentity { folder: folder.clone(), watchers: roles.users().clone() })
        }
        (true, ..) => {
            let text = format!("--web tls/{} needs --tls DIR and --roles FILE", web.address);
            return Err(CommandError::new(Exit::Usage, text));
        }
    };
    let illustrator = ProcessIllustrator::new();
    let illustrator = illustrator.map_err(|error| CommandError::new(Exit::Broken, error))?;
    Ok(Some(WebConfig { address: web.address, identity, illustrator: Arc::new(illustrator) }))
}

/// Metrics are for whoever reaches them, and nothing there is encrypted.
fn may_be_read(args: &args::Coordinator) -> Result<(), CommandError> {
    match args.metrics {
        Some(address) if !address.ip().to_canonical().is_loopback() && !args.guard.insecure => {
            let text = format!(
                "--metrics {address}: anyone who can reach this address can read the metrics, and \
                 there is no TLS; give --insecure, or an address of this machine alone, such as \
                 127.0.0.1:{}",
                address.port()
            );
            Err(CommandError::new(Exit::Usage, text))
        }
        _ => Ok(()),
    }
}

/// Bytes of the disk that the runs of one user may hold: half of it, if nothing is said.
fn quota(args: &args::Coordinator) -> Option<u64> {
    match args.quota {
        Some(gigabytes) => (gigabytes > 0.0).then_some((gigabytes * 1e9) as u64),
        None => total(args.state.as_deref().unwrap_or(Path::new("."))).map(|bytes| bytes / 2),
    }
}

/// Opens the pool; a router that is not there yet is waited for until asked to stop.
fn open(
    settings: &PoolConfig,
    link: &LinkConfig,
    endpoint: &str,
    stop: &AtomicBool,
) -> Result<Option<Pool>, CommandError> {
    let mut told = false;
    while !stop.load(Ordering::Relaxed) {
        let error = match Pool::start(settings.clone()) {
            Ok(pool) => return Ok(Some(pool)),
            Err(error @ LinkError::Connect { .. }) => error,
            Err(error) => return Err(refused(&error)),
        };
        if link.refusal(endpoint).is_some() {
            return Err(link.trouble(&error, endpoint));
        }
        if !std::mem::replace(&mut told, true) {
            logs::say(format!("the router at {endpoint} is not there yet, and waited for"));
        }
        std::thread::sleep(AGAIN);
    }
    Ok(None)
}

/// Workers of the coordinator's own. They show its certificate, and are called after it: roles let
/// such names in.
fn own_workers(
    args: &args::Coordinator,
    guard: &ServerAccess,
) -> Result<SpawnConfig, CommandError> {
    let exe = std::env::current_exe().map_err(|error| CommandError::new(Exit::Broken, error))?;
    let mut spawn = SpawnConfig::new(exe, usize::from(args.workers), usize::from(args.threads));
    spawn.args.extend(args.voice.words());
    spawn.args.extend(args.memory.words(usize::from(args.workers)));
    spawn.args.extend(["--coordinator".to_owned(), args.name.clone()]);
    if let Some(folder) = &args.guard.tls {
        spawn.args.extend(["--tls".to_owned(), folder.to_string_lossy().into_owned()]);
        spawn.prefix = format!("{}-", guard.link.name);
    }
    Ok(spawn)
}

pub(crate) fn router(args: &args::RouterArgs) -> Result<Exit, CommandError> {
    let stop = stop_when_told("links end")?;
    let guard = guard(&args.guard, &args.listen, true)?;
    if args.print_config {
        let text = router::config(&args.listen, &guard.rules).map_err(|error| refused(&error))?;
        print(text)?;
        return Ok(Exit::Done);
    }
    let router = Router::start(&args.listen, &guard.rules).map_err(|error| refused(&error))?;
    if !args.voice.quiet {
        logs::say(format!("listening on {}", router.endpoint()));
    }
    while !stop.load(Ordering::Relaxed) {
        std::thread::sleep(LOOK);
    }
    Ok(Exit::Done)
}

/// Who this process is to others, and who may connect to it.
struct ServerAccess {
    link: LinkConfig,
    rules: Rules,
    roles: Option<Roles>,
}

impl ServerAccess {
    /// Nobody hears a coordinator of a name that is not in the roles, nor one behind a router whose
    /// certificate they do not name.
    fn may_answer(&self, name: &str, routed: bool) -> Result<(), CommandError> {
        let (Some(roles), Some(certificate)) = (&self.roles, &self.link.certificate) else {
            return Ok(());
        };
        if !roles.names().iter().any(|known| known.as_str() == name) {
            let all: Vec<&str> = roles.names().iter().map(WorkerId::as_str).collect();
            let text = format!(
                "--name {name}: the roles have no coordinator of that name (names = {all:?})"
            );
            return Err(CommandError::new(Exit::Usage, text));
        }
        if !routed {
            return Ok(());
        }
        let (named, shown) = (roles.coordinator().as_str(), &certificate.name);
        if named == shown {
            return Ok(());
        }
        let text = format!(
            "the certificate is of {shown:?}, and the roles have {named:?} for coordinator: \
             behind a router that has them nobody would hear it"
        );
        Err(CommandError::new(Exit::Usage, text))
    }
}

/// Identity and roles; `listens`: others come here, which roles rule, and which is not open to
/// other machines without them.
fn guard(
    args: &args::AccessArgs,
    endpoint: &str,
    listens: bool,
) -> Result<ServerAccess, CommandError> {
    let usage = |text: String| CommandError::new(Exit::Usage, text);
    let link = tls::link(args.tls.as_deref(), endpoint, None, COORDINATOR)?;
    let mut rules = link.rules.clone();
    let Some(path) = &args.roles else {
        if listens && !is_loopback(endpoint) && !args.insecure {
            return Err(usage(
                "to listen on an address that other machines can reach, give --tls and --roles; \
                 on a network where everyone may do everything, give --insecure instead"
                    .to_owned(),
            ));
        }
        return Ok(ServerAccess { link, rules, roles: None });
    };
    let text =
        cullet_files::regular::read_text(path).map_err(|error| CommandError::file(path, error))?;
    let wrong = |error: &dyn std::fmt::Display| {
        usage(format!("{}: {error}", path.display())).at(path.display())
    };
    let names: Names = toml::from_str(&text).map_err(|error| wrong(&error))?;
    let roles = Roles::new(&names).map_err(|error| wrong(&error))?;
    if listens {
        rules.extend(roles.access());
    }
    Ok(ServerAccess { link, rules, roles: Some(roles) })
}

/// Whether an endpoint can only be reached from this machine.
fn is_loopback(endpoint: &str) -> bool {
    let place = endpoint.split_once('/').map_or(endpoint, |(_, place)| place);
    let host = place.rsplit_once(':').map_or(place, |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || host.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

fn trouble(error: &ServiceError) -> CommandError {
    let exit = match error {
        ServiceError::File { .. }
        | ServiceError::Taken { .. }
        | ServiceError::Full { .. }
        | ServiceError::Quota { .. }
        | ServiceError::Journal { .. }
        | ServiceError::NoJournal { .. }
        | ServiceError::Long { .. }
        | ServiceError::Damaged { .. } => Exit::File,
        ServiceError::Foreign { .. } => Exit::Usage,
        ServiceError::Link(error) => return refused(error),
        ServiceError::Web(WebError::Open { .. }) => Exit::Usage,
        ServiceError::Metrics { .. } | ServiceError::Web(_) => Exit::Broken,
    };
    let trouble = CommandError::new(exit, error);
    match error {
        ServiceError::File { path, .. }
        | ServiceError::Journal { path, .. }
        | ServiceError::NoJournal { path, .. }
        | ServiceError::Long { path, .. }
        | ServiceError::Damaged { path, .. } => trouble.at(path.display()),
        ServiceError::Taken { folder }
        | ServiceError::Full { folder, .. }
        | ServiceError::Foreign { folder, .. } => trouble.at(folder.display()),
        ServiceError::Metrics { address, .. } => trouble.at(address),
        ServiceError::Link(_) | ServiceError::Quota { .. } | ServiceError::Web(_) => trouble,
    }
}

pub(crate) fn worker(args: &args::WorkerArgs) -> Result<Exit, CommandError> {
    let first = args.connect.first().map(String::as_str).unwrap_or_default();
    let anonymous = format!("worker-{}", std::process::id());
    let link = tls::link(args.tls.as_deref(), first, args.name.as_deref(), &anonymous)?;
    if let (false, Some(why)) = (args.parent_watch, link.refusal(first)) {
        return Err(
            CommandError::new(Exit::Unreachable, format!("no link to {first}: {why}")).at(first)
        );
    }
    let name = link.name.clone();
    if !args.voice.quiet && !args.parent_watch {
        let all = args.connect.join(" or ");
        let way = match args.connect.len() {
            1 => "",
            _ => ", whichever answers first: all of them must lead to one coordinator",
        };
        let limit = match args.memory.bytes(1) {
            Some(bytes) => format!("a job may use {} MiB of memory", bytes >> 20),
            None => "a job may use any amount of memory".to_owned(),
        };
        logs::say(format!("{name}: connecting to {all}{way}; {limit}"));
    }
    let stop = stop_when_told("the job at hand is given back")?;
    let expired = leave_when_expired(&link, &stop);
    let config = WorkerConfig {
        rules: link.rules,
        certificate: link.certificate.map(|certificate| certificate.name),
        connect: args.connect.clone(),
        coordinator: args.coordinator.clone(),
        name,
        threads: usize::from(args.threads),
        parent_watch: args.parent_watch,
        job: Some(crate::job::command(args.threads, args.memory)?),
        idle_limit: args.exit_when_idle,
        stop,
        ..WorkerConfig::default()
    };
    let exit = |error: &WorkerError| match error {
        WorkerError::Connect { .. } => Exit::Unreachable,
        WorkerError::Threads { .. } => Exit::Broken,
        WorkerError::NoEndpoint | WorkerError::Wire(_) => Exit::Usage,
    };
    cullet_worker::run(config).map_err(|error| CommandError::new(exit(&error), error))?;
    if expired.load(Ordering::Relaxed) {
        let text = "the certificate has expired: put a new one in its place and start again";
        return Err(CommandError::new(Exit::Unreachable, text));
    }
    Ok(Exit::Done)
}

/// The link ends with the certificate, and no other comes about: better to leave, and to be started
/// again with a new one.
fn leave_when_expired(link: &LinkConfig, stop: &Arc<AtomicBool>) -> Arc<AtomicBool> {
    let (stop, expired) = (Arc::clone(stop), Arc::<AtomicBool>::default());
    let told = Arc::clone(&expired);
    if let Some(certificate) = &link.certificate {
        let left = Duration::from_secs(certificate.left().max(0) as u64);
        std::thread::spawn(move || {
            std::thread::sleep(left);
            told.store(true, Ordering::Relaxed);
            stop.store(true, Ordering::Relaxed);
        });
    }
    expired
}
