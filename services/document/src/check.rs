//! Holds a tree against the JSON schema: names, kinds, bounds and units, all errors at once.
//!
//! Only the words of JSON schema that our own types produce are understood.

use super::error::{SceneError, SceneErrorKind, suggest};
use super::tree::{Node, Path, TableEntry, Value, join, show};
use super::unit::{self, Dimension};
use serde_json::Value as Json;
use std::collections::{BTreeMap, BTreeSet};

/// What was found.
#[derive(Debug, Default)]
pub struct Findings {
    /// What is wrong.
    pub errors: Vec<SceneError>,
    /// The paths of what is wrong: what is there is read no further.
    pub bad: BTreeSet<Path>,
}

/// Checks `node` against `schema` and turns text with units into SI numbers in place.
#[must_use]
pub fn check(schema: &Json, node: &mut Node) -> Findings {
    let mut checker = SchemaChecker { root: schema, found: Findings::default() };
    checker.node(schema, node, &Path::new());
    checker.found
}

/// Follows references, and takes what is not `null` of an optional value.
pub fn resolve<'a>(root: &'a Json, schema: &'a Json) -> &'a Json {
    let mut schema = schema;
    loop {
        if let Some(name) = schema["$ref"].as_str().and_then(|name| name.strip_prefix("#/$defs/")) {
            schema = &root["$defs"][name];
        } else if let Some(choices) = schema["anyOf"].as_array() {
            match choices.iter().find(|choice| choice["type"] != "null") {
                Some(choice) => schema = choice,
                None => return schema,
            }
        } else {
            return schema;
        }
    }
}

/// Of a value that may be an item or a list of some, the choice that is like it.
fn one_or_some<'a>(schema: &'a Json, node: &Node) -> &'a Json {
    let choices = || schema["anyOf"].as_array().into_iter().flatten();
    let mut lists = choices().filter(|choice| choice["type"] == "array");
    let mut items =
        choices().filter(|choice| choice["type"] != "array" && choice["type"] != "null");
    match (lists.next(), items.next(), &node.value) {
        (Some(list), Some(_), Value::Array(_)) => list,
        (Some(_), Some(item), _) => item,
        _ => schema,
    }
}

/// Checks a document against its schema and collects the errors.
struct SchemaChecker<'a> {
    root: &'a Json,
    found: Findings,
}

