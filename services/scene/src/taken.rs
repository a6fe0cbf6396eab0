//! Items of a document, read as far as they are right.

use super::context::ResolveContext;
use cullet_document::tree::{Node, Path, Step};
use serde::de::DeserializeOwned;

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
        if !self.bad.iter().any(|bad| bad.starts_with(at)) {
            return match T::deserialize(node.to_toml()) {
                Ok(value) => Some(Taken { value, whole: true }),
                Err(error) => {
                    self.wrong(at, error.message().trim());
                    None
                }
            };
        }
        // Without the wrong values, or else without what these lie under, as little as will do.
        let deepest = self.bad.iter().map(Vec::len).max().unwrap_or(0);
        let without = |depth: usize| {
            let bad: Vec<Path> =
                self.bad.iter().map(|bad| bad[..bad.len().min(depth)].to_vec()).collect();
            T::deserialize(node.to_toml_without(at, &bad)?).ok()
        };
        let mut left = (at.len() + 1..=deepest).rev().filter_map(without);
        left.next().map(|value| Taken { value, whole: false })
    }

    /// Whether a value is wrong by itself, or something below it.
    pub(super) fn is_bad(&self, path: &[Step]) -> bool {
        self.bad.iter().any(|bad| bad.starts_with(path) || path.starts_with(bad))
    }
}
