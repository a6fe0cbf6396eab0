//! A scene document as a tree in which every key and value knows where it was written.

use super::error::SceneError;
use super::origin::{SourceSpan, Text};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Bound, Range};
use std::sync::Arc;

/// Most errors of grammar that are counted: the place of each is looked for in the whole text.
const MAX_SYNTAX_ERRORS: usize = 200;

/// A table entry.
#[derive(Clone, Debug, PartialEq)]
pub struct TableEntry {
    /// Where the key stands.
    pub key: SourceSpan,
    /// What it holds.
    pub node: Node,
}

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Where the value comes from.
    pub origin: SourceSpan,
    /// The value itself.
    pub value: Value,
}

/// What a node holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Text in quotes.
    String(String),
    /// A whole number.
    Integer(i64),
    /// A number; may be infinite or not a number until it is checked.
    Float(f64),
    /// `true` or `false`.
    Boolean(bool),
    /// A date or time: no scene value is one, kept to be refused with its place.
    Date(String),
    /// A list.
    Array(Vec<Node>),
    /// Keys and values, sorted by key.
    Table(BTreeMap<String, TableEntry>),
}

impl Value {
    /// The word for this kind of value in messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::String(_) => "text",
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a number",
            Self::Boolean(_) => "true or false",
            Self::Date(_) => "a date",
            Self::Array(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

/// One step of a path into the tree.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// Into a table.
    Key(String),
    /// Into a list.
    Index(usize),
}

impl From<&str> for Step {
    fn from(key: &str) -> Self {
        Self::Key(key.to_owned())
    }
}

impl From<usize> for Step {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

/// A path from the root.
pub type Path = Vec<Step>;

/// `path` and one more step.
#[must_use]
pub fn join(path: &[Step], step: impl Into<Step>) -> Path {
    let mut longer = path.to_vec();
    longer.push(step.into());
    longer
}

/// Those of `paths` that lie at a path or below it. They stand side by side, so that finding them
/// costs nothing of the others.
pub fn below<'a>(paths: &'a BTreeSet<Path>, at: &'a [Step]) -> impl Iterator<Item = &'a Path> {
    let from = (Bound::Included(at), Bound::Unbounded);
    paths.range::<[Step], _>(from).take_while(move |path| path.starts_with(at))
}

/// A path as people write it: `body[2].shape.size`.
#[must_use]
pub fn show(path: &[Step]) -> String {
    let mut text = String::new();
    for step in path {
        match step {
            Step::Key(key) if text.is_empty() => text.push_str(key),
            Step::Key(key) => {
                text.push('.');
                text.push_str(key);
            }
            Step::Index(index) => text.push_str(&format!("[{index}]")),
        }
    }
    text
}

impl Node {
    /// An empty table that stands nowhere in particular in `text`.
    #[must_use]
    pub fn empty_table(text: &Arc<Text>) -> Self {
        let origin = SourceSpan { text: Arc::clone(text), range: 0..0 };
        Self { origin, value: Value::Table(BTreeMap::new()) }
    }

    /// The entries, where this is a table.
    #[must_use]
    pub fn table(&self) -> Option<&BTreeMap<String, TableEntry>> {
        match &self.value {
            Value::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The items, where this is a list.
    #[must_use]
    pub fn array(&self) -> Option<&[Node]> {
        match &self.value {
            Value::Array(items) => Some(items),
            _ => None,
        }
    }

    /// The text, where this is text.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        match &self.value {
            Value::String(text) => Some(text),
            _ => None,
        }
    }

    /// The value under `key`, where this is a table that has it.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.table()?.get(key).map(|entry| &entry.node)
    }

    /// The items of the list under `key`; none where there is no list.
    #[must_use]
    pub fn items(&self, key: &str) -> &[Node] {
        self.get(key).and_then(Node::array).unwrap_or(&[])
    }

    /// Whether there is anything at a path.
    #[must_use]
    pub fn has(&self, path: &[Step]) -> bool {
        let below = |node, step: &Step| match step {
            Step::Key(key) => Node::get(node, key),
            Step::Index(index) => node.array().and_then(|items| items.get(*index)),
        };
        path.iter().try_fold(self, below).is_some()
    }

    /// The place of the deepest step of `path` that exists.
    #[must_use]
    pub fn nearest(&self, path: &[Step]) -> &SourceSpan {
        let mut node = self;
        for step in path {
            let next = match step {
                Step::Key(key) => node.get(key),
                Step::Index(index) => node.array().and_then(|items| items.get(*index)),
            };
            match next {
                Some(next) => node = next,
                None => break,
            }
        }
        &node.origin
    }

    /// [`Node::to_toml`] without what is at `bad` paths; `at`: the path of this node. A list that
    /// lacks an item is left out, and nothing is left of a node that is bad itself.
    #[must_use]
    pub fn to_toml_without(&self, at: &[Step], bad: &BTreeSet<Path>) -> Option<toml::Value> {
        match below(bad, at).next() {
            // The shortest path comes first.
            Some(path) if path == at => return None,
            Some(_) => {}
            None => return Some(self.to_toml()),
        }
        match &self.value {
            Value::Array(items) => {
                let kept = items.iter().enumerate();
                let kept = kept.map(|(index, item)| item.to_toml_without(&join(at, index), bad));
                kept.collect::<Option<Vec<_>>>().map(toml::Value::Array)
            }
            Value::Table(table) => {
                let kept = table.iter().filter_map(|(key, entry)| {
                    let below = join(at, key.as_str());
                    Some((key.clone(), entry.node.to_toml_without(&below, bad)?))
                });
                Some(toml::Value::Table(kept.collect()))
            }
            _ => Some(self.to_toml()),
        }
    }

