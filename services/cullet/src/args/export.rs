//! `cullet export` and `cullet report`: what is written for other programs, and as what.

use super::non_negative;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// A recording, or the folder of a run
    pub(crate) recording: PathBuf,
    /// The file to write, ending in .glb (Blender, Unreal, browsers), .usda (Houdini, Blender,
    /// Maya, Omniverse; pictures go into the folder FILE_pictures beside it) or .csv (tables)
    /// [default: export.glb in the recording's folder; none with --pieces]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Frames a second, from 1 to 1000; where the steps of the run are longer, each step is one
    #[arg(long, value_name = "FPS", default_value_t = 24.0, value_parser = non_negative)]
    pub(crate) fps: f64,
    /// First moment, in seconds of the run; it becomes time 0 [default: the beginning]
    #[arg(long, value_name = "SECONDS", value_parser = non_negative)]
    pub(crate) start: Option<f64>,
    /// Last moment, in seconds of the run [default: the end]
    #[arg(long, value_name = "SECONDS", value_parser = non_negative)]
    pub(crate) end: Option<f64>,
    /// Write a file each so many seconds, without animation: FILE_0001, FILE_0002, ...
    #[arg(long, value_name = "SECONDS", value_parser = non_negative, conflicts_with = "at")]
    pub(crate) every: Option<f64>,
    /// Write one moment, in seconds of the run, without animation
    #[arg(long, value_name = "SECONDS", value_parser = non_negative,
        conflicts_with_all = ["start", "end"])]
    pub(crate) at: Option<f64>,
    /// Write the pieces of what broke into this folder, at rest: each as NAME.glb, all together as
    /// pieces.glb, and a table, pieces.csv
    #[arg(long, value_name = "DIR")]
    pub(crate) pieces: Option<PathBuf>,
    /// Leave out the grains of debris
    #[arg(long)]
    pub(crate) no_grains: bool,
    /// Print what was written to standard output as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// A recording, the folder of a run, or the folder of a sweep
    pub(crate) run: PathBuf,
    /// The page to write [default: report.html in the folder, or beside the recording]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Leave the processor to others
    #[arg(long, hide = true)]
    pub(crate) background: bool,
}