impl SchemaChecker<'_> {
    fn wrong(&mut self, node: &Node, path: &Path, message: String) {
        self.note(SceneErrorKind::Wrong, node, path, message);
    }

    fn note(&mut self, kind: SceneErrorKind, node: &Node, path: &Path, message: String) {
        let error = SceneError::at(&node.origin, show(path), message);
        self.found.errors.push(error.of_kind(kind));
        self.found.bad.insert(path.clone());
    }

    fn node(&mut self, schema: &Json, node: &mut Node, path: &Path) {
        let schema = resolve(self.root, one_or_some(schema, node));
        if let Some(choices) = schema["oneOf"].as_array() {
            return self.one_of(choices, node, path);
        }
        if let Some(names) = schema["enum"].as_array() {
            let names: Vec<&str> = names.iter().filter_map(Json::as_str).collect();
            return self.word(&names, node, path);
        }
        if let Some(dimension) = schema["x-unit"].as_str().and_then(Dimension::by_name) {
            return self.quantity(schema, dimension, node, path);
        }
        let kinds = kinds(schema);
        let fits = |kind: &str| kinds.contains(&kind);
        match &node.value {
            Value::Table(_) if fits("object") => self.table(schema, node, path),
            Value::Array(_) if fits("array") => self.array(schema, node, path),
            Value::Integer(number) if fits("integer") => {
                let number = *number as f64;
                self.bounds(schema, number, "", node, path);
            }
            Value::Integer(number) if fits("number") => {
                let number = *number as f64;
                self.bounds(schema, number, "", node, path);
            }
            Value::Float(number) if fits("number") => {
                let number = *number;
                self.bounds(schema, number, "", node, path);
            }
            Value::String(_) if fits("string") => {}
            Value::Boolean(_) if fits("boolean") => {}
            other => {
                let message = format!("must be {}, not {}", expected(&kinds), described(other));
                self.wrong(node, path, message);
            }
        }
    }

    fn table(&mut self, schema: &Json, node: &mut Node, path: &Path) {
        let none = serde_json::Map::new();
        let properties = schema["properties"].as_object().unwrap_or(&none);
        let Value::Table(entries) = &mut node.value else {
            return;
        };
        let names: Vec<&str> = properties.keys().map(String::as_str).collect();
        for (key, entry) in entries.iter_mut() {
            let below = join(path, key.as_str());
            match properties.get(key) {
                Some(property) => self.node(property, &mut entry.node, &below),
                None if schema["additionalProperties"].is_object() => {
                    let property = schema["additionalProperties"].clone();
                    self.node(&property, &mut entry.node, &below);
                }
                None => self.unknown_key(key, entry, &names, &below),
            }
        }
        let missing: Vec<String> = schema["required"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Json::as_str)
            .filter(|key| !entries.contains_key(*key))
            .map(str::to_owned)
            .collect();
        for key in missing {
            self.note(SceneErrorKind::Missing, node, path, format!("`{key}` is missing"));
        }
    }

    fn unknown_key(&mut self, key: &str, entry: &TableEntry, names: &[&str], path: &Path) {
        let error = SceneError::at(&entry.key, show(path), format!("unknown key `{key}`"));
        self.found.errors.push(error.help(suggest(key, names)));
        self.found.bad.insert(path.clone());
    }

    fn array(&mut self, schema: &Json, node: &mut Node, path: &Path) {
        let Value::Array(items) = &mut node.value else {
            return;
        };
        let count = items.len() as u64;
        for (index, item) in items.iter_mut().enumerate() {
            self.node(&schema["items"], item, &join(path, index));
        }
        let least = schema["minItems"].as_u64().unwrap_or(0);
        let most = schema["maxItems"].as_u64().unwrap_or(u64::MAX);
        if count < least || count > most {
            let bound = match (least, most) {
                (least, most) if least == most => format!("{least}"),
                (least, u64::MAX) => format!("at least {least}"),
                (least, most) => format!("{least} to {most}"),
            };
            self.wrong(node, path, format!("must have {bound} items; it has {count}"));
        }
    }

    /// A choice of words, or of tables distinguished by their `kind`.
    fn one_of(&mut self, choices: &[Json], node: &mut Node, path: &Path) {
        let kind_of =
            |choice: &Json| choice["properties"]["kind"]["const"].as_str().map(str::to_owned);
        let kinds: Vec<String> = choices.iter().filter_map(kind_of).collect();
        if kinds.is_empty() {
            let names: Vec<&str> = choices
                .iter()
                .flat_map(|choice| {
                    let listed = choice["enum"].as_array().into_iter().flatten();
                    listed.chain(choice.get("const")).filter_map(Json::as_str)
                })
                .collect();
            return self.word(&names, node, path);
        }
        let names: Vec<&str> = kinds.iter().map(String::as_str).collect();
        if node.table().is_none() {
            let message = format!("must be a table, not {}", described(&node.value));
            return self.wrong(node, path, message);
        }
        let Some(kind) = node.get("kind") else {
            let message = format!("`kind` is missing; known: {}", names.join(", "));
            return self.note(SceneErrorKind::Missing, node, path, message);
        };
        let chosen = kind.text().and_then(|kind| kinds.iter().position(|known| known == kind));
        match chosen {
            Some(index) => self.table(&choices[index], node, path),
            None => {
                let mut kind = kind.clone();
                self.word(&names, &mut kind, &join(path, "kind"));
            }
        }
    }

    fn word(&mut self, names: &[&str], node: &mut Node, path: &Path) {
        let known = names.join(", ");
        match &node.value {
            Value::String(word) if names.contains(&word.as_str()) => {}
            Value::String(word) => {
                let message = format!("\"{word}\" is not one of {known}");
                let help = suggest(word, names).filter(|help| !help.starts_with("known: "));
                let error = SceneError::at(&node.origin, show(path), message).help(help);
                self.found.errors.push(error);
                self.found.bad.insert(path.clone());
            }
            other => {
                let message = format!("must be one of {known}, not {}", described(other));
                self.wrong(node, path, message);
            }
        }
    }

    fn quantity(&mut self, schema: &Json, dimension: Dimension, node: &mut Node, path: &Path) {
        let number = match &node.value {
            Value::Integer(number) => *number as f64,
            Value::Float(number) => *number,
            Value::String(text) => match unit::parse(text, dimension) {
                Ok(number) => number,
                Err(message) => return self.wrong(node, path, message),
            },
            other => {
                let unit = dimension.si();
                let plain = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
                let message = format!(
                    "must be a number{plain} or text with a unit of {}, not {}",
                    dimension.name(),
                    described(other)
                );
                return self.wrong(node, path, message);
            }
        };
        node.value = Value::Float(number);
        self.bounds(schema, number, dimension.si(), node, path);
    }

    fn bounds(&mut self, schema: &Json, number: f64, unit: &str, node: &Node, path: &Path) {
        let with_unit = |value: f64| {
            if unit.is_empty() { tell(value) } else { format!("{} {unit}", tell(value)) }
        };
        if !number.is_finite() {
            return self.wrong(node, path, format!("must be a finite number; it is {number}"));
        }
        let bound = |name: &str| schema[name].as_f64();
        let broken = [
            bound("minimum").filter(|least| number < *least).map(|b| ("at least", b)),
            bound("exclusiveMinimum").filter(|least| number <= *least).map(|b| ("above", b)),
            bound("maximum").filter(|most| number > *most).map(|b| ("at most", b)),
            bound("exclusiveMaximum").filter(|most| number >= *most).map(|b| ("below", b)),
        ];
        if let Some((word, bound)) = broken.into_iter().flatten().next() {
            let message =
                format!("must be {word} {}; it is {}", with_unit(bound), with_unit(number));
            self.wrong(node, path, message);
        }
    }
}

fn kinds(schema: &Json) -> Vec<&str> {
    match &schema["type"] {
        Json::String(kind) => vec![kind.as_str()],
        Json::Array(kinds) => kinds.iter().filter_map(Json::as_str).collect(),
        _ => Vec::new(),
    }
}

fn expected(kinds: &[&str]) -> String {
    let words: BTreeMap<&str, &str> = [
        ("array", "a list"),
        ("boolean", "true or false"),
        ("integer", "an integer"),
        ("number", "a number"),
        ("object", "a table"),
        ("string", "text"),
    ]
    .into();
    let named: Vec<&str> = kinds.iter().filter_map(|kind| words.get(kind).copied()).collect();
    named.join(" or ")
}

/// A value as a message shows it.
fn described(value: &Value) -> String {
    match value {
        Value::String(text) => format!("\"{}\"", text.chars().take(40).collect::<String>()),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => tell(*number),
        Value::Boolean(flag) => flag.to_string(),
        Value::Date(_) | Value::Array(_) | Value::Table(_) => value.kind().to_owned(),
    }
}

/// A number in the shortest form that people read easily.
#[must_use]
pub fn tell(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        format!("{value:e}")
    } else {
        format!("{value}")
    }
}
