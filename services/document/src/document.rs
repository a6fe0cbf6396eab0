//! From bytes to one tree: the main file, what it includes, and the overrides.

use super::error::{SceneError, SceneErrors};
use super::files::{Files, folder_of, key};
use super::overrides::NAMED_LISTS;
use super::tree::{self, Node, Value};
use crate::origin::Text;
use std::sync::Arc;

/// Deepest chain of includes: a longer one is a mistake, and each level costs stack.
pub const MAX_INCLUDE_DEPTH: usize = 8;

/// Longest scene file \[bytes\]: generators say in ten lines what a million lines would.
pub const MAX_SCENE_BYTES: usize = 8 << 20;

/// How files begin that people give in place of a text, and what they are.
const BINARY: [(&[u8], &str); 10] = [
    (b"\x89PNG", "a picture (PNG)"),
    (b"\xff\xd8\xff", "a picture (JPEG)"),
    (b"GIF8", "a picture (GIF)"),
    (b"%PDF", "a PDF"),
    (b"PK\x03\x04", "an archive (ZIP)"),
    (b"\x1f\x8b", "an archive (gzip)"),
    (b"\x89MCAP", "a recording (MCAP)"),
    (b"glTF", "a mesh (GLB)"),
    (b"BLENDER", "a file of Blender"),
    (b"\x7fELF", "a program"),
];

/// Reads the file under `main` and what it includes.
///
/// # Errors
/// What cannot be read, alone: what else seems wrong may follow from it.
pub fn read(files: &mut Files, main: &str) -> Result<(Node, Arc<Text>), SceneErrors> {
    let text = text_of(files, main)
        .map_err(|why| SceneErrors { errors: vec![SceneError::without_place(why)] })?;
    let mut errors = Vec::new();
    let node = expand(files, &text, &mut vec![main.to_owned()], &mut errors);
    if errors.is_empty() { Ok((node, text)) } else { Err(SceneErrors::sorted(errors)) }
}

fn text_of(files: &mut Files, key: &str) -> Result<Arc<Text>, String> {
    let bytes = files.get(key).map_err(|error| error.to_string())?;
    let label = files.label(key);
    if bytes.len() > MAX_SCENE_BYTES {
        return Err(format!("{label} is larger than {MAX_SCENE_BYTES} bytes"));
    }
    if let Some((_, kind)) = BINARY.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Err(format!("{label} is {kind}, and no text in TOML"));
    }
    match std::str::from_utf8(&bytes) {
        Ok(content) => {
            let content = content.strip_prefix('\u{feff}').unwrap_or(content).to_owned();
            Ok(Arc::new(Text { label, base: folder_of(key), content }))
        }
        Err(error) => Err(format!(
            "{label} is no text in TOML: it is not UTF-8, byte {} is wrong",
            error.valid_up_to()
        )),
    }
}

fn expand(
    files: &mut Files,
    text: &Arc<Text>,
    chain: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Node {
    let (node, faults) = tree::parse(text);
    match faults.first().and_then(|fault| fault.place.as_ref()) {
        // A script, a log: that its lines are no TOML says nothing of any of them.
        Some(place) if !text.label.to_lowercase().ends_with(".toml") => {
            let (label, line, shown) = (&text.label, place.line, place.shown());
            let message = format!("{label} is no text in TOML: line {line} is `{shown}`");
            errors.push(SceneError::without_place(message));
        }
        _ => errors.extend(faults),
    }
    included(files, node, chain, errors)
}

/// The key under which a specimen of the whole has its scene.
pub const SCENE: &str = "scene";

/// The scene of a specimen of the whole, laid on what it includes; any other document as it is.
///
/// # Errors
/// As [`read`].
pub fn scene_of(files: &mut Files, mut root: Node, main: &str) -> Result<Node, SceneErrors> {
    let below = match &mut root.value {
        Value::Table(table) => table.remove(SCENE),
        _ => None,
    };
    let Some(entry) = below else { return Ok(root) };
    let mut errors = Vec::new();
    let scene = included(files, entry.node, &mut vec![main.to_owned()], &mut errors);
    if errors.is_empty() { Ok(scene) } else { Err(SceneErrors::sorted(errors)) }
}

/// A document laid on the files that it includes.
fn included(
    files: &mut Files,
    node: Node,
    chain: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Node {
    let mut whole: Option<Node> = None;
    for item in node.items("include") {
        let Some(path) = item.text() else { continue };
        let included = key(&item.origin.text.base, path);
        if chain.contains(&included) || chain.len() > MAX_INCLUDE_DEPTH {
            let message = if chain.contains(&included) {
                format!("{path} includes itself")
            } else {
                format!("includes go deeper than {MAX_INCLUDE_DEPTH} files")
            };
            errors.push(SceneError::at(&item.origin, "include", message));
            continue;
        }
        match text_of(files, &included) {
            Ok(inner) => {
                chain.push(included);
                let below = expand(files, &inner, chain, errors);
                chain.pop();
                whole = Some(match whole {
                    Some(whole) => merge(whole, below, true),
                    None => below,
                });
            }
            Err(why) => errors.push(SceneError::at(&item.origin, "include", why)),
        }
    }
    match whole {
        Some(whole) => merge(whole, node, true),
        None => node,
    }
}

/// `over` laid on `under`: named lists follow one another, tables mix, other values are replaced.
fn merge(under: Node, over: Node, top: bool) -> Node {
    let origin = over.origin;
    let (mut table, over_table) = match (under.value, over.value) {
        (Value::Table(under), Value::Table(over)) => (under, over),
        (_, value) => return Node { origin, value },
    };
    for (name, entry) in over_table {
        let merged = match table.remove(&name) {
            None => entry,
            Some(before) => {
                let mut entry = entry;
                entry.node = if top && NAMED_LISTS.contains(&name.as_str()) {
                    follow(before.node, entry.node)
                } else {
                    merge(before.node, entry.node, false)
                };
                entry
            }
        };
        table.insert(name, merged);
    }
    Node { origin, value: Value::Table(table) }
}

fn follow(before: Node, after: Node) -> Node {
    match (before.value, after.value) {
        (Value::Array(mut first), Value::Array(second)) => {
            first.extend(second);
            Node { origin: after.origin, value: Value::Array(first) }
        }
        (_, value) => Node { origin: after.origin, value },
    }
}
