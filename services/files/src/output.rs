//! Where a run puts its files: folders that nobody else uses, files that are whole or not there.
//! Commands write their files through here, so that none of them writes over a recording.

use super::regular;
use std::fs::{self, File};
use std::io::{self, Read, Write};
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

/// What an MCAP file begins with.
const MCAP: [u8; 8] = *b"\x89MCAP0\r\n";
/// What the names of recordings end with, of whole ones and of those that are being written.
const OF_RECORDINGS: [&str; 2] = [".mcap", ".mcap.partial"];

/// Whether a file is a recording, by its name, or by its first bytes: either may be damaged.
/// `opened`: what came of opening it.
///
/// # Errors
/// It may not be read, and so it may be one.
fn is_recording(path: &Path, opened: io::Result<File>) -> io::Result<bool> {
    let ends_so = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        OF_RECORDINGS.iter().any(|end| name.ends_with(end))
    };
    let is_file = fs::metadata(path).is_ok_and(|about| !about.is_dir());
    if is_file && (ends_so(path) || path.canonicalize().is_ok_and(|path| ends_so(&path))) {
        return Ok(true);
    }
    let mut first = [0; MCAP.len()];
    match opened {
        Ok(mut file) => Ok(file.read_exact(&mut first).is_ok() && first == MCAP),
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => Err(io::Error::new(
            error.kind(),
            "what is there may not be read, and may be a recording; name another file",
        )),
        Err(_) => Ok(false),
    }
}

/// Refuses a file that is to be written where a recording is, under whatever name or link.
///
/// # Errors
/// There is a recording, or what may not be read and may be one.
pub fn refuse_recording(path: &Path) -> io::Result<()> {
    match is_recording(path, regular::open(path))? {
        true => Err(io::Error::new(
            io::ErrorKind::AlreadyExists,
            "it is a recording, and nothing is written over one; name another file",
        )),
        false => Ok(()),
    }
}

/// Creates a file that grows line by line, in place of what is there.
///
/// # Errors
/// The file system says no, or there is a recording.
pub fn create_file(path: &Path) -> io::Result<File> {
    refuse_recording(path)?;
    File::create(path)
}

/// Copies a file under a name only once it is whole.
///
/// # Errors
/// As [`write_file`].
pub fn copy_file(from: &Path, to: &Path) -> io::Result<()> {
    write_file(to, &regular::read(from)?)
}

/// Writes a file under its name only once it is whole.
///
/// # Errors
/// The file system says no, or there is a recording; the name is left as it was then.
pub fn write_file(path: &Path, content: &[u8]) -> io::Result<()> {
    refuse_recording(path)?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = plain().tempfile_in(folder)?;
    file.write_all(content)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{create_file, is_recording, write_file};
    use std::{fs, io};

    #[test]
    fn nothing_is_written_over_a_recording() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let recording = b"\x89MCAP0\r\nrecorded";
        for (name, bytes) in [
            ("page.html", &recording[..]),
            ("run.mcap", recording),
            ("RUN.MCAP", b"its first bytes are damaged"),
            ("run.mcap.partial", b""),
        ] {
            fs::write(at(name), bytes).expect("a file");
            for written in [write_file(&at(name), b"<p>"), create_file(&at(name)).map(drop)] {
                let why = written.expect_err("there is a recording").to_string();
                assert!(why.contains("name another file"), "{why}");
            }
            assert_eq!(fs::read(at(name)).expect("it is there"), bytes);
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("run.mcap"), at("link")).expect("a link");
            fs::hard_link(at("run.mcap"), at("twin")).expect("a link");
            assert!(write_file(&at("link"), b"").is_err() && write_file(&at("twin"), b"").is_err());
        }
        fs::write(at("old"), "an older page").expect("a file");
        write_file(&at("old"), b"a page").expect("it is no recording");
        write_file(&at("new.mcap"), b"").expect("nothing is there");
        assert_eq!(fs::read(at("old")).expect("it is there"), b"a page");
    }
    #[test]
    fn what_may_not_be_read_may_be_a_recording() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let shut = || Err(io::ErrorKind::PermissionDenied.into());
        for name in ["run.mcap", "page.html"] {
            fs::write(at(name), "shut").expect("a file");
        }
        assert!(is_recording(&at("run.mcap"), shut()).expect("its name says so"));
        let said = is_recording(&at("page.html"), shut()).expect_err("nobody knows").to_string();
        assert!(said.contains("name another file"), "{said}");
        let odd = is_recording(&at("page.html"), Err(io::ErrorKind::InvalidInput.into()));
        assert!(!odd.expect("a pipe is none"));
        fs::create_dir(at("folder.mcap")).expect("a folder");
        assert!(
            !is_recording(&at("folder.mcap"), shut().or(Err(io::ErrorKind::IsADirectory.into())))
                .expect("a folder is none")
        );
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("run.mcap"), at("link.html")).expect("a link");
            let named = is_recording(&at("link.html"), fs::File::open(at("link.html")));
            assert!(named.expect("it leads to one"), "by the name to which it leads");
        }
    }
}
