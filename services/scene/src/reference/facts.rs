//! What the schema says of one key: its type and unit, its default, its bounds and its meaning.

use super::tables;
use cullet_document::check::tell;
use cullet_document::unit::Dimension;
use serde_json::Value as Json;

/// The name of the type that a property refers to: itself, as an option, or as an item of a list.
pub(super) fn target(property: &'static Json) -> Option<&'static str> {
    let node = present(property);
    let name = node["$ref"].as_str().and_then(|name| name.strip_prefix("#/$defs/"));
    name.or_else(|| node.get("items").and_then(target))
}

/// What is not `null` of an optional value.
fn present(node: &'static Json) -> &'static Json {
    let choices = node["anyOf"].as_array().into_iter().flatten();
    choices.into_iter().find(|choice| choice["type"] != "null").unwrap_or(node)
}

/// Whether a value may be an item or a list of some.
fn is_one_or_some(node: &Json) -> bool {
    let choices = || node["anyOf"].as_array().into_iter().flatten();
    choices().any(|choice| is(choice, "array"))
        && choices().any(|choice| choice.get("$ref").is_some())
}

/// Whether a type names that kind of value.
fn is(node: &Json, kind: &str) -> bool {
    let kinds = node["type"].as_array().into_iter().flatten();
    node["type"] == kind || kinds.into_iter().any(|named| named == kind)
}

/// The words of a choice of words, each with its meaning.
pub(super) fn choices(node: &'static Json) -> Vec<(&'static str, &'static str)> {
    let choices = node["oneOf"].as_array().into_iter().flatten();
    choices
        .filter_map(|choice| Some((choice["const"].as_str()?, choice["description"].as_str()?)))
        .collect()
}

/// A unit as people write it.
pub(super) fn pretty(dimension: Dimension) -> String {
    match dimension.si() {
        "" => "1".to_owned(),
        unit => unit.replace('2', "²").replace('3', "³").replace(' ', "·"),
    }
}

/// The unit in brackets in a description, with its brackets.
pub(super) fn bracket(description: &str) -> Option<String> {
    let units = Dimension::ALL.into_iter().map(pretty).chain(["°".to_owned()]);
    units.map(|unit| format!("[{unit}]")).find(|unit| description.contains(&format!(" {unit}")))
}

/// A description without its unit, in one line.
pub(super) fn plain(description: &str) -> String {
    let joined = description.split_whitespace().collect::<Vec<_>>().join(" ");
    match bracket(&joined) {
        Some(unit) => joined.replacen(&format!(" {unit}"), "", 1),
        None => joined,
    }
}

/// Where a heading of the page is linked to.
pub(super) fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    heading.to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-")
}

/// A property of a table, with the schema that it stands in.
#[derive(Clone, Copy)]
pub(super) struct Key {
    pub(super) schema: &'static Json,
    pub(super) property: &'static Json,
    pub(super) required: bool,
}

impl Key {
    /// Type and unit, default and bounds, in a line.
    pub(super) fn facts(&self) -> String {
        let default = self.default_value();
        let bounds = bounds(present(self.property));
        let facts = [Some(self.kind()), default, bounds];
        facts.into_iter().flatten().collect::<Vec<_>>().join("; ")
    }

    /// What the key means.
    pub(super) fn meaning(&self) -> String {
        plain(self.property["description"].as_str().unwrap_or_default())
    }

    /// The words that it takes, if it takes words.
    pub(super) fn choices(&self) -> Vec<(&'static str, &'static str)> {
        let named = target(self.property).map(|name| &self.schema["$defs"][name]);
        named.map(choices).unwrap_or_default()
    }

    fn kind(&self) -> String {
        let unit = bracket(self.property["description"].as_str().unwrap_or_default());
        // The keys of a table have their own units.
        let unit = unit.filter(|_| target(self.property).is_none());
        let kind = self.kind_of(present(self.property));
        let kind = match kind.strip_prefix("list of tables,") {
            Some(link) if is_one_or_some(self.property) => {
                format!("table or list of tables,{link}")
            }
            _ => kind,
        };
        unit.map(|unit| format!("{kind} {unit}")).unwrap_or(kind)
    }

    fn kind_of(&self, node: &'static Json) -> String {
        if let Some(name) = node["$ref"].as_str().and_then(|name| name.strip_prefix("#/$defs/")) {
            return match tables::table(name) {
                Some(table) => {
                    format!("table, see [{}](#{})", table.heading, anchor(table.heading))
                }
                None => "one of the words below".to_owned(),
            };
        }
        if let Some(dimension) = node["x-unit"].as_str() {
            return format!("[{dimension}](#units)");
        }
        if is(node, "array") {
            let count = match (node["minItems"].as_u64(), node["maxItems"].as_u64()) {
                (Some(least), Some(most)) if least == most => format!(" of {least}"),
                (Some(least), Some(most)) => format!(" of {least} to {most}"),
                (None, Some(most)) => format!(" of at most {most}"),
                _ => String::new(),
            };
            let items = self.kind_of(&node["items"]);
            return match items.strip_prefix("table,") {
                Some(link) => format!("list of tables,{link}"),
                None if count.is_empty() => format!("list of {items}"),
                None => format!("list{count}: {items}"),
            };
        }
        let kinds = [("boolean", "`true` or `false`"), ("integer", "integer")];
        let kinds = kinds.into_iter().chain([("number", "number"), ("string", "text")]);
        match kinds.into_iter().find(|(kind, _)| is(node, kind)) {
            Some((_, word)) => word.to_owned(),
            None => format!("table: name = {}", self.kind_of(&node["additionalProperties"])),
        }
    }

    /// What holds without the key; nothing of a table, whose keys have their own defaults.
    pub(super) fn default_value(&self) -> Option<String> {
        if self.required {
            return Some("required".to_owned());
        }
        if let Some(words) = self.property["x-default"].as_str() {
            let required = words.starts_with("required");
            return Some(if required { words.to_owned() } else { format!("default: {words}") });
        }
        let dimension = self.property["x-unit"].as_str().and_then(Dimension::by_name);
        match self.property.get("default") {
            Some(default) => Some(format!("default: `{}`", toml(default, dimension))),
            None => is(self.property, "array").then(|| "default: none".to_owned()),
        }
    }
}

/// A default as a scene file would write it.
fn toml(value: &Json, dimension: Option<Dimension>) -> String {
    match value {
        Json::Array(items) => {
            let items: Vec<String> = items.iter().map(|item| toml(item, None)).collect();
            format!("[{}]", items.join(", "))
        }
        Json::Object(_) => "{}".to_owned(),
        Json::Number(number) => number.as_f64().map_or_else(String::new, |value| {
            let over = (1.0 / value).round();
            let long = tell(value).len() > 9 && (value * over - 1.0).abs() < 1e-12;
            match dimension.filter(|_| long) {
                Some(dimension) => format!("\"1/{over} {}\"", dimension.si()),
                None => tell(value),
            }
        }),
        other => other.to_string(),
    }
}

/// The range of a number, or of each number of a list.
fn bounds(node: &Json) -> Option<String> {
    if let Some(items) = node.get("items").or(node.get("additionalProperties")) {
        // That an integer is not negative goes without saying, or the description says more.
        let natural = items["type"] == "integer" && items.get("maximum").is_none();
        return bounds(items).filter(|_| !natural).map(|range| format!("each {range}"));
    }
    let bound = |name: &str| {
        node.get(name).and_then(|bound| match bound.as_u64() {
            Some(whole) => Some(whole.to_string()),
            None => bound.as_f64().map(tell),
        })
    };
    match (bound("minimum"), bound("exclusiveMinimum"), bound("maximum")) {
        (Some(least), _, Some(most)) => Some(format!("from {least} to {most}")),
        (Some(least), _, None) => Some(format!("at least {least}")),
        (None, Some(low), Some(most)) => Some(format!("above {low}, at most {most}")),
        (None, Some(low), None) => Some(format!("above {low}")),
        (None, None, Some(most)) => Some(format!("at most {most}")),
        (None, None, None) => None,
    }
}
