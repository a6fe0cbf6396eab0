//! `--set path=value`: any value of a scene by its path; bodies and materials by name.

use super::error::{SceneError, suggest};
use super::files::GIVEN_BASE;
use super::tree::{self, Node, TableEntry, Value};
use crate::origin::{SourceSpan, Text};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// The lists whose items are called by name.
pub const NAMED_LISTS: [&str; 7] =
    ["material", "body", "grid", "stack", "scatter", "instances", HITS];

/// The list whose items are called by the body that they are about, and made where there is none.
const HITS: &str = "hit";

/// The key by which an item of a named list is called.
fn calling_key(list: &str) -> &'static str {
    if list == HITS { "body" } else { "name" }
}

/// Keys that cannot stand beside the key that an override sets: the older ones go.
const RIVALS: [(&str, &[&str]); 10] = [
    ("shape", &["mesh", "fit", "scale", "repair", "up"]),
    ("mesh", &["shape"]),
    ("keyframes", &["animation"]),
    ("animation", &["keyframes", "interpolation"]),
    ("fit", &["scale"]),
    ("scale", &["fit"]),
    ("spacing", &["particles"]),
    ("particles", &["spacing"]),
    ("quaternion", &["axis", "degrees", "euler_degrees"]),
    ("euler_degrees", &["axis", "degrees", "quaternion"]),
];

/// Most steps of a path: deeper than any scene value.
const MAX_STEPS: usize = 16;

/// A part of an override's path.
struct PathPart {
    name: String,
    range: Range<usize>,
}

/// What the format of a document says that overrides must know.
#[derive(Clone, Copy, Debug)]
pub struct OverrideRules<'a> {
    /// The keys of its top level.
    pub sections: &'a [&'a str],
    /// Whether a material of that name exists without being written.
    pub is_preset: fn(&str) -> bool,
}

/// Puts each `path=value` into the tree, in order; what cannot be put is an error, the rest is
/// done.
pub fn apply_overrides(
    root: &mut Node,
    known: OverrideRules<'_>,
    arguments: &[String],
) -> Vec<SceneError> {
    arguments
        .iter()
        .filter_map(|argument| apply(root, known, argument).err().map(|error| *error))
        .collect()
}

fn apply(root: &mut Node, known: OverrideRules<'_>, argument: &str) -> Result<(), Box<SceneError>> {
    let (label, base) = ("--set".to_owned(), GIVEN_BASE.to_owned());
    let text = Arc::new(Text::new(label, base, argument.to_owned()));
    let whole = SourceSpan { text: Arc::clone(&text), range: 0..argument.len() };
    let Some(equals) = find_equals(argument) else {
        return Err(SceneError::at(&whole, "", "an override is written path=value").into());
    };
    let parts =
        split(&argument[..equals]).map_err(|why| Box::new(SceneError::at(&whole, "", why)))?;
    let value = parse_value(&text, equals + 1);
    let first = &parts[0];
    if !known.sections.contains(&first.name.as_str()) {
        let origin = SourceSpan { text: Arc::clone(&text), range: first.range.clone() };
        let error = SceneError::at(&origin, "", format!("there is no `{}`", first.name));
        return Err(Box::new(error.help(suggest(&first.name, known.sections))));
    }
    let mut rest = &parts[..];
    let is_table = root.get(&first.name).is_some_and(|node| node.table().is_some());
    let mut node = root;
    if NAMED_LISTS.contains(&first.name.as_str()) && !is_table {
        node = find_named(node, &text, &parts, known.is_preset)?;
        rest = &parts[2..];
        if rest.is_empty() {
            return Err(SceneError::at(
                &whole,
                "",
                "the path must name a value of it, as in a.b.c=1",
            )
            .into());
        }
    }
    put(node, &text, rest, value)
}

/// The first `=` outside quotes.
fn find_equals(argument: &str) -> Option<usize> {
    let mut quoted = false;
    for (at, c) in argument.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '=' if !quoted => return Some(at),
            _ => {}
        }
    }
    None
}

/// Splits `body."my name".velocity[0]` into its names.
fn split(path: &str) -> Result<Vec<PathPart>, String> {
    let mut parts = Vec::new();
    let mut name = String::new();
    let (mut start, mut quoted) = (0, false);
    let mut flush = |name: &mut String, range: Range<usize>| {
        let name = std::mem::take(name).trim().to_owned();
        if !name.is_empty() {
            parts.push(PathPart { name, range });
        }
    };
    for (at, c) in path.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '.' | '[' | ']' if !quoted => {
                flush(&mut name, start..at);
                start = at + 1;
            }
            other => name.push(other),
        }
    }
    flush(&mut name, start..path.len());
    if parts.is_empty() || parts.len() > MAX_STEPS {
        return Err(format!("a path has 1 to {MAX_STEPS} names"));
    }
    Ok(parts)
}

/// A TOML value, or else the text as it stands. Spaces before it keep its place in the argument.
fn parse_value(text: &Arc<Text>, from: usize) -> Node {
    let written = text.content[from..].trim();
    let start = from + (text.content[from..].len() - text.content[from..].trim_start().len());
    let origin = SourceSpan { text: Arc::clone(text), range: start..start + written.len() };
    let padded = format!("v={}{written}", " ".repeat(start.saturating_sub(2)));
    let shadow = Arc::new(Text::new(text.label.clone(), text.base.clone(), padded));
    let (parsed, errors) = tree::parse(&shadow);
    let one = parsed.table().is_some_and(|table| table.len() == 1) && start >= 2;
    match parsed.get("v") {
        Some(node) if errors.is_empty() && one => relocate(node, text),
        _ => Node { origin, value: Value::String(written.to_owned()) },
    }
}

