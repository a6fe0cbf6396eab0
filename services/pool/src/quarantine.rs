//! What reproduces a job that killed its workers.
//!
//! A folder named by the job's id: `job.bin`, its encoding, and `attempts.txt`, who died how: a
//! line an attempt with the run, the worker, what that is (version, build, threads, cores, memory
//! of a job) and when \[s since the first attempt\]. The command `cullet job FILE` solves a
//! `job.bin` in its own process, as a worker would. A job whose folder is there stays in
//! quarantine, in later lives of the coordinator too, until it is pardoned.

use cullet_files::{regular, state};
use cullet_proto::JobId;
use std::fs;
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

/// Reproductions kept in a folder; a further one is not written.
const MAX_KEPT: usize = 256;

/// Writes the reproduction of a job.
///
/// # Errors
/// The disk does not take it, or there are too many already.
pub(super) fn write(folder: &Path, id: JobId, job: &[u8], attempts: &str) -> Result<PathBuf> {
    state::folder(folder)?;
    let own = folder.join(id.to_string());
    if fs::read_dir(folder)?.count() >= MAX_KEPT && !own.exists() {
        let text = format!("{} holds {MAX_KEPT} jobs already", folder.display());
        return Err(Error::other(text));
    }
    state::folder(&own)?;
    state::put(&own.join("job.bin"), job)?;
    let lines = format!("{}\n", attempts.trim_end_matches('\n'));
    state::put(&own.join("attempts.txt"), state::seal(&lines).as_bytes())?;
    Ok(own)
}

/// How the attempts at a job ended that is in quarantine, if that is known.
pub(super) fn attempts(folder: &Path, id: JobId) -> Option<String> {
    let path = folder.join(id.to_string()).join("attempts.txt");
    let text = regular::read_text(&path).ok()?;
    let sound = state::unseal(&text);
    sound.inspect_err(|why| tracing::warn!("{}: {why}", path.display())).ok().map(str::to_owned)
}

/// The jobs that a folder holds.
///
/// # Errors
/// It cannot be read; one that is not there holds none.
pub(super) fn held(folder: &Path) -> Result<Vec<JobId>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let mut held = Vec::new();
    for entry in entries {
        held.extend(entry?.file_name().to_str().and_then(JobId::from_hex));
    }
    held.sort_unstable();
    Ok(held)
}

/// Removes what there is of a job that may be tried again.
///
/// # Errors
/// The disk does not let it go.
pub(super) fn release(folder: &Path, id: JobId) -> Result<()> {
    match fs::remove_dir_all(folder.join(id.to_string())) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        said => said,
    }
}

#[cfg(test)]
mod tests {
    use super::{attempts, write};
    use cullet_proto::JobId;

    #[test]
    fn attempts_are_read_back_and_none_in_which_a_bit_turned() {
        let folder = tempfile::tempdir().expect("a folder");
        let (id, text) = (JobId([7; 32]), "run 1 worker a\nrun 1 worker b\n");
        let own = write(folder.path(), id, b"job", text).expect("it is written");
        assert_eq!(attempts(folder.path(), id).as_deref(), Some(text));
        let path = own.join("attempts.txt");
        let sound = std::fs::read(&path).expect("a file");
        for at in 0..8 * text.len() {
            let mut bytes = sound.clone();
            bytes[at / 8] ^= 1 << (at % 8);
            std::fs::write(&path, &bytes).expect("it is damaged");
            assert_eq!(attempts(folder.path(), id), None, "bit {at}");
        }
        std::fs::write(&path, text).expect("of before there were checksums");
        assert_eq!(attempts(folder.path(), id).as_deref(), Some(text));
    }
}
