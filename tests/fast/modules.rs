//! No circles among the modules of a crate: a type that children need is in a leaf, and a parent
//! only declares its children and names what is public.
//!
//! An edge leads from a module to each that it names by `crate::`, `super::`, `self::` or the name
//! of a child, in a `use` or elsewhere. A public re-export is followed to where the item is, and is
//! itself no edge to a child. Tests, comments and literals are left out.

use crate::source::{product, without_literals};
use cullet_tests::{files, root};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::ops::Range;

/// The modules that are in a circle today, a line each. It may only become shorter.
const KNOWN: &str = include_str!("circles.txt");

/// The path of a module below its crate, or of an item below its module.
type Path = Vec<String>;

/// What is looked at of a file: its code, without comments, literals and tests.
fn bare(text: &str) -> String {
    without_literals(&product(text))
}

/// The modules of a crate and what is looked at of each.
fn modules(folder: &str) -> BTreeMap<Path, String> {
    let base = root().join(folder).join("src");
    let mut found: BTreeMap<Path, String> = BTreeMap::new();
    for file in files(&base, &[".rs"]) {
        let place = file.strip_prefix(&base).expect("below it").with_extension("");
        let mut path: Path = place.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        path.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
        let text = fs::read_to_string(&file).expect("a source file is readable");
        // A library and its program are both the root.
        *found.entry(path).or_default() += &bare(&text);
    }
    without_tests(&found)
}