/// The same node, said to stand in `text`.
fn relocate(node: &Node, text: &Arc<Text>) -> Node {
    let place =
        |origin: &SourceSpan| SourceSpan { text: Arc::clone(text), range: origin.range.clone() };
    let value = match &node.value {
        Value::Array(items) => {
            Value::Array(items.iter().map(|item| relocate(item, text)).collect())
        }
        Value::Table(table) => Value::Table(
            table
                .iter()
                .map(|(key, entry)| {
                    let node = relocate(&entry.node, text);
                    (key.clone(), TableEntry { key: place(&entry.key), node })
                })
                .collect(),
        ),
        other => other.clone(),
    };
    Node { origin: place(&node.origin), value }
}

/// The item of a named list that the second part of the path names or counts.
fn find_named<'a>(
    root: &'a mut Node,
    text: &Arc<Text>,
    parts: &[PathPart],
    is_preset: fn(&str) -> bool,
) -> Result<&'a mut Node, Box<SceneError>> {
    let list = &parts[0].name;
    let origin = |part: &PathPart| SourceSpan { text: Arc::clone(text), range: part.range.clone() };
    let Some(wanted) = parts.get(1) else {
        let message = format!("`{list}` is a list: name one of its items, as in {list}.NAME.KEY=…");
        return Err(SceneError::at(&origin(&parts[0]), "", message).into());
    };
    let names: Vec<String> = root
        .items(list)
        .iter()
        .map(|item| item.get(calling_key(list)).and_then(Node::text).unwrap_or("").to_owned())
        .collect();
    let by_name = names.iter().position(|name| *name == wanted.name);
    let by_count = wanted.name.parse::<usize>().ok().filter(|index| *index < names.len());
    let index = match by_name.or(by_count) {
        Some(index) => index,
        None if list == "material" && is_preset(&wanted.name) => {
            append(root, text, list, wanted, &["name", "preset"])
        }
        None if list == HITS => append(root, text, list, wanted, &[calling_key(list)]),
        None => {
            let known: Vec<&str> = names.iter().map(String::as_str).collect();
            let message = format!("the scene has no {list} \"{}\"", wanted.name);
            let error = SceneError::at(&origin(wanted), "", message);
            return Err(Box::new(error.help(suggest(&wanted.name, &known))));
        }
    };
    let missing =
        Box::new(SceneError::at(&origin(&parts[0]), "", format!("`{list}` is not a list")));
    let Value::Table(table) = &mut root.value else {
        return Err(missing);
    };
    match table.get_mut(list).map(|entry| &mut entry.node.value) {
        Some(Value::Array(items)) => items.get_mut(index).ok_or(missing),
        _ => Err(missing),
    }
}

/// Adds an item to a list, with the name that is wanted under each of these keys; returns its
/// index.
fn append(
    root: &mut Node,
    text: &Arc<Text>,
    list: &str,
    wanted: &PathPart,
    keys: &[&str],
) -> usize {
    let origin = SourceSpan { text: Arc::clone(text), range: wanted.range.clone() };
    let word = || TableEntry {
        key: origin.clone(),
        node: Node { origin: origin.clone(), value: Value::String(wanted.name.clone()) },
    };
    let item: BTreeMap<String, TableEntry> =
        keys.iter().map(|key| ((*key).to_owned(), word())).collect();
    let item = Node { origin: origin.clone(), value: Value::Table(item) };
    let Value::Table(table) = &mut root.value else {
        return 0;
    };
    let entry = table.entry(list.to_owned()).or_insert_with(|| TableEntry {
        key: origin.clone(),
        node: Node { origin, value: Value::Array(Vec::new()) },
    });
    match &mut entry.node.value {
        Value::Array(items) => {
            items.push(item);
            items.len() - 1
        }
        _ => 0,
    }
}

/// Puts `value` at the path below `node`, making tables on the way.
fn put(
    node: &mut Node,
    text: &Arc<Text>,
    parts: &[PathPart],
    value: Node,
) -> Result<(), Box<SceneError>> {
    let Some((part, rest)) = parts.split_first() else {
        *node = value;
        return Ok(());
    };
    let origin = SourceSpan { text: Arc::clone(text), range: part.range.clone() };
    match &mut node.value {
        Value::Table(table) => {
            for (key, rivals) in RIVALS {
                if key == part.name {
                    table.retain(|name, _| !rivals.contains(&name.as_str()));
                }
            }
            let empty = Node { origin: origin.clone(), value: Value::Table(BTreeMap::new()) };
            let entry = table
                .entry(part.name.clone())
                .or_insert_with(|| TableEntry { key: origin.clone(), node: empty });
            entry.key = origin;
            put(&mut entry.node, text, rest, value)
        }
        Value::Array(items) => {
            let count = items.len();
            let name = |item: &Node| item.get("name").and_then(Node::text).map(str::to_owned);
            let named = items.iter().position(|item| name(item).as_ref() == Some(&part.name));
            let index = named.or(part.name.parse::<usize>().ok());
            match index.and_then(|index| items.get_mut(index)) {
                Some(item) => put(item, text, rest, value),
                None => {
                    let message = format!(
                        "\"{}\" is no name in this list and no index of its {count} (0 is the \
                         first)",
                        part.name
                    );
                    Err(SceneError::at(&origin, "", message).into())
                }
            }
        }
        other => {
            let message = format!("there is nothing below {}: `{}`", other.kind(), part.name);
            Err(SceneError::at(&origin, "", message).into())
        }
    }
}
