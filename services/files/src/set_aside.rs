//! What a start finds and has no use for: it is never deleted, but moved into `set-aside` in the
//! state folder, under a name with the time and a number, and the log says so. Nothing there is
//! read again; whoever has looked at it may delete it.

use crate::{regular, state};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Name of the folder.
pub const NAME: &str = "set-aside";

/// Moves a file or folder of a state folder there, and says where it is now.
pub fn take(state: &Path, found: &Path) -> io::Result<PathBuf> {
    let folder = state.join(NAME);
    state::folder(&folder)?;
    let name = found.strip_prefix(state).unwrap_or(found).to_string_lossy().replace('/', "-");
    let name = name.trim_start_matches('.');
    let seconds = crate::clock::unix_ms() / 1000;
    let place = |number: u32| folder.join(format!("{seconds}-{number}-{name}"));
    let free = (1..u32::MAX).map(place).find(|place| !place.exists());
    let place = free.ok_or(io::ErrorKind::AlreadyExists)?;
    fs::rename(found, &place)?;
    state::sync(&folder)?;
    found.parent().map_or(Ok(()), state::sync)?;
    Ok(place)
}

/// Keeps a copy of a file of a state folder there, one of each content.
pub fn copy(path: &Path) -> io::Result<PathBuf> {
    let folder = path.with_file_name(NAME);
    state::folder(&folder)?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(regular::open(path)?)?;
    let digest = hasher.finalize().to_hex();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let place = folder.join(format!("{name}-{}", &digest[..16]));
    if place.exists() {
        return Ok(place);
    }
    let mut beside = state::unfinished(&folder)?;
    io::copy(&mut regular::open(path)?, beside.as_file_mut())?;
    beside.as_file().sync_all()?;
    beside.persist(&place).map_err(|error| error.error)?;
    state::sync(&folder)?;
    Ok(place)
}

/// Moves something there that nobody knows of, and says why.
pub fn tell(state: &Path, found: &Path, why: &str) {
    let from = found.display();
    match take(state, found) {
        Ok(place) => tracing::warn!("{from}: {why}; it is set aside as {}", place.display()),
        Err(error) => tracing::error!("{from}: {why}; it stays, for it cannot be moved: {error}"),
    }
}

/// Moves a file of a state folder there that is not as it was written.
pub fn damaged(path: &Path) {
    tell(path.parent().unwrap_or(Path::new(".")), path, "it is damaged");
}
