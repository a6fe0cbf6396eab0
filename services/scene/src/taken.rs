//! Items of a document, read as far as they are right.

use super::context::ResolveContext;
use cullet_document::tree::{Node, Path, Step, below};
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;

/// An item of a document.
pub(super) struct Taken<T> {
    /// What it says; without those of its values that are wrong by themselves.
    pub(super) value: T,
    /// Whether it lacks none. Of one that lacks some no body is made: it is only looked at, so that
    /// all that is wrong with it is said at once.
    pub(super) whole: bool,
}

impl ResolveContext<'_> {
    /// Reads an item. Nothing where too little of it is left; why is noted, unless it was already.
    pub(super) fn take<T: DeserializeOwned>(
        &mut self,
        node: &Node,
        at: &[Step],
    ) -> Option<Taken<T>> {
        if self.files.is_stopped() {
            return None;
        }
        let Some(deepest) = below(&self.bad, at).map(Vec::len).max() else {
            return match T::deserialize(node.to_toml()) {
                Ok(value) => Some(Taken { value, whole: true }),
                Err(error) => {
                    self.wrong(at, error.message().trim());
                    None
                }
            };
        };
        // Without the wrong values, or else without what these lie under, as little as will do.
        let without = |depth: usize| {
            let cut = |bad: &Path| bad[..bad.len().min(depth)].to_vec();
            let bad: BTreeSet<Path> = below(&self.bad, at).map(cut).collect();
            T::deserialize(node.to_toml_without(at, &bad)?).ok()
        };
        let mut left = (at.len() + 1..=deepest).rev().filter_map(without);
        left.next().map(|value| Taken { value, whole: false })
    }

    /// Whether a value is wrong by itself, or something below it.
    pub(super) fn is_bad(&self, path: &[Step]) -> bool {
        self.lies_in_bad(path) || below(&self.bad, path).next().is_some()
    }

    /// Whether a value is wrong by itself, or something that it is a part of.
    pub(super) fn lies_in_bad(&self, path: &[Step]) -> bool {
        (0..=path.len()).any(|length| self.bad.contains(&path[..length]))
    }
}
