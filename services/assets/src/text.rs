//! Text of mesh files, however programs write it.

use std::borrow::Cow;

/// The text of a file: UTF-8 with or without its mark, UTF-16 with its mark, or else Latin-1.
pub(crate) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match bytes {
        [0xef, 0xbb, 0xbf, text @ ..] => decode_bytes(text),
        [0xff, 0xfe, text @ ..] => decode_pairs(text, u16::from_le_bytes),
        [0xfe, 0xff, text @ ..] => decode_pairs(text, u16::from_be_bytes),
        text => decode_bytes(text),
    }
}

fn decode_bytes(text: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(text) {
        Ok(text) => Cow::Borrowed(text),
        // The bytes of Latin-1 are the first 256 characters.
        Err(_) => Cow::Owned(text.iter().map(|&byte| char::from(byte)).collect()),
    }
}

fn decode_pairs(text: &[u8], unit: fn([u8; 2]) -> u16) -> Cow<'static, str> {
    let units = text.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let text = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
    Cow::Owned(text.collect())
}

/// Lines with their numbers from 1. Any of `\n`, `\r\n` and `\r` ends one.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = Some(text);
    let lines = std::iter::from_fn(move || {
        let text = rest?;
        let Some(end) = text.find(['\n', '\r']) else {
            rest = None;
            return Some(text);
        };
        let ends = if text[end..].starts_with("\r\n") { 2 } else { 1 };
        rest = Some(&text[end + ends..]);
        Some(&text[..end])
    });
    (1..).zip(lines)
}

/// Lines, of which a `\` at the end of one joins it to the next, under the number of the first. A
/// comment, from `#`, is not joined, for a path may end it.
pub(crate) fn joined_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut left = lines(text);
    std::iter::from_fn(move || {
        let (number, line) = left.next()?;
        let mut whole = Cow::Borrowed(line);
        while let Some(begun) = whole.trim_end().strip_suffix('\\')
            && !begun.contains('#')
        {
            let next = left.next().map_or("", |(_, next)| next);
            whole = Cow::Owned(format!("{begun} {next}"));
        }
        Some((number, whole))
    })
}

/// A number as programs write it.
///
/// # Errors
/// Why it is none, in words.
pub(crate) fn number(word: &str) -> Result<f64, String> {
    word.parse().or_else(|_| match word.to_ascii_lowercase().as_str() {
        // As some C libraries print what is no number.
        lower if lower.contains("1.#") || lower.contains("nan") => Ok(f64::NAN),
        _ if word.contains(',') && word.replace(',', ".").parse::<f64>().is_ok() => {
            Err(format!("\"{word}\" is no number: decimals are behind a point, not a comma"))
        }
        _ => Err(format!("\"{word}\" is no number")),
    })
}

#[cfg(test)]
mod tests {
    use super::{decode, joined_lines, lines, number};

    #[test]
    fn text_is_read_in_any_encoding() {
        let utf16 = |unit: fn(u16) -> [u8; 2], mark: [u8; 2]| -> Vec<u8> {
            mark.into_iter().chain("Säule".encode_utf16().flat_map(unit)).collect()
        };
        for bytes in [
            "Säule".as_bytes().to_vec(),
            "\u{feff}Säule".as_bytes().to_vec(),
            b"S\xe4ule".to_vec(),
            utf16(u16::to_le_bytes, [0xff, 0xfe]),
            utf16(u16::to_be_bytes, [0xfe, 0xff]),
        ] {
            assert_eq!(decode(&bytes), "Säule", "{bytes:?}");
        }
    }

    #[test]
    fn lines_end_as_on_any_system_and_go_on_behind_a_backslash() {
        let of = |text| lines(text).collect::<Vec<_>>();
        assert_eq!(of("a\nb\r\nc\rd"), [(1, "a"), (2, "b"), (3, "c"), (4, "d")]);
        let text = "f 1 \\\r\n 2 \\  \n3\n# C:\\\nv";
        let joined: Vec<_> = joined_lines(text).map(|(n, line)| (n, line.into_owned())).collect();
        let words: Vec<_> = joined[0].1.split_whitespace().collect();
        assert_eq!((joined[0].0, words), (1, vec!["f", "1", "2", "3"]));
        assert_eq!(joined[1..], [(4, "# C:\\".to_owned()), (5, "v".to_owned())]);
        assert_eq!(joined_lines("\\").count(), 1);
    }

    #[test]
    fn numbers_are_as_programs_write_them() {
        for (word, value) in [("1.", 1.0), (".5", 0.5), ("+1e-05", 1e-5), ("-1E+03", -1e3)] {
            assert_eq!(number(word), Ok(value));
        }
        assert!(number("-1.#IND").is_ok_and(f64::is_nan));
        assert!(number("inf").is_ok_and(f64::is_infinite));
        assert!(number("1,5").is_err_and(|why| why.contains("comma")));
        assert!(number("x").is_err());
    }
}
