//! A scene and its files as one blob: a line of JSON that names them, then their bytes.

use super::error::LinkError;
use cullet_document::files::{Bundle, SceneFile};
use cullet_proto::codec::{self, WireError};
use cullet_proto::ids::digest;
use cullet_proto::service::{self, BundleFile, BundleTable};

/// Most bytes of all files of a bundle.
pub const MAX_BUNDLE: u64 = 256 << 20;
/// Most files of a bundle.
const MAX_FILES: u64 = 512;
/// Longest path \[bytes\].
const MAX_PATH: usize = 200;
/// Longest key of a file \[bytes\].
const MAX_KEY: u64 = 4_096;

/// Holds a path to being a plain one below a folder.
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

/// A bundle as a blob; its overrides travel beside it.
///
/// # Errors
/// A name, size or count that may not be.
pub(crate) fn encode(bundle: &Bundle) -> Result<Vec<u8>, LinkError> {
    let row =
        |file: &SceneFile| BundleFile { key: file.key.clone(), length: file.bytes.len() as u64 };
    let files: Vec<BundleFile> = bundle.files.iter().map(row).collect();
    let table = BundleTable { name: bundle.name.clone(), main: bundle.main.clone(), files };
    check(&table)?;
    let bulk: Vec<u8> = bundle.files.iter().flat_map(|file| file.bytes.iter().copied()).collect();
    Ok(service::seal(&table, &bulk)?)
}

/// Sixteen digits that a scene with all its files and overrides has, and no other.
///
/// # Errors
/// As [`Client::submit`](super::client::Client::submit) of it.
pub fn mark(bundle: &Bundle) -> Result<String, LinkError> {
    let mut bytes = encode(bundle)?;
    for set in &bundle.overrides {
        bytes.extend_from_slice(&(set.len() as u64).to_le_bytes());
        bytes.extend_from_slice(set.as_bytes());
    }
    let mut hex = service::hex_of(&digest(&bytes));
    hex.truncate(16);
    Ok(hex)
}

/// The bundle in a blob.
///
/// # Errors
/// As `encode`, or bytes that are not those that the table names.
pub fn decode(bytes: &[u8], overrides: &[String]) -> Result<Bundle, LinkError> {
    let (table, mut bulk) = service::open::<BundleTable>(bytes)?;
    check(&table)?;
    let mut files = Vec::new();
    for BundleFile { key, length } in table.files {
        let what = "a bundle's files";
        let (file, rest) = bulk.split_at_checked(length as usize).ok_or(WireError::Short {
            what,
            have: bulk.len(),
            need: length as usize,
        })?;
        files.push(SceneFile { key, bytes: file.to_vec().into() });
        bulk = rest;
    }
    if !bulk.is_empty() {
        return Err(WireError::Trailing { what: "a bundle's files", extra: bulk.len() }.into());
    }
    let overrides = overrides.to_vec();
    Ok(Bundle { name: table.name, main: table.main, overrides, files })
}

fn check(table: &BundleTable) -> Result<(), LinkError> {
    // The name becomes part of a folder's name: it must not lead anywhere else.
    check_path(&table.name)?;
    let refused = |path: &str, reason| {
        Err(LinkError::Path { path: path.chars().take(MAX_PATH).collect(), reason })
    };
    if table.name.contains('/') {
        return refused(&table.name, "a scene's name has no slash");
    }
    codec::limit("a bundle's files", table.files.len() as u64, MAX_FILES)?;
    let total = table.files.iter().fold(0u64, |sum, file| sum.saturating_add(file.length));
    codec::limit("a bundle's bytes", total, MAX_BUNDLE)?;
    for (index, file) in table.files.iter().enumerate() {
        codec::limit("a key's length", file.key.len() as u64, MAX_KEY)?;
        if table.files[..index].iter().any(|other| other.key == file.key) {
            return refused(&file.key, "it is there twice");
        }
    }
    if !table.files.iter().any(|file| file.key == table.main) {
        return refused(&table.main, "the bundle does not have its scene file");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bundle(name: &str, keys: &[&str]) -> Bundle {
        let file = |key: &&str| SceneFile {
            key: (*key).to_owned(),
            bytes: key.as_bytes().repeat(2).into(),
        };
        let (name, main) = (name.to_owned(), "scene/a.toml".to_owned());
        Bundle { name, main, overrides: vec!["a=1".into()], files: keys.iter().map(file).collect() }
    }

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
        // A scene may use files outside its folder: keys are names, and no path on any disk.
        let good = bundle("pot", &["scene/a.toml", "scene/../b.obj"]);
        let bytes = encode(&good)?;
        assert_eq!(decode(&bytes, &good.overrides)?, good);
        assert!(decode(&bytes[..bytes.len() - 1], &[]).is_err(), "short");
        assert!(decode(&[&bytes[..], b"x"].concat(), &[]).is_err(), "long");
        for name in ["", "..", "../pot", "/tmp/pot", "a/b"] {
            let bad = encode(&bundle(name, &["scene/a.toml"]));
            assert!(matches!(bad, Err(LinkError::Path { .. })), "{name}");
        }
        assert!(encode(&bundle("pot", &["scene/b.toml"])).is_err(), "no main file");
        assert!(encode(&bundle("pot", &["scene/a.toml", "scene/a.toml"])).is_err(), "twice");
        let bomb = br#"{"name":"a","main":"b","files":[{"key":"b","length":99999999999999}]}"#;
        assert!(matches!(decode(bomb, &[]), Err(LinkError::Wire(WireError::Limit { .. }))));
        Ok(())
    }
}
