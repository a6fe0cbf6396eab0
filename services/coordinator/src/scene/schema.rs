//! The JSON schema of scene files, from the same types that read them.

use super::format::Document;
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

/// A schema as a file has it.
pub(crate) fn printed(schema: &Json) -> String {
    let mut text = serde_json::to_string_pretty(schema).unwrap_or_default();
    text.push('\n');
    text
}

/// Brackets in descriptions stand escaped for rustdoc; people read them plain. TOML knows no null.
pub(super) fn plain_brackets(node: &mut Json) {
    match node {
        Json::Object(table) => {
            table.retain(|key, value| key != "default" || !value.is_null());
            for (key, value) in table.iter_mut() {
                match value {
                    Json::String(text) if key == "description" => {
                        *text = text.replace("\\[", "[").replace("\\]", "]");
                    }
                    other => plain_brackets(other),
                }
            }
        }
        Json::Array(items) => items.iter_mut().for_each(plain_brackets),
        _ => {}
    }
}
