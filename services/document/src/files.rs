//! The files of a scene: from the disk, or from a bundle that a client sent.
//!
//! Each file has a *key*, a plain string: `scene/<path>` for what a scene file names (relative to
//! the folder of the main file), `given/<path>` for what a `--set` argument names (relative to the
//! current folder). A bundle maps keys to bytes, so a coordinator on another machine never opens a
//! path of its own.

use cullet_files::regular;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Most bytes of one file: a scene must not fill the coordinator's memory.
pub const MAX_FILE_BYTES: u64 = 256 << 20;

/// Most bytes of all files of a scene together, for the same reason.
pub const MAX_TOTAL_BYTES: u64 = 512 << 20;

/// Most files of a scene.
pub const MAX_FILES: usize = 256;

/// Longest scene file \[bytes\]: generators say in ten lines what a million lines would.
pub const MAX_SCENE_BYTES: usize = 8 << 20;

/// Most texts of a document: its main file and all includes, one that is included twice counted
/// twice, because it is parsed twice. Includes that fan out stop here.
pub const MAX_TEXTS: usize = 256;

/// Most bytes of all these texts together, for the same reason.
pub const MAX_TEXT_BYTES: usize = 2 * MAX_SCENE_BYTES;

/// The key prefix of files that a scene file names.
pub const SCENE_BASE: &str = "scene/";

/// The key prefix of files that an override names.
pub const GIVEN_BASE: &str = "given/";

/// Why a file could not be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// Not there, or not readable.
    #[error("cannot read {path}: {reason}")]
    Unreadable {
        /// The file concerned.
        path: String,
        /// What the system said.
        reason: String,
    },
    /// The bundle does not have it.
    #[error("{path} is not in the bundle")]
    NotBundled {
        /// Which key.
        path: String,
    },
    /// Larger than accepted.
    #[error("{path} is larger than {limit} bytes")]
    TooLarge {
        /// The file concerned.
        path: String,
        /// The bound \[bytes\].
        limit: u64,
    },
    /// More files than accepted.
    #[error("the scene names more than {limit} files")]
    TooMany {
        /// The bound.
        limit: usize,
    },
    /// More texts than accepted.
    #[error(
        "the document would have more than {limit} files with all that it includes; one that is \
         included several times counts each time"
    )]
    TooManyTexts {
        /// The bound.
        limit: usize,
    },
    /// Texts that are too long together.
    #[error(
        "with {path} the document would have more than {limit} bytes with all that it includes"
    )]
    TooMuchText {
        /// The file that is over the bound.
        path: String,
        /// The bound \[bytes\].
        limit: usize,
    },
    /// Whoever wanted the document wants it no more.
    #[error("loading was stopped")]
    Stopped,
}

/// One file that a scene used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneFile {
    /// Its key.
    pub key: String,
    /// Its bytes.
    pub bytes: Arc<Vec<u8>>,
}

/// A scene with everything it needs, to be sent elsewhere.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bundle {
    /// What the scene is called.
    pub name: String,
    /// The key of the main file.
    pub main: String,
    /// `path=value` arguments, in order.
    pub overrides: Vec<String>,
    /// Every file, by key.
    pub files: Vec<SceneFile>,
}

/// Where files come from.
#[derive(Clone, Debug)]
pub enum Source {
    /// The disk: the folder of the main file, and the current folder for overrides.
    Disk {
        /// Folder of the main scene file.
        folder: PathBuf,
    },
    /// Memory.
    Bundle(BTreeMap<String, Arc<Vec<u8>>>),
}

/// A source and what was taken from it so far.
#[derive(Debug)]
pub struct Files {
    source: Source,
    used: BTreeMap<String, Arc<Vec<u8>>>,
    total: u64,
    texts: usize,
    text_bytes: usize,
    stop: Option<Arc<AtomicBool>>,
}

impl Files {
    /// Nothing taken yet.
    #[must_use]
    pub fn new(source: Source) -> Self {
        Self { source, used: BTreeMap::new(), total: 0, texts: 0, text_bytes: 0, stop: None }
    }

    /// The same until this is set: nothing can be had any more then.
    #[must_use]
    pub fn until(self, stop: Arc<AtomicBool>) -> Self {
        Self { stop: Some(stop), ..self }
    }

