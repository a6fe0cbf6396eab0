//! Where in a text something is written.

use std::ops::Range;
use std::sync::Arc;

/// A text that values came from: a file, or one `--set` argument.
#[derive(Debug, PartialEq, Eq)]
pub struct Text {
    /// How the text is called in messages.
    pub label: String,
    /// Prefix of file names that are relative to this text: its folder's key (see `files`).
    pub base: String,
    /// Its characters.
    pub content: String,
}

/// A range of bytes in a source text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceSpan {
    /// Which text.
    pub text: Arc<Text>,
    /// Byte range in it.
    pub range: Range<usize>,
}
