//! Where a run puts its files: folders that nobody else uses, files that are whole or not there.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What a file's name begins with until it is whole.
pub const UNFINISHED: &str = ".cullet-";
/// Most runs of one scene in one folder; past it the caller must name a folder.
const MOST_RUNS: u32 = 100_000;

/// Makes `<base>/<scene>-<n>` with the least n that is free.
///
/// # Errors
/// The folder cannot be made, or every n up to 100 000 is taken.
pub fn next_folder(base: &Path, scene: &str) -> io::Result<PathBuf> {
    fs::create_dir_all(base)?;
    for n in 1..=MOST_RUNS {
        let folder = base.join(format!("{scene}-{n}"));
        match fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::new(io::ErrorKind::AlreadyExists, format!("{MOST_RUNS} runs are there already")))
}

/// Temporary files are their owner's alone; what a run leaves is as readable as any other file.
fn plain() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// Writes a file under its name only once it is whole.
///
/// # Errors
/// The file system says no; nothing is left under the name then.
pub fn write_file(path: &Path, content: &[u8]) -> io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = plain().tempfile_in(folder)?;
    file.write_all(content)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}
