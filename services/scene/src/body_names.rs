//! Names of bodies, as what directs a shot uses them.

use super::context::ResolveContext;
use super::scene::SceneBody;
use cullet_document::error::nearest;
use cullet_document::tree::{Path, join};
use std::collections::{BTreeMap, BTreeSet};

/// Which bodies a name means: itself, those that a generator made, those of a group.
pub(super) struct BodyNames<'a> {
    known: BTreeMap<&'a str, Vec<usize>>,
    /// Names of what moves as it deforms.
    soft: BTreeSet<String>,
    /// Whether a name that is not known may be that of a body that could not be made.
    unmade: &'a dyn Fn(&str) -> bool,
}

impl<'a> BodyNames<'a> {
    pub(super) fn new(
        bodies: &'a [SceneBody],
        soft: impl Iterator<Item = String>,
        unmade: &'a dyn Fn(&str) -> bool,
    ) -> Self {
        let mut known: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (index, body) in bodies.iter().enumerate() {
            let names = [Some(&body.name), body.generator.as_ref(), body.group.as_ref()];
            for name in names.into_iter().flatten() {
                let of = known.entry(name).or_default();
                if of.last() != Some(&index) {
                    of.push(index);
                }
            }
        }
        Self { known, soft: soft.collect(), unmade }
    }

    /// The bodies of some names, each once, rising; what is wrong with a name is noted below
    /// `path`. A name that is there twice is looked up once.
    pub(super) fn all(
        &self,
        context: &mut ResolveContext<'_>,
        names: &[String],
        path: &Path,
    ) -> BTreeSet<usize> {
        let (mut found, mut seen) = (BTreeSet::new(), BTreeSet::new());
        for (index, name) in names.iter().enumerate().filter(|(_, name)| seen.insert(*name)) {
            match self.known.get(name.as_str()) {
                Some(bodies) => found.extend(bodies),
                None => self.unknown(context, name, &join(path, index)),
            }
        }
        found
    }

    /// Whether there is a body of that name.
    pub(super) fn knows(&self, name: &str) -> bool {
        self.known.contains_key(name)
    }

    /// The one body of a name.
    pub(super) fn one(
        &self,
        context: &mut ResolveContext<'_>,
        name: &str,
        path: &Path,
    ) -> Option<usize> {
        match self.known.get(name).map(Vec::as_slice) {
            Some([one]) => return Some(*one),
            Some(many) => {
                let count = many.len();
                let message = format!("a joint takes one body; \"{name}\" are {count}");
                context.wrong(path, message);
            }
            None => self.unknown(context, name, path),
        }
        None
    }

    /// Notes that there is no rigid body of that name.
    pub(super) fn unknown(&self, context: &mut ResolveContext<'_>, name: &str, path: &Path) {
        if self.soft.contains(name) {
            let message = format!("\"{name}\" is not rigid: it moves as it deforms");
            context.wrong(path, message);
        } else if !(self.unmade)(name) {
            let near = context.advice(|| nearest(name, self.known.keys().copied()));
            let help = near.map(|near| format!("did you mean `{near}`?"));
            context.wrong_with(path, format!("there is no body \"{name}\""), help);
        }
    }
}
