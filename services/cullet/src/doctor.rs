//! `cullet doctor`: is this machine, and is that coordinator, fit for work.

use crate::args;
use crate::client::print_json;
use crate::exit::{CommandError, Exit, print};
use crate::shown::lines;
use crate::tls::{self, Certificate, LinkConfig};
use cullet_coordinator::free;
use cullet_pool::client::Client;
use cullet_proto::keys::UserVerb;
use cullet_proto::service::{About, Nothing};
use cullet_proto::{envelope, service};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Less room than this is worth a word: a long run's recording has some hundred MB.
const LITTLE: u64 = 2 << 30;
/// Clocks that differ by more make logs of two machines hard to read together \[s\].
const SKEW: f64 = 2.0;
/// A certificate that ends within so many days is worth a word.
const SOON: f64 = 3.0;

/// One thing that was looked at.
#[derive(Debug, Serialize)]
struct Finding {
    what: &'static str,
    good: bool,
    text: String,
}

fn finding(what: &'static str, good: bool, text: impl Into<String>) -> Finding {
    Finding { what, good, text: text.into() }
}

pub(crate) fn doctor(args: &args::Doctor) -> Result<Exit, CommandError> {
    let who = &args.who;
    let mut found = here(args);
    if let Some(endpoint) = &args.connect {
        let link = tls::link(who.tls.as_deref(), endpoint, who.user.as_deref(), "doctor")?;
        found.extend(link.certificate.as_ref().map(about_certificate));
        there(endpoint, &link, who, &mut found);
    }
    if who.json {
        print_json(&found)?;
    } else {
        let mark = |good| if good { "ok " } else { "BAD" };
        let line = |f: &Finding| format!("{} {:<12} {}\n", mark(f.good), f.what, lines(&f.text));
        print(found.iter().map(line).collect::<String>())?;
    }
    let reached = found.iter().all(|f| f.good || f.what != "coordinator");
    match (found.iter().all(|f| f.good), reached) {
        (true, _) => Ok(Exit::Done),
        (false, false) => Ok(Exit::Unreachable),
        (false, true) => Ok(Exit::Unwell),
    }
}

fn here(args: &args::Doctor) -> Vec<Finding> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let version = cullet::describe_version();
    let mut found = vec![
        finding("version", true, format!("{version}, wire {}", envelope::MAJOR)),
        finding("cores", true, format!("{cores} here")),
    ];
    let folder = args.disk.display();
    found.push(match free(&args.disk) {
        Some(bytes) => {
            let room = format!("{:.1} GB free in {folder}", bytes as f64 / 1e9);
            finding("disk", bytes >= LITTLE, room)
        }
        None => finding("disk", false, format!("{folder}: how full it is cannot be told")),
    });
    let probe = tempfile_in(&args.disk);
    found.push(match probe {
        Ok(()) => finding("write", true, format!("files can be written in {folder}")),
        Err(error) => finding("write", false, format!("{folder}: {error}")),
    });
    let memory = match cullet_worker::memory::share(1) {
        Some(bytes) => format!("a worker alone here lets a job hold {} MiB", bytes >> 20),
        None => "how much there is cannot be told: a job here may hold any".to_owned(),
    };
    found.push(finding("memory", true, memory));
    let solvers = cullet_worker::solvers().join(", ");
    found.push(finding("solvers", true, format!("a worker of this version solves: {solvers}")));
    found
}

fn tempfile_in(folder: &std::path::Path) -> std::io::Result<()> {
    let path = folder.join(format!(".cullet-doctor-{}", std::process::id()));
    std::fs::write(&path, b"x")?;
    std::fs::remove_file(&path)
}

fn about_certificate(certificate: &Certificate) -> Finding {
    let (name, days) = (&certificate.name, certificate.left() as f64 / 86_400.0);
    let text = format!("{name:?}, good for {days:.1} days more");
    finding("certificate", days >= SOON, text)
}

