//! What a source file says as a product: its code without comments and without what only tests
//! compile. Lines keep their numbers.

use std::collections::BTreeSet;
use std::ops::Range;

/// What a byte of a source file belongs to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Part {
    Code,
    Comment,
    /// The inside of a string or of a character; the quotes are code.
    Literal,
}

/// What each byte of a source file belongs to.
fn parts(text: &str) -> Vec<Part> {
    let bytes = text.as_bytes();
    let mut found = vec![Part::Code; bytes.len()];
    let mut at = 0;
    while at < bytes.len() {
        let rest = &text.as_bytes()[at..];
        let (part, inside, next) = if rest.starts_with(b"//") {
            let end = at + rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            (Part::Comment, at..end, end)
        } else if rest.starts_with(b"/*") {
            let end = at + block_comment(rest);
            (Part::Comment, at..end, end)
        } else if let Some(hashes) = raw_string(bytes, at) {
            let start = at + hashes + 2;
            let close = format!("\"{}", "#".repeat(hashes));
            let end = start + text[start..].find(&close).unwrap_or(text.len() - start);
            (Part::Literal, start..end, end + close.len())
        } else if rest[0] == b'"' {
            let end = at + 1 + escaped(&rest[1..], b'"');
            (Part::Literal, at + 1..end, end + 1)
        } else if rest[0] == b'\'' && is_character(&text[at + 1..]) {
            let end = at + 1 + escaped(&rest[1..], b'\'');
            (Part::Literal, at + 1..end, end + 1)
        } else {
            (Part::Code, at..at + 1, at + 1)
        };
        found[inside].fill(part);
        at = next;
    }
    found
}

/// The length of a block comment at the start, with those that it holds.
fn block_comment(bytes: &[u8]) -> usize {
    let (mut depth, mut at) = (0_usize, 0);
    while at < bytes.len() {
        match &bytes[at..] {
            [b'/', b'*', ..] => (depth, at) = (depth + 1, at + 2),
            [b'*', b'/', ..] => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at.min(bytes.len())
}

/// The number of `#` of a raw string that begins with the `r` at a place, if one does.
fn raw_string(bytes: &[u8], at: usize) -> Option<usize> {
    let word = |&b: &u8| b.is_ascii_alphanumeric() || b == b'_';
    let before = &bytes[..at];
    let start = before.iter().rposition(|b| !word(b)).map_or(0, |place| place + 1);
    let prefixed = matches!(&before[start..], b"" | b"b" | b"c");
    let hashes = bytes[at + 1..].iter().take_while(|&&b| b == b'#').count();
    (bytes[at] == b'r' && prefixed && bytes.get(at + 1 + hashes) == Some(&b'"')).then_some(hashes)
}

/// The number of bytes before the quote that ends a literal with escapes.
fn escaped(bytes: &[u8], quote: u8) -> usize {
    let mut at = 0;
    while at < bytes.len() && bytes[at] != quote {
        at += if bytes[at] == b'\\' { 2 } else { 1 };
    }
    at.min(bytes.len())
}

/// Whether what follows a `'` is a character, and no lifetime.
fn is_character(rest: &str) -> bool {
    let mut chars = rest.chars();
    matches!((chars.next(), chars.next()), (Some('\\'), _) | (Some(_), Some('\'')))
}

/// The code of a product file: without comments and without items that only tests compile, with
/// strings as they are. Each line is where it was.
pub(crate) fn product(text: &str) -> String {
    let parts = parts(text);
    // Places in the masked text are those of the text.
    let code = masked(text, &parts);
    let of_tests = test_items(code.as_bytes(), code.contains("#![cfg(test)]"));
    let kept = |&(at, byte): &(usize, u8)| {
        byte == b'\n' || parts[at] != Part::Comment && !of_tests.iter().any(|all| all.contains(&at))
    };
    let bytes = text.bytes().enumerate().filter(kept).map(|(_, byte)| byte).collect();
    let lines = String::from_utf8(bytes).expect("only whole characters are taken out");
    lines.split('\n').map(str::trim_end).collect::<Vec<_>>().join("\n")
}

/// Where masked code has items that only tests compile, with their attributes.
fn test_items(code: &[u8], whole: bool) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    found.extend(whole.then_some(0..code.len()));
    let mut at = 0;
    while let Some(attribute) = find(code, b"#[cfg(", at) {
        at = close(code, attribute + 1);
        if only_tests(&code[attribute..at]) {
            at = item_end(code, at);
            found.push(attribute..at);
        }
    }
    found
}

/// The names of the modules in files of their own that only tests compile.
pub(crate) fn test_modules(text: &str) -> BTreeSet<String> {
    fn declared(code: &str) -> BTreeSet<String> {
        let name = |line: &str| {
            let (_, name) = line.trim().strip_suffix(';')?.rsplit_once("mod ")?;
            Some(name.to_owned())
        };
        code.lines().filter_map(name).collect()
    }
    let shipped = declared(&product(text));
    declared(&without_literals(text)).into_iter().filter(|name| !shipped.contains(name)).collect()
}

/// Code without comments and without the insides of strings and characters, whose places are filled
/// with spaces, so that each byte of code stays where it was.
pub(crate) fn without_literals(text: &str) -> String {
    masked(text, &parts(text))
}

fn masked(text: &str, parts: &[Part]) -> String {
    let byte = |(byte, part)| match (byte, part) {
        (b'\n', _) => b'\n',
        (_, Part::Code) => byte,
        _ => b' ',
    };
    let bytes = text.bytes().zip(parts.iter().copied()).map(byte).collect();
    String::from_utf8(bytes).expect("literals and comments are whole characters")
}

fn find(code: &[u8], word: &[u8], from: usize) -> Option<usize> {
    let place = code.get(from..)?.windows(word.len()).position(|part| part == word)?;
    Some(from + place)
}

/// The place after the bracket that closes the one at a place.
pub(crate) fn close(code: &[u8], open: usize) -> usize {
    let mut depth = 0_usize;
    for (at, byte) in code.iter().enumerate().skip(open) {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    code.len()
}

/// Where masked code declares things by a keyword such as `fn`, and their names.
pub(crate) fn declarations<'a>(code: &'a str, keyword: &str) -> Vec<(usize, &'a str)> {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let name = |(at, _): (usize, &str)| {
        let rest = &code[at + keyword.len()..];
        let apart = !code[..at].ends_with(word) && rest.starts_with(char::is_whitespace);
        let name = rest.trim_start();
        // In a macro it may be one of its parameters.
        let plain = name.strip_prefix('$').unwrap_or(name);
        let end = name.len() - plain.len() + plain.find(|c| !word(c)).unwrap_or(plain.len());
        (apart && plain.starts_with(word)).then_some((at, &name[..end]))
    };
    code.match_indices(keyword).filter_map(name).collect()
}

