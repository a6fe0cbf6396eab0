//! Text broken into lines.

/// Widest line of the page \[columns\].
pub(super) const WIDTH: usize = 118;

/// The words of a text; code between backticks is one word with what adjoins it.
fn words(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut code = false;
    for c in text.chars() {
        code ^= c == '`';
        if c.is_whitespace() && !code {
            words.push(String::new());
        } else if let Some(word) = words.last_mut() {
            word.push(if c.is_whitespace() { ' ' } else { c });
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// A text as lines: the first begins with `first`, the others with `indent`.
pub(super) fn wrapped(text: &str, first: &str, indent: &str) -> String {
    let (mut lines, mut line, mut empty) = (String::new(), first.to_owned(), true);
    for word in words(text) {
        if !empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines.push_str(&line);
            lines.push('\n');
            (line, empty) = (indent.to_owned(), true);
        }
        if !empty {
            line.push(' ');
        }
        line.push_str(&word);
        empty = false;
    }
    lines + &line + "\n"
}

#[cfg(test)]
mod tests {
    use super::{WIDTH, wrapped};

    #[test]
    fn lines_end_between_words_and_code_stays_in_one_line() {
        let text = "word ".repeat(22) + "`a b c d` end";
        let lines = wrapped(&text, "- ", "  ");
        let lines: Vec<&str> = lines.lines().collect();
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert!(lines[0].starts_with("- word") && lines[0].chars().count() <= WIDTH);
        assert_eq!(lines[1], "  `a b c d` end");
    }
}
