//! Places in the file.

use cullet_document::tree::{Path, Step};

pub(super) fn path(names: &[&str]) -> Path {
    names.iter().map(|name| (*name).into()).collect()
}

/// The path of an item of a list.
pub(super) fn item(list: &str, index: usize) -> Path {
    vec![Step::from(list), Step::from(index)]
}

/// The path of a key below another.
pub(super) fn below(path: &[Step], name: &str) -> Path {
    let mut longer = path.to_vec();
    longer.push(name.into());
    longer
}
