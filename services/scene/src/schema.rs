//! The JSON schema of scene files, from the same types that read them.

use super::format::Document;
pub use cullet_document::schema::{plain_brackets, printed};
use serde_json::Value as Json;
use std::sync::OnceLock;

/// The schema as one value.
pub(super) fn schema_json() -> &'static Json {
    static SCHEMA: OnceLock<Json> = OnceLock::new();
    SCHEMA.get_or_init(|| {
        let mut schema = schemars::schema_for!(Document).to_value();
        schema["title"] = Json::String("A Cullet scene".to_owned());
        plain_brackets(&mut schema);
        schema
    })
}

/// The schema that editors take: `cullet schema` prints it, `scenes/scene.schema.json` is it.
#[must_use]
pub fn schema() -> String {
    printed(schema_json())
}
