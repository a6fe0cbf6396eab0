//! From a file to a specimen, or every error at once.

use super::resolve;
use super::schema::schema_json;
use super::subject::Specimen;
use super::whole;
use cullet_document::error::{SceneError, SceneErrors};
use cullet_document::files::{Files, SCENE_BASE, Source};
use cullet_document::overrides::{OverrideRules, apply_overrides};
use cullet_document::tree::Node;
use cullet_document::{check, document};
use cullet_scene::is_preset;
use serde_json::Value as Json;
use std::path::Path;

/// The sections whose keys may be given without it.
const SHORT: [&str; 2] = ["solver", "run"];

/// Loads a specimen. `overrides` are `path=value` arguments, applied in order; a path of one name
/// is one of `[solver]` or `[run]`.
///
/// # Errors
/// Everything that is wrong with it, in the order of the text.
pub fn load(path: &Path, overrides: &[String]) -> Result<Specimen, SceneErrors> {
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    let Some(base) = path.file_name().map(|name| name.to_string_lossy().into_owned()) else {
        let message = format!("{} is no file", path.display());
        return Err(SceneErrors { errors: vec![SceneError::without_place(message)] });
    };
    let name = path.file_stem().map_or_else(|| base.clone(), |s| s.to_string_lossy().into_owned());
    let mut files = Files::new(Source::Disk { folder });
    let (root, _) = document::read(&mut files, &format!("{SCENE_BASE}{base}"))?;
    if root.get(document::SCENE).is_some() {
        return whole::read(name, path, &mut files, root, overrides);
    }
    build(name, &mut files, root, overrides)
}

fn build(
    name: String,
    files: &mut Files,
    mut root: Node,
    overrides: &[String],
) -> Result<Specimen, SceneErrors> {
    let schema = schema_json();
    let keys = |node: &Json| -> Vec<String> {
        let keys = check::resolve(schema, node)["properties"].as_object();
        keys.map(|keys| keys.keys().cloned().collect()).unwrap_or_default()
    };
    // What `spelled_out` leaves alone is no key of these: they are there to be suggested.
    let short = SHORT.iter().flat_map(|name| keys(&schema["properties"][*name]));
    let sections: Vec<String> = keys(schema).into_iter().chain(short).collect();
    let sections: Vec<&str> = sections.iter().map(String::as_str).collect();
    let full: Vec<String> = overrides.iter().map(|text| spelled_out(schema, text)).collect();
    let rules = OverrideRules { sections: &sections, is_preset };
    let mut errors = apply_overrides(&mut root, rules, &full);
    let findings = check::check(schema, &mut root);
    errors.extend(findings.errors.iter().cloned());
    if !errors.is_empty() {
        return Err(SceneErrors::sorted(errors));
    }
    let resolved = resolve::resolve(&root, files);
    match resolved {
        Ok(specimen) => Ok(Specimen { name, ..specimen }),
        Err(errors) => Err(SceneErrors::sorted(errors)),
    }
}

/// `spacing=…` for `solver.spacing=…`.
fn spelled_out(schema: &Json, argument: &str) -> String {
    let name = argument.split('=').next().unwrap_or_default().trim();
    let has = |section: &str| {
        let section = check::resolve(schema, &schema["properties"][section]);
        section["properties"].get(name).is_some()
    };
    match SHORT.into_iter().find(|section| has(section)) {
        Some(section) => format!("{section}.{argument}"),
        None => argument.to_owned(),
    }
}
