//! Cells of tables (CSV): what a text becomes in one, and which text a cell stands for.
//!
//! A spreadsheet computes a cell that begins as a formula does, in quotes or not. Names of a scene
//! and values of a sweep are anybody's, so such a text gets an apostrophe before it, by which a
//! spreadsheet knows a text. A number stays one, whatever its sign.
//!
//! Where a comma is in numbers, a spreadsheet parts cells at `;`, and some part them at tabs; then
//! quotes that begin amid a cell keep nothing together, line breaks included. So what follows one
//! of these in a text is marked in the same way: `x;=1` becomes `x;'=1`.

use std::borrow::Cow;

/// What a formula begins with; spreadsheets take the wide letters of East Asian keyboards, too.
const FORMULA: [char; 8] = ['=', '+', '-', '@', '＝', '＋', '－', '＠'];
/// What spreadsheets pass over before it.
const BLANK: [char; 3] = ['\t', '\r', '\n'];
/// What stands before a text that begins so.
const MARK: char = '\'';

/// Whether a text begins as a formula does, behind marks, quotes and spaces.
fn is_formula(text: &str) -> bool {
    text.trim_start_matches([MARK, ' ', '"']).starts_with(FORMULA)
}

/// Whether a cell begins so.
fn is_formula_cell(text: &str) -> bool {
    is_formula(text) || text.trim_start_matches([MARK, ' ', '"']).starts_with(BLANK)
}

/// The parts of a text that may become cells of their own, each with what parts it from the next.
fn parts(text: &str) -> impl Iterator<Item = &str> + Clone {
    text.split_inclusive([';', '\t', '\r', '\n'])
}

/// Writes a text as a cell: in quotes where it has commas, quotes or line breaks, and marked as a
/// text where a spreadsheet would compute it or a part of it.
#[must_use]
pub fn quote_cell(text: &str) -> String {
    if text.parse::<f64>().is_ok_and(f64::is_finite) {
        return text.to_owned();
    }
    let mut cell = String::with_capacity(text.len() + 1);
    for part in parts(text) {
        if is_formula(part) || cell.is_empty() && is_formula_cell(text) {
            cell.push(MARK);
        }
        cell.push_str(part);
    }
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell,
    }
}

/// Reads the text for which a cell stands; its quotes are already gone.
#[must_use]
pub fn read_cell(cell: &str) -> Cow<'_, str> {
    let marked = |part: &&str| part.strip_prefix(MARK).is_some_and(is_formula);
    let first = cell.strip_prefix(MARK).filter(|text| is_formula_cell(text));
    let rest = first.unwrap_or(cell);
    // The first part has lost its mark, if it had one.
    let later = parts(rest).skip(1);
    if !later.clone().any(|part| marked(&part)) {
        return Cow::Borrowed(rest);
    }
    let bare = |part| if marked(&part) { &part[MARK.len_utf8()..] } else { part };
    Cow::Owned(parts(rest).take(1).chain(later.map(bare)).collect())
}

#[cfg(test)]
mod tests {
    use super::{quote_cell, read_cell};

    #[test]
    fn no_cell_is_a_formula_and_every_text_is_read_back() {
        for (text, cell) in [
            ("pot", "pot"),
            ("+1+1", "'+1+1"),
            ("@SUM(1)", "'@SUM(1)"),
            ("=1+1", "'=1+1"),
            ("=SUM(1,2)", "\"'=SUM(1,2)\""),
            ("=cmd|' /c calc'!\"A1\"", "\"'=cmd|' /c calc'!\"\"A1\"\"\""),
            (" =1", "' =1"),
            ("＝1", "'＝1"),
            ("\t=1", "'\t'=1"),
            ("-10 mm", "'-10 mm"),
            ("-inf", "'-inf"),
            ("-10", "-10"),
            ("+1.5e-3", "+1.5e-3"),
            ("'pot'", "'pot'"),
            ("'=1", "''=1"),
            ("''=1", "'''=1"),
            ("a,b", "\"a,b\""),
            ("", ""),
            ("x;=1+1", "x;'=1+1"),
            ("x; \"=1+1", "\"x;' \"\"=1+1\""),
            ("x;'=1", "x;''=1"),
            ("x;'1", "x;'1"),
            ("=1;=2;3;@A", "'=1;'=2;3;'@A"),
            ("a\t-b", "a\t'-b"),
            ("a\r\n+b\n\nc", "\"a\r\n'+b\n\nc\""),
            (";=1", ";'=1"),
            ("'\t'=1", "''\t''=1"),
            ("x;-10", "x;'-10"),
            ("w 0.5 kg; v -1 kg", "w 0.5 kg; v -1 kg"),
        ] {
            assert_eq!(quote_cell(text), cell);
            let inside = cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
            let bare = inside.map_or(cell.to_owned(), |inside| inside.replace("\"\"", "\""));
            assert_eq!(read_cell(&bare), text, "{cell}");
        }
    }
    /// Every text of up to six of these letters, whatever stands beside what.
    #[test]
    fn any_text_is_read_back() {
        let letters = ['=', '\'', ' ', '"', ';', '\t', '\n', '1'];
        let mut texts = vec![String::new()];
        for length in 0..6 {
            let of = texts.iter().filter(|text| text.len() == length);
            let more = of.flat_map(|text| letters.map(|letter| format!("{text}{letter}")));
            texts.extend(more.collect::<Vec<_>>());
        }
        for text in &texts {
            let cell = quote_cell(text);
            let inside = cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
            let quoted = inside.filter(|_| text.contains(['"', '\n']));
            let bare = quoted.map_or(cell.clone(), |inside| inside.replace("\"\"", "\""));
            assert_eq!(read_cell(&bare), *text, "{cell}");
            let apart = |part: &str| part.trim_start_matches([' ', '"']).starts_with('=');
            assert!(!cell.split([';', '\t', '\n']).any(apart), "{cell}");
        }
    }
}
