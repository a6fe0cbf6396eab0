//! Where in a text something is written.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// A text that values came from: a file, or one `--set` argument.
#[derive(Debug)]
pub struct Text {
    /// How the text is called in messages.
    pub label: String,
    /// Prefix of file names that are relative to this text: its folder's key (see `files`).
    pub base: String,
    /// Its characters.
    pub content: String,
    /// At which byte each of its lines begins, once somebody asked.
    lines: OnceLock<Vec<usize>>,
}

impl Text {
    /// A text and what it is called.
    #[must_use]
    pub fn new(label: String, base: String, content: String) -> Self {
        Self { label, base, content, lines: OnceLock::new() }
    }

    /// The line that has this byte, from 0, and where that line begins. The first call reads the
    /// text, later ones look it up.
    pub(crate) fn line_at(&self, byte: usize) -> (usize, usize) {
        let lines = self.lines.get_or_init(|| {
            let ends = self.content.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
            std::iter::once(0).chain(ends.map(|(end, _)| end + 1)).collect()
        });
        let line = lines.partition_point(|begin| *begin <= byte) - 1;
        (line, lines[line])
    }
}

impl PartialEq for Text {
    fn eq(&self, other: &Self) -> bool {
        let Self { label, base, content, .. } = other;
        std::ptr::eq(self, other)
            || (&self.label, &self.base, &self.content) == (label, base, content)
    }
}

impl Eq for Text {}

/// A range of bytes in a source text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceSpan {
    /// Which text.
    pub text: Arc<Text>,
    /// Byte range in it.
    pub range: Range<usize>,
}
