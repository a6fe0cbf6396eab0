//! Files of a state folder: their owner's alone, whole or not there, and with a checksum, so that a
//! bit that turned is found when they are read.
//!
//! A text ends with a line that has the checksum of what is before it ([`seal`]); a line of a text
//! that grows has its own behind it ([`line()`]). What was written before there were checksums has
//! neither, and is read as it is.

use cullet_proto::chunks::sum;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

/// What a file's name begins with until it is whole.
const UNFINISHED: &str = crate::output::UNFINISHED;
/// What the last line of a sealed text begins with.
const SEAL: &str = "crc32c ";
/// Bytes of that line: the word, the checksum and the end.
const SEALED: usize = SEAL.len() + 9;
/// Between a line and its checksum.
const MARK: &str = " #";

/// A file that is its owner's alone where it is made.
pub fn options() -> OpenOptions {
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options
}

/// A file that is its owner's alone and has no name yet.
pub fn unfinished(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    tempfile::Builder::new().prefix(UNFINISHED).append(true).tempfile_in(folder)
}

/// Makes a folder, and those above it, that is its owner's alone.
pub fn folder(path: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(path)
}

/// Takes a folder that was made before from the eyes of others. Of a group it stays: somebody gave
/// it to them.
pub fn hide(path: &Path) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(path)?.permissions().mode() & 0o7777;
        if mode & 0o007 != 0 {
            fs::set_permissions(path, fs::Permissions::from_mode(mode & !0o007))?;
        }
    }
    #[cfg(not(unix))]
    let _it_has_other_rights = path;
    Ok(())
}

/// Writes a file that is whole or not there, also after a crash of the machine.
pub fn put(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut beside = unfinished(folder)?;
    beside.write_all(bytes)?;
    beside.as_file().sync_all()?;
    beside.persist(path).map_err(|error| error.error)?;
    sync(folder)
}

/// Writes a folder's names through.
pub fn sync(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

/// A text with its checksum.
pub fn seal(text: &str) -> String {
    format!("{text}{SEAL}{:08x}\n", sum(text.as_bytes()))
}

/// The text that was sealed, or one that never was.
///
/// # Errors
/// Why it is not to be used.
pub fn unseal(sealed: &str) -> Result<&str, &'static str> {
    let last = sealed.trim_end_matches('\n').rsplit('\n').next().unwrap_or_default();
    let parts = sealed.len().checked_sub(SEALED).and_then(|at| sealed.split_at_checked(at));
    match parts.filter(|(_, seal)| seal.starts_with(SEAL)) {
        // Wherever it stands: before it there may have been an end of a line.
        Some((text, found)) if found == format!("{SEAL}{:08x}\n", sum(text.as_bytes())) => Ok(text),
        None if !last.starts_with(SEAL) => Ok(sealed),
        _ => Err("its checksum is wrong"),
    }
}

/// A number in a file of its own, with its checksum.
pub fn number(number: u64) -> String {
    seal(&format!("{number}\n"))
}

/// The number in a file of its own.
///
/// # Errors
/// Why it is not to be used.
pub fn read_number(bytes: &[u8]) -> Result<u64, &'static str> {
    let text = unseal(std::str::from_utf8(bytes).map_err(|_| "it is no text")?)?;
    let digits = text.strip_suffix('\n').unwrap_or(text);
    let plain = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    digits.parse().ok().filter(|_| plain).ok_or("it is no number")
}

/// A line with its checksum.
pub fn line(text: &str) -> String {
    format!("{text}{MARK}{:08x}\n", sum(text.as_bytes()))
}

/// What a line says (without its end), and whether it had a checksum, which is right.
///
/// # Errors
/// Why it is not to be used.
pub fn read_line(line: &str) -> Result<(&str, bool), &'static str> {
    let Some((text, told)) = line.rsplit_once(MARK) else { return Ok((line, false)) };
    match told == format!("{:08x}", sum(text.as_bytes())) {
        true => Ok((text, true)),
        false => Err("its checksum is wrong"),
    }
}

#[cfg(test)]
mod tests {
    use super::{line, number, read_line, read_number, seal, unseal};

    /// Every bit of a text, turned: what is read is what was written, or nothing.
    fn turned(whole: &str, read: impl Fn(&[u8]) -> bool) {
        for at in 0..8 * whole.len() {
            let mut bytes = whole.as_bytes().to_vec();
            bytes[at / 8] ^= 1 << (at % 8);
            assert!(!read(&bytes), "bit {at} of {whole:?}");
        }
    }

    #[test]
    fn a_bit_that_turned_is_found_wherever_it_is() {
        for last in [0, 7, 70, 4_711, u64::MAX] {
            assert_eq!(read_number(number(last).as_bytes()), Ok(last));
            turned(&number(last), |bytes| read_number(bytes).is_ok());
        }
        for text in ["0123456789abcdef 12", "7 0", ""] {
            let whole = line(text);
            let plain = whole.trim_end_matches('\n');
            assert_eq!(read_line(plain), Ok((text, true)));
            // One without a mark is none that has one.
            turned(plain, |bytes| {
                std::str::from_utf8(bytes)
                    .is_ok_and(|text| read_line(text).is_ok_and(|read| read.1))
            });
        }
        let whole = seal("a\nb\n");
        assert_eq!(unseal(&whole), Ok("a\nb\n"));
        // One whose seal has another word is read with that line, in which nothing else is wrong.
        turned(&whole, |bytes| {
            let text = std::str::from_utf8(bytes).unwrap_or("crc32c 0");
            unseal(text).is_ok_and(|text| !text.starts_with("a\nb\n") || text == "a\nb\n")
        });
    }

    #[test]
    fn what_was_written_before_there_were_checksums_is_read() {
        assert_eq!((read_number(b"7\n"), read_number(b"12")), (Ok(7), Ok(12)));
        assert_eq!(unseal("a\nb\n"), Ok("a\nb\n"));
        assert_eq!(read_line("0123 7"), Ok(("0123 7", false)));
        for bad in [&b""[..], b"\n", b"7 8\n", b"+7\n", b"7\n\n", b"x\n", b"\xff\n"] {
            assert!(read_number(bad).is_err(), "{bad:?}");
        }
    }
}
