//! A scene that is not on the disk yet, and how it comes there.

use crate::exit::CommandError;
use crate::folder::Folder;
use cullet_files::output::write_file;
use std::fs;
use std::path::Path;

/// What editors complete a scene by.
pub(super) const SCHEMA_FILE: &str = "scene.schema.json";

/// A scene that is not on the disk yet.
pub(super) struct NewScene {
    /// What it is, a line each.
    pub(super) about: Vec<String>,
    /// Its files beside the schema, by name.
    pub(super) files: Vec<(String, Vec<u8>)>,
}

impl NewScene {
    /// Writes its files and the schema into a new folder: all of them, or none.
    pub(super) fn write(&self, folder: &Path) -> Result<(), CommandError> {
        let made = Folder::at(folder)?;
        let schema = (SCHEMA_FILE.to_owned(), cullet_scene::schema().into_bytes());
        let mut written = Vec::new();
        for (name, bytes) in self.files.iter().chain([&schema]) {
            let path = folder.join(name);
            if let Err(error) = write_file(&path, bytes) {
                for path in &written {
                    let _ours_alone = fs::remove_file(path);
                }
                made.forget();
                return Err(CommandError::file(&path, error));
            }
            written.push(path);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::NewScene;
    use std::fs;

    #[test]
    fn what_cannot_be_written_whole_is_not_written() {
        let base = tempfile::tempdir().expect("a folder");
        let folder = base.path().join("a/b");
        let files = ["scene.toml", "none/mesh.obj"].map(|name| (name.to_owned(), vec![1]));
        let scene = NewScene { about: Vec::new(), files: files.to_vec() };
        assert!(scene.write(&folder).is_err());
        assert_eq!(fs::read_dir(base.path()).expect("a folder").count(), 0, "something is left");
    }
}
