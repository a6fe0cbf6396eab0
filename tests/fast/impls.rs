//! A type whose methods lie in many files is several things, or a circle that no import shows.
//!
//! Only the impls of the type itself count: that of a trait may stand where the trait is, or the
//! other type that it converts to. Types are told apart by crate and name.

use crate::source::without_literals;
use crate::tree::{NamedText, assert_none, check_list, crate_of, products};
use std::collections::{BTreeMap, BTreeSet};

/// In how many files the methods of a type may lie.
const MAX_FILES: usize = 3;

/// The types whose methods lie in more files today: the crate, the type and the number of files.
const KNOWN: &str = include_str!("impls.txt");

/// The types that a file has methods of.
fn implemented(code: &str) -> BTreeSet<String> {
    let code = without_literals(code);
    let mut found = BTreeSet::new();
    let mut start = 0;
    for line in code.split_inclusive('\n') {
        let after = start + line.len() - line.trim_start().len();
        start += line.len();
        let rest = code[after..].strip_prefix("unsafe ").unwrap_or(&code[after..]);
        let head = rest.strip_prefix("impl").filter(|rest| rest.starts_with([' ', '<']));
        let Some(head) = head.and_then(|head| head.split('{').next()) else { continue };
        found.extend(type_of(head));
    }
    found
}

/// The type of an impl between its keyword and its brace, unless it is one of a trait.
fn type_of(head: &str) -> Option<String> {
    let mut depth = 0_usize;
    let mut before = ' ';
    let mut plain = String::new();
    // What angle brackets hold is left out: parameters may speak of traits too.
    for c in head.chars() {
        match c {
            '<' => depth += 1,
            '>' if before != '-' => depth = depth.saturating_sub(1),
            _ if depth == 0 => plain.push(c),
            _ => {}
        }
        before = c;
    }
    let words: Vec<&str> = plain.split_whitespace().take_while(|word| *word != "where").collect();
    let path = words.first().filter(|_| !words.contains(&"for"))?;
    path.rsplit("::").next().map(str::to_owned)
}

/// The types of a crate whose methods lie in too many files, and how many.
fn spread(products: &[NamedText]) -> BTreeMap<String, usize> {
    let mut files: BTreeMap<String, usize> = BTreeMap::new();
    for (name, code) in products {
        let folder = crate_of(name).unwrap_or("");
        for of in implemented(code) {
            *files.entry(format!("{folder} {of}")).or_default() += 1;
        }
    }
    files.retain(|_, count| *count > MAX_FILES);
    files
}

#[test]
fn methods_of_a_type_lie_together() {
    let list = ("tests/fast/impls.txt", KNOWN);
    let complaint = format!("its methods lie in more than {MAX_FILES} files");
    assert_none(&check_list(list, &spread(products()), &complaint));
}

#[test]
fn types_in_many_files_are_found() {
    let file = |number: usize| {
        let text = "impl<T: Into<Vec<u8>>> a::Wide<T>\nwhere\n    T: Copy,\n{\n}\n\
                    impl Wide<u8> {}\n\
                    impl From<u8> for Deep {}\nfn f() -> impl Fn() {}\n";
        (format!("services/a/src/m{number}.rs"), text.to_owned())
    };
    let other = ("services/b/src/lib.rs".to_owned(), "impl Wide {}".to_owned());
    let mut files: Vec<NamedText> = (0..MAX_FILES).map(file).chain([other]).collect();
    assert_eq!(spread(&files), BTreeMap::new());
    files.push((
        "services/a/src/lib.rs".to_owned(),
        "    impl Wide<'_> {}\nimpl From<u8> for A {}".to_owned(),
    ));
    assert_eq!(spread(&files), [("services/a Wide".to_owned(), MAX_FILES + 1)].into());
}
