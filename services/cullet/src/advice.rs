//! What is said of a path that is given for a scene and is none: which scene is meant, or how one
//! is made of what it is.

use crate::exit::{CommandError, Exit};
use crate::shipped::{SHIPPED, ShippedScene};
use crate::shown::shown;
use cullet_document::error::nearest;
use cullet_scene::SCENE_FILE;
use std::path::{Path, PathBuf};

/// How meshes end that are read here.
const MESHES: [&str; 5] = ["glb", "gltf", "obj", "stl", "ply"];
/// How others end that a modelling program writes, or keeps.
const OTHER_MESHES: [&str; 12] =
    ["fbx", "blend", "usd", "usda", "usdc", "usdz", "abc", "dae", "3ds", "3mf", "step", "stp"];
/// The folder in which scenes lie, in a copy of the repository.
const SCENES: &str = "scenes";
/// Most names of a folder that are looked at.
const MOST_NAMES: usize = 4096;

/// Refuses a path that is no scene and no sweep, with what is meant.
pub(crate) fn require_scene(path: &Path) -> Result<(), CommandError> {
    let told = match path.try_exists() {
        Ok(false) => advise_missing(path),
        _ if path.is_dir() => return Ok(()),
        _ => match advise_mesh(path) {
            Some(told) => told,
            None => return Ok(()),
        },
    };
    Err(CommandError::new(Exit::Usage, told).at(path.display()))
}

/// What is said of a mesh.
fn advise_mesh(path: &Path) -> Option<String> {
    let end = path.extension()?.to_str()?.to_lowercase();
    let file = path.display().to_string();
    let name = path.file_stem()?.to_string_lossy();
    let (file, name) = (shown(&file), shown(&name));
    if MESHES.contains(&&end[..]) {
        return Some(format!(
            "{file} is a mesh; a scene of it is made with `cullet new {name} --mesh {file}`, then \
             `cullet run {name}`"
        ));
    }
    OTHER_MESHES.contains(&&end[..]).then(|| {
        format!(
            "{file} is a mesh of a format that is not read here; export it as .glb or .obj, then \
             `cullet new {name} --mesh {name}.glb` makes a scene of it"
        )
    })
}

/// What is said of a path where nothing is.
fn advise_missing(path: &Path) -> String {
    let name = scene_name(path);
    let told = format!("there is no file or folder `{}`", shown(&path.display().to_string()));
    if let Some(near) = near_scene(path, &name) {
        return format!("{told}; did you mean {}?", shown(&near.display().to_string()));
    }
    let names = SHIPPED.iter().map(|scene| scene.name);
    let make = |name: &str| format!("`cullet new {name} --from {name}`, then `cullet run {name}`");
    match (ShippedScene::find(&name), nearest(&name, names)) {
        (Some(_), _) => format!("{told}; a scene of this name is shipped: {}", make(&name)),
        (None, Some(near)) => format!("{told}; a scene called {near} is shipped: {}", make(near)),
        (None, None) => {
            format!(
                "{told}; `cullet new NAME` makes a scene, `cullet scenes` lists what is shipped"
            )
        }
    }
}

/// What the scene at a path is called: `pot` for `pot`, `pot.toml` and `pot/scene.toml`.
fn scene_name(path: &Path) -> String {
    let named = match path.file_name() {
        Some(file) if file == SCENE_FILE => path.parent().unwrap_or(path),
        _ => path,
    };
    let stem = |file: &Path| match file.extension() {
        Some(end) if end == "toml" => file.file_stem().map(ToOwned::to_owned),
        _ => file.file_name().map(ToOwned::to_owned),
    };
    stem(named).map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The scene that has that name, or nearly that, beside the path or in the folder of scenes.
fn near_scene(path: &Path, name: &str) -> Option<PathBuf> {
    let beside = match path.file_name() {
        Some(file) if file == SCENE_FILE => path.parent().and_then(Path::parent),
        _ => path.parent(),
    };
    let found: Vec<PathBuf> =
        beside.into_iter().chain([Path::new(SCENES)]).flat_map(scenes_in).collect();
    let names: Vec<String> = found.iter().map(|scene| scene_name(scene)).collect();
    let near = nearest(name, names.iter().map(String::as_str));
    let same = names.iter().position(|known| known == name);
    let at = same.or_else(|| names.iter().position(|known| Some(&known[..]) == near))?;
    found.into_iter().nth(at)
}

/// The scenes and sweeps in a folder.
fn scenes_in(folder: &Path) -> Vec<PathBuf> {
    let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(place).into_iter().flatten().flatten().take(MOST_NAMES);
    let paths = entries.map(|entry| folder.join(entry.file_name()));
    let is_scene = |path: &PathBuf| {
        path.join(SCENE_FILE).is_file() || path.extension().is_some_and(|end| end == "toml")
    };
    let mut found: Vec<PathBuf> = paths.filter(is_scene).collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::require_scene;
    use std::fs;
    use std::path::Path;

    fn refuse(path: &Path) -> String {
        require_scene(path).expect_err("it is no scene").to_string()
    }

    #[test]
    fn a_path_where_nothing_is_is_told_with_the_scene_that_is_meant() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        for name in ["vase", "mine"] {
            fs::create_dir(at(name)).expect("a folder");
            fs::write(at(name).join("scene.toml"), "").expect("a file");
        }
        fs::write(at("drop.toml"), "").expect("a file");
        for (asked, near) in
            [("vas", "vase"), ("vas/scene.toml", "vase"), ("dropp.toml", "drop.toml")]
        {
            let meant = format!("did you mean {}?", at(near).display());
            assert!(refuse(&at(asked)).ends_with(&meant), "{}", refuse(&at(asked)));
        }
        let (vase, drop) = (at("vase"), at("drop.toml"));
        assert!([vase, drop].iter().all(|path| require_scene(path).is_ok()));
        let pot = "`cullet new pot --from pot`, then `cullet run pot`";
        for (asked, told) in [("pot", "of this name is shipped: "), ("pott", "called pot is")] {
            let why = refuse(&at(asked));
            assert!(why.starts_with("there is no file or folder `"), "{why}");
            assert!(why.contains(told) && why.ends_with(pot), "{why}");
        }
        assert!(refuse(&at("xyzzy")).contains("`cullet scenes` lists"), "{}", refuse(&at("xyzzy")));
    }

    #[test]
    fn a_mesh_is_told_with_the_command_that_makes_a_scene_of_it() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, words) in [
            ("cow.glb", "`cullet new cow --mesh "),
            ("cow.OBJ", "`cullet new cow --mesh "),
            ("cow.Stl", "`cullet new cow --mesh "),
            ("cow.ply", "`cullet new cow --mesh "),
            ("cow.gltf", "`cullet new cow --mesh "),
            ("cow.FBX", "export it as .glb or .obj"),
        ] {
            let path = folder.path().join(name);
            fs::write(&path, "glTF").expect("a file");
            let why = refuse(&path);
            assert!(why.contains("is a mesh") && why.contains(words), "{why}");
        }
    }
}
