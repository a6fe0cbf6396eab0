//! What reproduces a job that killed its workers.
//!
//! A folder named by the job's id: `job.bin`, its encoding, and `attempts.txt`, who died how. The
//! command `cullet job FILE` solves a `job.bin` in its own process, as a worker would.

use cullet_proto::JobId;
use std::fs;
use std::path::{Path, PathBuf};

/// Bundles kept in a folder; a further one is not written.
const MAX_BUNDLES: usize = 256;

/// Writes the bundle of a job.
///
/// # Errors
/// The disk does not take it, or there are too many already.
pub(super) fn write(
    folder: &Path,
    id: JobId,
    job: &[u8],
    attempts: &[String],
) -> std::io::Result<PathBuf> {
    fs::create_dir_all(folder)?;
    let bundle = folder.join(id.to_string());
    if fs::read_dir(folder)?.count() >= MAX_BUNDLES && !bundle.exists() {
        let text = format!("{} holds {MAX_BUNDLES} bundles already", folder.display());
        return Err(std::io::Error::other(text));
    }
    fs::create_dir_all(&bundle)?;
    fs::write(bundle.join("job.bin"), job)?;
    fs::write(bundle.join("attempts.txt"), attempts.join("\n") + "\n")?;
    Ok(bundle)
}
