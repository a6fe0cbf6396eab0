//! The page in the tree is the types; every key has a meaning, a unit and a default; every example
//! loads; what the loader checks beyond the schema stands in the descriptions.

use super::facts::{Key, anchor, bracket, plain, pretty, target};
use super::reference;
use super::tables::{TABLES, Table, table};
use crate::schema::schema_json;
use crate::tests::animation::animated_glb::{GlbChannel, animated_glb};
use crate::{body, direction, geometry, limits, load_bundle, material, places, resolve, strength};
use cullet_document::check::tell;
use cullet_document::document::MAX_INCLUDE_DEPTH;
use cullet_document::files::{Bundle, SceneFile};
use cullet_document::unit::Dimension;
use cullet_proto::strength::MAX_STROKES;
use serde_json::Value as Json;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

#[test]
fn the_page_in_the_tree_is_the_types() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene.md");
    if std::env::var_os("CULLET_BLESS").is_some() {
        std::fs::write(&path, reference()).expect("writes");
    }
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(written == reference(), "run `cullet schema --reference > docs/scene.md`");
}

#[test]
fn links_lead_to_headings_and_lines_fit() {
    let page = reference();
    let headings = page.lines().filter(|line| line.starts_with('#'));
    let anchors: BTreeSet<String> =
        headings.map(|line| anchor(line.trim_start_matches('#').trim())).collect();
    for link in page.split("](#").skip(1) {
        let link = link.split(')').next().unwrap_or_default();
        assert!(anchors.contains(link), "#{link} leads nowhere");
    }
    for line in page.lines() {
        assert!(line.chars().count() <= 120, "too wide: {line}");
        let cells = line.split('|').filter(|_| line.starts_with('|'));
        assert!(cells.into_iter().all(|cell| cell.split_whitespace().count() <= 40), "{line}");
    }
}

/// Tables of the schema, each kind of a table by itself: type, kind, schema.
fn written_tables() -> Vec<(&'static str, Option<&'static str>, &'static Json)> {
    let schema = schema_json();
    let mut found = vec![("Document", None, schema)];
    for (name, node) in schema["$defs"].as_object().expect("types") {
        if node["type"] == "object" {
            found.push((name, None, node));
        }
        for kind in node["oneOf"].as_array().into_iter().flatten() {
            let named = kind["properties"]["kind"]["const"].as_str();
            found.extend(named.map(|named| (name.as_str(), Some(named), kind)));
        }
    }
    found
}

fn properties(node: &'static Json) -> impl Iterator<Item = (&'static str, &'static Json)> {
    let all = node["properties"].as_object().into_iter().flatten();
    all.map(|(name, property)| (name.as_str(), property))
        .filter(|(name, property)| *name != "kind" || property["const"].is_null())
}

#[test]
fn every_table_has_a_section_with_all_its_keys_in_their_order() {
    let page = reference();
    for (name, kind, node) in written_tables() {
        let table = table(name).unwrap_or_else(|| panic!("{name} is not in TABLES"));
        assert_eq!(page.matches(&format!("# {}\n", table.heading)).count(), 1, "{name}");
        let keys: BTreeSet<&str> = (table.keys)(kind).into_iter().collect();
        let known: BTreeSet<&str> = properties(node).map(|(name, _)| name).collect();
        assert_eq!(keys, known, "{name} {kind:?}");
        let kind = kind.unwrap_or_default();
        assert_eq!(table.examples.iter().filter(|(of, _)| *of == kind).count(), 1, "{name} {kind}");
    }
}

/// The quantities, integers and plain numbers in a value, as far as they are written in place.
fn numbers(node: &'static Json, found: &mut Vec<&'static Json>) {
    let kind = node["type"].to_string();
    if kind.contains("number") || kind.contains("integer") {
        found.push(node);
    }
    for below in ["items", "additionalProperties"].into_iter().filter_map(|key| node.get(key)) {
        numbers(below, found);
    }
}

#[test]
fn every_key_has_a_meaning_a_unit_and_a_default() {
    let schema = schema_json();
    for (table, kind, node) in written_tables() {
        let required = node["required"].as_array().cloned().unwrap_or_default();
        for (name, property) in properties(node) {
            let place = format!("{table} {} {name}", kind.unwrap_or_default());
            let description = property["description"].as_str().unwrap_or_default();
            let words = plain(description);
            assert!(words.split_whitespace().count() >= 3, "{place}: \"{words}\" says too little");
            let mut found = Vec::new();
            numbers(property, &mut found);
            for number in found {
                let unit = bracket(description).unwrap_or_else(|| panic!("{place} has no unit"));
                if let Some(dimension) = number["x-unit"].as_str().and_then(Dimension::by_name) {
                    assert_eq!(unit, format!("[{}]", pretty(dimension)), "{place}");
                }
            }
            let required = required.iter().any(|key| key == name);
            let key = Key { schema, property, required };
            let is_table = target(property).is_some_and(|name| super::table(name).is_some());
            assert!(is_table || key.default_value().is_some(), "{place} has no default");
        }
    }
}

#[test]
fn every_type_kind_and_word_has_a_meaning() {
    for (name, node) in schema_json()["$defs"].as_object().expect("types") {
        let choices = node["oneOf"].as_array().into_iter().flatten();
        for node in choices.chain([node]) {
            let words = node["description"].as_str().unwrap_or_default();
            assert!(words.split_whitespace().count() >= 3, "{name}: {node}");
        }
        assert!(node.get("enum").is_none(), "{name} has words without a meaning");
    }
}

