//! The schema of the file.

use super::format;
use cullet_scene::schema::{plain_brackets, printed};
use serde_json::Value as Json;
use std::sync::OnceLock;

pub(super) fn schema_json() -> &'static Json {
    static SCHEMA: OnceLock<Json> = OnceLock::new();
    SCHEMA.get_or_init(|| {
        let mut schema = schemars::schema_for!(format::SpecimenDocument).to_value();
        schema["title"] = Json::String("A Cullet specimen".to_owned());
        plain_brackets(&mut schema);
        schema
    })
}

/// The schema that editors take: `cullet schema --specimen` prints it.
#[must_use]
pub fn schema() -> String {
    printed(schema_json())
}
