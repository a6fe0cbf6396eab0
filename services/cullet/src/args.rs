//! The command line: commands, their arguments and their help.

mod export;
mod farm;
mod limit;
mod new;
mod picture;
mod run;
mod voice;
mod web;

pub(crate) use export::{ExportArgs, ReportArgs};
pub(crate) use farm::DEFAULT_ENDPOINT;
pub(crate) use farm::{
    ConnectArgs, Doctor, DrainArgs, FetchArgs, OfRun, OfRuns, Ps, RouterArgs, SubmitArgs, What, Who,
};
pub(crate) use limit::{Memory, duration, memory, read_whole};
pub(crate) use new::{New, Scenes};
pub(crate) use picture::{CloseArgs, Preview, SheetArgs, StillArgs};
pub(crate) use run::{Check, OpenJobArgs, RunArgs, SceneArgs};
pub(crate) use voice::{Log, Voice};
pub(crate) use web::{WebAddress, own_address, read_address};

use clap::{Args, Parser, Subcommand};
use cullet_lab::SweptSetting;
use cullet_proto::WorkerId;
use cullet_proto::keys::DEFAULT_COORDINATOR;
use cullet_record::RESOLVED_CELLS;
use std::path::PathBuf;

/// Simulate things that break, on this machine or on a farm of workers
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100, after_help = EXIT_CODES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

pub(crate) const EXIT_CODES: &str = "Exit codes: 0 done · 1 doctor or inspect found a problem · \
2 the run failed: the simulation broke down · 3 the run is done, but an expectation of the scene \
or specimen does not hold · 4 the run is done, but a picture could not be drawn · 5 the run was \
cancelled · 6 the run stalled: the pool gave up one of its jobs (cullet retry) · 7 the run \
failed: the coordinator found an error in its scene · 8 the run failed: one of its files could \
not be read or written, or its user holds too much of the disk · 64 an argument, a scene or a \
mesh is wrong · 66 the run, worker or file does not exist · 69 no coordinator answers, or it is \
shutting down · 70 this machine has no thread, process or address left, or there is a bug · 74 a \
file could not be read or written · 75 not now: the queue or the disk is full, the run is not \
over, or another coordinator has the name · 76 the coordinator sent something invalid · 77 the \
coordinator refused · 130 interrupted (the recording is finished first). SIGINT, SIGTERM and \
SIGHUP end a run early but cleanly, and a coordinator or a worker with code 0; a second SIGINT \
quits at once.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a scene on this machine, with worker processes of its own
    Run(RunArgs),
    /// Run the scenes that clients submit, with workers from other terminals or machines
    Coordinator(Coordinator),
    /// Solve jobs for a coordinator
    Worker(WorkerArgs),
    /// Relay messages between coordinators, workers and clients that connect to it
    Router(RouterArgs),
    /// Send a scene or a sweep to a coordinator, follow it, and fetch its results
    Submit(SubmitArgs),
    /// List the runs of a coordinator
    Ps(Ps),
    /// Print the details of a run
    Show(OfRun),
    /// Print the log of a run
    Logs(OfRun),
    /// Show the progress and the log of a run until it is over
    Watch(OfRun),
    /// Wait for a run to end; the exit code says how it ended
    Wait(OfRun),
    /// Cancel a run; its recording so far is kept
    Cancel(OfRun),
    /// Pause a run
    Pause(OfRun),
    /// Resume a paused run
    Resume(OfRun),
    /// Queue a failed, stalled or cancelled run again
    Retry(OfRun),
    /// Delete runs that are over, with their recordings, from the coordinator's disk
    Delete(OfRuns),
    /// Fetch the results of a run, or of all runs of a sweep
    Fetch(FetchArgs),
    /// List the workers of a coordinator
    Workers(Ps),
    /// Drain a worker: it finishes its current job, gets no other, and exits
    Drain(DrainArgs),
    /// Check a coordinator and this machine: connections, versions, clocks, disk, cores
    Doctor(Doctor),
    /// Print the events and the summary of a recording
    Inspect(Inspect),
    /// Repair a recording whose writer was killed
    Recover(Recover),
    /// Draw preview.png and preview.gif from a recording
    Preview(Preview),
    /// Draw one moment of a recording as a large picture
    Still(StillArgs),
    /// Write a recording as GLB, USD, tables or pieces, for Blender, Houdini, Unreal and browsers
    Export(ExportArgs),
    /// Write a run or a sweep as one page for a browser, which opens without a server
    Report(ReportArgs),
    /// Check a scene or a sweep and list its contents, without running it
    Check(Check),
    /// Write a scene or a sweep as an Open Job Description template, for render farms
    #[command(name = "openjd")]
    OpenJob(OpenJobArgs),
    /// List the material presets with the source of each value
    Materials(Materials),
    /// Print the JSON schema of scene files, specimens, scene benchmarks or benchmark suites, the
    /// reference of scene files, or the messages of a recording
    Schema(Schema),
    /// Create a folder with a scene: a commented one, a copy of a shipped one, or one of a mesh
    New(New),
    /// List the scenes that are shipped with this program, for `cullet new --from`
    Scenes(Scenes),
    /// Print the completion script for a shell
    Completions(Completions),
    /// Write the manual pages of all commands
    Man(Man),
    /// Run benchmark specimens and compare their results with the expected values
    Bench(Bench),
    /// Run a benchmark suite and plot error against cost
    Frontier(Frontier),
    /// Solve the job in a file, such as a quarantined one; without a file, the jobs a worker sends
    #[command(hide = true)]
    Job(JobArgs),
}