    /// The same data for serde, places dropped.
    #[must_use]
    pub fn to_toml(&self) -> toml::Value {
        match &self.value {
            Value::String(text) | Value::Date(text) => toml::Value::String(text.clone()),
            Value::Integer(number) => toml::Value::Integer(*number),
            Value::Float(number) => toml::Value::Float(*number),
            Value::Boolean(flag) => toml::Value::Boolean(*flag),
            Value::Array(items) => toml::Value::Array(items.iter().map(Node::to_toml).collect()),
            Value::Table(table) => toml::Value::Table(
                table.iter().map(|(key, entry)| (key.clone(), entry.node.to_toml())).collect(),
            ),
        }
    }
}

/// Names of the items of a document's lists, by which paths are told. They are looked at once for
/// all paths.
#[derive(Debug)]
pub struct ItemNames<'a> {
    /// By list: each item's name, where it has one that no other of the list has.
    lists: BTreeMap<&'a str, Vec<Option<&'a str>>>,
}

impl<'a> ItemNames<'a> {
    /// Those of the lists at the top of a tree.
    #[must_use]
    pub fn of(root: &'a Node) -> Self {
        let names = |items: &'a [Node]| {
            let name = |item: &'a Node| item.get("name").and_then(Node::text);
            let mut count: BTreeMap<&str, usize> = BTreeMap::new();
            items.iter().filter_map(name).for_each(|name| *count.entry(name).or_default() += 1);
            let alone = |name: &&str| count.get(name) == Some(&1);
            items.iter().map(|item| name(item).filter(alone)).collect()
        };
        let lists = root.table().into_iter().flatten();
        let lists = lists.filter_map(|(key, entry)| Some((&key[..], names(entry.node.array()?))));
        Self { lists: lists.collect() }
    }

    /// A path as `--set` takes it: `body.pot.shape` for `body[1].shape`, where the item has a name
    /// that no other one of its list has.
    #[must_use]
    pub fn tell(&self, path: &str) -> String {
        let item = || {
            let (list, rest) = path.split_once('[')?;
            let (index, rest) = rest.split_once(']')?;
            let name = (*self.lists.get(list)?.get(index.parse::<usize>().ok()?)?)?;
            let plain = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
            let numeric = name.bytes().all(|byte| byte.is_ascii_digit());
            let sound = !name.trim().is_empty() && !name.contains(['"', '\n']);
            let quote = if name.chars().all(plain) && !numeric { "" } else { "\"" };
            sound.then(|| format!("{list}.{quote}{name}{quote}{rest}"))
        };
        item().unwrap_or_else(|| path.to_owned())
    }
}

/// Reads TOML into a tree, going on after errors of grammar.
#[must_use]
pub fn parse(text: &Arc<Text>) -> (Node, Vec<SceneError>) {
    let (table, faults) = toml::de::DeTable::parse_recoverable(&text.content);
    let mut errors = Vec::new();
    for fault in faults.into_iter().take(MAX_SYNTAX_ERRORS) {
        let range = fault.span().unwrap_or(0..0);
        let origin = SourceSpan { text: Arc::clone(text), range };
        errors.push(SceneError::at(&origin, "", fault.message().trim().to_owned()));
    }
    let span = table.span();
    let node = convert_table(text, span, table.into_inner(), &mut errors);
    (node, errors)
}

fn convert_table(
    text: &Arc<Text>,
    range: Range<usize>,
    table: toml::de::DeTable<'_>,
    errors: &mut Vec<SceneError>,
) -> Node {
    let mut entries = BTreeMap::new();
    for (key, value) in table {
        let key_origin = SourceSpan { text: Arc::clone(text), range: key.span() };
        let node = convert(text, value, errors);
        entries.insert(key.into_inner().into_owned(), TableEntry { key: key_origin, node });
    }
    Node { origin: SourceSpan { text: Arc::clone(text), range }, value: Value::Table(entries) }
}

fn convert(
    text: &Arc<Text>,
    value: toml::Spanned<toml::de::DeValue<'_>>,
    errors: &mut Vec<SceneError>,
) -> Node {
    use toml::de::DeValue;
    let range = value.span();
    let origin = SourceSpan { text: Arc::clone(text), range: range.clone() };
    let value = match value.into_inner() {
        DeValue::String(string) => Value::String(string.into_owned()),
        DeValue::Boolean(flag) => Value::Boolean(flag),
        DeValue::Datetime(date) => Value::Date(date.to_string()),
        DeValue::Integer(number) => {
            let parsed = i64::from_str_radix(number.as_str(), number.radix());
            let message = || format!("{} does not fit 64 bits", number.as_str());
            Value::Integer(parsed.unwrap_or_else(|_| {
                errors.push(SceneError::at(&origin, "", message()));
                0
            }))
        }
        DeValue::Float(number) => {
            let parsed = number.as_str().parse::<f64>();
            Value::Float(parsed.unwrap_or_else(|_| {
                let message = format!("{} is not a number", number.as_str());
                errors.push(SceneError::at(&origin, "", message));
                0.0
            }))
        }
        DeValue::Array(items) => {
            let items = items.into_iter().map(|item| convert(text, item, errors));
            Value::Array(items.collect())
        }
        DeValue::Table(table) => return convert_table(text, range, table, errors),
    };
    Node { origin, value }
}
