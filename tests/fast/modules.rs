//! No circles among the modules of a crate: a type that children need is in a leaf, and a parent
//! only declares its children and names what is public.
//!
//! An edge leads from a module to each that it names by `crate::`, `super::`, `self::` or the name
//! of a child, in a `use` or elsewhere. A public re-export is followed to where the item is. Tests
//! are left out.

use cullet_tests::{files, root};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// The modules that are in a circle today, a line each. It may only become shorter.
const KNOWN: &str = include_str!("circles.txt");

/// The path of a module below its crate, or of an item below its module.
type Path = Vec<String>;

/// The modules of a crate: their code, without comments and tests.
fn modules(folder: &str) -> BTreeMap<Path, String> {
    let base = root().join(folder).join("src");
    let mut found = BTreeMap::new();
    for file in files(&base, &[".rs"]) {
        let place = file.strip_prefix(&base).expect("below it").with_extension("");
        let mut path: Path = place.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        path.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
        if path.iter().any(|part| part == "tests") {
            continue;
        }
        let text = fs::read_to_string(&file).expect("a source file is readable");
        let end = text.find("#[cfg(test)]\nmod tests {").unwrap_or(text.len());
        let code = |line: &str| line.split("//").next().unwrap_or("").to_owned();
        // A library and its program are both the root.
        let all: &mut String = found.entry(path).or_default();
        text[..end].lines().map(code).for_each(|line| *all += &(line + "\n"));
    }
    found
}

/// The paths of a tree of imports such as `crate::a::{self, b::{C, D as E}}`.
fn paths(tree: &str) -> Vec<Path> {
    let tree = tree.trim();
    let Some((before, inner)) = tree.strip_suffix('}').and_then(|tree| tree.split_once('{')) else {
        let path = tree.split(" as ").next().unwrap_or(tree);
        return vec![path.split("::").map(|part| part.trim().to_owned()).collect()];
    };
    let prefix: Path = before.split("::").map(|part| part.trim().to_owned()).collect();
    let prefix: Path = prefix.into_iter().filter(|part| !part.is_empty()).collect();
    let (mut depth, mut start, mut found) = (0, 0, Vec::new());
    for (at, c) in inner.char_indices().chain([(inner.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let item = inner[start..at].trim();
                start = at + 1;
                for path in paths(item).iter().filter(|_| !item.is_empty()) {
                    let below = if *path == ["self"] { &[] } else { &path[..] };
                    found.push([&prefix, below].concat());
                }
            }
            _ => {}
        }
    }
    found
}

/// The imports of a module, and whether each is public.
fn imports(code: &str) -> Vec<(bool, Path)> {
    let mut found = Vec::new();
    for statement in code.split(';') {
        let start = statement.rfind("use ").filter(|&at| {
            let before = statement[..at].chars().next_back();
            before.is_none_or(char::is_whitespace) && !statement[at..].contains(['=', '('])
        });
        let Some(at) = start else { continue };
        let line = statement[..at].rsplit('\n').next().unwrap_or("");
        for path in paths(&statement[at + 4..]) {
            found.push((line.trim_start().starts_with("pub"), path));
        }
    }
    found
}

/// Paths in code that begin with `crate` or `super`.
fn mentions(code: &str) -> Vec<Path> {
    let mut found = Vec::new();
    for head in ["crate::", "super::"] {
        for (at, _) in code.match_indices(head) {
            let before = code[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || "_:$".contains(c)) {
                continue;
            }
            let word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
            let end = code[at..].find(|c| !word(c)).map_or(code.len(), |end| at + end);
            let path = code[at..end].trim_end_matches(':');
            found.push(path.split("::").map(str::to_owned).collect());
        }
    }
    found
}

/// Where a path that is written in a module leads, from the root of its crate.
fn absolute(here: &Path, path: &Path, all: &BTreeMap<Path, String>) -> Option<Path> {
    let mut at = here.clone();
    let mut rest = &path[..];
    match rest.first().map(String::as_str)? {
        "crate" => {
            at.clear();
            rest = &rest[1..];
        }
        "self" => rest = &rest[1..],
        "super" => {
            while rest.first().is_some_and(|part| part == "super") {
                at.pop();
                rest = &rest[1..];
            }
        }
        child => {
            let child: Path = here.iter().cloned().chain([child.to_owned()]).collect();
            all.contains_key(&child).then_some(())?;
        }
    }
    at.extend(rest.iter().cloned());
    Some(at)
}

