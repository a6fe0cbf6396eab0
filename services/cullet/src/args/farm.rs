//! Commands to a farm, their arguments and their help.

use super::{AccessArgs, SceneArgs, SheetArgs, Voice};
use super::{endpoint, name, non_negative, read_whole};
use clap::Args;
use cullet_proto::keys::DEFAULT_COORDINATOR;
use std::path::PathBuf;

/// Where a coordinator listens by default.
pub(crate) const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7447";

/// Where the coordinator is, and who asks.
#[derive(Debug, Args)]
pub(crate) struct ConnectArgs {
    /// Zenoh endpoint of the coordinator
    #[arg(long, value_name = "ENDPOINT", env = "CULLET_CONNECT", default_value = DEFAULT_ENDPOINT,
        value_parser = endpoint)]
    pub(crate) connect: String,
    #[command(flatten)]
    pub(crate) who: Who,
}

/// Who asks, and in which form the answer is printed.
#[derive(Debug, Args)]
pub(crate) struct Who {
    /// Folder with ca.pem, cert.pem and key.pem for mutual TLS
    #[arg(long, value_name = "DIR", env = "CULLET_TLS")]
    pub(crate) tls: Option<PathBuf>,
    /// Name of the user; runs of different users share the workers evenly [default: the
    /// certificate's name, or user]
    #[arg(long, value_name = "NAME", env = "CULLET_USER", value_parser = name)]
    pub(crate) user: Option<String>,
    /// Name of the coordinator (its --name), if there are several on the network
    #[arg(long, value_name = "NAME", env = "CULLET_COORDINATOR",
        default_value = DEFAULT_COORDINATOR, value_parser = name)]
    pub(crate) coordinator: String,
    /// Longest time in seconds to try to connect, and then to wait for each answer
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = non_negative)]
    pub(crate) patience: f64,
    /// Print JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct RouterArgs {
    /// Zenoh endpoint to listen on
    #[arg(long, default_value = DEFAULT_ENDPOINT, value_parser = endpoint)]
    pub(crate) listen: String,
    /// Print the router's settings as a configuration file for zenohd (zenohd -c FILE), and exit
    #[arg(long)]
    pub(crate) print_config: bool,
    #[command(flatten)]
    pub(crate) guard: AccessArgs,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct SubmitArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) place: ConnectArgs,
    /// Priority, from -100 to 100; higher ones run first
    #[arg(long, default_value_t = 0, allow_hyphen_values = true,
        value_parser = read_whole::<i32>(-100..=100))]
    pub(crate) priority: i32,
    /// Of a sweep, submit only the runs that the coordinator does not have yet
    #[arg(long)]
    pub(crate) rest: bool,
    /// Print the run's number and exit; see `watch`, `wait` and `fetch`
    #[arg(long, conflicts_with_all = ["watch", "out"])]
    pub(crate) detach: bool,
    /// Show the progress while it runs, as `watch` does
    #[arg(long)]
    pub(crate) watch: bool,
    /// Folder for the results [default: runs/SCENE-N]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) sheet: SheetArgs,
}

/// A run at a coordinator.
#[derive(Debug, Args)]
pub(crate) struct OfRun {
    /// The run's number, as `submit` and `ps` print it
    #[arg(value_name = "RUN", value_parser = number)]
    pub(crate) run: u64,
    #[command(flatten)]
    pub(crate) place: ConnectArgs,
}

/// Runs at a coordinator.
#[derive(Debug, Args)]
pub(crate) struct OfRuns {
    /// The runs' numbers, as `submit` and `ps` print them
    #[arg(value_name = "RUN", required = true, value_parser = number)]
    pub(crate) runs: Vec<u64>,
    #[command(flatten)]
    pub(crate) place: ConnectArgs,
}

#[derive(Debug, Args)]
pub(crate) struct Ps {
    #[command(flatten)]
    pub(crate) place: ConnectArgs,
}

#[derive(Debug, Args)]
pub(crate) struct FetchArgs {
    /// The number of a run, or a sweep file, for all of its runs with a contact sheet and a table
    #[arg(value_name = "RUN|SWEEP", value_parser = what)]
    pub(crate) what: What,
    #[command(flatten)]
    pub(crate) place: ConnectArgs,
    /// Follow the run to its end first
    #[arg(long)]
    pub(crate) follow: bool,
    /// With a sweep, the same --set values as for its `submit`
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) set: Vec<String>,
    /// Folder for the results [default: runs/SCENE-N]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) sheet: SheetArgs,
}

/// What is fetched.
#[derive(Clone, Debug)]
pub(crate) enum What {
    /// The run of this number.
    Run(u64),
    /// The runs of the sweep in this file.
    Sweep(PathBuf),
}

fn number(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| "a run is named by its number, as `submit` and `ps` print it".to_owned())
}

#[allow(clippy::unnecessary_wraps, reason = "a parser of arguments")]
fn what(text: &str) -> Result<What, String> {
    Ok(text.parse().map_or_else(|_| What::Sweep(text.into()), What::Run))
}

#[derive(Debug, Args)]
pub(crate) struct Doctor {
    /// Zenoh endpoint of a coordinator; without one, only this machine is checked
    #[arg(long, value_name = "ENDPOINT", env = "CULLET_CONNECT", value_parser = endpoint)]
    pub(crate) connect: Option<String>,
    /// Folder whose disk is checked
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub(crate) disk: PathBuf,
    #[command(flatten)]
    pub(crate) who: Who,
}

#[derive(Debug, Args)]
pub(crate) struct DrainArgs {
    /// The worker's name, as `workers` prints it
    pub(crate) worker: String,
    #[command(flatten)]
    pub(crate) place: ConnectArgs,
}