impl Command {
    /// Whether it asks a coordinator and does nothing else.
    pub(crate) fn is_client(&self) -> bool {
        matches!(
            self,
            Self::Submit(_)
                | Self::Ps(_)
                | Self::Show(_)
                | Self::Logs(_)
                | Self::Watch(_)
                | Self::Wait(_)
                | Self::Cancel(_)
                | Self::Pause(_)
                | Self::Resume(_)
                | Self::Retry(_)
                | Self::Delete(_)
                | Self::Fetch(_)
                | Self::Workers(_)
                | Self::Drain(_)
                | Self::Doctor(_)
        )
    }
}

#[derive(Debug, Args)]
pub(crate) struct JobArgs {
    /// The file: `job.bin` of a stalled run or from the quarantine
    pub(crate) file: Option<PathBuf>,
    /// Threads that solve a job
    #[arg(long, default_value_t = 1, value_parser = read_whole::<u16>(1..=256))]
    pub(crate) threads: u16,
}

#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// The shell
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub(crate) struct Man {
    /// Folder for the pages, one file per command; it is created if it does not exist
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct Schema {
    /// Print every key of a scene file with unit, default, bounds and meaning, as Markdown
    #[arg(long, conflicts_with_all = ["recording", "specimen", "whole", "frontier"])]
    pub(crate) reference: bool,
    /// Print the messages of a recording as a Protocol Buffers file
    #[arg(long, conflicts_with_all = ["specimen", "whole", "frontier"])]
    pub(crate) recording: bool,
    /// Print the schema of benchmark specimens
    #[arg(long, conflicts_with_all = ["frontier", "whole"])]
    pub(crate) specimen: bool,
    /// Print the schema of scene benchmarks
    #[arg(long, conflicts_with = "frontier")]
    pub(crate) whole: bool,
    /// Print the schema of benchmark suites, which `cullet frontier` runs
    #[arg(long)]
    pub(crate) frontier: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Frontier {
    /// The benchmark suite
    #[arg(default_value = "tests/frontier/standing.toml", value_name = "SET")]
    pub(crate) set: PathBuf,
    /// Run only the chart of this name, and keep the rows of the others; may be repeated
    #[arg(long, value_name = "NAME")]
    pub(crate) only: Vec<String>,
    /// Folder for MACHINE.csv and for the charts in MACHINE/
    #[arg(short, long, default_value = "docs/frontier", value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Name of this machine [default: the name of its processor]
    #[arg(long, value_parser = machine)]
    pub(crate) machine: Option<String>,
    /// Longest wall time of a run, in seconds; a longer run is ended with the status `timeout`
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0, value_parser = non_negative)]
    pub(crate) limit: f64,
    /// Run only the two coarsest points of each curve, with at most two seeds, and name the machine
    /// MACHINE-quick
    #[arg(long)]
    pub(crate) quick: bool,
    /// Run nothing; print and plot what MACHINE.csv holds
    #[arg(long)]
    pub(crate) redraw: bool,
    /// Specimens or scenes to run at once; with more than 1 they affect each other's cost
    #[arg(long, default_value_t = 1, value_parser = read_whole::<u16>(1..=256))]
    pub(crate) workers: u16,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct Bench {
    /// Specimen files, or folders that contain them
    #[arg(required = true, value_name = "SPECIMEN|DIR")]
    pub(crate) specimens: Vec<PathBuf>,
    /// Run with each of these values, such as spacing=2mm,1mm,0.5mm; if repeated, with every
    /// combination
    #[arg(long, value_name = "KEY=A,B,C")]
    pub(crate) sweep: Vec<SweptSetting>,
    /// Override a value of every specimen, such as solver.precision=single
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) set: Vec<String>,
    /// Write one line per metric and run to this file
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write samples as CSV, points as MCAP and pictures as PNG to this folder
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print the results to standard output as JSON, one line per run
    #[arg(long)]
    pub(crate) json: bool,
    /// Runs to do at once [default: cores − 1, at least 1]
    #[arg(long, value_parser = read_whole::<u16>(1..=256))]
    pub(crate) workers: Option<u16>,
    /// Longest wall time of a run, in seconds; a longer run is ended with the status `timeout`
    #[arg(long, value_name = "SECONDS", default_value_t = 3600.0, value_parser = non_negative)]
    pub(crate) limit: f64,
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
    /// Name of this coordinator, which must be unique on its network
    #[arg(long, default_value = DEFAULT_COORDINATOR, value_parser = name)]
    pub(crate) name: String,
    #[command(flatten)]
    pub(crate) guard: AccessArgs,
    /// Folder in which runs are kept, so that they continue after a crash [default: none is kept]
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
    /// Size in GB of the cache of finished jobs in the state folder; 0: no cache
    #[arg(long, value_name = "GB", default_value_t = 4.0, value_parser = non_negative)]
    pub(crate) cache: f64,
    /// Disk quota of each user's runs in GB; 0: no quota [default: half of the disk]
    #[arg(long, value_name = "GB", value_parser = non_negative)]
    pub(crate) quota: Option<f64>,
    /// Memory limit of the coordinator itself in MiB, or none; beyond it the run with the most
    /// bodies is stopped. auto: the memory of the machine or container, less a reserve
    #[arg(long, value_name = "MIB", default_value = "auto", value_parser = memory)]
    pub(crate) world_memory: Memory,
    /// Free disk space in GB that is reserved for active runs; with less, no run is accepted or
    /// started [default: a twentieth of the disk, at most 2]
    #[arg(long, value_name = "GB", value_parser = non_negative)]
    pub(crate) reserve: Option<f64>,
    /// Number of runs to keep; beyond it, the oldest finished run of the user with the most runs
    /// is deleted
    #[arg(long, default_value_t = 4096, value_name = "N",
        value_parser = read_whole::<u16>(1..=4096))]
    pub(crate) keep: u16,
    /// Number of runs to do at once; the others wait
    #[arg(
        long,
        default_value_t = 2,
        value_name = "N",
        value_parser = read_whole::<u16>(1..=64)
    )]
    pub(crate) runs: u16,
    /// Worker processes to start on this machine
    #[arg(long, default_value_t = 0, value_parser = read_whole::<u16>(0..=256))]
    pub(crate) workers: u16,
    /// Threads with which each of these workers solves a job
    #[arg(long, default_value_t = 1, value_parser = read_whole::<u16>(1..=256))]
    pub(crate) threads: u16,
    /// Memory limit of a job of these workers in MiB, or none; a job that exceeds it is ended.
    /// auto: the memory of the machine or container, less a reserve, divided among these workers
    #[arg(long, value_name = "MIB", env = "CULLET_MEMORY", default_value = "auto",
        value_parser = memory)]
    pub(crate) memory: Memory,
    /// Folder for recordings [default: recordings in the state folder; without one, runs]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Exit after this many runs [default: run until stopped]
    #[arg(long, value_name = "N", value_parser = read_whole::<u32>(0..=i64::from(u32::MAX)))]
    pub(crate) stop_after: Option<u32>,
    /// Serve /metrics (Prometheus), /healthz and /readyz over HTTP at this address, such as
    /// 127.0.0.1:9464; an address that other machines reach needs --insecure
    #[arg(long, value_name = "ADDRESS", value_parser = read_address)]
    pub(crate) metrics: Option<std::net::SocketAddr>,
    /// Serve the farm as a page for browsers at this address: 127.0.0.1:8080, for this machine
    /// alone, or tls/HOST-IP:PORT, for users and operators who show their certificates
    #[arg(long, value_name = "ADDRESS", value_parser = WebAddress::parse)]
    pub(crate) web: Option<WebAddress>,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

