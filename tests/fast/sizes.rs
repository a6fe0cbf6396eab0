//! Sizes: of lines, files, functions and traits.

use crate::source::{close, declarations, without_literals};
use crate::tree::{NamedText, assert_none, planted, sources};

const MAX_LINE: usize = 100;
const MAX_FUNCTION: usize = 70;
const MAX_FILE: usize = 500;
const MAX_TRAIT_METHODS: usize = 4;

/// Files that are too long, and lines that are too wide.
fn check_lines(sources: &[NamedText]) -> Vec<String> {
    let mut faults = Vec::new();
    for (name, text) in sources {
        let count = text.lines().count();
        if count > MAX_FILE {
            let ask = "is it two nouns?";
            faults.push(format!("{name} has {count} lines; {ask} (at most {MAX_FILE})"));
        }
        for (number, line) in text.lines().enumerate() {
            let width = line.chars().count();
            if width > MAX_LINE {
                faults.push(format!("{name}:{} is {width} columns wide", number + 1));
            }
        }
    }
    faults
}

/// The functions of a source file that have a body: the line of each, and its lines.
fn functions(text: &str) -> Vec<(usize, usize)> {
    let code = without_literals(text);
    let bodies = declarations(&code, "fn").into_iter().filter_map(|(at, _)| {
        let body = body_of(code.as_bytes(), at)?;
        let line = code[..at].lines().count().max(1);
        Some((line, code[at..body.1].lines().count()))
    });
    bodies.collect()
}

/// Where the braces of a declaration are, if it has some.
fn body_of(code: &[u8], from: usize) -> Option<(usize, usize)> {
    let mut at = from;
    loop {
        match code.get(at)? {
            b'{' => return Some((at, close(code, at))),
            b';' => return None,
            b'(' | b'[' => at = close(code, at),
            _ => at += 1,
        }
    }
}

fn check_functions(sources: &[NamedText]) -> Vec<String> {
    let mut faults = Vec::new();
    for (name, text) in sources {
        let long = functions(text).into_iter().filter(|(_, lines)| *lines > MAX_FUNCTION);
        faults.extend(
            long.map(|(line, lines)| format!("{name}:{line} is a function of {lines} lines")),
        );
    }
    faults
}

fn check_traits(sources: &[NamedText]) -> Vec<String> {
    let mut faults = Vec::new();
    for (name, text) in sources {
        let code = without_literals(text);
        for (at, of) in declarations(&code, "trait") {
            let Some((open, end)) = body_of(code.as_bytes(), at) else { continue };
            let inner = &code[open + 1..end];
            let is_method = |&(at, _): &(usize, &str)| {
                inner[..at].matches('{').count() == inner[..at].matches('}').count()
            };
            let methods = declarations(inner, "fn").iter().filter(|found| is_method(found)).count();
            if methods > MAX_TRAIT_METHODS {
                faults.push(format!("{name}: the trait {of} has {methods} methods"));
            }
        }
    }
    faults
}

#[test]
fn lines_and_files_stay_readable() {
    assert_none(&check_lines(sources()));
}

#[test]
fn functions_fit_on_a_screen() {
    assert_none(&check_functions(sources()));
}

#[test]
fn traits_are_small() {
    assert_none(&check_traits(sources()));
}

#[test]
fn long_lines_and_files_are_found() {
    let lines = "\n".repeat(MAX_FILE + 1);
    let wide = "\u{e9}".repeat(MAX_LINE + 1);
    let files = planted([("long.rs", &lines), ("wide.rs", &wide), ("good.rs", "fn f() {}")]);
    let said = check_lines(&files);
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said[0].contains("501 lines") && said[1].contains("wide.rs:1 is 101 columns"));
}

#[test]
fn functions_of_every_kind_are_found() {
    let heads = [
        "fn f()",
        "pub(super) fn f()",
        "pub(in crate::a) fn f<'a>(x: &'a str)",
        "pub(crate) const fn f(x: [u8; 3]) -> [u8; 4]",
        "pub unsafe fn f()",
        "async fn f()",
        "unsafe extern \"C\" fn f()",
    ];
    for head in heads {
        let inside = "    g(\"}\"); // }\n".repeat(MAX_FUNCTION - 1);
        let text =
            format!("mod a;\nimpl A {{\n    #[must_use]\n    {head} {{\n{inside}    }}\n}}\n");
        assert_eq!(functions(&text), [(4, MAX_FUNCTION + 1)], "{head}");
        let said = check_functions(&planted([("a.rs", &text)]));
        assert_eq!(said, ["a.rs:4 is a function of 71 lines"], "{head}");
    }
    assert_eq!(functions("type F = fn(u8) -> u8;\ntrait A {\n    fn f();\n}\n// fn g() {}"), []);
}

#[test]
fn large_traits_are_found() {
    let methods = "    fn f(&self) { fn inner() {} }\n".repeat(4);
    let text =
        format!("pub(crate) trait Small {{\n{methods}}}\ntrait Large {{\n{methods}    fn g();\n}}");
    assert_eq!(check_traits(&planted([("a.rs", &text)])), ["a.rs: the trait Large has 5 methods"]);
}
