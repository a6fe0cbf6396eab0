//! The scene loader: a TOML file to bodies that are ready for the world, or every error at once.
//!
//! [`mod@format`] is the one source of the reader, of the schema and of the [`reference()`].
//! `cullet_document` reads the text; `resolve` makes bodies of it. `position` places the *origin*
//! of a shape or mesh file (or the point that `anchor` names); a loaded body's own origin is its
//! centroid, and its pose makes up for it.

mod admission;
pub mod body;
mod expect;
pub mod form;
pub mod format;
mod generate;
mod limits;
pub mod look;
pub mod material;
mod overlap;
pub mod paint;
mod preflight;
mod reference;
pub mod resolve;
pub mod rigid;
pub mod schema;
pub mod shape;
mod taken;
#[cfg(test)]
mod tests;

pub use expect::Observed;
pub use format::{Expect, SolverChoice, View};
pub use material::{
    Kind, Preset, SceneMaterial, Sourced, is_preset, preset, presets, presets_json, presets_text,
};
pub use reference::reference;
pub use schema::schema;

use cullet_document::files::{Files, SCENE_BASE, Source};
use cullet_document::overrides::{Known, apply_overrides};
use cullet_document::{Bundle, SceneError, SceneErrors, SceneFile, check, document};
use cullet_geometry::{Mat3, Pose, Solid, Vec3};
use cullet_proto::strength::Strength;
use std::path::Path;
use std::sync::Arc;

/// The name of the scene file in a scene's folder.
pub const SCENE_FILE: &str = "scene.toml";

/// A body of a scene, ready for the world.
#[derive(Clone, Debug)]
pub struct SceneBody {
    /// What the scene calls it.
    pub name: String,
    /// The generator that made it.
    pub generator: Option<String>,
    /// Its shape; the centroid is the origin \[m\]. Shared by bodies of equal shape.
    pub solid: Arc<Solid>,
    /// Convex parts that stand in for it in collisions, in the same frame \[m\]. Shared likewise.
    pub hulls: Arc<Vec<Vec<Vec3>>>,
    /// Volume \[m³\].
    pub volume: f64,
    /// Inertia about the centroid at unit density, in the body's frame \[m⁵\].
    pub inertia: Mat3,
    /// Body frame to world frame \[m\].
    pub pose: Pose,
    /// Velocity of the centroid \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity in the world frame \[rad/s\].
    pub spin: Vec3,
    /// What it is made of. Shared by bodies of one material.
    pub material: Arc<SceneMaterial>,
    /// How its strength varies; the seed is the run's affair. Shared by bodies of one mould.
    pub strength: Arc<Strength>,
    /// The least share of its material's strength that the scene gave a part of it \[1\].
    pub weakest: f64,
    /// Whether it never moves.
    pub fixed: bool,
    /// Whether it can break.
    pub breakable: bool,
    /// Grid spacing of its solves \[m\]; the solver chooses without it.
    pub spacing: Option<f64>,
    /// About so many material points in place of the scene's `max_particles`.
    pub particles: Option<u32>,
    /// In place of the world's impulse threshold \[N·s\].
    pub impulse_threshold: Option<f64>,
    /// Which solver: the body's own choice, or the scene's.
    pub solver: SolverChoice,
    /// What was repaired of its mesh, a line each.
    pub repairs: Vec<String>,
}

/// A scene, checked and complete.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The name of its folder, or of its file.
    pub name: String,
    /// What it shows, in a line.
    pub description: String,
    /// The rigid world and its clock.
    pub world: format::World,
    /// How bodies are broken.
    pub fracture: format::Fracture,
    /// How true and how dear solves should be.
    pub fidelity: format::Fidelity,
    /// The bodies, in the order of the file, then grids, stacks and scatters.
    pub bodies: Vec<SceneBody>,
    /// What the scene must show.
    pub expect: Expect,
    /// Where the preview looks from.
    pub view: Option<View>,
    /// What is unusual or was repaired, a line each.
    pub warnings: Vec<String>,
    /// The main file as it is written.
    pub source_text: String,
    /// The `path=value` arguments that were applied.
    pub overrides: Vec<String>,
    /// The key of the main file.
    pub main: String,
    /// Every file that was read, by key.
    pub files: Vec<SceneFile>,
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

    /// Everything that another machine needs to load the same scene by [`load_bundle`].
    #[must_use]
    pub fn bundle(&self) -> Bundle {
        Bundle {
            name: self.name.clone(),
            main: self.main.clone(),
            overrides: self.overrides.clone(),
            files: self.files.clone(),
        }
    }

    /// How many steps the run takes.
    #[must_use]
    pub fn steps(&self) -> u64 {
        (self.world.duration / self.world.step).round() as u64
    }
}

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
    let files =
        bundle.files.iter().map(|file| (file.key.clone(), Arc::clone(&file.bytes))).collect();
    let files = Files::new(Source::Bundle(files));
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
    let (root, text, mut errors) = document::read(&mut files, &main);
    let Some(text) = text else {
        return Err(SceneErrors { errors });
    };
    let garbled = !errors.is_empty();
    let mut root = document::scene_of(&mut files, root, &main, &mut errors);
    let schema = schema::schema_json();
    let sections: Vec<&str> = schema["properties"]
        .as_object()
        .map(|sections| sections.keys().map(String::as_str).collect())
        .unwrap_or_default();
    let known = Known { sections: &sections, is_preset };
    errors.extend(apply_overrides(&mut root, known, overrides));
    let mut findings = check::check(schema, &mut root);
    if garbled {
        // What is no TOML is left out, and may be what is missing.
        findings.errors.retain(|error| !error.message.ends_with("is missing"));
    }
    errors.append(&mut findings.errors);
    let resolved = resolve::resolve(&root, findings, garbled, &mut files);
    errors.extend(resolved.errors);
    if !errors.is_empty() {
        let errors = errors.into_iter().map(|error| error.named(&root)).collect();
        return Err(SceneErrors::sorted(errors));
    }
    let mut scene = resolved.scene;
    for line in &mut scene.warnings {
        *line = root.with_names(line);
    }
    scene.name = name;
    scene.source_text = text.content.clone();
    scene.overrides = overrides.to_vec();
    scene.main = main;
    scene.files = files.into_used();
    Ok(scene)
}
