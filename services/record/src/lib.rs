//! The recording of a run: one MCAP file that any viewer opens, from which everything that decided
//! the run can be read back.
//!
//! | topic | message | what |
//! |---|---|---|
//! | `/scene/<object>` | `foxglove.SceneUpdate` | an object's whole state, for viewers |
//! | `/fragments` | `foxglove.PointCloud` | centres of bodies, for viewers without meshes |
//! | `/tf` | `foxglove.FrameTransforms` | the world turned so that up is z |
//! | `/log` | `foxglove.Log` | a line an event |
//! | `/stats` | `cullet.RunStats` | numbers worth a plot |
//! | `/geometry` | `cullet.Geometry` | each solid once, lossless, by digest |
//! | `/body` | `cullet.Body` | each body at its birth |
//! | `/shape` | `cullet.NewShape` | the new shape of a body that was deformed |
//! | `/bodies` | `cullet.BodyPoses` | the lossless pose track |
//! | `/debris` | `cullet.Grains` | grains of debris: what is born, what flies |
//! | `/cracks` | `cullet.Cracks` | cracks that end inside a body, as open surfaces |
//! | `/joints` | `cullet.BodyJoint` | each joint when it is made |
//! | `/events` | `cullet.RunEvent` | what happened |
//! | `/jobs` | `cullet.JobReport` | how jobs came out |
//! | `/sampled` | `cullet.Sampled` | which fragments were sampled or directed, and not solved |
//! | `/pool` | `cullet.PoolReport` | who computed them, and for how long |
//! | `/appearance` | `cullet.Appearance` | what mesh files have beside the shapes |
//! | `/sheets/surface` | `cullet.SheetSurface` | each surface of a sheet once, by digest |
//! | `/sheets` | `cullet.SheetFrame` | where the points of a sheet are |
//! | `/windows` | `cullet.SheetWindow` | what came of a window of a sheet's time |
//!
//! The digest of a run covers `/geometry`, `/body`, `/shape`, `/bodies`, `/debris`, `/cracks`,
//! `/joints`, `/events`, `/jobs`, and of sheets all three topics: no wall time and no worker name
//! is in them.
//! Log time is simulated time; publish time is wall time since the start of the run.

mod appearance;
mod canvas;
mod digest;
mod directed;
mod display;
mod draw_budget;
mod end;
mod event;
mod found;
mod grains;
#[cfg(test)]
mod hole_tests;
mod holes;
mod inspect;
mod largest;
mod layout;
mod masses;
mod meta;
mod moment;
mod object;
pub mod palette;
pub mod points;
mod pose_row;
mod quantity_scale;
mod raw_records;
mod read;
mod recorder;
mod recover;
mod rest;
mod resume;
pub mod scale;
mod shares;
mod sheet_book;
mod sheet_census;
mod sheet_display;
mod sheet_read;
#[cfg(test)]
mod sheet_tests;
mod sheets;
mod sink;
mod summary;
pub mod synthetic;
#[cfg(test)]
mod tests;
mod thick_sheet;
mod trace;
mod trail;

pub use appearance::skin_of;
pub use cullet_model::FragmentOrigin;
pub use digest::RunDigest;
pub use directed::DirectedTotals;
pub use event::{Event, Touch, event_text};
pub use holes::Holes;
pub use inspect::{Inspection, inspect};
pub use largest::{PieceRank, rank_table, ranks};
pub use masses::{Fit, Fits, FragmentMass, RESOLVED_CELLS, fit, masses, table};
pub use meta::{InteriorLook, RunMeta, View};
pub use pose_row::PoseRow;
pub use quantity_scale::QuantityScale;
pub use read::Recording;
pub use recorder::{Finished, Level, Recorder};
pub use recover::{Recovery, recover};
pub use rest::RestPlace;
pub use shares::{DirectedShares, Shares};
pub use sheet_book::SheetAbout;
pub use sheet_census::{PieceCount, SheetCensus, SheetTotals};
pub use sheet_read::{FrameTime, RecordedSheet, SheetMoment, SoundWindow};
pub use sheets::SolvedWindow;
pub use sink::MessageTap;
pub use summary::{Jobs, LedgerTotals, SCHEMA_VERSION, Summary, Tally};
pub use thick_sheet::{PlacedSheet, SheetSide, ThickSheet, ThickVertex};
pub use trace::{Trace, traces};
pub use trail::RunTrail;

