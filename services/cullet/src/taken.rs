//! Which folders have a run already.

use cullet_pool::Fetching;
use cullet_run::RESULTS;
use std::path::Path;

/// What says that a folder holds a run or a sweep, whole or not.
const SIGNS: [&str; 5] = ["run.mcap", "run.mcap.partial", RESULTS, "table.csv", "1/run.mcap"];

/// Whether a folder holds a run or a sweep, whole or not: nothing else is recorded there.
#[must_use]
pub fn is_taken(folder: &Path) -> bool {
    SIGNS.iter().any(|name| folder.join(name).exists())
}

/// Whether a run may be fetched into a folder: one that holds none, or in which a fetch was broken
/// off, which goes on there.
#[must_use]
pub fn is_free_to_fetch(folder: &Path) -> bool {
    Fetching::is_in(folder) || !is_taken(folder)
}

#[cfg(test)]
mod tests {
    use super::{Fetching, is_free_to_fetch, is_taken};
    use std::fs;

    #[test]
    fn a_folder_with_a_run_or_a_sweep_is_taken() {
        for (name, taken) in [
            ("run.mcap", true),
            ("run.mcap.partial", true),
            ("results", true),
            ("table.csv", true),
            ("1/run.mcap", true),
            ("notes", false),
        ] {
            let folder = tempfile::tempdir().expect("a folder");
            fs::create_dir(folder.path().join("1")).expect("a folder");
            fs::write(folder.path().join(name), "").expect("a file");
            assert_eq!(is_taken(folder.path()), taken, "{name}");
            assert_eq!(is_free_to_fetch(folder.path()), !taken, "{name}");
            drop(Fetching::begin(folder.path(), "run 1").expect("it begins"));
            assert!(is_free_to_fetch(folder.path()), "{name}: a fetch was broken off there");
        }
    }
}
