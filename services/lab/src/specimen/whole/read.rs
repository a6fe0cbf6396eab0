//! From a file to a specimen of the whole.

use super::super::asked;
use super::super::subject::{Specimen, Subject};
use super::format::SceneBenchmarkDocument;
use super::scene::Whole;
use super::schema::schema_json;
use super::watch;
use cullet_document::check;
use cullet_document::document::SCENE;
use cullet_document::error::{SceneError, SceneErrorKind, SceneErrors};
use cullet_document::files::Files;
use cullet_document::overrides::{OverrideRules, apply_overrides};
use cullet_document::tree::{Node, Value};
use cullet_proto::JobId;
use cullet_scene::context::ResolveContext;
use cullet_scene::{Scene, is_preset, load};
use serde::Deserialize;
use std::path::Path;

/// What `scene.` stands for in overrides.
const PREFIX: &str = "scene.";

/// Reads what stands around a scene, and the scene.
pub(in crate::specimen) fn read(
    name: String,
    path: &Path,
    files: &mut Files,
    mut root: Node,
    arguments: &[String],
) -> Result<Specimen, SceneErrors> {
    let of_scene = |text: &String| text.trim_start().strip_prefix(PREFIX).map(str::to_owned);
    let inner: Vec<String> = arguments.iter().filter_map(of_scene).collect();
    let outer: Vec<String> =
        arguments.iter().filter(|text| of_scene(text).is_none()).cloned().collect();
    let mut errors = Vec::new();
    let scene = load(path, &inner).map_err(|found| {
        let unmade = found.errors.iter().all(|error| error.kind == SceneErrorKind::Geometry);
        let below = |error: SceneError| {
            let path = if error.path.is_empty() { SCENE } else { PREFIX }.to_owned() + &error.path;
            SceneError { path, ..error }
        };
        let found: Vec<SceneError> = found.errors.into_iter().map(below).collect();
        let told: Vec<String> =
            found.iter().map(|error| format!("{}: {}", error.path, error.message)).collect();
        if !unmade {
            errors.extend(found);
        }
        Flaw { text: told.join("; "), overrides: inner }
    });
    if let Value::Table(table) = &mut root.value {
        table.remove(SCENE);
    }
    let schema = schema_json();
    let sections = schema["properties"].as_object();
    let sections: Vec<&str> =
        sections.map(|all| all.keys().map(String::as_str).collect()).unwrap_or_default();
    errors.extend(apply_overrides(
        &mut root,
        OverrideRules { sections: &sections, is_preset },
        &outer,
    ));
    errors.extend(check::check(schema, &mut root).errors);
    if !errors.is_empty() {
        return Err(SceneErrors::sorted(errors));
    }
    let document = SceneBenchmarkDocument::deserialize(root.to_toml()).map_err(|error| {
        let error = SceneError::at(&root.origin, "", error.message().trim());
        SceneErrors { errors: vec![error] }
    })?;
    resolve(name, &root, files, &document, (path, scene))
}

/// A scene with a body that cannot be made: why, and the arguments that it had.
struct Flaw {
    text: String,
    overrides: Vec<String>,
}

fn resolve(
    name: String,
    root: &Node,
    files: &mut Files,
    document: &SceneBenchmarkDocument,
    (path, scene): (&Path, Result<Scene, Flaw>),
) -> Result<Specimen, SceneErrors> {
    let mut shop = ResolveContext::new(root, files);
    // Without its bodies nobody knows what their probes would be about.
    let watches = scene
        .as_ref()
        .map_or_else(|_| Vec::new(), |scene| watch::read(&mut shop, &document.probe, scene));
    let names: Vec<&str> = document.probe.iter().map(|probe| probe.name.as_str()).collect();
    let (metrics, expected) = asked::read(&mut shop, &document.metric, &document.expect, &names);
    if !shop.errors.is_empty() {
        return Err(SceneErrors::sorted(shop.errors));
    }
    let probes = document.probe.iter().map(|p| (p.name.clone(), watch::unit(p.kind)));
    let file = path.to_owned();
    let (whole, warnings, flaw) = match scene {
        Ok(scene) => {
            let (step, id) = (scene.world.step, id(&scene));
            (Whole { file, overrides: scene.overrides, watches, step, id }, scene.warnings, None)
        }
        Err(Flaw { text, overrides }) => {
            let id = JobId::of(format!("{name} {overrides:?} {text}").as_bytes());
            (Whole { file, overrides, watches, step: 0.0, id }, Vec::new(), Some(text))
        }
    };
    Ok(Specimen {
        name,
        description: document.description.clone(),
        solver: "world".to_owned(),
        subject: Subject::Whole(Box::new(whole)),
        probes: probes.collect(),
        speeds: Vec::new(),
        metrics,
        expected,
        ends: document.run.ends,
        flaw,
        warnings,
    })
}

fn id(scene: &Scene) -> JobId {
    let parts = scene.files.iter().flat_map(|file| [file.key.as_bytes(), &file.bytes[..]]);
    let parts = parts.chain(scene.overrides.iter().map(String::as_bytes));
    let with_length = |part: &[u8]| [&(part.len() as u64).to_le_bytes()[..], part].concat();
    JobId::of(&parts.flat_map(with_length).collect::<Vec<u8>>())
}