use cullet_proto::recording::{AppearanceError, GeometryError, SheetError};
use std::path::{Path, PathBuf};

/// Topic of [`cullet_proto::recording::Geometry`].
pub const GEOMETRY: &str = "/geometry";
/// Topic of [`cullet_proto::recording::Body`].
pub const BODY: &str = "/body";
/// Topic of [`cullet_proto::recording::NewShape`].
pub const SHAPE: &str = "/shape";
/// Topic of [`cullet_proto::recording::BodyPoses`].
pub const BODIES: &str = "/bodies";
/// Topic of [`cullet_proto::recording::Grains`].
pub const DEBRIS: &str = "/debris";
/// Topic of [`cullet_proto::recording::Cracks`].
pub const CRACKS: &str = "/cracks";
/// Topic of [`cullet_proto::recording::BodyJoint`].
pub const JOINTS: &str = "/joints";
/// Topic of [`cullet_proto::recording::RunEvent`].
pub const EVENTS: &str = "/events";
/// Topic of [`cullet_proto::recording::JobReport`].
pub const JOBS: &str = "/jobs";
/// Topic of [`cullet_proto::recording::Sampled`].
pub const SAMPLED: &str = "/sampled";
/// Topic of [`cullet_proto::recording::PoolReport`].
pub const POOL: &str = "/pool";
/// Topic of [`cullet_proto::recording::Appearance`].
pub const APPEARANCE: &str = "/appearance";
/// Topic of [`cullet_proto::recording::RunStats`].
pub const STATS: &str = "/stats";
/// Topic of [`cullet_proto::recording::SheetSurface`].
pub const SHEET_SURFACE: &str = "/sheets/surface";
/// Topic of [`cullet_proto::recording::SheetFrame`].
pub const SHEETS: &str = "/sheets";
/// Topic of [`cullet_proto::recording::SheetWindow`].
pub const WINDOWS: &str = "/windows";

/// What the library says, or, where it only passes it on, what the system said to it.
fn words(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::Io(source) => cullet_files::regular::words(source),
        other => other.to_string(),
    }
}

