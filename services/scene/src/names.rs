//! Names of a scene: which there are, and whether what names a body names one that is there.

use super::body_names::BodyNames;
use super::directed;
use super::directions::SceneDirections;
use super::resolve::{Builder, MAX_NAME};
use super::scene::SceneBody;
use cullet_document::error::nearest;
use cullet_document::tree::{Node, Path, join};
use std::collections::BTreeSet;

/// The lists whose items make many bodies.
const GENERATORS: [&str; 4] = ["grid", "stack", "scatter", "instances"];

impl Builder<'_> {
    /// Names are unique, not too long, and expectations name what is there.
    pub(super) fn names(&mut self) {
        let mut known: BTreeSet<String> = BTreeSet::new();
        for list in ["body", "grid", "stack", "scatter", "instances", "sheet"] {
            for (index, node) in self.context.root.items(list).iter().enumerate() {
                let path: Path = vec![list.into(), index.into(), "name".into()];
                let Some(name) = node.get("name").and_then(Node::text) else {
                    continue;
                };
                if !is_name(name) {
                    let message = format!("a name has 1 to {MAX_NAME} bytes and no slash");
                    self.context.wrong(&path, message);
                } else if !known.insert(name.to_owned()) {
                    self.context.wrong(&path, format!("a second one is called \"{name}\""));
                }
            }
        }
        let written = known.clone();
        for (body, path) in self.bodies.iter().zip(&self.paths) {
            if body.generator.is_some() && !known.insert(body.name.clone()) {
                let message = format!("makes a second body called \"{}\"", body.name);
                self.context.wrong(path, message);
                break;
            }
        }
        self.group_names(&known);
        self.expected_names(&known, &written);
    }

    /// Bodies that could not be made, of those that are written.
    pub(super) fn lost(&self, bodies: &[SceneBody]) -> LostBodies {
        let made: BTreeSet<&str> =
            bodies.iter().filter_map(|body| body.generator.as_deref()).collect();
        let name = |item: &Node| item.get("name").and_then(Node::text).map(str::to_owned);
        let lists = GENERATORS.into_iter();
        let generators = lists.flat_map(|list| self.context.root.items(list)).map(name);
        let there = |name: &Option<String>| name.as_ref().is_some_and(|it| made.contains(&it[..]));
        let single: Vec<Option<String>> =
            self.context.root.items("body").iter().map(name).collect();
        let whole = bodies.iter().map(|body| body.name.as_str());
        let soft = self.moving.iter().map(|body| body.name.as_str());
        let known: BTreeSet<&str> = whole.chain(soft).collect();
        let is_lost = |name: &String| !known.contains(&name[..]) && !made.contains(&name[..]);
        LostBodies {
            any: single.iter().any(Option::is_none) || generators.clone().any(|it| it.is_none()),
            generators: generators.filter(|name| !there(name)).flatten().collect(),
            names: single.into_iter().flatten().filter(is_lost).collect(),
        }
    }

    fn expected_names(&mut self, known: &BTreeSet<String>, written: &BTreeSet<String>) {
        let expect = self.document.expect.clone();
        let lists = [("broken", &expect.broken), ("unbroken", &expect.unbroken)];
        let mut named: Vec<(Path, &String)> = Vec::new();
        for (key, list) in lists {
            for (index, name) in list.iter().enumerate() {
                named.push((vec!["expect".into(), key.into(), index.into()], name));
            }
        }
        for name in expect.min_fragments_of.keys() {
            let path = vec!["expect".into(), "min_fragments_of".into(), name.as_str().into()];
            named.push((path, name));
        }
        let lost = self.lost(&self.bodies);
        for (path, name) in named {
            if !known.contains(name) && !lost.covers(name) {
                let near = || nearest(name, written.iter().map(String::as_str));
                let near = self.context.advice(near);
                let help = near.map(|near| format!("did you mean `{near}`?"));
                let message = format!("there is no body \"{name}\"");
                self.context.wrong_with(&path, message, help);
            }
        }
    }

    /// Names of groups are no names of anything else.
    fn group_names(&mut self, known: &BTreeSet<String>) {
        let bodies = self.context.root.items("body").iter().enumerate();
        let single = bodies.map(|(index, node)| (vec!["body".into(), index.into()], node));
        let mut written: Vec<(Path, &Node)> = single.collect();
        for list in GENERATORS {
            for (index, node) in self.context.root.items(list).iter().enumerate() {
                let path: Path = vec![list.into(), index.into(), "body".into()];
                written.extend(node.get("body").map(|node| (path, node)));
            }
        }
        for (path, node) in written {
            let Some(name) = node.get("group").and_then(Node::text) else { continue };
            let path = join(&path, "group");
            if !is_name(name) {
                let message = format!("a name has 1 to {MAX_NAME} bytes and no slash");
                self.context.wrong(&path, message);
            } else if known.contains(name) {
                let message = format!("a body, generator or sheet is called \"{name}\"");
                self.context.wrong(&path, message);
            }
        }
    }

    /// Joints, glue and fields.
    pub(super) fn directions(&mut self) -> SceneDirections {
        let bodies = std::mem::take(&mut self.bodies);
        let lost = self.lost(&bodies);
        let soft = self.moving.iter().map(|body| body.name.clone());
        let unmade = |name: &str| lost.covers(name);
        let names = BodyNames::new(&bodies, soft, &unmade);
        let seed = self.document.world.seed;
        let found = directed::directions(&mut self.context, &bodies, &names, seed);
        self.bodies = bodies;
        found
    }
}

/// Whether a text can be a name.
fn is_name(name: &str) -> bool {
    !name.trim().is_empty() && name.len() <= MAX_NAME && !name.contains('/')
}

/// Bodies that are written and could not be made.
pub(super) struct LostBodies {
    /// Names of lists of bodies that are not there.
    generators: BTreeSet<String>,
    /// Names of single bodies.
    names: BTreeSet<String>,
    /// Whether any name may be one of theirs, because the name of one is not known.
    any: bool,
}

impl LostBodies {
    pub(super) fn covers(&self, name: &str) -> bool {
        let begins = name.char_indices().map(|(at, _)| &name[..at]).take(MAX_NAME + 1);
        let mut begins = begins.chain([name]);
        self.any
            || self.names.contains(name)
            || !self.generators.is_empty() && begins.any(|begin| self.generators.contains(begin))
    }
}