    /// Whether loading is to end.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// The same with files that are given, and are not looked for in the source.
    ///
    /// # Errors
    /// Over a limit.
    pub fn with(mut self, given: Vec<SceneFile>) -> Result<Self, FileError> {
        for SceneFile { key, bytes } in given {
            if bytes.len() as u64 > MAX_FILE_BYTES {
                return Err(FileError::TooLarge { path: key, limit: MAX_FILE_BYTES });
            }
            self.take(&key, bytes)?;
        }
        Ok(self)
    }

    /// The bytes under `key`; the second call for a key costs nothing.
    ///
    /// # Errors
    /// Missing, unreadable, or over a limit.
    pub fn get(&mut self, key: &str) -> Result<Arc<Vec<u8>>, FileError> {
        self.get_within(key, MAX_FILE_BYTES)
    }

    /// As [`Files::get`], for a file of at most `limit` bytes; of a larger one no more is read.
    fn get_within(&mut self, key: &str, limit: u64) -> Result<Arc<Vec<u8>>, FileError> {
        if self.is_stopped() {
            return Err(FileError::Stopped);
        }
        let bytes = match (self.used.get(key), &self.source) {
            (Some(bytes), _) => Arc::clone(bytes),
            _ if self.used.len() >= MAX_FILES => {
                return Err(FileError::TooMany { limit: MAX_FILES });
            }
            (None, Source::Disk { folder }) => Arc::new(read_disk(&disk_path(folder, key), limit)?),
            (None, Source::Bundle(files)) => match files.get(key) {
                Some(bytes) => Arc::clone(bytes),
                None => return Err(FileError::NotBundled { path: key.to_owned() }),
            },
        };
        if bytes.len() as u64 > limit {
            return Err(FileError::TooLarge { path: self.label(key), limit });
        }
        if !self.used.contains_key(key) {
            self.take(key, Arc::clone(&bytes))?;
        }
        Ok(bytes)
    }

    /// The text under `key`, to be parsed: each call counts, whether or not the file was there
    /// before.
    ///
    /// # Errors
    /// As [`Files::get`], and where the texts would be too many or too long together.
    pub fn text(&mut self, key: &str) -> Result<Arc<Vec<u8>>, FileError> {
        if self.texts >= MAX_TEXTS {
            return Err(FileError::TooManyTexts { limit: MAX_TEXTS });
        }
        let left = MAX_TEXT_BYTES - self.text_bytes;
        let bytes = self.get_within(key, left.min(MAX_SCENE_BYTES) as u64);
        let bytes = bytes.map_err(|error| match error {
            FileError::TooLarge { path, .. } if left < MAX_SCENE_BYTES => {
                FileError::TooMuchText { path, limit: MAX_TEXT_BYTES }
            }
            other => other,
        })?;
        self.texts += 1;
        self.text_bytes += bytes.len();
        Ok(bytes)
    }

    fn take(&mut self, key: &str, bytes: Arc<Vec<u8>>) -> Result<(), FileError> {
        if self.used.len() >= MAX_FILES {
            return Err(FileError::TooMany { limit: MAX_FILES });
        }
        self.total += bytes.len() as u64;
        if self.total > MAX_TOTAL_BYTES {
            let path = "the scene with all its files".to_owned();
            return Err(FileError::TooLarge { path, limit: MAX_TOTAL_BYTES });
        }
        self.used.insert(key.to_owned(), bytes);
        Ok(())
    }

    /// The bytes under `key`, if they are there and no more than `limit`; what is not had counts
    /// for nothing.
    pub fn get_up_to(&mut self, key: &str, limit: u64) -> Option<Arc<Vec<u8>>> {
        self.get_within(key, limit).ok()
    }

    /// What a person calls the file under `key`.
    #[must_use]
    pub fn label(&self, key: &str) -> String {
        match &self.source {
            Source::Disk { folder } => disk_path(folder, key).display().to_string(),
            Source::Bundle(_) => key.strip_prefix(SCENE_BASE).unwrap_or(key).to_owned(),
        }
    }