/// Who may connect.
#[derive(Debug, Args)]
pub(crate) struct AccessArgs {
    /// Folder with ca.pem, cert.pem and key.pem for mutual TLS; the endpoint is then tls/HOST:PORT
    #[arg(long, value_name = "DIR", requires = "roles")]
    pub(crate) tls: Option<PathBuf>,
    /// File that names the certificates of workers, of users (who submit runs) and of operators
    /// (who control everybody's runs): workers = ["a"], users = ["ann"], operators = ["olga"]
    #[arg(long, value_name = "FILE", requires = "tls")]
    pub(crate) roles: Option<PathBuf>,
    /// Let other machines connect without TLS, and read the metrics, which have no TLS
    #[arg(long)]
    pub(crate) insecure: bool,
}

#[derive(Debug, Args)]
pub(crate) struct WorkerArgs {
    /// Zenoh endpoint of the coordinator or its router; may be repeated, for other ways to the same
    /// coordinator: a worker uses the first endpoint that it reaches
    #[arg(long, value_name = "ENDPOINT", env = "CULLET_CONNECT", default_value = DEFAULT_ENDPOINT,
        value_parser = endpoint)]
    pub(crate) connect: Vec<String>,
    /// Name of the coordinator (its --name), if there are several on the network
    #[arg(long, value_name = "NAME", env = "CULLET_COORDINATOR",
        default_value = DEFAULT_COORDINATOR, value_parser = name)]
    pub(crate) coordinator: String,
    /// Folder with ca.pem, cert.pem and key.pem for mutual TLS
    #[arg(long, value_name = "DIR", env = "CULLET_TLS")]
    pub(crate) tls: Option<PathBuf>,
    /// Name in logs and recordings [default: the certificate's name, or one with the process id]
    #[arg(long, value_parser = name)]
    pub(crate) name: Option<String>,
    /// Threads that solve a job
    #[arg(long, default_value_t = 1, value_parser = read_whole::<u16>(1..=256))]
    pub(crate) threads: u16,
    /// Memory limit of a job in MiB, or none; a job that exceeds it is ended. auto: the memory of
    /// the machine or container, less a reserve
    #[arg(long, value_name = "MIB", env = "CULLET_MEMORY", default_value = "auto",
        value_parser = memory)]
    pub(crate) memory: Memory,
    /// Exit with code 0 after this long without a job, such as 90, 90s, 5min or 2h, also if no
    /// coordinator answers [default: stay]
    #[arg(long, value_name = "DURATION", value_parser = duration)]
    pub(crate) exit_when_idle: Option<std::time::Duration>,
    /// Exit when standard input closes, as it does when the parent process ends
    #[arg(long, hide = true)]
    pub(crate) parent_watch: bool,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct Inspect {
    /// A recording, or the folder of a run
    pub(crate) recording: PathBuf,
    /// More recordings, such as of other seeds, to fit together with the first
    #[arg(requires = "masses")]
    pub(crate) more: Vec<PathBuf>,
    /// Print the summary to standard output as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the masses of the fragments as CSV, and the distributions fitted to them
    #[arg(long, conflicts_with = "json")]
    pub(crate) masses: bool,
    /// Fit only fragments of at least this many grid cells
    #[arg(long, value_name = "N", requires = "masses", default_value_t = RESOLVED_CELLS,
        value_parser = non_negative)]
    pub(crate) cells: f64,
    /// Print the largest pieces of each object beside those of this run, such as a draft's beside
    /// the final's, and how far they are apart
    #[arg(long, value_name = "RUN", conflicts_with_all = ["json", "masses"])]
    pub(crate) against: Option<PathBuf>,
    /// So many of the largest pieces
    #[arg(long, value_name = "N", requires = "against", default_value_t = 5,
        value_parser = read_whole::<usize>(0..=i64::MAX))]
    pub(crate) largest: usize,
}

