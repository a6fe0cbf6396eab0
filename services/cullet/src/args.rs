//! What a person types.

mod farm;
mod limit;
mod voice;

pub(crate) use farm::DEFAULT_ENDPOINT;
pub(crate) use farm::{Doctor, Drain, Fetch, OfRun, OfRuns, Place, Ps, Router, Submit, What, Who};
pub(crate) use limit::{Memory, memory};
pub(crate) use voice::{Log, Voice};

use clap::{Args, Parser, Subcommand};
use cullet_lab::Sweep;
use cullet_proto::WorkerId;
use cullet_proto::keys::DEFAULT_COORDINATOR;
use cullet_record::RESOLVED_CELLS;
use std::path::PathBuf;

/// Cullet breaks things, truthfully and at scale.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100, after_help = EXIT_CODES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

pub(crate) const EXIT_CODES: &str = "Exit codes: 0 done · 1 doctor or inspect: something is not \
well · 2 the run failed: its world broke down · 3 the run is done, and an expectation of the \
scene or specimen does not hold · 4 the run is done, and a picture could not be drawn · 5 the run \
was cancelled · 6 the run stalled: the pool gave up a job of it (cullet retry) · 7 the run failed: \
its scene is wrong, as the coordinator found · 8 the run failed: a file of it could not be read \
or written, or its user holds too much of the disk · 64 arguments, a scene or a mesh are wrong · \
66 what was named is not there · 69 no coordinator answers, or it leaves · 70 this machine gives \
no thread, process or address, or there is a defect · 74 a file could not be read or written · \
75 not now: the queue or the disk is full, the run is not over, or another coordinator has the \
name · 76 what the coordinator sends is not sound · 77 the coordinator says no · 130 interrupted \
(the recording is finished). SIGINT, SIGTERM and SIGHUP end a run early but in order, a \
coordinator or a worker with code 0; a second SIGINT quits at once.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a scene here: a coordinator and worker processes on this machine
    Run(Run),
    /// Wait for submitted scenes and for workers from other terminals or machines
    Coordinator(Coordinator),
    /// Work for a coordinator
    Worker(Worker),
    /// Carry messages between coordinators, workers and clients that all connect to this
    Router(Router),
    /// Send a scene or a sweep to a coordinator, follow it, fetch what it recorded
    Submit(Submit),
    /// List the runs of a coordinator
    Ps(Ps),
    /// Say what is known of a run
    Show(OfRun),
    /// Print what a run has said
    Logs(OfRun),
    /// Watch a run until it is over
    Watch(OfRun),
    /// Wait for the end of a run; the exit code says which
    Wait(OfRun),
    /// End a run; its recording so far is kept
    Cancel(OfRun),
    /// Lay a run aside
    Pause(OfRun),
    /// Take up a run that was laid aside
    Resume(OfRun),
    /// Put a run that failed, stalled or was cancelled back into the queue
    Retry(OfRun),
    /// Delete runs that are over, with their recordings, from the coordinator's disk
    Delete(OfRuns),
    /// Fetch what a run recorded, or all runs of a sweep
    Fetch(Fetch),
    /// List the workers of a coordinator
    Workers(Ps),
    /// Give a worker no more jobs: it finishes the one at hand and leaves
    Drain(Drain),
    /// Look at a coordinator and at this machine: who is there, versions, clocks, disk, cores
    Doctor(Doctor),
    /// Say what a recording holds, from the recording alone
    Inspect(Inspect),
    /// Make a readable recording of one whose writer was killed
    Recover(Recover),
    /// Draw preview.png and preview.gif of a recording
    Preview(Preview),
    /// Draw one moment of a recording as a large picture
    Still(Still),
    /// Check a scene or a sweep and say what is in it, without running it
    Check(Check),
    /// List the material presets with the source of each value
    Materials(Materials),
    /// Print the reference of scene files, or the JSON schema of scene files, of specimen files or
    /// of standing sets
    Schema(Schema),
    /// Make a folder with a scene to begin with, which says what each of its keys means
    New(New),
    /// Print what makes a shell complete these commands
    Completions(Completions),
    /// Write manual pages of these commands
    Man(Man),
    /// Run specimens and hold their numbers against what is expected
    Bench(Bench),
    /// Run a standing set of specimens and scenes and draw error over cost
    Frontier(Frontier),
    /// Solve the job in a file, as a quarantined one is kept; without one, jobs that a worker sends
    #[command(hide = true)]
    Job(Job),
}

