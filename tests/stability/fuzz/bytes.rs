//! Edits: how random bytes become a damaged file.

/// Words that are valid somewhere and wrong almost everywhere.
const WORDS: [&str; 24] = [
    "nan",
    "-inf",
    "1e308",
    "-1",
    "0",
    "1e-320",
    "99999999999999999999",
    "4294967296",
    "\"\"",
    "\"1 m\"",
    "\"-5 GPa\"",
    "[]",
    "[[[[[[[[",
    "{}",
    "true",
    "[body]",
    "\n",
    "\r",
    "\t",
    "=",
    "ß",
    "\u{0}",
    "\u{feff}",
    "../../x",
];

/// One edit in four bytes: what, where (two), with what.
const EDIT: usize = 4;

/// Most bytes of an input: as many edits as still leave something of the file.
pub(super) const INPUT: usize = 1 + 8 * EDIT;

/// The seed that the first byte names, with the edits that the other bytes name.
pub(super) fn damaged(input: &[u8], seeds: &[Vec<u8>]) -> (usize, Vec<u8>) {
    let (first, edits) = input.split_first().map_or((0, input), |(k, rest)| (*k, rest));
    let which = usize::from(first) % seeds.len();
    let mut bytes = seeds[which].clone();
    for edit in edits.chunks_exact(EDIT) {
        apply([edit[0], edit[1], edit[2], edit[3]], &mut bytes);
    }
    (which, bytes)
}

fn apply([what, low, high, with]: [u8; EDIT], bytes: &mut Vec<u8>) {
    let spot = usize::from(low) | usize::from(high) << 8;
    if bytes.is_empty() {
        bytes.push(with);
        return;
    }
    // Large files are reached too: a place is a share of the length there.
    let at = if bytes.len() > 1 << 16 { (spot * bytes.len()) >> 16 } else { spot % bytes.len() };
    let run = at..bytes.len().min(at + usize::from(with) + 1);
    let word = WORDS[usize::from(with) % WORDS.len()].bytes();
    match what % 10 {
        0 => bytes[at] = with,
        1 => bytes[at] ^= 1 << (with % 8),
        2 => drop(bytes.drain(run)),
        3 => {
            let copy = bytes[run].to_vec();
            bytes.splice(at..at, copy);
        }
        4 => bytes.truncate(at),
        5 => drop(bytes.splice(at..at, word)),
        6 => {
            let token = token(bytes, at);
            bytes.splice(token, word);
        }
        7 => bytes[run].fill(if with % 2 == 0 { 0 } else { 0xff }),
        8 => {
            let line = line(bytes, at);
            bytes.drain(line);
        }
        _ => {
            let line = line(bytes, at);
            let copy = bytes[line].to_vec();
            bytes.splice(at..at, copy);
        }
    }
}

/// The word or number around a place.
fn token(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let inner = |b: &u8| b.is_ascii_alphanumeric() || b"._-+".contains(b);
    let start = bytes[..at].iter().rposition(|b| !inner(b)).map_or(0, |k| k + 1);
    let end = bytes[at..].iter().position(|b| !inner(b)).map_or(bytes.len(), |k| at + k);
    start..end.max(start)
}

/// The line around a place.
fn line(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let start = bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |k| k + 1);
    let end = bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |k| at + k + 1);
    start..end.max(start)
}
