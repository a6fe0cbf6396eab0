//! JSON schemas as files have them.

use serde_json::Value as Json;

/// A schema as a file has it.
pub fn printed(schema: &Json) -> String {
    let mut text = serde_json::to_string_pretty(schema).unwrap_or_default();
    text.push('\n');
    text
}

/// Brackets in descriptions stand escaped for rustdoc; people read them plain. TOML knows no null.
pub fn plain_brackets(node: &mut Json) {
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