#[derive(Debug, Args)]
pub(crate) struct Job {
    /// The file, `job.bin` of a run that stalled or of a quarantine
    pub(crate) file: Option<PathBuf>,
    /// Threads to solve with
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: u16,
}

#[derive(Debug, Args)]
pub(crate) struct New {
    /// The folder to make; its name is the scene's
    #[arg(value_name = "NAME")]
    pub(crate) folder: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// For which shell
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub(crate) struct Man {
    /// Folder for the pages, a file for each command; it is made if it is not there
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct Schema {
    /// Print every key of scene files with unit, default, bounds and meaning, as Markdown
    #[arg(long, conflicts_with_all = ["specimen", "whole", "frontier"])]
    pub(crate) reference: bool,
    /// That of specimen files
    #[arg(long, conflicts_with_all = ["frontier", "whole"])]
    pub(crate) specimen: bool,
    /// That of specimens of the whole
    #[arg(long, conflicts_with = "frontier")]
    pub(crate) whole: bool,
    /// That of standing sets for `cullet frontier`
    #[arg(long)]
    pub(crate) frontier: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Frontier {
    /// The standing set
    #[arg(default_value = "tests/frontier/standing.toml", value_name = "SET")]
    pub(crate) set: PathBuf,
    /// Only the chart of this name; may be given more than once. Rows of others stay as they are
    #[arg(long, value_name = "NAME")]
    pub(crate) only: Vec<String>,
    /// Folder for MACHINE.csv and the charts in MACHINE/
    #[arg(long, default_value = "docs/frontier", value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// What this machine is called [default: its processor's name]
    #[arg(long, value_parser = machine)]
    pub(crate) machine: Option<String>,
    /// Longest wall time of a run in seconds; after it the run has the status `timeout`
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0, value_parser = moment)]
    pub(crate) limit: f64,
    /// Only the two coarsest points of each curve, with two seeds at most, as machine MACHINE-quick
    #[arg(long)]
    pub(crate) quick: bool,
    /// Run nothing: read MACHINE.csv, print and draw
    #[arg(long)]
    pub(crate) redraw: bool,
    /// Specimens or scenes run at once; more than 1 disturb each other's costs
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) workers: u16,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct Bench {
    /// Specimen files, or folders of them
    #[arg(required = true, value_name = "SPECIMEN|DIR")]
    pub(crate) specimens: Vec<PathBuf>,
    /// Run with each of these values, such as spacing=2mm,1mm,0.5mm; given more than once: with
    /// every combination
    #[arg(long, value_name = "KEY=A,B,C")]
    pub(crate) sweep: Vec<Sweep>,
    /// Override a value of every specimen, such as solver.precision=single
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) set: Vec<String>,
    /// Write a line for each metric of each run into this file
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write samples as CSV, points as MCAP and pictures of them as PNG into this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print results as JSON on standard output, a line a run
    #[arg(long)]
    pub(crate) json: bool,
    /// Runs at once [default: cores − 1, at least 1]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) workers: Option<u16>,
    /// Longest wall time of a run in seconds; after it the run has the status `timeout`
    #[arg(long, value_name = "SECONDS", default_value_t = 3600.0, value_parser = moment)]
    pub(crate) limit: f64,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// A scene file, the folder that holds scene.toml, or the file of a sweep
    pub(crate) scene: PathBuf,
    /// Override a value of the scene, such as world.duration=2 or body.target.mesh="bunny.obj"
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) set: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct Run {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Worker processes [default: cores − 1, at least 1]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) workers: Option<u16>,
    /// Threads a worker solves with
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: u16,
    /// Most memory in MiB that a job may hold, or none; one that takes more is ended. auto: what
    /// the machine or the container has, less a reserve, shared among the workers
    #[arg(long, value_name = "MIB", env = "CULLET_MEMORY", default_value = "auto",
        value_parser = memory)]
    pub(crate) memory: Memory,
    /// Where to put run.mcap, summary.json and the previews [default: runs/SCENE-N]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print the summary as JSON on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Draw no preview
    #[arg(long)]
    pub(crate) no_pictures: bool,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct Coordinator {
    /// Zenoh endpoint to listen on
    #[arg(long, default_value = DEFAULT_ENDPOINT, value_parser = endpoint)]
    pub(crate) listen: String,
    /// Zenoh endpoint of a router to connect to instead of listening
    #[arg(long, value_name = "ENDPOINT", conflicts_with = "listen", value_parser = endpoint)]
    pub(crate) router: Option<String>,
    /// What it is called: of several on one network each has a name of its own
    #[arg(long, default_value = DEFAULT_COORDINATOR, value_parser = name)]
    pub(crate) name: String,
    #[command(flatten)]
    pub(crate) guard: Guard,
    /// Folder that keeps the runs, so that they go on after a crash [default: they are forgotten]
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
    /// Most GB of finished jobs kept in the state folder for any later run; 0: none
    #[arg(long, value_name = "GB", default_value_t = 4.0, value_parser = moment)]
    pub(crate) cache: f64,
    /// Most GB of the disk that the runs of one user may hold; 0: no bound [default: half of it]
    #[arg(long, value_name = "GB", value_parser = moment)]
    pub(crate) quota: Option<f64>,
    /// Most memory in MiB that the coordinator itself may hold, or none: beyond it the run with the
    /// most bodies is stopped. auto: what the machine or the container has, less a reserve
    #[arg(long, value_name = "MIB", default_value = "auto", value_parser = memory)]
    pub(crate) world_memory: Memory,
    /// GB of the disk kept for runs that go on: with less no run is taken and none begins [default:
    /// a twentieth of it, at most 2]
    #[arg(long, value_name = "GB", value_parser = moment)]
    pub(crate) reserve: Option<f64>,
    /// Runs remembered; beyond it the oldest that is over is deleted, of the user who has most
    #[arg(long, default_value_t = 4096, value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) keep: u16,
    /// Runs at once; the others wait
    #[arg(
        long,
        default_value_t = 2,
        value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=64)
    )]
    pub(crate) runs: u16,
    /// Worker processes to start here
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    pub(crate) workers: u16,
    /// Threads each of them solves with
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: u16,
    /// Most memory in MiB that a job of theirs may hold, or none; one that takes more is ended.
    /// auto: what the machine or the container has, less a reserve, shared among them
    #[arg(long, value_name = "MIB", env = "CULLET_MEMORY", default_value = "auto",
        value_parser = memory)]
    pub(crate) memory: Memory,
    /// Folder for recordings [default: recordings in the state folder, or runs without one]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Leave after this many runs [default: stay until told to stop]
    #[arg(long, value_name = "N")]
    pub(crate) stop_after: Option<u32>,
    /// Answer /metrics (Prometheus), /healthz and /readyz over HTTP here, such as 127.0.0.1:9464;
    /// beyond this machine only with --insecure
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) metrics: Option<std::net::SocketAddr>,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