/// Whether an attribute `#[cfg(…)]` is true in tests only: it asks for `test`, or for all of some
/// things of which one is `test`.
fn only_tests(attribute: &[u8]) -> bool {
    let text: String = attribute.iter().map(|&b| char::from(b)).collect();
    let text: String = text.split_whitespace().collect();
    let Some(asked) = text.strip_prefix("#[cfg(").and_then(|text| text.strip_suffix(")]")) else {
        return false;
    };
    let Some(all) = asked.strip_prefix("all(").and_then(|all| all.strip_suffix(')')) else {
        return asked == "test";
    };
    let mut depth = 0;
    let apart = |c: char| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == ',' && depth == 0
    };
    all.split(apart).any(|one| one == "test")
}

/// Words that an item can begin with, and whether it can end with a brace.
const ITEMS: &[(&str, bool)] = &[
    ("async", true),
    ("const", false),
    ("enum", true),
    ("extern", true),
    ("fn", true),
    ("impl", true),
    ("let", false),
    ("macro_rules", true),
    ("mod", true),
    ("static", false),
    ("struct", true),
    ("trait", true),
    ("type", false),
    ("union", true),
    ("unsafe", true),
    ("use", false),
];

/// The place after the item (or the field, arm, variant or statement) that an attribute which ends
/// at a place belongs to.
fn item_end(code: &[u8], from: usize) -> usize {
    let blank = |at: usize| code[at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
    let mut at = from + blank(from);
    while code[at..].starts_with(b"#[") {
        at = close(code, at + 1);
        at += blank(at);
    }
    let (mut word, mut after) = word_at(code, at);
    if word == "pub" {
        after += blank(after);
        if code.get(after) == Some(&b'(') {
            after = close(code, after);
        }
        after += blank(after);
        (word, after) = word_at(code, after);
    }
    // `const fn` ends as a function does.
    let second = word_at(code, after + blank(after)).0;
    let function = word == "const" && ["fn", "unsafe", "async", "extern"].contains(&second);
    let kind = ITEMS.iter().find(|(name, _)| *name == word);
    match kind.map(|(_, braced)| *braced || function) {
        Some(braced) => declared_end(code, at, braced),
        None => member_end(code, at),
    }
}

fn word_at(code: &[u8], at: usize) -> (&str, usize) {
    let rest = code.get(at..).unwrap_or_default();
    let word = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
    let length = rest.iter().take_while(|b| word(b)).count();
    (std::str::from_utf8(&rest[..length]).expect("ASCII"), at + length)
}

/// The place after the `;` of a declaration, or after its braces where it can end with them.
fn declared_end(code: &[u8], from: usize, braced: bool) -> usize {
    let mut at = from;
    while at < code.len() {
        match code[at] {
            b';' => return at + 1,
            b'{' if braced => return close(code, at),
            b'(' | b'[' | b'{' => at = close(code, at),
            _ => at += 1,
        }
    }
    at
}

/// The place after the comma or semicolon of a field, arm, variant or statement, or before the
/// bracket that closes around it.
fn member_end(code: &[u8], from: usize) -> usize {
    let (mut at, mut angles) = (from, 0_usize);
    while at < code.len() {
        match code[at] {
            b';' => return at + 1,
            b',' if angles == 0 => return at + 1,
            b'{' => {
                let end = close(code, at);
                return end + usize::from(matches!(code.get(end), Some(b',' | b';')));
            }
            b'(' | b'[' => {
                at = close(code, at);
                continue;
            }
            b')' | b']' | b'}' => return at,
            b'<' => angles += 1,
            b'>' if !matches!(code[at - 1], b'-' | b'=') => angles = angles.saturating_sub(1),
            _ => {}
        }
        at += 1;
    }
    at
}

#[test]
fn only_what_ships_is_read() {
    let text = r##"use a::b; // why
#[cfg(test)]
use a::{c, d};
/* a /* nested */ comment " */ struct Kept<'a>(&'a str);
impl Kept<'_> {
    #[cfg(test)]
    #[must_use]
    pub(crate) const fn gone(&self) -> [u8; 2] { ['{' as u8, b'\''] }
    fn stays(&self) -> &'static str { "// no } comment #[cfg(test)]" }
}
#[cfg(all(test, unix))]
mod tests { const OPEN: &str = r#"}"{"#; }
#[cfg(any(test, unix))]
fn both() {}
struct Fields {
    #[cfg(test)]
    gone: BTreeMap<u8, u8>,
    stays: u8,
}
#[cfg(test)]
mod sim;
fn last() { match x {
    #[cfg(test)]
    Event::Gone(_) if x => {}
    Event::Stays => {}
} }
fn more() -> Fields {
    #[cfg(test)]
    #[allow(unused)]
    let chosen = if a { b } else { c };
    Fields { stays: 1, #[cfg(test)] gone: none() }
}"##;
    let code = product(text);
    assert_eq!(code.lines().count(), text.lines().count(), "lines stay where they are");
    let lines = |word: &str| code.lines().position(|line| line.contains(word));
    assert_eq!((lines("why"), lines("nested"), lines("{c, d}")), (None, None, None));
    assert_eq!((lines("fn gone"), lines("mod tests"), lines("OPEN")), (None, None, None));
    assert_eq!((lines("gone: "), lines("Event::Gone"), lines("mod sim")), (None, None, None));
    assert_eq!((lines("u8>,"), lines("else"), lines("none()")), (None, None, None));
    assert_eq!(
        (lines("struct Kept"), lines("fn stays"), lines("fn both")),
        (Some(3), Some(8), Some(13))
    );
    assert_eq!(
        (lines("stays: u8"), lines("Event::Stays"), lines("fn last")),
        (Some(17), Some(24), Some(21))
    );
    assert!(code.contains("\"// no } comment #[cfg(test)]\""), "strings stay: {code}");
    assert_eq!(test_modules(text).into_iter().collect::<Vec<_>>(), ["sim"]);
    let (open, shut) = (code.matches('{').count(), code.matches('}').count());
    assert_eq!((open, shut), (9, 10), "those of the items that stay, and one in a string:\n{code}");
}

#[test]
fn literals_are_told_from_code() {
    let masked =
        without_literals(r##"f("println!(\"", 'x', b'"', '\'', r#"mod"#, &'a y, r#for) // z"##);
    let kept = r##"f("           ", ' ', b' ', '  ', r#"   "#, &'a y, r#for)     "##;
    assert_eq!(masked, kept);
    assert_eq!(product("#![cfg(test)]\nfn f() {}\n").trim(), "");
    assert_eq!(product("#[cfg(not(test))]\nfn f() {}"), "#[cfg(not(test))]\nfn f() {}");
}
