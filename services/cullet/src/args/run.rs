//! What is run: scenes and sweeps, here or as a job of a render farm.

use super::{CloseArgs, Command, Memory, SheetArgs, Voice, WebAddress};
use super::{memory, own_address, read_whole};
use crate::exit::CommandError;
use clap::Args;
use cullet::RunAgain;
use cullet_files::regular;
use std::net::SocketAddr;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// A scene file, a folder with a scene.toml, or a sweep file
    pub(crate) scene: PathBuf,
    /// Override a value of the scene, such as world.duration=2 or body.target.mesh="bunny.obj"
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) set: Vec<String>,
    /// Override the values in this file, one PATH=VALUE per line, before those of --set; blank
    /// lines and lines that begin with # are skipped
    #[arg(long, value_name = "FILE")]
    pub(crate) set_file: Option<PathBuf>,
    /// Solve coarsely for a first look, about so many times cheaper: short for
    /// --set fidelity.draft=TIMES
    #[arg(long, value_name = "TIMES", num_args = 0..=1, require_equals = true,
        default_missing_value = "7")]
    pub(crate) draft: Option<String>,
}

impl SceneArgs {
    /// Puts what is in the file of overrides, and what makes a draft, before the others.
    pub(crate) fn take_set_file(&mut self) -> Result<(), CommandError> {
        if let Some(times) = self.draft.take() {
            self.set.insert(0, format!("fidelity.draft={times}"));
        }
        let Some(path) = self.set_file.take() else { return Ok(()) };
        let text = regular::read_text(&path).map_err(|error| CommandError::file(&path, error))?;
        let lines = text.lines().map(str::trim);
        let told = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
        self.set.splice(0..0, told.map(str::to_owned));
        Ok(())
    }
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Worker processes [default: cores − 1, at least 1]
    #[arg(long, value_parser = read_whole::<u16>(1..=256))]
    pub(crate) workers: Option<u16>,
    /// Threads with which a worker solves a job
    #[arg(long, default_value_t = 1, value_parser = read_whole::<u16>(1..=256))]
    pub(crate) threads: u16,
    /// Memory limit of a job in MiB, or none; a job that exceeds it is ended. auto: the memory of
    /// the machine or container, less a reserve, divided among the workers
    #[arg(long, value_name = "MIB", env = "CULLET_MEMORY", default_value = "auto",
        value_parser = memory)]
    pub(crate) memory: Memory,
    /// Folder for run.mcap, summary.json and the previews [default: runs/SCENE-N]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Delete the run that is in the folder first: a job that is tried again begins anew
    #[arg(long, requires = "out")]
    pub(crate) replace: bool,
    #[command(flatten)]
    pub(crate) again: AgainArgs,
    #[command(flatten)]
    pub(crate) part: PartArgs,
    #[command(flatten)]
    pub(crate) sheet: SheetArgs,
    #[command(flatten)]
    pub(crate) close: CloseArgs,
    /// Print the summary to standard output as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Do not draw the previews
    #[arg(long)]
    pub(crate) no_pictures: bool,
    /// Show the run as a page for a browser on this machine while it goes on
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true,
        default_missing_value = "127.0.0.1:8080", value_parser = WebAddress::parse)]
    pub(crate) live: Option<WebAddress>,
    /// Serve the run to Foxglove and Lichtblick on this machine while it goes on
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true,
        default_missing_value = "127.0.0.1:8765", value_parser = own_address)]
    pub(crate) foxglove: Option<SocketAddr>,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

/// Which earlier run is taken up, and what is kept for later ones.
#[derive(Debug, Args)]
pub(crate) struct AgainArgs {
    /// Take up an earlier run, by its folder: jobs whose problem is the same take the result from
    /// there, and only the others are solved. The digest of the run is the same without it
    #[arg(long, value_name = "RUN")]
    pub(crate) from: Option<PathBuf>,
    /// Resume that run at step N: whatever is set anew, the steps before N must come out as they
    /// are recorded there, or this run is refused
    #[arg(long, value_name = "N", requires = "from",
        value_parser = read_whole::<u64>(0..=i64::MAX))]
    pub(crate) from_step: Option<u64>,
    /// Keep up to so many MiB of results of jobs beside the recording, in the folder results, for a
    /// later --from; 0: none. A sweep keeps none
    #[arg(long, value_name = "MIB", default_value_t = 1024,
        value_parser = read_whole::<u64>(0..=16_777_216))]
    pub(crate) results: u64,
}

impl AgainArgs {
    pub(crate) fn options(&self) -> RunAgain<'_> {
        RunAgain { keep: self.results << 20, ..self.of_sweep() }
    }

    /// The same for the runs of a sweep.
    pub(crate) fn of_sweep(&self) -> RunAgain<'_> {
        RunAgain { from: self.from.as_deref(), from_step: self.from_step, keep: 0 }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
}

/// How much of a sweep is done.
#[derive(Debug, Args)]
pub(crate) struct PartArgs {
    /// Of a sweep, do only run N, into the folder N of --out; code 0 if it is done, also if an
    /// expectation does not hold, which --gather reports
    #[arg(long, value_name = "N", requires = "out",
        value_parser = read_whole::<usize>(1..=i64::MAX))]
    pub(crate) only: Option<usize>,
    /// Of a sweep, run nothing: draw the sheet and write the table of the runs that are in --out
    #[arg(long, requires = "out", conflicts_with_all = ["only", "replace", "live", "foxglove"])]
    pub(crate) gather: bool,
}

/// What a template for render farms is made from.
#[derive(Debug, Args)]
pub(crate) struct OpenJobArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) sheet: SheetArgs,
    /// The file to write, ending in .json, such as template.json [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

impl Command {
    /// The scene or sweep that it is about.
    pub(crate) fn scene(&mut self) -> Option<&mut SceneArgs> {
        match self {
            Self::Run(args) => Some(&mut args.scene),
            Self::Submit(args) => Some(&mut args.scene),
            Self::Check(args) => Some(&mut args.scene),
            Self::OpenJob(args) => Some(&mut args.scene),
            _ => None,
        }
    }
}
