//! Any other file that is written like a scene: checked against the schema of its type, with all
//! errors at once.

use super::error::{SceneError, SceneErrors};
use super::files::{Files, SCENE_BASE, Source};
use super::tree::{Node, Step};
use super::{check, document};
use crate::schema::plain_brackets;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value as Json;
use std::path::Path;

/// A file that was read, to say later where in it something is wrong.
#[derive(Debug)]
pub struct ConfigDocument {
    root: Node,
}

/// The schema of a type of file, under a title.
pub fn schema_of<T: JsonSchema>(title: &str) -> Json {
    let mut schema = schemars::schema_for!(T).to_value();
    schema["title"] = Json::String(title.to_owned());
    plain_brackets(&mut schema);
    schema
}

impl ConfigDocument {
    /// Reads a file that has that schema.
    ///
    /// # Errors
    /// Everything that is wrong with it, in the order of the text.
    pub fn read<T: DeserializeOwned>(path: &Path, schema: &Json) -> Result<(T, Self), SceneErrors> {
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        let base = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let mut files = Files::new(Source::Disk { folder });
        let main = format!("{SCENE_BASE}{}", base.unwrap_or_default());
        let (mut root, _) = document::read(&mut files, &main)?;
        let errors = check::check(schema, &mut root).errors;
        if !errors.is_empty() {
            return Err(SceneErrors::sorted(errors));
        }
        match T::deserialize(root.to_toml()) {
            Ok(value) => Ok((value, Self { root })),
            Err(error) => {
                let error = SceneError::at(&root.origin, "", error.message().trim());
                Err(SceneErrors { errors: vec![error] })
            }
        }
    }

    /// What is wrong at a path such as `chart[0].option[1].set`.
    pub fn wrong(&self, path: &str, message: impl Into<String>) -> SceneError {
        let names = path.split(['.', '[']).map(|name| name.trim_end_matches(']'));
        let step = |name: &str| match name.parse::<usize>() {
            Ok(index) => Step::Index(index),
            Err(_) => Step::from(name),
        };
        let steps: Vec<Step> = names.map(step).collect();
        SceneError::at(self.root.nearest(&steps), path, message)
    }

    /// All of that, in the order of the text.
    pub fn all(errors: Vec<SceneError>) -> SceneErrors {
        SceneErrors::sorted(errors)
    }
}
