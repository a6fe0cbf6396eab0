//! Text that comes from others, as a terminal may have it. Everything that this program prints goes
//! through here: what a terminal would act upon, such as ESC, or would not show as it stands, such
//! as a change of direction, is written as JSON writes it. So JSON means the same after it.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a terminal acts upon a letter, shows nothing for it, or shows others in another order.
fn acts(letter: char) -> bool {
    letter.is_control()
        || matches!(letter,
            // Marks, embeddings, overrides and isolates of direction; two ends of lines.
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{206f}'
            // No width at all.
            | '\u{200b}' | '\u{2060}'..='\u{2065}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e007f}')
}

fn escape(text: &str, kept: &[char]) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            _ if !acts(letter) || kept.contains(&letter) => out.push(letter),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            _ => letter.encode_utf16(&mut [0; 2]).iter().for_each(|unit| {
                let _ = write!(out, "\\u{unit:04x}");
            }),
        }
    }
    out
}

/// A name or a line of others: it stays one line.
pub(crate) fn shown(text: &str) -> Cow<'_, str> {
    match text.contains(acts) {
        true => escape(text, &[]).into(),
        false => text.into(),
    }
}

/// The same in a column: a longer one loses its end.
pub(crate) fn cell(text: &str, most: usize) -> Cow<'_, str> {
    let shown = shown(text);
    match shown.char_indices().nth(most) {
        Some(_) => shown.chars().take(most.saturating_sub(1)).chain(['…']).collect(),
        None => shown,
    }
}

/// What others say in several lines: those after the first are indented, so that none of them looks
/// like a line of ours.
pub(crate) fn lines(text: &str) -> String {
    let all: Vec<_> = text.split('\n').map(|line| shown(line.trim_end_matches('\r'))).collect();
    all.join("\n    ")
}

/// A whole output, of ours and with ends of lines, that goes to a terminal.
pub(crate) fn output(text: &str) -> Cow<'_, str> {
    let harmless = |letter| !acts(letter) || matches!(letter, '\n' | '\t');
    match text.chars().all(harmless) {
        true => text.into(),
        false => escape(text, &['\n', '\t']).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::{cell, lines, output, shown};

    const EVIL: &str = "a\u{1b}]0;title\u{7}\u{9b}2J\r\u{202e}b\u{7f}\u{e0001}";
    const TOLD: &str = r"a\u001b]0;title\u0007\u009b2J\r\u202eb\u007f\udb40\udc01";

    #[test]
    fn nothing_that_a_terminal_acts_upon_is_left() {
        assert_eq!(shown(EVIL), TOLD);
        assert_eq!(output(EVIL), TOLD);
        assert_eq!(shown("one\ntwo\tx"), r"one\ntwo\tx");
        assert_eq!(output("one\ntwo\tx"), "one\ntwo\tx");
        assert_eq!(lines("one\r\ntwo\u{1b}c\nthree"), "one\n    two\\u001bc\n    three");
        for plain in ["", "größer, 大きい, \"a\\b\"", "e\u{301}", "👩\u{200d}🔬"] {
            assert_eq!((&*shown(plain), &*output(plain), &*lines(plain)), (plain, plain, plain));
        }
    }

    #[test]
    fn json_says_the_same_after_it() {
        let json = serde_json::to_string_pretty(&[EVIL, "\n"]).expect("JSON");
        let told = output(&json).into_owned();
        assert!(told.chars().all(|letter| letter == '\n' || !super::acts(letter)), "{told}");
        let back: Vec<String> = serde_json::from_str(&told).expect("JSON");
        assert_eq!(back, [EVIL, "\n"]);
    }

    #[test]
    fn a_long_name_does_not_fill_the_terminal() {
        assert_eq!(cell("pot", 3), "pot");
        assert_eq!(cell("ältere", 3), "äl…");
        assert_eq!(cell(&"x".repeat(1 << 20), 40).chars().count(), 40);
        assert_eq!(cell("\u{1b}", 4), r"\u0…");
    }
}