/// Who names whom.
fn graph(all: &BTreeMap<Path, String>) -> BTreeMap<&Path, BTreeSet<&Path>> {
    let mut elsewhere: BTreeMap<Path, Path> = BTreeMap::new();
    for (here, code) in all {
        for (_, path) in imports(code).into_iter().filter(|(public, _)| *public) {
            let name: Path = here.iter().cloned().chain(path.last().cloned()).collect();
            if let Some(place) = absolute(here, &path, all).filter(|_| !all.contains_key(&name)) {
                elsewhere.insert(name, place);
            }
        }
    }
    let follow = |mut path: Path| {
        // As deep as re-exports of re-exports go, and a bound on those that go round.
        for _ in 0..8 {
            let Some(n) = (1..=path.len()).rev().find(|&n| elsewhere.contains_key(&path[..n]))
            else {
                break;
            };
            path = elsewhere[&path[..n]].iter().chain(&path[n..]).cloned().collect();
        }
        path
    };
    let mut edges: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
    for (here, code) in all {
        let private = imports(code).into_iter().filter(|(public, _)| !public);
        let named = private.map(|(_, path)| path).chain(mentions(code));
        for path in named.filter_map(|path| absolute(here, &path, all)).map(follow) {
            let owner = (0..=path.len()).rev().find_map(|n| all.get_key_value(&path[..n]));
            if let Some((owner, _)) = owner.filter(|(owner, _)| *owner != here) {
                edges.entry(here).or_default().insert(owner);
            }
        }
    }
    edges
}

/// All that can be reached from a module.
fn reached<'a>(
    edges: &BTreeMap<&'a Path, BTreeSet<&'a Path>>,
    from: &'a Path,
) -> BTreeSet<&'a Path> {
    let mut found = BTreeSet::new();
    let mut open = vec![from];
    while let Some(module) = open.pop() {
        for next in edges.get(module).into_iter().flatten() {
            if found.insert(*next) {
                open.push(next);
            }
        }
    }
    found
}

#[test]
fn circles_of_modules_become_fewer() {
    let mut found = BTreeSet::new();
    let manifests = files(&root(), &["Cargo.toml"]);
    for manifest in manifests {
        let folder = manifest.parent().and_then(|folder| folder.strip_prefix(root()).ok());
        let Some(folder) = folder.map(|folder| folder.to_string_lossy().replace('\\', "/")) else {
            continue;
        };
        if !(folder.starts_with("services/") || folder == "proto") {
            continue;
        }
        let all = modules(&folder);
        let edges = graph(&all);
        for module in all.keys().filter(|module| reached(&edges, module).contains(module)) {
            found.insert(format!("{folder} {}", module.join("::")).trim_end().to_owned());
        }
    }
    let known: BTreeSet<String> = KNOWN.lines().map(str::to_owned).collect();
    let new: Vec<_> = found.difference(&known).collect();
    assert!(new.is_empty(), "in a circle, and not on the list: {new:#?}");
    let gone: Vec<_> = known.difference(&found).collect();
    assert!(gone.is_empty(), "in no circle any more: take from tests/fast/circles.txt {gone:#?}");
}

#[test]
fn imports_are_taken_apart() {
    let code =
        "pub use a::{self, b::{C, D as E}};\nfn f() { x(); }\nuse super::g;\nlet because = 1;";
    let flat = |path: &Path| path.join("::");
    let found: Vec<_> = imports(code).iter().map(|(public, path)| (*public, flat(path))).collect();
    let wanted = [(true, "a"), (true, "a::b::C"), (true, "a::b::D"), (false, "super::g")];
    assert_eq!(found, wanted.map(|(public, path)| (public, path.to_owned())));
    assert_eq!(mentions("crate::x::y(mycrate::z, super::w)").len(), 2);
}