/// Bounds that the loader checks beyond the schema, and whose description has them.
#[test]
fn what_the_loader_bounds_is_described() {
    let (weakest, strongest) = strength::FACTORS;
    let (least, most) = material::STRENGTH_OVER_YOUNG;
    let described: [(&str, &str, f64); 20] = [
        ("World", "gravity", limits::MAX_GRAVITY),
        ("World", "step", limits::MAX_STEPS),
        ("Document", "include", MAX_INCLUDE_DEPTH as f64),
        ("Body", "position", body::MAX_DISTANCE),
        ("Grid", "", body::MAX_DISTANCE),
        ("Stack", "", body::MAX_DISTANCE),
        ("Instances", "", body::MAX_DISTANCE),
        ("Instances", "file", places::MOST_PLACES as f64),
        ("Body", "velocity", body::MAX_SPEED),
        ("Body", "spin", body::MAX_SPIN),
        ("Body", "name", resolve::MAX_NAME as f64),
        ("Body", "paint", MAX_STROKES as f64),
        ("Rotation", "axis", direction::MIN_LENGTH),
        ("Rotation", "quaternion", direction::MIN_LENGTH),
        ("WeakPlane", "normal", direction::MIN_LENGTH),
        ("Layers", "normal", direction::MIN_LENGTH),
        ("Shape", "", geometry::MIN_SIZE),
        ("Shape", "", geometry::MAX_SIZE),
        ("Material", "", least),
        ("Material", "", most),
    ];
    let schema = schema_json();
    let words = |node: &Json| node["description"].as_str().unwrap_or_default().to_owned();
    for (table, key, bound) in described {
        let node = if table == "Document" { schema } else { &schema["$defs"][table] };
        let words = words(if key.is_empty() { node } else { &node["properties"][key] });
        let said = words
            .split_whitespace()
            .any(|word| word.trim_end_matches(['.', ',', ':']) == tell(bound));
        assert!(said, "{table} {key} says nothing of {}: {words}", tell(bound));
    }
    let corners = schema["$defs"]["Paint"]["oneOf"].as_array().into_iter().flatten();
    let file = corners.filter_map(|kind| kind["properties"].get("file")).next().expect("corners");
    assert!(words(file).contains(&format!("from {} to {}", tell(weakest), tell(strongest))));
}

const FLOOR: &str = r#"
[[body]]
name = "floor"
shape = { kind = "box", size = [8, 8, "20 cm"] }
position = [0, 0, "-11 cm"]
material = "granite"
fixed = true
"#;

const VASE: &str = r#"
[[body]]
name = "vase"
shape = { kind = "sphere", radius = "10 cm" }
position = [0, 0, 20]
material = "porcelain"
"#;

/// What an included file of an example adds.
const GROUND: &str = r#"
[[body]]
name = "ground"
shape = { kind = "box", size = [1, 1, 1] }
position = [0, 0, -10]
material = "granite"
fixed = true
"#;

const FIGURE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// An arm that swings.
fn arm() -> Vec<u8> {
    let (times, values) = (vec![0.0, 1.0], vec![0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]);
    let (path, curve) = ("rotation", "LINEAR");
    let channel = GlbChannel { animation: 0, node: 0, path, curve, times, values };
    animated_glb(&[r#""name":"arm""#], ([0.0; 3], [1.0; 3]), &["Swing"], &[channel], "")
}

/// A scene around an example of a table: a floor, a vase, and a body for lines of one.
fn around(table: &Table, kind: &str, example: &str) -> String {
    let lines = match (kind, table.name) {
        ("", _) => example.to_owned(),
        ("corners", _) | (_, "Shape") => example.to_owned(),
        _ => format!("shape = {{ kind = \"box\", size = [0.2, 0.1, 0.1] }}\n{example}"),
    };
    let body = "[[body]]\nname = \"example\"\nmaterial = \"granite\"\nposition = [0, 0, 5]\n";
    let body = if kind.is_empty() { "" } else { body };
    format!("{body}{lines}{FLOOR}{VASE}")
}

#[test]
fn every_example_loads() {
    let file = |key: &str, text: &str| SceneFile {
        key: format!("scene/{key}"),
        bytes: Arc::new(text.as_bytes().to_vec()),
    };
    for table in TABLES {
        for (kind, example) in table.examples {
            let text = around(table, kind, example);
            let bundle = Bundle {
                name: "example".to_owned(),
                main: "scene/scene.toml".to_owned(),
                overrides: Vec::new(),
                files: vec![
                    file("scene.toml", &text),
                    file("floor.toml", GROUND),
                    file("figure.obj", FIGURE),
                    SceneFile { key: "scene/arm.glb".to_owned(), bytes: Arc::new(arm()) },
                    file("places.csv", "x,y,z\n-3,3,0.1\n3,3,0.1\n"),
                    file("factors.txt", "1\n0.5\n0.5\n2\n"),
                ],
            };
            let scene = load_bundle(&bundle)
                .unwrap_or_else(|errors| panic!("{} {kind}:\n{errors}\n{text}", table.name));
            assert!(scene.bodies.len() >= 2, "{} {kind}", table.name);
        }
    }
}
