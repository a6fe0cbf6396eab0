//! What is drawn of a recording: arguments and their help.

use super::{non_negative, size};
use crate::exit::{CommandError, Exit};
use clap::Args;
use cullet_picture::Framing;
use std::path::PathBuf;

/// Most moments of each run on the sheet of a sweep.
const MOST_TIMES: usize = 16;
/// Most pictures on a sheet with moments: they are all in memory, half a MB each.
const MOST_PICTURES: usize = 2_000;

/// Which moments the sheet of a sweep shows.
#[derive(Debug, Args)]
pub(crate) struct SheetArgs {
    /// Of a sweep, show each run at these times on the sheet, a row per run, such as 0.1,0.3,0.5
    /// [default: each once, shortly after its first fracture]
    #[arg(long, value_name = "SECONDS", value_delimiter = ',', value_parser = non_negative)]
    pub(crate) at: Vec<f64>,
}

impl SheetArgs {
    /// Whether as many runs fit on one sheet; `None`: a scene, which has no sheet.
    pub(crate) fn fits(&self, runs: Option<usize>) -> Result<(), CommandError> {
        let times = self.at.len();
        let why = match runs {
            _ if times == 0 => return Ok(()),
            None => "it is for sweeps; of a run, `cullet still --at` draws one moment".to_owned(),
            Some(_) if times > MOST_TIMES => {
                format!("{times} times; the sheet of a sweep has at most {MOST_TIMES}")
            }
            Some(runs) if runs * times > MOST_PICTURES => format!(
                "{runs} runs at {times} times are {} pictures; a sheet has at most {MOST_PICTURES}",
                runs * times
            ),
            Some(_) => return Ok(()),
        };
        Err(CommandError::new(Exit::Usage, format!("--at: {why}")))
    }
}

/// What fills the pictures of a run.
#[derive(Debug, Args)]
pub(crate) struct CloseArgs {
    /// Move the camera of the pictures in, to the first body that is struck, or to the body of this
    /// name, and its pieces near it until a second later
    #[arg(long, value_name = "NAME", num_args = 0..=1, require_equals = true,
        default_missing_value = "")]
    pub(crate) close: Option<String>,
}

impl CloseArgs {
    /// What the pictures show.
    pub(crate) fn framing(&self) -> Framing {
        self.close.as_deref().map_or(Framing::Whole, Framing::of_close)
    }
}

#[derive(Debug, Args)]
pub(crate) struct Preview {
    /// A recording, or the folder of a run
    pub(crate) recording: PathBuf,
    /// Folder for the pictures [default: the recording's folder]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) close: CloseArgs,
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
    /// Move the camera in, until the objects that break, or the body of this name and its pieces,
    /// fill the picture at that moment
    #[arg(long, value_name = "NAME", num_args = 0..=1, require_equals = true,
        default_missing_value = "")]
    pub(crate) close: Option<String>,
    /// The file to write, ending in .png [default: still.png in the recording's folder]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}