#[derive(Debug, Args)]
pub(crate) struct Recover {
    /// A recording, usually run.mcap.partial, or the folder of a run
    pub(crate) recording: PathBuf,
    /// The file to write [default: the recording's name without .partial, or with .recovered.mcap]
    #[arg(short, long)]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Materials {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// An endpoint of the transport: `tcp/HOST:PORT` or `tls/HOST:PORT`, and options of Zenoh after it.
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
    let bad =
        "a machine's name has 1 to 64 letters, digits, `-`, `_` or `.`, and no `.` at its start";
    if good { Ok(text.to_owned()) } else { Err(bad.to_owned()) }
}

fn non_negative(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    let number = number.filter(|number| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| "it must be a number of at least 0".to_owned())
}

/// Least and most pixels of a side of a still.
const PIXELS: std::ops::RangeInclusive<usize> = 16..=7680;

fn size(text: &str) -> Result<(usize, usize), String> {
    let sides = text.split_once(['x', 'X']);
    let number = |text: &str| text.trim().parse().ok().filter(|n| PIXELS.contains(n));
    let read = sides.and_then(|(across, down)| Some((number(across)?, number(down)?)));
    let (least, most) = (PIXELS.start(), PIXELS.end());
    read.ok_or_else(|| {
        format!("a size is WIDTHxHEIGHT, each from {least} to {most}, such as 1920x1080")
    })
}

fn name(text: &str) -> Result<String, String> {
    WorkerId::new(text).map(|name| name.to_string()).map_err(|error| error.to_string())
}