/// Who may come in.
#[derive(Debug, Args)]
pub(crate) struct Guard {
    /// Folder with ca.pem, cert.pem and key.pem: mutual TLS, with an endpoint tls/HOST:PORT
    #[arg(long, value_name = "DIR", requires = "roles")]
    pub(crate) tls: Option<PathBuf>,
    /// File with the names of certificates that may work, that may submit, and that may control
    /// what is others': workers = ["a"], users = ["ann"], operators = ["olga"]
    #[arg(long, value_name = "FILE", requires = "tls")]
    pub(crate) roles: Option<PathBuf>,
    /// Listen beyond this machine without TLS, and answer metrics there, which have none
    #[arg(long)]
    pub(crate) insecure: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Worker {
    /// Zenoh endpoint of the coordinator or its router; may be given more than once, for other ways
    /// to the same coordinator: a worker works for one at a time, the first that it reaches
    #[arg(long, required = true, value_name = "ENDPOINT", env = "CULLET_CONNECT",
        value_parser = endpoint)]
    pub(crate) connect: Vec<String>,
    /// For which coordinator, where there are several on a network: its --name
    #[arg(long, value_name = "NAME", env = "CULLET_COORDINATOR",
        default_value = DEFAULT_COORDINATOR, value_parser = name)]
    pub(crate) coordinator: String,
    /// Folder with ca.pem, cert.pem and key.pem: mutual TLS
    #[arg(long, value_name = "DIR", env = "CULLET_TLS")]
    pub(crate) tls: Option<PathBuf>,
    /// Name in logs and recordings [default: the certificate's, or from the process id]
    #[arg(long, value_parser = name)]
    pub(crate) name: Option<String>,
    /// Threads to solve with
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: u16,
    /// Most memory in MiB that a job may hold, or none; one that takes more is ended. auto: what
    /// the machine or the container has, less a reserve
    #[arg(long, value_name = "MIB", env = "CULLET_MEMORY", default_value = "auto",
        value_parser = memory)]
    pub(crate) memory: Memory,
    /// Leave when standard input closes, as it does when the parent process ends
    #[arg(long, hide = true)]
    pub(crate) parent_watch: bool,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct Inspect {
    /// The recording, or the folder of a run
    pub(crate) recording: PathBuf,
    /// More recordings, of other seeds, whose masses are fitted together with the first one's
    #[arg(requires = "masses")]
    pub(crate) more: Vec<PathBuf>,
    /// Print the summary as JSON on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the fragments' masses as CSV, and the laws fitted to them
    #[arg(long, conflicts_with = "json")]
    pub(crate) masses: bool,
    /// Fit fragments of at least so many cells of the grid that made them
    #[arg(long, value_name = "N", requires = "masses", default_value_t = RESOLVED_CELLS)]
    pub(crate) cells: f64,
}

