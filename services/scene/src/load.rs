//! A scene from its file, or from what another machine bundled.

use super::material::is_preset;
use super::resolve;
use super::scene::Scene;
use super::schema;
use cullet_document::files::{FileError, Files, SCENE_BASE, Source};
use cullet_document::overrides::{OverrideRules, apply_overrides};
use cullet_document::tree::ItemNames;
use cullet_document::{Bundle, SceneError, SceneErrors, SceneFile, check, document};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The name of the scene file in a scene's folder.
pub const SCENE_FILE: &str = "scene.toml";

/// Loads a scene: a file, or its folder. `overrides` are `path=value` arguments, applied in order.
///
/// # Errors
/// Everything that is wrong with it, in the order of the text.
pub fn load(path: &Path, overrides: &[String]) -> Result<Scene, SceneErrors> {
    let file = if path.is_dir() { path.join(SCENE_FILE) } else { path.to_owned() };
    let folder = file.parent().map(Path::to_owned).unwrap_or_default();
    let base = file.file_name().map(|name| name.to_string_lossy().into_owned());
    let Some(base) = base else {
        let message = format!("{} is no file", path.display());
        return Err(SceneErrors { errors: vec![SceneError::without_place(message)] });
    };
    let name = name_of(&file, &base);
    let source = Source::Disk { folder };
    build(name, Files::new(source), format!("{SCENE_BASE}{base}"), overrides)
}

/// What a scene at this path is called.
#[must_use]
pub fn name_at(path: &Path) -> String {
    let file = if path.is_dir() { path.join(SCENE_FILE) } else { path.to_owned() };
    let base = file.file_name().map(|name| name.to_string_lossy().into_owned());
    name_of(&file, &base.unwrap_or_default())
}

/// Loads a scene that another machine bundled; no file of this machine is opened.
///
/// # Errors
/// As [`load`].
pub fn load_bundle(bundle: &Bundle) -> Result<Scene, SceneErrors> {
    load_bundle_until(bundle, Arc::default())
}

/// As [`load_bundle`], until `stop` is set: then it ends soon, with an error that says so.
///
/// # Errors
/// As [`load`].
pub fn load_bundle_until(bundle: &Bundle, stop: Arc<AtomicBool>) -> Result<Scene, SceneErrors> {
    let files =
        bundle.files.iter().map(|file| (file.key.clone(), Arc::clone(&file.bytes))).collect();
    let files = Files::new(Source::Bundle(files)).until(stop);
    build(bundle.name.clone(), files, bundle.main.clone(), &bundle.overrides)
}

/// The folder's name for `…/pot/scene.toml`, the file's for `…/pot.toml`.
fn name_of(file: &Path, base: &str) -> String {
    let stem = || file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let folder = || {
        let folder = file.parent()?;
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let name = folder.canonicalize().ok()?;
        name.file_name().map(|name| name.to_string_lossy().into_owned())
    };
    let name = if base == SCENE_FILE { folder().or_else(stem) } else { stem() };
    name.unwrap_or_else(|| "scene".to_owned())
}

fn build(
    name: String,
    mut files: Files,
    main: String,
    overrides: &[String],
) -> Result<Scene, SceneErrors> {
    let (root, text) = document::read(&mut files, &main)?;
    let mut root = document::scene_of(&mut files, root, &main)?;
    let schema = schema::schema_json();
    let sections: Vec<&str> = schema["properties"]
        .as_object()
        .map(|sections| sections.keys().map(String::as_str).collect())
        .unwrap_or_default();
    let known = OverrideRules { sections: &sections, is_preset };
    let mut errors = apply_overrides(&mut root, known, overrides);
    let mut findings = check::check(schema, &mut root);
    errors.append(&mut findings.errors);
    let resolved = resolve::resolve(&root, findings, &mut files);
    errors.extend(resolved.errors);
    if files.is_stopped() {
        // What was not looked at any more is missing in the scene, or in what is wrong with it.
        let error = SceneError::without_place(FileError::Stopped.to_string());
        return Err(SceneErrors { errors: vec![error] });
    }
    let names = ItemNames::of(&root);
    if !errors.is_empty() {
        errors.iter_mut().for_each(|error| error.path = names.tell(&error.path));
        return Err(SceneErrors::sorted(errors));
    }
    let mut scene = resolved.scene;
    for line in &mut scene.warnings {
        *line = names.tell(line);
    }
    scene.name = name;
    scene.source_text = text.content.clone();
    scene.overrides = overrides.to_vec();
    scene.main = main;
    scene.files = files.into_used();
    Ok(scene)
}

impl Scene {
    /// Loads a scene: a file, or the folder that holds [`SCENE_FILE`]. `overrides` are `path=value`
    /// arguments as `--set` takes them, applied in order.
    ///
    /// # Errors
    /// As [`load`].
    pub fn load(path: impl AsRef<Path>, overrides: &[String]) -> Result<Self, SceneErrors> {
        load(path.as_ref(), overrides)
    }

    /// Reads a scene from its text, under this name. It can include and name no other file.
    ///
    /// # Errors
    /// As [`load`].
    pub fn parse(name: &str, text: &str, overrides: &[String]) -> Result<Self, SceneErrors> {
        let main = format!("{SCENE_BASE}{SCENE_FILE}");
        let files = vec![SceneFile { key: main.clone(), bytes: Arc::new(text.into()) }];
        let (name, overrides) = (name.to_owned(), overrides.to_vec());
        load_bundle(&Bundle { name, main, overrides, files })
    }

    /// Reads a scene from its text, under this name, with the files that it names: those given by
    /// key (`scene/pot.obj` for what the text calls `pot.obj`), and those that lie in `folder`;
    /// without a folder there are no others.
    ///
    /// # Errors
    /// As [`load`].
    pub fn assemble(
        name: &str,
        text: &str,
        mut given: Vec<SceneFile>,
        folder: Option<&Path>,
        overrides: &[String],
    ) -> Result<Self, SceneErrors> {
        let main = format!("{SCENE_BASE}{SCENE_FILE}");
        given.push(SceneFile { key: main.clone(), bytes: Arc::new(text.into()) });
        let source = match folder {
            Some(folder) => Source::Disk { folder: folder.to_owned() },
            None => Source::Bundle(BTreeMap::new()),
        };
        let files = Files::new(source).with(given).map_err(|error| SceneErrors {
            errors: vec![SceneError::without_place(error.to_string())],
        })?;
        build(name.to_owned(), files, main, overrides)
    }
}
