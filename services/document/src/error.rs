//! Errors of a scene: all of them at once, each with its place, its value and its bound.

use super::origin::SourceSpan;
use std::fmt;
use std::ops::Range;

/// Most errors shown by `Display`; the rest are counted. More lines than this help nobody.
const MAX_SHOWN: usize = 20;

/// Longest source line shown \[characters\]; longer ones are cut so that a minified file stays
/// readable.
const MAX_LINE: usize = 160;

/// A place in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourcePlace {
    /// The file, or the `--set` argument.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Length in characters on that line, at least 1.
    pub width: usize,
    /// Byte range in the whole text.
    pub range: Range<usize>,
    /// That line of the text, cut where it is too long to be read.
    pub text: String,
}

impl SourcePlace {
    fn of(origin: &SourceSpan) -> Self {
        let content = &origin.text.content;
        let start = floor_boundary(content, origin.range.start);
        let end = floor_boundary(content, origin.range.end).max(start);
        let (line, line_start) = origin.text.line_at(start);
        let line_end = content[start..].find('\n').map_or(content.len(), |at| start + at);
        let shown_end = end.min(line_end);
        let shown = content[line_start..line_end].trim_end_matches('\r');
        Self {
            file: origin.text.label.clone(),
            line: line + 1,
            column: content[line_start..start].chars().count() + 1,
            width: content[start..shown_end.max(start)].chars().count().max(1),
            range: start..end,
            text: shown.chars().take(MAX_LINE).collect(),
        }
    }
}

fn floor_boundary(text: &str, index: usize) -> usize {
    let mut index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}

/// What kind of thing is wrong with a scene, for code that goes by it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SceneErrorKind {
    /// What is there does not hold.
    #[default]
    Wrong,
    /// A key that has to be there is not.
    Missing,
    /// All was read, and no body can be made of it or has room there.
    Geometry,
}

/// One thing that is wrong with a scene. Where it is gets worked out when somebody asks: a scene
/// may have a hundred thousand errors, of which twenty are shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    /// What of which text it is about, if it has a place in a text.
    pub origin: Option<SourceSpan>,
    /// Path of the value, as `--set` takes it; may be empty.
    pub path: String,
    /// What is wrong: the value and the bound.
    pub message: String,
    /// What could be meant instead.
    pub help: Option<String>,
    /// What kind of thing is wrong.
    pub kind: SceneErrorKind,
}

