//! From bytes to one tree: the main file, what it includes, and the overrides.

use super::error::{SceneError, SceneErrors};
use super::files::{Files, folder_of, key};
use super::overrides::NAMED_LISTS;
use super::tree::{self, Node, Value};
use crate::origin::Text;
use std::sync::Arc;

/// Deepest chain of includes: a longer one is a mistake, and each level costs stack.
pub const MAX_INCLUDE_DEPTH: usize = 8;

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
    let bytes = files.text(key).map_err(|error| error.to_string())?;
    let label = files.label(key);
    if let Some((_, kind)) = BINARY.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Err(format!("{label} is {kind}, and no text in TOML"));
    }
    match std::str::from_utf8(&bytes) {
        Ok(content) => {
            let content = content.strip_prefix('\u{feff}').unwrap_or(content).to_owned();
            Ok(Arc::new(Text::new(label, folder_of(key), content)))
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
    match faults.first().and_then(SceneError::place) {
        // A script, a log: that its lines are no TOML says nothing of any of them.
        Some(place) if !text.label.to_lowercase().ends_with(".toml") => {
            let (label, line, shown) = (&text.label, place.line, place.text);
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

#[cfg(test)]
mod tests {
    use super::super::files::{Files, MAX_SCENE_BYTES, MAX_TEXTS, SCENE_BASE, Source};
    use super::{MAX_INCLUDE_DEPTH, read};
    use std::collections::BTreeMap;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::time::{Duration, Instant};

    fn files<'a>(texts: impl IntoIterator<Item = (&'a str, String)>) -> Files {
        let all = texts.into_iter();
        let all = all.map(|(name, text)| (format!("{SCENE_BASE}{name}"), Arc::new(text.into())));
        Files::new(Source::Bundle(all.collect::<BTreeMap<_, _>>()))
    }

    fn including(name: &str, times: usize) -> String {
        format!("include = [{}]\n", vec![format!("\"{name}\""); times].join(", "))
    }

    fn said(mut files: Files) -> String {
        let begun = Instant::now();
        let said = read(&mut files, "scene/0.toml").expect_err("it is over a bound").to_string();
        assert!(begun.elapsed() < Duration::from_secs(5), "{:?}: {said}", begun.elapsed());
        said
    }

    /// Each of eight files includes the next one 64 times: 64^8 texts, if all were read.
    #[test]
    fn includes_that_fan_out_have_one_bound_in_all() {
        let names: Vec<String> = (0..=MAX_INCLUDE_DEPTH).map(|n| format!("{n}.toml")).collect();
        let next = |n: usize| names.get(n + 1).map_or_else(String::new, |next| including(next, 64));
        let said = said(files((0..names.len()).map(|n| (names[n].as_str(), next(n)))));
        assert!(said.contains("more than 256 files with all that it includes"), "{said}");
    }

    #[test]
    fn texts_are_bounded_together() {
        let long = "#".repeat(MAX_SCENE_BYTES - 1) + "\n";
        let main = "include = [\"a.toml\", \"a.toml\", \"b.toml\"]\n";
        let said = said(files([
            ("0.toml", main.to_owned()),
            ("a.toml", long),
            ("b.toml", "\n".to_owned()),
        ]));
        assert!(said.contains("with a.toml the document would have more than 16777216 bytes"));
        let said = self::said(files([("0.toml", "#".repeat(MAX_SCENE_BYTES + 1))]));
        assert_eq!(said, "0.toml is larger than 8388608 bytes");
    }

    #[test]
    fn a_file_may_be_included_more_than_once() {
        let part = "[[body]]\n".to_owned();
        let mut files = files([("0.toml", including("a.toml", MAX_TEXTS - 1)), ("a.toml", part)]);
        let (root, _) = read(&mut files, "scene/0.toml").expect("all that may be");
        assert_eq!(root.items("body").len(), MAX_TEXTS - 1);
    }

    #[test]
    fn nothing_is_read_for_who_wants_it_no_more() {
        let stop = Arc::new(AtomicBool::new(true));
        let said = said(files([("0.toml", String::new())]).until(stop));
        assert_eq!(said, "loading was stopped");
    }
}