/// Why a recording could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file system said no.
    #[error("{path}: {}", cullet_files::regular::words(source))]
    Io {
        /// The file concerned.
        path: PathBuf,
        /// What it said.
        source: std::io::Error,
    },
    /// The MCAP library said no.
    #[error("{path}: {}", words(source))]
    Mcap {
        /// The file concerned.
        path: PathBuf,
        /// What it said.
        source: mcap::McapError,
    },
    /// The file does not begin as an MCAP file does.
    #[error("{path} is not an MCAP file")]
    NotMcap {
        /// The file concerned.
        path: PathBuf,
    },
    /// Nothing in it is of a run.
    #[error(
        "{path} is an MCAP file, but no recording of a run: another program wrote it, or nothing \
         is left of it"
    )]
    Foreign {
        /// The file concerned.
        path: PathBuf,
    },
    /// The run that it holds has no such moment.
    #[error("{path} has no moment {time} s: it goes from 0 to {end} s")]
    Beyond {
        /// The file concerned.
        path: PathBuf,
        /// Which moment \[s\].
        time: f64,
        /// Its last one \[s\].
        end: f64,
    },
    /// The run that it holds has no such body.
    #[error("{path}: no body is called {name:?}; there are {known}")]
    NoBody {
        /// The file concerned.
        path: PathBuf,
        /// What was asked for.
        name: String,
        /// Names of the bodies that its scene had, with commas between them.
        known: String,
    },
    /// It holds the points of a specimen, and no run.
    #[error(
        "{path} holds the points of a specimen, for a viewer: there is no run in it; \
         its numbers are in the .csv beside it"
    )]
    Specimen {
        /// The file concerned.
        path: PathBuf,
    },
    /// All that a recording had is damaged.
    #[error("{path}: nothing can be saved, for all {damaged} records in it are damaged")]
    Lost {
        /// The file concerned.
        path: PathBuf,
        /// Chunks and records.
        damaged: u64,
    },
    /// A recording has holes that another run was to be compared with.
    #[error("{path} has holes, so that no run can be compared with it: {missing}")]
    Patchy {
        /// The file concerned.
        path: PathBuf,
        /// What is missing.
        missing: String,
    },
    /// A file unpacks to more than any recording does.
    #[error(
        "{path} unpacks to more than {bound} bytes, the bound for a file of its size: no run is \
         recorded so, and nothing of it is read; record the run again, or take another copy of it"
    )]
    Swollen {
        /// The file concerned.
        path: PathBuf,
        /// To how much it may unpack \[bytes\].
        bound: u64,
    },
    /// A run that was to be as another one up to a step is not.
    #[error(
        "at step {step} the run is not as in {path} ({what} differs), so that it cannot resume at \
         step {until}: what is set anew may change nothing before that step"
    )]
    Differs {
        /// The recording of the other run.
        path: PathBuf,
        /// The first step that differs.
        step: u64,
        /// The first step that may differ.
        until: u64,
        /// What differs.
        what: &'static str,
    },
    /// A message of ours does not decode.
    #[error("a message on {topic} at {log_time} ns does not decode: {reason}")]
    Decode {
        /// Its topic.
        topic: String,
        /// Its log time \[ns\].
        log_time: u64,
        /// What is wrong.
        reason: String,
    },
    /// The recorder was told of a body that it does not know.
    #[error("body {body} was not recorded before its {what}")]
    UnknownBody {
        /// The body concerned.
        body: u64,
        /// What came too early.
        what: &'static str,
    },
    /// A body was recorded whose geometry was not.
    #[error("the geometry of body {body} was not recorded before it")]
    UnknownGeometry {
        /// The body concerned.
        body: u64,
    },
    /// The mesh of a body is not a solid, or is not the one that was recorded.
    #[error("the geometry of body {body}: {source}")]
    Geometry {
        /// The body concerned.
        body: u64,
        /// What is wrong with it.
        source: GeometryError,
    },
    /// What a body looks like is damaged.
    #[error("the appearance of body {body}: {source}")]
    Appearance {
        /// The body concerned.
        body: u64,
        /// What is wrong with it.
        source: AppearanceError,
    },
    /// Cracks that end inside a body are damaged.
    #[error("the cracks of body {body}: {source}")]
    Cracks {
        /// The body concerned.
        body: u64,
        /// What is wrong with them.
        source: cullet_geometry::mesh::MeshError,
    },
    /// The recorder was told of a sheet that it does not know.
    #[error("sheet {sheet} was not recorded before its {what}")]
    UnknownSheet {
        /// The sheet concerned.
        sheet: u32,
        /// What came too early.
        what: &'static str,
    },
    /// A surface, frame or window of a sheet is not sound.
    #[error("sheet {sheet} at step {step}: {source}")]
    Sheet {
        /// The sheet concerned.
        sheet: u32,
        /// The step of its frame, or the first of its window.
        step: u64,
        /// What is wrong with it.
        source: SheetError,
    },
    /// A number that must be finite is not.
    #[error("{what} is {value}; it must be finite")]
    NotFinite {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A picture could not be encoded.
    #[error("{path}: {reason}")]
    Picture {
        /// The file concerned.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl RecordError {
    /// An error of the file system, with the path that it is about.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, source }
    }
}
