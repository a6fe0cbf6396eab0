//! What is drawn of a recording: arguments and their help.

use super::{non_negative, size};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct Preview {
    /// A recording, or the folder of a run
    pub(crate) recording: PathBuf,
    /// Folder for the pictures [default: the recording's folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct StillArgs {
    /// A recording, or the folder of a run
    pub(crate) recording: PathBuf,
    /// Time of the picture, in seconds of the run [default: shortly after the first fracture,
    /// or when half of what tears in sheets is torn]
    #[arg(long, value_name = "SECONDS", value_parser = non_negative)]
    pub(crate) at: Option<f64>,
    /// Show the last moment that is recorded, also of a run that goes on
    #[arg(long, conflicts_with = "at")]
    pub(crate) last: bool,
    /// Leave the processor to others
    #[arg(long, hide = true)]
    pub(crate) background: bool,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = size)]
    pub(crate) size: (usize, usize),
    /// Move the camera in, until the objects that break fill the picture
    #[arg(long)]
    pub(crate) close: bool,
    /// The file to write, ending in .png [default: still.png in the recording's folder]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}