    /// Everything taken, by key.
    #[must_use]
    pub fn into_used(self) -> Vec<SceneFile> {
        self.used.into_iter().map(|(key, bytes)| SceneFile { key, bytes }).collect()
    }
}

/// The key of `path` as written in a text whose base is `base`; `.` and `..` are worked out by
/// name.
#[must_use]
pub fn key(base: &str, path: &str) -> String {
    let path = path.replace('\\', "/");
    if path.starts_with('/') {
        let root = if base.starts_with(GIVEN_BASE) { GIVEN_BASE } else { SCENE_BASE };
        return format!("{root}{path}");
    }
    let (root, folder) = match base.split_once('/') {
        Some((root, folder)) => (root, folder),
        None => (base, ""),
    };
    let absolute = folder.starts_with('/');
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(path.split('/')) {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => {
                parts.pop();
            }
            other => parts.push(other),
        }
    }
    let slash = if absolute { "/" } else { "" };
    format!("{root}/{slash}{}", parts.join("/"))
}

/// The base of texts under `key`: everything up to its last slash.
#[must_use]
pub fn folder_of(key: &str) -> String {
    key.rfind('/').map_or_else(String::new, |at| key[..=at].to_owned())
}

fn disk_path(folder: &Path, key: &str) -> PathBuf {
    match key.strip_prefix(SCENE_BASE) {
        Some(path) => folder.join(path),
        None => PathBuf::from(key.strip_prefix(GIVEN_BASE).unwrap_or(key)),
    }
}

fn read_disk(path: &Path, limit: u64) -> Result<Vec<u8>, FileError> {
    let name = path.display().to_string();
    let unreadable = |error: std::io::Error| FileError::Unreadable {
        path: name.clone(),
        reason: regular::words(&error),
    };
    let file = regular::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::{FileError, Files, MAX_FILES, SceneFile, Source, folder_of, key};
    use std::collections::BTreeMap;
    use std::sync::Arc;

    #[test]
    fn what_is_too_large_is_not_taken() {
        let bundle = BTreeMap::from([("scene/a.png".to_owned(), Arc::new(vec![7; 100]))]);
        let mut files = Files::new(Source::Bundle(bundle));
        assert_eq!(files.get_up_to("scene/a.png", 99), None);
        assert_eq!(files.get_up_to("scene/b.png", 99), None);
        assert_eq!((files.total, files.used.len()), (0, 0));
        assert_eq!(files.get_up_to("scene/a.png", 100).map(|bytes| bytes.len()), Some(100));
        assert_eq!((files.total, files.into_used().len()), (100, 1));
    }

    #[test]
    fn what_is_given_is_not_looked_for() {
        let file = |key: &str| SceneFile { key: key.to_owned(), bytes: Arc::new(vec![7; 3]) };
        let empty = || Files::new(Source::Bundle(BTreeMap::new()));
        let mut files = empty().with(vec![file("scene/a.png")]).expect("it is small");
        assert_eq!(files.get("scene/a.png").map(|bytes| bytes.len()), Ok(3));
        assert!(files.get("scene/b.png").is_err());
        assert_eq!((files.total, files.into_used().len()), (3, 1));
        let many = (0..=MAX_FILES).map(|n| file(&n.to_string())).collect();
        assert_eq!(empty().with(many).expect_err("too many"), FileError::TooMany { limit: 256 });
    }

    #[test]
    fn keys_are_worked_out_by_name() {
        assert_eq!(key("scene/", "a/b.obj"), "scene/a/b.obj");
        assert_eq!(key("scene/lib/", "./x/../b.obj"), "scene/lib/b.obj");
        assert_eq!(key("scene/lib/", "../common.toml"), "scene/common.toml");
        assert_eq!(key("scene/", "../common.toml"), "scene/../common.toml");
        assert_eq!(key("scene/../", "../x.toml"), "scene/../../x.toml");
        assert_eq!(key("given/", "/abs/x.obj"), "given//abs/x.obj");
        assert_eq!(key("scene//abs/", "x.obj"), "scene//abs/x.obj");
        assert_eq!(folder_of("scene/a/b.toml"), "scene/a/");
        assert_eq!(folder_of("scene/b.toml"), "scene/");
    }
}