#[derive(Debug, Args)]
pub(crate) struct Recover {
    /// The recording, usually run.mcap.partial, or the folder of a run
    pub(crate) recording: PathBuf,
    /// The file to write [default: the name without .partial, or with .recovered.mcap]
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Preview {
    /// The recording, or the folder of a run
    pub(crate) recording: PathBuf,
    /// Folder for the pictures [default: beside the recording]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Still {
    /// The recording, or the folder of a run
    pub(crate) recording: PathBuf,
    /// When, in seconds of the run [default: a moment after the first break]
    #[arg(long, value_name = "SECONDS", value_parser = moment)]
    pub(crate) at: Option<f64>,
    /// Pixels across and down
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = size)]
    pub(crate) size: (usize, usize),
    /// Let what breaks fill the picture
    #[arg(long)]
    pub(crate) close: bool,
    /// The file to write, which ends in .png [default: still.png beside the recording]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
}

#[derive(Debug, Args)]
pub(crate) struct Materials {
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// An endpoint as the transport takes it: `tcp/HOST:PORT` or `tls/HOST:PORT`, and what Zenoh may be
/// told after it.
fn endpoint(text: &str) -> Result<String, String> {
    let place = text.split(['?', '#']).next().unwrap_or_default();
    let kind = place.strip_prefix("tcp/").or_else(|| place.strip_prefix("tls/"));
    let parts = kind.and_then(|place| place.rsplit_once(':'));
    match parts {
        Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => {
            Ok(text.to_owned())
        }
        _ => {
            Err("an endpoint is tcp/HOST:PORT or tls/HOST:PORT, such as tcp/127.0.0.1:7447"
                .to_owned())
        }
    }
}

/// A name that is a file's and a folder's.
fn machine(text: &str) -> Result<String, String> {
    let fits = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let named = !text.is_empty() && text.len() <= 64 && !text.starts_with('.');
    let good = named && text.chars().all(fits);
    let bad = "a machine's name is 1 to 64 letters, digits, `-`, `_` or `.`, no `.` first";
    if good { Ok(text.to_owned()) } else { Err(bad.to_owned()) }
}

fn moment(text: &str) -> Result<f64, String> {
    let time: Option<f64> = text.parse().ok().filter(|time: &f64| time.is_finite() && *time >= 0.0);
    time.ok_or_else(|| "a moment is a number of seconds from 0 on".to_owned())
}

/// Least and most pixels of a side of a still.
const PIXELS: std::ops::RangeInclusive<usize> = 16..=7680;

fn size(text: &str) -> Result<(usize, usize), String> {
    let sides = text.split_once(['x', 'X']);
    let number = |text: &str| text.trim().parse().ok().filter(|n| PIXELS.contains(n));
    let read = sides.and_then(|(across, down)| Some((number(across)?, number(down)?)));
    let (least, most) = (PIXELS.start(), PIXELS.end());
    read.ok_or_else(|| format!("a size is WIDTHxHEIGHT, each {least} to {most}, such as 1920x1080"))
}

fn name(text: &str) -> Result<String, String> {
    WorkerId::new(text).map(|name| name.to_string()).map_err(|error| error.to_string())
}