/// The modules that are declared for more than tests, as all modules above them are.
fn without_tests(all: &BTreeMap<Path, String>) -> BTreeMap<Path, String> {
    let declared = |path: &[String]| {
        let Some((name, above)) = path.split_last() else { return true };
        all.get(above).is_some_and(|code| code.contains(&format!("mod {name};")))
    };
    let shipped = |path: &Path| (0..=path.len()).all(|n| declared(&path[..n]));
    all.iter().filter(|(path, _)| shipped(path)).map(|(a, b)| (a.clone(), b.clone())).collect()
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

/// Where the imports of a module are, from `use` to the semicolon.
fn statements(code: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    for statement in code.split(';') {
        let end = start + statement.len();
        let import = statement.rfind("use ").filter(|&at| {
            let before = statement[..at].chars().next_back();
            before.is_none_or(char::is_whitespace) && !statement[at..].contains(['=', '('])
        });
        found.extend(import.map(|at| start + at..end));
        start = end + 1;
    }
    found
}

/// The imports of a module, and whether each is public.
fn imports(code: &str) -> Vec<(bool, Path)> {
    let mut found = Vec::new();
    for statement in statements(code) {
        let line = code[..statement.start].rsplit('\n').next().unwrap_or("");
        for path in paths(&code[statement.start + 4..statement.end]) {
            found.push((line.trim_start().starts_with("pub"), path));
        }
    }
    found
}

/// Paths outside imports that begin with `crate`, `super`, `self` or one of these children.
fn mentions(code: &str, children: &[&str]) -> Vec<Path> {
    let imported = statements(code);
    let mut found = Vec::new();
    for head in ["crate", "super", "self"].iter().chain(children) {
        for (at, _) in code.match_indices(&format!("{head}::")) {
            let before = &code[..at];
            let inside = before.ends_with(|c: char| c.is_alphanumeric() || "_:$".contains(c));
            // A method of the name of a child, `a.child::<T>()`; but `0..child::MAX` is a range.
            let method = before.ends_with('.') && !before.ends_with("..");
            if inside || method || imported.iter().any(|import| import.contains(&at)) {
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
        // What a public import names of a child is followed to where it is.
        let upward = |path: &Path| ["crate", "super"].contains(&path[0].as_str());
        let imported = imports(code).into_iter();
        let imported = imported.filter(|(public, path)| !public || upward(path));
        let below = all.keys().filter(|path| path.len() == here.len() + 1);
        let children = below.filter(|path| path.starts_with(here)).filter_map(|path| path.last());
        let children: Vec<&str> = children.map(String::as_str).collect();
        let named = imported.map(|(_, path)| path).chain(mentions(code, &children));
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

/// The modules that reach themselves.
fn circles(all: &BTreeMap<Path, String>) -> Vec<&Path> {
    let edges = graph(all);
    all.keys().filter(|module| reached(&edges, module).contains(module)).collect()
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
        for module in circles(&all) {
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
    assert_eq!(mentions("crate::x::y(mycrate::z, super::w)", &[]).len(), 2);
}

/// The modules in circles of a crate of these modules, each given by its path and its text.
fn planted(modules: &[(&str, &str)]) -> Vec<String> {
    let path = |path: &str| match path {
        "" => Vec::new(),
        _ => path.split("::").map(str::to_owned).collect(),
    };
    let all = modules.iter().map(|(name, text)| (path(name), bare(text))).collect();
    circles(&without_tests(&all)).iter().map(|path| path.join("::")).collect()
}

/// The circles of a crate with a parent of this text and a child that uses a type of the parent.
fn planted_parent(text: &str) -> Vec<String> {
    let child = "use super::T;\npub fn f() -> T { T }";
    let parent = format!("mod child;\npub struct T;\n{text}");
    planted(&[("", "mod parent;"), ("parent", &parent), ("parent::child", child)])
}

#[test]
fn a_parent_that_names_its_child_is_in_a_circle_with_it() {
    for text in [
        "fn g() { child::f(); }",
        "fn g() { self::child::f(); }",
        "struct S(child::U);",
        "fn g(x: &[child::U]) {}",
        "use child::f;",
        "fn g() { use self::child::f; }",
        "const ALL: Range<u32> = 0..child::MAX;",
        "#[cfg(test)]\nuse a::{B, C};\nfn g() { child::f(); }",
        "#[cfg(test)]\nmod tests { const A: [char; 2] = ['}', '\\'']; }\nfn g() { child::f(); }",
        "#[cfg(test)]\nmod tests { const A: &str = \"}\"; }\nfn g() { child::f(); }",
        "struct S<'a> {\n#[cfg(test)]\npub a: B<C, D>,\nb: &'a child::U }",
        "const QUOTE: char = '\"'; fn g() { child::f(); } // \"",
    ] {
        assert_eq!(planted_parent(text), ["parent", "parent::child"], "{text}");
    }
}

#[test]
fn a_parent_that_only_declares_its_child_is_in_no_circle() {
    for text in [
        "",
        "pub use child::f;",
        "pub(crate) use self::child::{f, g as h};",
        "fn g(x: X) { x.child::<T>(); }",
        "fn g() { grandchild::f(); a::child::f(); }",
        "fn g() { g(); } // child::f()",
        "/* child::f() */",
        "const A: &str = \"child::f()\";",
        "const A: &str = r#\"\" child::f()\"#;",
        "#[cfg(test)]\nfn g<A, B>() { child::f(); }",
        "struct S {\n#[cfg(test)]\na: child::U,\nb: A }",
        "#[cfg(test)]\nmod tests { fn g() { child::f(); } }",
    ] {
        assert_eq!(planted_parent(text), [""; 0], "{text}");
    }
}

#[test]
fn a_public_import_is_followed_and_a_module_of_tests_is_left_out() {
    let parent = ("", "mod a;\nmod b;\npub use a::A;\npub use b::B;");
    let (a, b) = (("a", "use super::B;\npub struct A(B);"), ("b", "pub struct B;"));
    assert_eq!(planted(&[parent, a, b]), [""; 0]);
    let round = ("b", "pub struct B(Box<crate::A>);");
    assert_eq!(planted(&[parent, a, round]), ["a", "b"]);
    let declared = "#[cfg(test)]\nmod a;\n#[cfg(test)]\nmod b;\npub use a::A;\npub use b::B;";
    let parent = ("", declared);
    assert_eq!(planted(&[parent, a, round]), [""; 0]);
}
