//! `cullet new`: a folder with a scene to begin with, a copy of one that is shipped, or one of a
//! mesh.

mod draft;
mod mesh;

use crate::args;
use crate::exit::{CommandError, Exit, print};
use crate::shipped::ShippedScene;
use crate::shown::{lines as lines_of, shown};
use cullet_scene::SCENE_FILE;
use draft::{NewScene, SCHEMA_FILE};
use std::fs;

/// The scene that a person begins with.
const SCENE: &str = include_str!("new/scene.toml");
/// Where shipped scenes have their schema.
const SHIPPED_SCHEMA: &str = "#:schema ../scene.schema.json";

/// Makes a folder with a scene; what is there already is left alone.
pub(crate) fn new(args: &args::New) -> Result<Exit, CommandError> {
    let folder = &args.folder;
    let there = fs::read_dir(folder).map(|mut entries| entries.next().is_some());
    if there.unwrap_or(folder.exists()) {
        let text = format!("{}: it is there already; nothing was written", folder.display());
        return Err(CommandError::new(Exit::Usage, text).at(folder.display()));
    }
    let name = folder.display().to_string();
    let name = shown(&name);
    let scene = match (&args.from, &args.mesh) {
        (Some(shipped), _) => copy_shipped(ShippedScene::require(shipped)?, &name),
        (None, Some(file)) => mesh::make_scene(file, &name)?,
        (None, None) => NewScene {
            about: vec![format!("{name}/{SCENE_FILE} is a scene to begin with")],
            files: vec![(SCENE_FILE.to_owned(), SCENE.into())],
        },
    };
    scene.write(folder)?;
    let about = scene.about.iter().map(|line| lines_of(line) + "\n").collect::<String>();
    print(format!("{about}  cullet check {name}\n  cullet run {name}\n"))?;
    Ok(Exit::Done)
}

/// A shipped scene as it is, but for the place of its schema.
fn copy_shipped(scene: &ShippedScene, name: &str) -> NewScene {
    let local = format!("#:schema {SCHEMA_FILE}");
    let files = scene.files.iter().map(|file| {
        let text = std::str::from_utf8(file.bytes).ok();
        let rest = text.and_then(|text| text.strip_prefix(SHIPPED_SCHEMA));
        let bytes = rest.map(|rest| format!("{local}{rest}").into_bytes());
        (file.name.to_owned(), bytes.unwrap_or_else(|| file.bytes.to_vec()))
    });
    let about = vec![format!("{name}/{SCENE_FILE} is a copy of the shipped scene {}", scene.name)];
    NewScene { about, files: files.collect() }
}

#[cfg(test)]
mod tests {
    use super::copy_shipped;
    use crate::shipped::SHIPPED;
    use cullet::Scene;

    #[test]
    fn a_copy_of_a_shipped_scene_has_all_of_its_files_and_is_that_scene() {
        let base = tempfile::tempdir().expect("a folder");
        for shipped in SHIPPED {
            let folder = base.path().join(shipped.name);
            let copy = copy_shipped(shipped, "x");
            assert_eq!(copy.files.len(), shipped.files.len());
            for ((name, bytes), file) in copy.files.iter().zip(shipped.files) {
                let text = String::from_utf8(bytes.clone()).expect("a text");
                let back = text.replacen("#:schema s", "#:schema ../s", 1);
                assert!(name == file.name && back.as_bytes() == file.bytes, "{name}");
                assert!(!text.contains("../"), "{}/{name} leads out of its folder", shipped.name);
            }
            copy.write(&folder).unwrap_or_else(|why| panic!("{why}"));
        }
        // One that has a mesh is read from there as from here.
        let here = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/gummy");
        let [here, copy] = [here.as_ref(), base.path().join("gummy").as_path()]
            .map(|path: &std::path::Path| Scene::load(path, &[]).expect("a scene"));
        let files = |scene: &Scene| scene.files.iter().map(|f| f.key.clone()).collect::<Vec<_>>();
        assert_eq!((files(&here), &here.name), (files(&copy), &copy.name));
    }
}
