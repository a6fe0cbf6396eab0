//! No decision by the words of a message: who words it anew must not change what is done. What code
//! goes by is a kind of error, an exit code or a key.

use crate::tree::{NamedText, assert_none, check_list, planted, products};
use std::collections::{BTreeMap, BTreeSet};

/// Questions to a text whose answer depends on its words.
const QUESTIONS: &[&str] = &[".contains(", ".starts_with(", ".ends_with("];

/// The files that ask a text for words today, and how often: of errors to which Zenoh and the
/// runtime of Rust give no kind.
const KNOWN: &str = include_str!("by_words.txt");

/// Whether a text is words of a sentence: two words of letters, or more.
fn is_wording(text: &str) -> bool {
    let word = |word: &&str| word.len() > 1 && word.chars().all(char::is_alphabetic);
    text.split([' ', ':', ',']).filter(word).count() > 1
}

/// The string at the start of some code, as it is written.
fn string(code: &str) -> Option<&str> {
    let inside = code.strip_prefix('"')?;
    let mut escaped = false;
    let end = inside.find(|c: char| {
        let ends = c == '"' && !escaped;
        escaped = c == '\\' && !escaped;
        ends
    });
    Some(&inside[..end?])
}

/// The constants of all code that are words of a sentence.
fn named_wordings(products: &[NamedText]) -> BTreeSet<&str> {
    let lines = products.iter().flat_map(|(_, code)| code.lines());
    lines
        .filter_map(|line| {
            let (name, value) = line.split_once("const ")?.1.split_once(": &str = ")?;
            string(value).filter(|text| is_wording(text)).map(|_| name)
        })
        .collect()
}

/// How often each file asks a text for words.
fn questions(products: &[NamedText]) -> BTreeMap<String, usize> {
    let names = named_wordings(products);
    let asks = |code: &str| match string(code) {
        Some(text) => is_wording(text),
        None => {
            let end = code.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
            let name = code[..end.unwrap_or(code.len())].rsplit("::").next().unwrap_or("");
            names.contains(name)
        }
    };
    let count = |code: &str| {
        let places = QUESTIONS.iter().flat_map(|ask| code.split(ask).skip(1));
        places.filter(|rest| asks(rest)).count()
    };
    let counts = products.iter().map(|(name, code)| (name.clone(), count(code)));
    counts.filter(|(_, count)| *count > 0).collect()
}

#[test]
fn messages_decide_nothing() {
    let list = ("tests/fast/by_words.txt", KNOWN);
    let complaint = "it asks a text for its words: give what it means a kind";
    assert_none(&check_list(list, &questions(products()), complaint));
}

#[test]
fn decisions_by_words_are_found() {
    let files = planted([
        ("a.rs", "if why.ends_with(\"is missing\") && said.contains(\"not \\\"it\\\" but\") {}"),
        ("b.rs", "if why.starts_with(net::UNABLE) {}"),
        ("c.rs", "pub const UNABLE: &str = \"Unable to connect\";\nconst PREFIX: &str = \"tls/\";"),
        ("d.rs", "if name.ends_with(\".glb\") && name.contains(PREFIX) && all.contains(&one) {}"),
        ("e.rs", "out.push(\"is missing\"); let text = \"of its\"; \"a b\".contains('x');"),
    ]);
    let found = questions(&files);
    assert_eq!(found, [("a.rs".to_owned(), 2), ("b.rs".to_owned(), 1)].into());
}
