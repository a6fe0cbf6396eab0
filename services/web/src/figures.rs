//! What a run came to, from the summary beside its recording.

use crate::view::RunFigures;
use std::io::Read;
use std::path::Path;

/// The file.
const SUMMARY: &str = "summary.json";
/// Most bytes of it.
const MAX_BYTES: u64 = 1 << 20;

/// Reads the summary in a folder; without one, or with one that is none, all is empty.
pub(crate) fn read(folder: &Path) -> RunFigures {
    let path = folder.join(SUMMARY);
    let read = || {
        let mut text = String::new();
        let file = cullet_files::regular::open(&path)?;
        file.take(MAX_BYTES).read_to_string(&mut text)?;
        serde_json::from_str(&text).map_err(std::io::Error::other)
    };
    read().unwrap_or_else(|error: std::io::Error| {
        tracing::debug!("{}: {error}", path.display());
        RunFigures::default()
    })
}
