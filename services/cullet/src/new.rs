//! `cullet new`.

use crate::args;
use crate::exit::{CommandError, Exit, print};
use crate::folder::Folder;
use cullet_files::output::write_file;

/// The scene that a person begins with.
const SCENE: &str = include_str!("new/scene.toml");
/// What editors complete it by.
const SCHEMA_FILE: &str = "scene.schema.json";

/// Makes a folder with a scene; what is there already is left alone.
pub(crate) fn new(args: &args::New) -> Result<Exit, CommandError> {
    let folder = &args.folder;
    let there = std::fs::read_dir(folder).map(|mut entries| entries.next().is_some());
    if there.unwrap_or(folder.exists()) {
        let text = format!("{}: it is there already; nothing was written", folder.display());
        return Err(CommandError::new(Exit::Usage, text).at(folder.display()));
    }
    let made = Folder::at(folder)?;
    let files =
        [(SCHEMA_FILE, cullet_scene::schema()), (cullet_scene::SCENE_FILE, SCENE.to_owned())];
    for (name, text) in files {
        let path = folder.join(name);
        write_file(&path, text.as_bytes()).map_err(|error| {
            made.forget();
            CommandError::file(&path, error)
        })?;
    }
    let name = folder.display();
    print(format!(
        "{name}/scene.toml is a scene to begin with\n  cullet check {name}\n  cullet run {name}\n"
    ))?;
    Ok(Exit::Done)
}
