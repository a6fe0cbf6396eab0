//! Files that are opened, and what the system says of those that are not, in words for people.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::Path;

/// Opens a file to be read. What is no regular file is refused: a pipe that nobody writes to would
/// be waited for without end.
///
/// # Errors
/// It is not there, may not be read, or is no regular file.
pub fn open(path: &Path) -> io::Result<File> {
    open_with(OpenOptions::new().read(true), path)
}

/// Opens a file as these options say, to be written or made as well; as [`open`], what is no
/// regular file is refused.
///
/// # Errors
/// As [`open`]; and what the options do not allow.
pub fn open_with(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    // So that no device is touched; what comes into its place after this look is looked at again.
    fs::metadata(path).map_or(Ok(()), |about| check(&about))?;
    // The opening of a pipe does not wait for whoever has its other end.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        options,
        rustix::fs::OFlags::NONBLOCK.bits().cast_signed(),
    );
    let file = options.open(path)?;
    check(&file.metadata()?)?;
    Ok(file)
}

fn check(about: &fs::Metadata) -> io::Result<()> {
    match about.file_type() {
        kind if kind.is_file() => Ok(()),
        kind if kind.is_dir() => Err(ErrorKind::IsADirectory.into()),
        _ => Err(io::Error::new(ErrorKind::InvalidInput, UNFIT)),
    }
}

/// What is said of a pipe, a socket or a device.
const UNFIT: &str = "it is no regular file: a pipe, a socket or a device";

/// The bytes of a file that [`open`] opens.
///
/// # Errors
/// As [`open`]; and what comes up while it is read.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    io::Read::read_to_end(&mut open(path)?, &mut bytes)?;
    Ok(bytes)
}

/// The text of a file that [`open`] opens.
///
/// # Errors
/// As [`read`]; it is no UTF-8 text.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        io::Error::new(ErrorKind::InvalidData, format!("it is not UTF-8 text: byte {at} is wrong"))
    })
}

/// The system's words without its error numbers.
#[must_use]
pub fn words(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "there is no such file".to_owned(),
        ErrorKind::PermissionDenied => "permission denied".to_owned(),
        ErrorKind::IsADirectory => "it is a folder".to_owned(),
        ErrorKind::NotADirectory => "a part of the path is no folder".to_owned(),
        _ => {
            let text = error.to_string();
            let end = text.find(" (os error ").unwrap_or(text.len());
            text[..end].to_owned()
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::{open, open_with, read};
    use std::fs::{self, OpenOptions};
    use std::io::ErrorKind;
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    fn pipe(path: &Path) {
        let made = std::process::Command::new("mkfifo").arg(path).status();
        assert!(made.is_ok_and(|status| status.success()));
    }

    #[test]
    fn what_is_no_regular_file_is_refused_however_it_is_opened() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().join("pipe");
        pipe(&place);
        let mut ways = [OpenOptions::new(), OpenOptions::new(), OpenOptions::new()];
        ways[0].read(true);
        ways[1].append(true).create(true);
        ways[2].write(true).create(true).truncate(true);
        for options in &mut ways {
            for path in [&place, Path::new("/dev/zero")] {
                let said = open_with(options, path).expect_err("it is no file");
                assert_eq!(said.kind(), ErrorKind::InvalidInput, "{said}");
            }
            let said = open_with(options, folder.path()).expect_err("it is a folder");
            assert_eq!(said.kind(), ErrorKind::IsADirectory, "{said}");
        }
        let new = folder.path().join("new");
        assert_eq!(open(&new).expect_err("it is not there").kind(), ErrorKind::NotFound);
        assert!(open_with(&mut ways[1], &new).is_ok() && read(&new).is_ok());
    }

    /// A pipe that comes into the place of a file between the look and the opening is not waited
    /// for.
    #[test]
    fn a_file_that_becomes_a_pipe_is_not_waited_for() {
        let folder = tempfile::tempdir().expect("a folder");
        let (place, own) = (folder.path().join("it"), folder.path().to_owned());
        let over = Arc::new(AtomicBool::new(false));
        let until = Arc::clone(&over);
        pipe(&own.join("pipe"));
        fs::write(own.join("file"), "text").expect("a file");
        let swapping = std::thread::spawn(move || {
            while !until.load(Ordering::Relaxed) {
                for kind in ["pipe", "file"] {
                    fs::hard_link(own.join(kind), own.join("next")).expect("a link");
                    fs::rename(own.join("next"), own.join("it")).expect("it takes the place");
                    // Of two names of one thing the renaming leaves both.
                    let _gone = fs::remove_file(own.join("next"));
                }
            }
        });
        for _ in 0..20_000 {
            if let Err(error) = read(&place) {
                let kinds = [ErrorKind::InvalidInput, ErrorKind::NotFound];
                assert!(kinds.contains(&error.kind()), "{error}");
            }
        }
        over.store(true, Ordering::Relaxed);
        swapping.join().expect("it swapped to the end");
    }
}