fn there(endpoint: &str, link: &LinkConfig, who: &args::Who, found: &mut Vec<Finding>) {
    let asked = Instant::now();
    let patience = Duration::from_secs_f64(who.patience.clamp(0.1, 86_400.0));
    let client = Client::connect_as(endpoint, &link.rules, patience)
        .and_then(|client| client.with(&who.coordinator, &link.name));
    let client = match client {
        Ok(client) => client,
        Err(error) => {
            let text = link.trouble(&error, endpoint).to_string();
            found.push(finding("coordinator", false, text));
            return;
        }
    };
    // The first answer waits for the link; the second one is the way there and back.
    let about = client.question::<_, About>(UserVerb::About, &Nothing {});
    let connected = asked.elapsed();
    let asked = Instant::now();
    let about = about.and_then(|_| client.question::<_, About>(UserVerb::About, &Nothing {}));
    let about = match about {
        Ok(about) => about,
        Err(error) => {
            let text = link.trouble(&error, endpoint).to_string();
            found.push(finding("coordinator", false, text));
            return;
        }
    };
    let (way, first) = (asked.elapsed().as_secs_f64() * 1e3, connected.as_secs_f64());
    let text = format!("{endpoint} answers in {way:.1} ms, {first:.2} s with the connection");
    found.push(finding("coordinator", true, text));
    about_it(&about, found);
    match client.workers() {
        Ok(workers) => about_workers(&workers, found),
        Err(error) => found.push(finding("workers", false, error.to_string())),
    }
}

fn about_it(about: &About, found: &mut Vec<Finding>) {
    let same = about.version == env!("CARGO_PKG_VERSION") && about.wire == envelope::MAJOR;
    let text = format!("the coordinator is cullet {}, wire {}", about.version, about.wire);
    found.push(finding("versions", same, text));
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |now| now.as_secs_f64());
    let skew = about.now_ms as f64 / 1e3 - now;
    found.push(finding("clocks", skew.abs() <= SKEW, format!("they differ by {skew:.3} s")));
    let (up, cores) = (about.up_ms as f64 / 1e3, about.cores);
    let (at_once, queued, running) = (about.runs_at_once, about.queued, about.running);
    let text = format!(
        "up {up:.0} s, {cores} cores, {running} of at most {at_once} runs active, {queued} queued"
    );
    found.push(finding("runs", true, text));
    let room = about.free_bytes.map(|bytes| format!("{:.1} GB free", bytes as f64 / 1e9));
    let kept = match about.state.as_str() {
        "" => "no state folder: runs are forgotten when it ends".to_owned(),
        folder => format!("state in {folder}"),
    };
    let good = about.free_bytes.is_none_or(|bytes| bytes >= LITTLE);
    let text = format!("{kept}, {}", room.unwrap_or_else(|| "room unknown".to_owned()));
    found.push(finding("state", good, text));
}

/// Names that several workers have, which makes them one to whoever reads a list.
pub(crate) fn twins(workers: &[service::WorkerInfo]) -> impl Iterator<Item = String> {
    let mut names: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for worker in workers.iter().filter(|worker| worker.up && worker.twin) {
        names.entry(&worker.name).or_default().push(&worker.session);
    }
    names.into_iter().map(|(name, sessions)| {
        let (count, sessions) = (sessions.len(), sessions.join(", "));
        format!(
            "{count} workers are called {name} ({sessions}): lists, logs and timelines do not tell \
             them apart, and one word drains them all; give each a --name of its own"
        )
    })
}

/// What a worker is and what it can solve.
fn about_worker(worker: &service::WorkerInfo) -> String {
    let service::WorkerInfo { name, version, build, threads, cores, done, .. } = worker;
    let solves = worker.solvers.as_ref().map_or("anything".to_owned(), |all| all.join(", "));
    let memory = worker.memory.map_or_else(
        || ", any memory a job".to_owned(),
        |bytes| format!(", {} MiB a job", bytes >> 20),
    );
    format!(
        "{name}: version {version}, build {build}, {threads} threads of {cores} cores{memory}; \
         solves {solves}; {done} jobs done"
    )
}

fn about_workers(workers: &[service::WorkerInfo], found: &mut Vec<Finding>) {
    let up: Vec<_> = workers.iter().filter(|worker| worker.up && !worker.drained).collect();
    if up.is_empty() {
        found.push(finding("workers", false, "there is none: jobs wait until one comes"));
    }
    let builds: BTreeSet<&str> = up.iter().map(|worker| worker.build.as_str()).collect();
    if builds.len() > 1 {
        let all = builds.into_iter().collect::<Vec<_>>().join(", ");
        let text = format!("workers are of different builds, {all}: their bits may differ");
        found.push(finding("builds", false, text));
    }
    found.extend(twins(workers).map(|text| finding("names", false, text)));
    for worker in up {
        let same = worker.version == env!("CARGO_PKG_VERSION");
        found.push(finding("worker", same, about_worker(worker)));
    }
}
