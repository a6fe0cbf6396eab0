//! The scenes that come with the program, with all their files: `cullet scenes`, and what
//! `cullet new --from` copies. The folder `scenes` of the sources is the list.

use crate::args;
use crate::exit::{CommandError, Exit, print};
use cullet_document::error::suggest;
use cullet_scene::SCENE_FILE;
use serde_json::json;

/// A scene that is in the program.
pub(crate) struct ShippedScene {
    pub(crate) name: &'static str,
    pub(crate) files: &'static [ShippedFile],
}

/// A file of such a scene.
pub(crate) struct ShippedFile {
    pub(crate) name: &'static str,
    pub(crate) bytes: &'static [u8],
}

include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

impl ShippedScene {
    /// The scene of that name.
    pub(crate) fn find(name: &str) -> Option<&'static Self> {
        SHIPPED.iter().find(|scene| scene.name == name)
    }

    /// The same, for whoever wants it and no other.
    pub(crate) fn require(name: &str) -> Result<&'static Self, CommandError> {
        Self::find(name).ok_or_else(|| {
            let known: Vec<&str> = SHIPPED.iter().map(|scene| scene.name).collect();
            let near = suggest(name, &known).unwrap_or_default();
            let text = format!("no scene called {name:?} is shipped (cullet scenes): {near}");
            CommandError::new(Exit::Usage, text)
        })
    }

    /// What it shows, in its own words.
    fn description(&self) -> String {
        let file = self.files.iter().find(|file| file.name == SCENE_FILE);
        let text = file.and_then(|file| std::str::from_utf8(file.bytes).ok()).unwrap_or_default();
        let table: toml::Table = text.parse().unwrap_or_default();
        table.get("description").and_then(toml::Value::as_str).unwrap_or_default().to_owned()
    }
}

/// `cullet scenes`: a line for each.
pub(crate) fn list_scenes(args: &args::Scenes) -> Result<Exit, CommandError> {
    if args.json {
        let scenes = SHIPPED.iter().map(|scene| {
            let files: Vec<&str> = scene.files.iter().map(|file| file.name).collect();
            json!({"name": scene.name, "description": scene.description(), "files": files})
        });
        let scenes: Vec<serde_json::Value> = scenes.collect();
        print(format!("{:#}\n", serde_json::Value::from(scenes)))?;
        return Ok(Exit::Done);
    }
    let width = SHIPPED.iter().map(|scene| scene.name.len()).max().unwrap_or_default();
    let line = |scene: &ShippedScene| format!("{:width$}  {}\n", scene.name, scene.description());
    print(SHIPPED.iter().map(line).collect::<String>())?;
    Ok(Exit::Done)
}

#[cfg(test)]
mod tests {
    use super::{SHIPPED, ShippedScene};
    use std::fs;
    use std::path::{Path, PathBuf};

    /// What lies in a folder, by name.
    fn entries(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("it").path()).collect();
        paths.sort();
        paths
    }

    fn name(path: &Path) -> String {
        path.file_name().expect("a name").to_string_lossy().into_owned()
    }

    #[test]
    fn every_scene_of_the_sources_is_in_the_program_byte_for_byte() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let scenes: Vec<PathBuf> =
            entries(&folder).into_iter().filter(|path| path.is_dir()).collect();
        assert!(scenes.len() >= 47 && scenes.len() == SHIPPED.len(), "{scenes:?}");
        for path in scenes {
            let scene = ShippedScene::find(&name(&path)).unwrap_or_else(|| panic!("{path:?}"));
            let mut files = entries(&path);
            files.retain(|file| file.is_file() && !name(file).starts_with('.'));
            let names: Vec<String> = files.iter().map(|file| name(file)).collect();
            assert_eq!(scene.files.iter().map(|file| file.name).collect::<Vec<_>>(), names);
            for (file, shipped) in files.iter().zip(scene.files) {
                assert!(fs::read(file).expect("a file") == shipped.bytes, "{file:?} is another");
            }
        }
    }

    #[test]
    fn each_says_what_it_shows_in_one_line_and_they_are_not_large() {
        for scene in SHIPPED {
            let told = scene.description();
            assert!(told.ends_with('.') && !told.contains('\n'), "{}: {told:?}", scene.name);
        }
        let bytes: usize =
            SHIPPED.iter().flat_map(|scene| scene.files).map(|f| f.bytes.len()).sum();
        assert!(bytes < 800_000, "{bytes} bytes of scenes in the program");
    }

    #[test]
    fn an_unknown_name_is_told_with_the_one_that_is_meant() {
        for (asked, meant) in [("pott", "`pot`"), ("clay-pott", "`clay-pot`"), ("xyzzy", "beams")] {
            let why = ShippedScene::require(asked).err().expect("there is none").to_string();
            assert!(why.contains(asked) && why.contains(meant), "{why}");
        }
    }
}
