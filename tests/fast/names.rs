//! A name is of one type in the whole workspace.

use cullet_tests::{files, root};
use std::collections::BTreeMap;
use std::fs;

/// The names that several types share today, and how many do. It may only become shorter.
const KNOWN: &str = include_str!("names.txt");

/// The name of the type that a line declares, if it does.
fn declared(line: &str) -> Option<&str> {
    let code = line.trim_start();
    let inner = code.len() < line.len();
    let code = match code.strip_prefix("pub") {
        Some(rest) if rest.starts_with('(') => rest.split_once(") ")?.1,
        Some(rest) => rest.strip_prefix(' ')?,
        None => code,
    };
    let (kind, rest) = code.split_once(' ')?;
    // A type inside of something is one of its trait.
    let is_type = match kind {
        "struct" | "enum" | "trait" | "union" => true,
        "type" => !inner,
        _ => false,
    };
    let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
    (is_type && end > 0).then_some(&rest[..end])
}

#[test]
fn names_of_several_types_become_fewer() {
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    let sources = ["proto/src", "services"].map(|folder| files(&root().join(folder), &[".rs"]));
    for path in sources.iter().flatten() {
        let name = path.to_string_lossy().replace('\\', "/");
        let aside = ["/tests/", "/tests.rs", "/benches/", "/examples/"];
        if aside.iter().any(|part| name.contains(part)) {
            continue;
        }
        let text = fs::read_to_string(path).expect("a source file is readable");
        let end = text.find("#[cfg(test)]\nmod tests {").unwrap_or(text.len());
        for name in text[..end].lines().filter_map(declared) {
            *count.entry(name.to_owned()).or_default() += 1;
        }
    }
    count.retain(|_, types| *types > 1);
    let known: BTreeMap<String, usize> = KNOWN
        .lines()
        .map(|line| {
            let (name, types) = line.split_once(' ').expect("a name and a number");
            (name.to_owned(), types.parse().expect("a number"))
        })
        .collect();
    for (name, types) in &count {
        let allowed = known.get(name).copied().unwrap_or(1);
        assert!(*types <= allowed, "{types} types are called {name}: find another name");
    }
    for (name, allowed) in &known {
        let types = count.get(name).copied().unwrap_or(1);
        assert!(types >= *allowed, "tests/fast/names.txt: of {name} there are {types} now");
    }
}

#[test]
fn declarations_of_types_are_known() {
    let found = |line| declared(line);
    assert_eq!(found("pub struct Grain {"), Some("Grain"));
    assert_eq!(found("    pub(crate) enum Kind<'a> {"), Some("Kind"));
    assert_eq!(found("type Path = Vec<Step>;"), Some("Path"));
    assert_eq!((found("    type Item = u8;"), found("let structure = 1;")), (None, None));
}