impl SceneError {
    /// An error at a place.
    #[must_use]
    pub fn at(origin: &SourceSpan, path: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            origin: Some(origin.clone()),
            path: path.into(),
            message: message.into(),
            help: None,
            kind: SceneErrorKind::Wrong,
        }
    }

    /// An error that has no place in a text: a file that cannot be read.
    #[must_use]
    pub fn without_place(message: impl Into<String>) -> Self {
        let (path, message) = (String::new(), message.into());
        Self { origin: None, path, message, help: None, kind: SceneErrorKind::Wrong }
    }

    /// Where it is, if it has a place in a text.
    #[must_use]
    pub fn place(&self) -> Option<SourcePlace> {
        self.origin.as_ref().map(SourcePlace::of)
    }

    /// The same, with advice.
    #[must_use]
    pub fn help(mut self, help: Option<impl Into<String>>) -> Self {
        self.help = help.map(Into::into);
        self
    }

    /// The same, of another kind.
    #[must_use]
    pub fn of_kind(self, kind: SceneErrorKind) -> Self {
        Self { kind, ..self }
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(place) = self.place() else {
            write!(out, "{}", self.message)?;
            return match &self.help {
                Some(help) => write!(out, "\n  help: {help}"),
                None => Ok(()),
            };
        };
        write!(out, "{}:{}:{}: ", place.file, place.line, place.column)?;
        if !self.path.is_empty() {
            write!(out, "{}: ", self.path)?;
        }
        writeln!(out, "{}", self.message)?;
        let shown = &place.text;
        let margin = place.line.to_string().len();
        write!(out, "  {} | {shown}", place.line)?;
        if place.column <= MAX_LINE {
            let pad: String = shown
                .chars()
                .take(place.column - 1)
                .map(|c| if c == '\t' { '\t' } else { ' ' })
                .collect();
            let marks = "^".repeat(place.width.min(MAX_LINE + 1 - place.column));
            write!(out, "\n  {:margin$} | {pad}{marks}", "")?;
        }
        match &self.help {
            Some(help) => write!(out, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

/// Everything that is wrong with a scene, in the order of the text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneErrors {
    /// At least one, when returned as an error.
    pub errors: Vec<SceneError>,
}

impl SceneErrors {
    /// Sorts by place, so that a reader meets them in the order of the file.
    #[must_use]
    pub fn sorted(mut errors: Vec<SceneError>) -> Self {
        let place = |error: &SceneError| {
            let origin = error.origin.clone();
            origin.map(|SourceSpan { text, range }| (text.label.clone(), range.start))
        };
        errors.sort_by_cached_key(place);
        errors.dedup();
        Self { errors }
    }
}

impl fmt::Display for SceneErrors {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.errors.iter().take(MAX_SHOWN).enumerate() {
            if index > 0 {
                writeln!(out)?;
            }
            write!(out, "{error}")?;
        }
        let hidden = self.errors.len().saturating_sub(MAX_SHOWN);
        if hidden > 0 {
            write!(out, "\nand {hidden} more")?;
        }
        Ok(())
    }
}

impl std::error::Error for SceneErrors {}

/// Words that people use for keys and names that are called otherwise here, and what those are for.
const ALIASES: [(&str, &str, &str); 14] = [
    ("camera", "view", "it says where pictures look from: eye, target, field"),
    ("cam", "view", "it says where pictures look from: eye, target, field"),
    ("object", "body", "a body is a [[body]]"),
    ("objects", "body", "a body is a [[body]]"),
    ("bodies", "body", "a body is a [[body]]"),
    ("simulation", "world", "it has gravity, step, duration and seed"),
    ("settings", "world", "it has gravity, step, duration and seed"),
    ("physics", "world", "it has gravity, step, duration and seed"),
    ("assert", "expect", "it says what the scene must show"),
    ("fov", "field", "an angle from bottom to top"),
    ("look_at", "target", "a point"),
    ("angular_velocity", "spin", "in rad/s, or with a unit"),
    ("timestep", "step", "in s, or with a unit"),
    ("dt", "step", "in s, or with a unit"),
];

/// Shortest word that is looked for inside names.
const SHORTEST_PART: usize = 3;

/// The name nearest to `word`, if it is near enough to be meant: at most a third of its letters are
/// other ones, and one of a short word.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    let most = (lower.chars().count() / 3).max(1);
    let near = known.into_iter().filter_map(|name| {
        let distance = strsim::osa_distance(&lower, &name.to_lowercase());
        (distance <= most && distance < name.chars().count()).then_some((distance, name))
    });
    near.min_by_key(|(distance, _)| *distance).map(|(_, name)| name)
}

/// Names that have the word in them, at most three.
fn with_part<'a>(word: &str, known: &[&'a str]) -> Vec<&'a str> {
    let lower = word.to_lowercase();
    if lower.chars().count() < SHORTEST_PART {
        return Vec::new();
    }
    let has = |name: &&&str| name.to_lowercase().contains(&lower);
    known.iter().filter(has).take(3).copied().collect()
}

/// Advice for an unknown name: the nearest one, those that it is a part of, or all of a short list.
#[must_use]
pub fn suggest(word: &str, known: &[&str]) -> Option<String> {
    let lower = word.to_lowercase();
    let other = ALIASES.iter().find(|(from, to, _)| *from == lower && known.contains(to));
    if let Some((_, name, what)) = other {
        return Some(format!("did you mean `{name}`? {what}"));
    }
    if let Some(name) = nearest(word, known.iter().copied()) {
        return Some(format!("did you mean `{name}`?"));
    }
    let longer = with_part(word, known);
    if !longer.is_empty() {
        return Some(format!("did you mean `{}`?", longer.join("` or `")));
    }
    if known.is_empty() {
        return None;
    }
    let shown: Vec<&str> = known.iter().take(20).copied().collect();
    let more = if known.len() > 20 { ", …" } else { "" };
    Some(format!("known: {}{more}", shown.join(", ")))
}
