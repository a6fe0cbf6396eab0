//! The files of the tree that the gates read, as pairs of a name below the root and a text.

use crate::source::{product, test_modules};
use cullet_tests::{files, root};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::sync::LazyLock;

/// The name of a file below the root, and what it says.
pub(crate) type NamedText = (String, String);

/// Every Rust file of the tree.
pub(crate) fn sources() -> &'static [NamedText] {
    static ALL: LazyLock<Vec<NamedText>> = LazyLock::new(|| read(&[".rs"]));
    &ALL
}

/// The code of all that ships.
pub(crate) fn products() -> &'static [NamedText] {
    static ALL: LazyLock<Vec<NamedText>> = LazyLock::new(|| shipped(sources()));
    &ALL
}

/// Every file of the tree whose name ends in one of `endings`.
pub(crate) fn read(endings: &[&str]) -> Vec<NamedText> {
    let root = root();
    let named = files(&root, endings).into_iter().filter_map(|path| {
        let text = fs::read_to_string(&path).ok()?;
        let name = path.strip_prefix(&root).expect("below the root");
        Some((name.to_string_lossy().replace('\\', "/"), text))
    });
    named.collect()
}

/// The code of those files that ship: of `src` folders, without modules that only tests compile.
pub(crate) fn shipped(sources: &[NamedText]) -> Vec<NamedText> {
    let in_crate = |name: &str| {
        let of_tests = name.ends_with("/tests.rs") || name.contains("/tests/");
        !of_tests && (name.starts_with("proto/src/") || crate_of(name).is_some())
    };
    let inside: Vec<_> = sources.iter().filter(|(name, _)| in_crate(name)).collect();
    let of_tests: BTreeSet<String> = inside
        .iter()
        .flat_map(|(name, text)| {
            let folder = folder_of_children(name);
            test_modules(text).into_iter().map(move |module| format!("{folder}/{module}"))
        })
        .collect();
    let ships = |name: &str| {
        !of_tests.iter().any(|module| {
            name.strip_prefix(module.as_str())
                .is_some_and(|rest| rest == ".rs" || rest.starts_with('/'))
        })
    };
    let ours = inside.into_iter().filter(|(name, _)| ships(name));
    ours.map(|(name, text)| (name.clone(), product(text))).collect()
}

/// The folder of the crate that a source file below `src` is of.
pub(crate) fn crate_of(name: &str) -> Option<&str> {
    let (folder, _) = name.split_once("/src/")?;
    (folder == "proto" || folder.starts_with("services/")).then_some(folder)
}

/// The folder that holds the modules which a file declares.
fn folder_of_children(name: &str) -> &str {
    let stem = name.strip_suffix(".rs").unwrap_or(name);
    let parent = stem.rsplit_once('/').map_or("", |(folder, _)| folder);
    let is_parent = ["/mod", "/lib", "/main"].iter().any(|end| stem.ends_with(end));
    if is_parent { parent } else { stem }
}

/// What is wrong with a list of what a gate allows for now, lines of a key and a number, where
/// `found` is what there is. It may only become shorter.
pub(crate) fn check_list(
    (file, list): (&str, &str),
    found: &BTreeMap<String, usize>,
    complaint: &str,
) -> Vec<String> {
    let known: BTreeMap<&str, usize> = list
        .lines()
        .filter_map(|line| line.rsplit_once(' '))
        .map(|(key, number)| (key, number.parse().expect("a number at the end of the line")))
        .collect();
    let new = found.iter().filter_map(|(key, &count)| {
        let allowed = known.get(key.as_str()).copied().unwrap_or(0);
        let text = format!("{key} {count}: {complaint} ({file} allows {allowed})");
        (count > allowed).then_some(text)
    });
    let gone = known.iter().filter_map(|(key, &allowed)| match found.get(*key) {
        None => Some(format!("take the line `{key} {allowed}` out of {file}")),
        Some(&count) if count < allowed => {
            Some(format!("the line `{key} {allowed}` of {file} is `{key} {count}` now"))
        }
        Some(_) => None,
    });
    new.chain(gone).collect()
}

/// Fails with all that a gate has found.
#[track_caller]
pub(crate) fn assert_none(faults: &[String]) {
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

/// Files that a test makes up.
pub(crate) fn planted<const N: usize>(files: [(&str, &str); N]) -> Vec<NamedText> {
    files.map(|(name, text)| (name.to_owned(), text.to_owned())).to_vec()
}

#[test]
fn modules_of_tests_do_not_ship() {
    let files = planted([
        ("services/a/src/lib.rs", "#[cfg(test)]\nmod sim;\nmod b;"),
        ("services/a/src/sim.rs", "fn f() {}"),
        ("services/a/src/sim/deep.rs", "fn f() {}"),
        ("services/a/src/b.rs", "#[cfg(test)]\nmod c;"),
        ("services/a/src/b/c.rs", "fn f() {}"),
        ("services/a/src/c.rs", "fn f() {} // why"),
        ("services/a/src/tests.rs", "fn f() {}"),
        ("services/a/tests/d.rs", "fn f() {}"),
        ("services/a/build.rs", "fn f() {}"),
    ]);
    let ships = shipped(&files);
    let names: Vec<_> = ships.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["lib", "b", "c"].map(|stem| format!("services/a/src/{stem}.rs")));
    assert_eq!(ships[2].1, "fn f() {}");
}

#[test]
fn lists_become_shorter_only() {
    let found = [("a b", 2), ("c", 1), ("d", 1)].map(|(key, count)| (key.to_owned(), count)).into();
    let list = ("list.txt", "a b 3\nc 1\ngone 4");
    assert_eq!(
        check_list(list, &found, "too many"),
        [
            "d 1: too many (list.txt allows 0)",
            "the line `a b 3` of list.txt is `a b 2` now",
            "take the line `gone 4` out of list.txt",
        ]
    );
    assert_eq!(check_list(("list.txt", "a b 2\nc 1\nd 1"), &found, "too many"), [""; 0]);
}
