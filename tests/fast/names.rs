//! A name is of one type in the whole workspace, and a value is not named like the function that
//! it is the result of.

use crate::source::{declarations, without_literals};
use crate::tree::{NamedText, assert_none, check_list, planted, products};
use std::collections::BTreeMap;

/// The names that several types share today, and how many do.
const SHARED: &str = include_str!("names.txt");

/// The files with values that are named like their function today, and how many.
const LIKE_THEIR_FUNCTION: &str = include_str!("named_like_result.txt");

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

/// The names that several types share, and how many do.
fn shared(products: &[NamedText]) -> BTreeMap<String, usize> {
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    for (_, code) in products {
        for name in without_literals(code).lines().filter_map(declared) {
            *count.entry(name.to_owned()).or_default() += 1;
        }
    }
    count.retain(|_, types| *types > 1);
    count
}

/// The values of a file that are named like their function: `let x = x(…)` and `let x = a::x(…)`. A
/// method or a field is a question to a value, and its answer may have its name.
fn like_their_function(code: &str) -> Vec<String> {
    let code = without_literals(code);
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    for (at, name) in declarations(&code, "let") {
        let rest = code[at + "let".len()..].trim_start();
        let rest = rest.strip_prefix("mut ").map_or(rest, str::trim_start);
        let name = if name == "mut" { &rest[..rest.find(|c| !word(c)).unwrap_or(0)] } else { name };
        let statement = rest.split(';').next().unwrap_or("");
        let Some((left, right)) = statement.split_once('=') else { continue };
        let typed = left.trim_end() == name || left[name.len()..].trim_start().starts_with(':');
        let right = right.trim_start();
        let path = &right[..right.find(|c| !word(c) && c != ':').unwrap_or(right.len())];
        let after = &right[path.len()..];
        let called = after.starts_with('(') || path.ends_with("::") && after.starts_with('<');
        let function = path.trim_end_matches(':').rsplit("::").next().unwrap_or("");
        if typed && called && function == name {
            found.push(name.to_owned());
        }
    }
    found
}

#[test]
fn names_of_several_types_become_fewer() {
    let list = ("tests/fast/names.txt", SHARED);
    assert_none(&check_list(list, &shared(products()), "find another name for one of them"));
}

#[test]
fn values_named_like_their_function_become_fewer() {
    let counts =
        products().iter().map(|(name, code)| (name.clone(), like_their_function(code).len()));
    let found = counts.filter(|(_, count)| *count > 0).collect();
    let list = ("tests/fast/named_like_result.txt", LIKE_THEIR_FUNCTION);
    assert_none(&check_list(list, &found, "`let x = x(…)` names a value like its function"));
}

#[test]
fn declarations_of_types_are_known() {
    let found = |line| declared(line);
    assert_eq!(found("pub struct Grain {"), Some("Grain"));
    assert_eq!(found("    pub(crate) enum Kind<'a> {"), Some("Kind"));
    assert_eq!(found("type Path = Vec<Step>;"), Some("Path"));
    assert_eq!((found("    type Item = u8;"), found("let structure = 1;")), (None, None));
}

#[test]
fn shared_names_are_found() {
    let files = planted([("a.rs", "struct Grain;\nenum One {}"), ("b.rs", "pub type Grain = u8;")]);
    assert_eq!(shared(&files), [("Grain".to_owned(), 2)].into());
}

#[test]
fn values_named_like_their_function_are_found() {
    let found = "let held = held(x); let mut sum = a::sum(y); let cut: Cut =\n    Self::cut(z)?;\n\
                 let read = read::<u8>(x); if let Some(x) = x() {}";
    assert_eq!(like_their_function(found), ["held", "sum", "cut", "read"]);
    let other = "let held = self.held(x); let sum = sums(y); let cut = cut; let a = a(1) == b;\n\
                 let read = write(read(x)); let y = \"let x = x(1);\"; let Some(y) = y() else {};";
    assert_eq!(like_their_function(other), ["a"]);
}
