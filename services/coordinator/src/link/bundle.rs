//! A scene and its files as one blob, and which paths may be in it.

use super::LinkError;
use cullet_proto::envelope::{self, Kind};
use cullet_proto::ids::digest;
use cullet_proto::mesh::Slabs;
use cullet_proto::pool::{FileEntry, MAX_FILES, MAX_PATH};
use cullet_proto::{WireError, codec};

/// Most bytes of all files of a bundle.
pub const MAX_BUNDLE: u64 = 256 << 20;

/// Holds a path to being a plain one below the bundle's folder.
///
/// # Errors
/// [`LinkError::Path`] with the reason.
pub fn check_path(path: &str) -> Result<(), LinkError> {
    let refused =
        |reason| Err(LinkError::Path { path: path.chars().take(MAX_PATH).collect(), reason });
    if path.is_empty() || path.len() > MAX_PATH {
        return refused("a path has 1 to 200 bytes");
    }
    if path.starts_with('/') {
        return refused("it is absolute");
    }
    if path.contains(['\\', ':']) || path.chars().any(char::is_control) {
        return refused("it holds a backslash, a colon or a control character");
    }
    if path.split('/').any(|part| part.is_empty() || part == "." || part == "..") {
        return refused("a part of it is empty, '.' or '..'");
    }
    Ok(())
}

/// The files as one blob.
pub(super) fn encode(files: &[(String, Vec<u8>)]) -> Result<Vec<u8>, LinkError> {
    let mut table = Vec::new();
    let mut bulk = Vec::new();
    for (path, bytes) in files {
        check_path(path)?;
        let length = bytes.len() as u64;
        table.push(FileEntry { path: path.clone(), length, digest: digest(bytes) });
        bulk.extend_from_slice(bytes);
    }
    check_table(&table)?;
    Ok(envelope::seal(Kind::Bundle, &table, &bulk)?)
}

/// The files in a blob.
pub(super) fn decode(bytes: &[u8]) -> Result<Vec<(String, Vec<u8>)>, LinkError> {
    let (table, bulk) = envelope::open::<Vec<FileEntry>>(Kind::Bundle, bytes)?;
    check_table(&table)?;
    let mut slabs = Slabs::new(bulk);
    let mut files = Vec::new();
    for FileEntry { path, length, .. } in table {
        check_path(&path)?;
        files.push((path, slabs.take("a bundle", length as usize, 1)?.to_vec()));
    }
    slabs.end("a bundle")?;
    Ok(files)
}

fn check_table(table: &[FileEntry]) -> Result<(), LinkError> {
    codec::limit("a bundle's files", table.len() as u64, MAX_FILES as u64)?;
    let total = table.iter().fold(0u64, |sum, file| sum.saturating_add(file.length));
    codec::limit("a bundle's bytes", total, MAX_BUNDLE)?;
    if table.is_empty() {
        return Err(WireError::Short { what: "a bundle's files", have: 0, need: 1 }.into());
    }
    for (index, file) in table.iter().enumerate() {
        if table[..index].iter().any(|other| other.path == file.path) {
            let (path, reason) = (file.path.clone(), "it is there twice");
            return Err(LinkError::Path { path, reason });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_would_leave_the_folder_are_refused() {
        for good in ["scene.toml", "meshes/bunny.obj", "a..b/c"] {
            assert!(check_path(good).is_ok(), "{good}");
        }
        let long = "x".repeat(MAX_PATH + 1);
        let bad = ["", "/etc/passwd", "..", "a/../b", "./a", "a//b", "a/", "c:\\x", "a\0", &long];
        for bad in bad {
            assert!(matches!(check_path(bad), Err(LinkError::Path { .. })), "{bad}");
        }
    }

    #[test]
    fn a_bundle_comes_back_and_a_forged_one_does_not() -> Result<(), LinkError> {
        let files = vec![("scene.toml".into(), b"x = 1".to_vec()), ("m/a.obj".into(), vec![])];
        let bytes = encode(&files)?;
        assert_eq!(decode(&bytes)?, files);
        assert!(decode(&bytes[..bytes.len() - 1]).is_err());
        let (path, length) = ("../x".to_owned(), 0);
        let table = vec![FileEntry { path, length, digest: [0; 32] }];
        let forged = envelope::seal(Kind::Bundle, &table, &[])?;
        assert!(matches!(decode(&forged), Err(LinkError::Path { .. })));
        let twice = vec![files[0].clone(), files[0].clone()];
        assert!(matches!(encode(&twice), Err(LinkError::Path { .. })));
        assert!(encode(&[]).is_err());
        Ok(())
    }
}
