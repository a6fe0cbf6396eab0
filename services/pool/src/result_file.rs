//! A file with the result of a finished job, in a folder, by the digest of the problem.
//!
//! It holds a digest, the build that found the result, and the result; it is read only if these
//! and the problem fit the digest, so that a damaged one, or one of another problem, is as good as
//! none.
//! Older ones do not name the problem in the digest; the oldest have the result alone.

use cullet_dispatch::Build;
use cullet_files::output::UNFINISHED;
use cullet_files::{regular, state};
use cullet_proto::JobId;
use cullet_proto::chunks::MAX_BLOB;
use cullet_proto::ids::digest;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// Ending of a file that holds a result.
pub(super) const ENDING: &str = "verdict";
/// Behind the digest, where a build follows: a result alone begins with another word. The digest is
/// of the problem too.
const TAG: [u8; 8] = *b"of a job";
/// The same of before the digest was of the problem.
const OLD_TAG: [u8; 8] = *b"by build";
/// Bytes before the result: digest, tag, build.
pub(super) const HEAD: usize = 32 + TAG.len() + 32;

/// What a folder has of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ResultFile {
    /// Nothing.
    Missing,
    /// A file that is not as it was written, or of another problem.
    Damaged,
    /// Something that cannot be read, and why not.
    Unreadable(String),
    /// A result.
    Sound {
        /// The bytes of the verdict.
        verdict: Vec<u8>,
        /// What found it, if that is known.
        build: Option<Build>,
    },
}

impl ResultFile {
    /// Where it is.
    #[must_use]
    pub fn path(folder: &Path, job: JobId) -> PathBuf {
        folder.join(job.to_string()).with_extension(ENDING)
    }

    /// The job whose result a file has, by its name.
    #[must_use]
    pub fn job_of(path: &Path) -> Option<JobId> {
        let name = path.file_stem().and_then(|name| name.to_str()).and_then(JobId::from_hex);
        name.filter(|_| path.extension().is_some_and(|ending| ending == ENDING))
    }

    /// Whether a file is one that was not written to its end.
    #[must_use]
    pub fn is_unfinished(path: &Path) -> bool {
        let name = path.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| name.starts_with(UNFINISHED)) && path.is_file()
    }

    /// Deletes those in a folder, and the folder unless there is something else in it. A folder
    /// that is not there is no error.
    ///
    /// # Errors
    /// It is a link to another place, or what the system says.
    pub fn delete_all(folder: &Path) -> io::Result<()> {
        if folder.is_symlink() {
            let why = "it is a link to another place, where nothing is deleted";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
        }
        let files = match fs::read_dir(folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            files => files?,
        };
        for file in files {
            let path = file?.path();
            if Self::job_of(&path).is_some() || Self::is_unfinished(&path) {
                fs::remove_file(path)?;
            }
        }
        // Something of the user's may be in it.
        let _it_stays = fs::remove_dir(folder);
        Ok(())
    }

    /// Reads it.
    #[must_use]
    pub fn read(folder: &Path, job: JobId) -> Self {
        let bytes = match bytes_of(&Self::path(folder, job)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Self::Missing,
            Err(error) => return Self::Unreadable(regular::words(&error)),
            Ok(bytes) => bytes,
        };
        let Some((seal, rest)) = bytes.split_first_chunk::<32>() else { return Self::Damaged };
        let sound = match rest.starts_with(&TAG) {
            true => digest_of(&[&job.0, rest]) == *seal,
            false => digest(rest) == *seal,
        };
        if !sound {
            return Self::Damaged;
        }
        let told = rest.strip_prefix(&TAG).or_else(|| rest.strip_prefix(&OLD_TAG));
        let build = told.and_then(|rest| rest.first_chunk()).copied().map(Build);
        let mut verdict = bytes;
        verdict.drain(..if build.is_some() { HEAD } else { 32 });
        Self::Sound { verdict, build }
    }

    /// The size of the file of a result \[bytes\].
    #[must_use]
    pub fn size_of(verdict: &[u8]) -> u64 {
        (verdict.len() + HEAD) as u64
    }

    /// Writes one, whole or not at all: beside its place and renamed. Who may read the folder may
    /// read it.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(folder: &Path, job: JobId, verdict: &[u8], build: Build) -> io::Result<()> {
        let mut beside = state::unfinished(folder)?;
        beside.write_all(&digest_of(&[&job.0, &TAG, &build.0, verdict]))?;
        for part in [&TAG, build.0.as_slice(), verdict] {
            beside.write_all(part)?;
        }
        readable_as(folder, beside.as_file())?;
        beside.persist(Self::path(folder, job)).map_err(|error| error.error)?;
        Ok(())
    }
}

/// The digest of these parts, one after another.
fn digest_of(parts: &[&[u8]]) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        hasher.update(part);
    }
    *hasher.finalize().as_bytes()
}

/// The bytes of a regular file that is no link, and no larger than that of any result.
fn bytes_of(path: &Path) -> io::Result<Vec<u8>> {
    let unfit = |why: &str| Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    let about = fs::symlink_metadata(path)?;
    if about.is_symlink() {
        return unfit("it is a link to another file");
    }
    let most = MAX_BLOB + HEAD as u64;
    let mut bytes = Vec::new();
    regular::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 <= most {
        true => Ok(bytes),
        false => unfit("it is larger than any result"),
    }
}

/// Gives a file the rights of its folder.
fn readable_as(folder: &Path, file: &fs::File) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = (fs::metadata(folder)?.permissions().mode() & 0o666) | 0o600;
        file.set_permissions(fs::Permissions::from_mode(mode))?;
    }
    #[cfg(not(unix))]
    let _they_are_the_same = (folder, file);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::ResultFile;
    use cullet_dispatch::Build;
    use cullet_proto::JobId;
    use std::fs;

    #[test]
    fn a_result_is_that_of_its_problem_in_a_regular_file() {
        let dir = tempfile::tempdir().expect("a folder");
        let folder = dir.path().join("results");
        fs::create_dir(&folder).expect("a folder");
        let ([one, two], build) = ([1, 2].map(|number| JobId([number; 32])), Build([3; 32]));
        ResultFile::write(&folder, one, b"CULT", build).expect("it is written");
        let sound = ResultFile::Sound { verdict: b"CULT".to_vec(), build: Some(build) };
        assert_eq!(ResultFile::read(&folder, one), sound);
        // The same under the name of another problem.
        let [path, other] = [one, two].map(|job| ResultFile::path(&folder, job));
        fs::copy(&path, &other).expect("a file");
        assert_eq!(ResultFile::read(&folder, two), ResultFile::Damaged);
        fs::remove_file(&other).expect("it goes");
        assert_eq!(ResultFile::read(&folder, two), ResultFile::Missing);
        fs::create_dir(&other).expect("a folder");
        assert!(matches!(ResultFile::read(&folder, two), ResultFile::Unreadable(_)));
        fs::remove_dir(&other).expect("it goes");
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&path, &other).expect("a link");
            let read = ResultFile::read(&folder, two);
            assert_eq!(read, ResultFile::Unreadable("it is a link to another file".to_owned()));
            // Nothing is deleted behind a link.
            let link = dir.path().join("link");
            std::os::unix::fs::symlink(&folder, &link).expect("a link");
            assert!(ResultFile::delete_all(&link).is_err() && path.exists());
        }
        // A file that was not finished goes with the others.
        fs::write(folder.join(".cullet-half"), "").expect("a file");
        ResultFile::delete_all(&folder).expect("it goes");
        assert!(!folder.exists());
    }
}
