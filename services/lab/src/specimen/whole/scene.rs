//! The scene of a specimen of the whole.

use super::watch::ResolvedProbe;
use cullet_proto::JobId;
use std::path::PathBuf;

/// A scene that is run to be measured.
#[derive(Clone, Debug)]
pub struct Whole {
    /// The file of the specimen, which any command takes for that of its scene.
    pub file: PathBuf,
    /// `path=value` arguments of the scene.
    pub overrides: Vec<String>,
    /// What is read; nothing where the scene has a flaw.
    pub watches: Vec<ResolvedProbe>,
    /// Time step of the world, 0 where the scene has a flaw \[s\].
    pub step: f64,
    /// Digest of all files of the scene and of the overrides.
    pub id: JobId,
}
