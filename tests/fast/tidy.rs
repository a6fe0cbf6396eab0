//! The shape of the house: who may depend on whom, what a pure crate may not touch, sizes, and
//! documents that name real paths.

use cullet_tests::{files, root};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Crate folder and the Cullet crates that it may depend on, those lowest in the house first.
const MAY_USE: &[(&str, &[&str])] = &[
    ("proto", &["geometry", "model", "specimen"]),
    ("services/geometry", &[]),
    ("services/simd", &[]),
    ("services/dispatch", &[]),
    ("services/model", &["geometry"]),
    ("services/fragment", &["geometry", "model"]),
    ("services/specimen", &["geometry", "model"]),
    ("services/fracture", &["fragment", "geometry", "model", "simd", "specimen"]),
    ("services/continuum", &["geometry", "model", "simd"]),
    ("services/shell", &["continuum", "fragment", "geometry", "model", "simd", "specimen"]),
    ("services/peridynamics", &["continuum", "fragment", "geometry", "model", "simd", "specimen"]),
    ("services/membrane", &["continuum", "geometry", "model", "simd", "specimen"]),
    ("services/geometric", &["fragment", "geometry", "model"]),
    ("services/world", &["geometry", "model"]),
    ("services/plan", &["geometry", "model", "world"]),
    ("services/tls", &[]),
    ("services/files", &["proto"]),
    ("services/document", &["files"]),
    ("services/assets", &["geometry"]),
    ("services/record", &["files", "geometry", "model", "proto", "world"]),
    ("services/picture", &["geometry", "proto", "record"]),
    ("services/view", &["proto", "record"]),
    ("services/export", &["files", "geometry", "proto", "record"]),
    ("services/scene", &["assets", "document", "geometry", "model", "plan", "proto", "world"]),
    ("services/pool", &["dispatch", "document", "files", "geometry", "model", "proto"]),
    (
        "services/run",
        &["files", "geometry", "model", "plan", "pool", "proto", "record", "scene", "world"],
    ),
    (
        "services/lab",
        &[
            "document", "files", "geometry", "model", "picture", "pool", "proto", "record",
            "scene", "specimen",
        ],
    ),
    ("services/web", &["files", "proto"]),
    ("services/coordinator", &["files", "picture", "pool", "proto", "run", "scene", "web"]),
    (
        "services/worker",
        &[
            "dispatch",
            "fracture",
            "fragment",
            "geometric",
            "geometry",
            "membrane",
            "model",
            "peridynamics",
            "proto",
            "shell",
            "specimen",
        ],
    ),
    (
        "services/cullet",
        &[
            "coordinator",
            "document",
            "export",
            "files",
            "geometry",
            "model",
            "lab",
            "picture",
            "pool",
            "proto",
            "record",
            "run",
            "scene",
            "view",
            "web",
            "worker",
        ],
    ),
    // The facade alone, which has no name beyond `cullet`.
    ("services/python", &[]),
];

const PURE: &[&str] = &[
    "services/geometry",
    "services/simd",
    "services/model",
    "services/specimen",
    "services/fragment",
    "services/fracture",
    "services/shell",
    "services/peridynamics",
    "services/continuum",
    "services/membrane",
    "services/geometric",
    "services/world",
    "services/plan",
    "services/dispatch",
];

/// A library, and the only places that may name it.
const NAMED_ONLY_IN: &[(&str, &[&str])] = &[
    ("rapier3d_f64", &["services/world/src/rigid"]),
    ("parry3d_f64", &["services/world/src/rigid"]),
    ("manifold_rust", &["services/geometry/src/boolean"]),
    ("spade::", &["services/membrane/src/surface"]),
    ("bincode::", &["proto/src/codec.rs"]),
    ("zenoh::", &["services/pool/src", "services/worker/src/link"]),
    ("mcap::", &["services/record/src"]),
    ("hyper::", &["services/web/src"]),
    ("axum::", &["services/web/src"]),
    ("tungstenite::", &["services/web/src"]),
];

const MAX_LINE: usize = 100;
const MAX_FUNCTION: usize = 70;
const MAX_FILE: usize = 500;
const MAX_TRAIT_METHODS: usize = 4;

fn sources() -> Vec<(String, String)> {
    let root = root();
    files(&root, &[".rs"])
        .into_iter()
        .map(|path| {
            let text = fs::read_to_string(&path).expect("a source file is readable");
            let name = path.strip_prefix(&root).expect("below the root");
            (name.to_string_lossy().replace('\\', "/"), text)
        })
        .collect()
}

/// The part of a source file before its tests, without comments.
fn product(text: &str) -> String {
    let end = text.find("#[cfg(test)]").unwrap_or(text.len());
    text[..end]
        .lines()
        .map(|line| if line.trim_start().starts_with("//") { "" } else { line })
        .collect::<Vec<_>>()
        .join("\n")
}

fn manifest(folder: &str) -> toml::Table {
    let text = fs::read_to_string(root().join(folder).join("Cargo.toml")).expect("a manifest");
    text.parse().expect("a manifest parses")
}

#[test]
fn crates_depend_only_on_whom_they_may() {
    for (folder, allowed) in MAY_USE {
        let table = manifest(folder);
        let used: BTreeSet<&str> = table["dependencies"]
            .as_table()
            .expect("a dependency table")
            .keys()
            .filter_map(|name| name.strip_prefix("cullet-"))
            .collect();
        let allowed: BTreeSet<&str> = allowed.iter().copied().collect();
        let extra: Vec<_> = used.difference(&allowed).collect();
        assert!(extra.is_empty(), "{folder} must not depend on {extra:?}");
    }
}

#[test]
fn pure_crates_touch_nothing() {
    let banned = [
        "std::fs",
        "std::net",
        "std::time",
        "std::thread",
        "std::process",
        "std::env",
        "std::io",
        "println!",
        "eprintln!",
        "tracing::",
        "async fn",
        "HashMap",
        "HashSet",
        "serde",
        "mul_add(",
        "SystemTime",
        "Instant",
    ];
    let libm_names = ["sin", "cos", "tan", "exp", "ln", "powf", "cbrt", "atan2", "acos", "asin"];
    for (name, text) in sources() {
        let pure = PURE.iter().any(|pure| name.starts_with(&format!("{pure}/src")));
        if !pure || name.ends_with("/tests.rs") || name.contains("/tests/") {
            continue;
        }
        let code = without_wire(&product(&text));
        for word in banned {
            // There it is looked into by name, never walked through.
            if word == "HashMap" && name == "services/dispatch/src/by_name.rs" {
                continue;
            }
            assert!(!code.contains(word), "{name} is pure and must not use `{word}`");
        }
        for function in libm_names {
            let call = format!(".{function}(");
            assert!(
                !code.contains(&call),
                "{name}: `{call}` is the system's; use libm::{function}"
            );
        }
    }
    for folder in PURE {
        let table = manifest(folder);
        for heavy in ["serde", "tokio", "zenoh", "tracing", "mcap"] {
            let used = table["dependencies"].as_table().and_then(|t| t.get(heavy));
            let optional = |used: &toml::Value| used.get("optional") == Some(&true.into());
            let allowed = used.is_none_or(|used| heavy == "serde" && optional(used));
            assert!(allowed, "{folder} is pure and must not depend on {heavy}");
        }
    }
}

/// Code without what only the feature `wire` adds to types that cross the wire.
fn without_wire(code: &str) -> String {
    let wire = |line: &&str| line.trim_start().starts_with("#[cfg_attr(feature = \"wire\",");
    code.lines().filter(|line| !wire(line)).collect::<Vec<_>>().join("\n")
}

/// What is written and read of pure types is what crosses the wire: `proto` alone asks for it, and
/// the pure crates below that its types are made of.
#[test]
fn only_the_wire_turns_on_the_feature_wire() {
    for (folder, _) in MAY_USE {
        let table = manifest(folder);
        let asks = |value: &toml::Value| {
            let features = value.get("features").and_then(toml::Value::as_array);
            features.is_some_and(|all| all.contains(&"wire".into()))
        };
        for kind in ["dependencies", "dev-dependencies"] {
            let some = table.get(kind).and_then(toml::Value::as_table);
            let asking = some.into_iter().flatten().filter(|(_, value)| asks(value));
            let names: Vec<&String> = asking.map(|(name, _)| name).collect();
            assert!(*folder == "proto" || names.is_empty(), "{folder} turns on wire of {names:?}");
        }
    }
}

#[test]
fn what_the_wire_adds_is_told_from_the_rest() {
    let code = "#[cfg_attr(feature = \"wire\", derive(serde::Serialize))]\nstruct A;";
    assert_eq!(without_wire(code), "struct A;");
    let bare = "#[derive(serde::Serialize)]\nstruct A;";
    assert_eq!(without_wire(bare), bare);
}

/// `println!` and `eprintln!` panic where nobody reads them, and pass text of others on as it is:
/// `logs` and `exit` in `services/cullet/src` do neither.
#[test]
fn the_program_prints_in_one_place() {
    for (name, text) in sources() {
        let shipped = name.contains("/src/") && !name.starts_with("tests/");
        if !shipped || name.ends_with("/tests.rs") || name.contains("/tests/") {
            continue;
        }
        let code = product(&text);
        for word in ["print!(", "println!("] {
            assert!(!code.contains(word), "{name} prints by itself");
        }
    }
}

#[test]
fn a_library_is_named_where_it_lives() {
    for (name, text) in sources() {
        if name.starts_with("tests/") || name.contains("/benches/") || name.contains("/tests/") {
            continue;
        }
        let code = product(&text);
        for (library, places) in NAMED_ONLY_IN {
            let allowed = places.iter().any(|place| name.starts_with(place));
            assert!(allowed || !code.contains(library), "{name} names `{library}`");
        }
    }
}

#[test]
fn lines_and_files_stay_readable() {
    for (name, text) in sources() {
        let count = text.lines().count();
        assert!(
            count <= MAX_FILE,
            "{name} has {count} lines; is it two nouns? (at most {MAX_FILE})"
        );
        for (number, line) in text.lines().enumerate() {
            let width = line.chars().count();
            assert!(width <= MAX_LINE, "{name}:{} is {width} columns wide", number + 1);
        }
    }
}

/// Lengths of the functions of a formatted source file: from the `fn` line to the line that closes
/// at its indent.
fn functions(text: &str) -> Vec<(usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (start, line) in lines.iter().enumerate() {
        let code = line.trim_start();
        let indent = line.len() - code.len();
        let head = code.split('(').next().unwrap_or("");
        if !head.split_whitespace().any(|word| word == "fn") || code.starts_with("//") {
            continue;
        }
        let close = format!("{}}}", " ".repeat(indent));
        let body = lines[start..].iter().position(|l| *l == close);
        let ends_here = lines[start..].iter().position(|l| l.trim_end().ends_with(';'));
        match (body, ends_here) {
            (Some(end), semicolon)
                if lines[start..start + end].iter().any(|l| l.ends_with('{')) =>
            {
                let declared = semicolon.is_some_and(|s| {
                    s < end && !lines[start..=start + s].iter().any(|l| l.ends_with('{'))
                });
                if !declared {
                    found.push((start + 1, end + 1));
                }
            }
            _ => {}
        }
    }
    found
}

#[test]
fn functions_fit_on_a_screen() {
    for (name, text) in sources() {
        for (line, length) in functions(&text) {
            assert!(length <= MAX_FUNCTION, "{name}:{line} is a function of {length} lines");
        }
    }
}

#[test]
fn traits_are_small() {
    for (name, text) in sources() {
        let lines: Vec<&str> = text.lines().collect();
        for (start, line) in lines.iter().enumerate() {
            if !(line.starts_with("pub trait ") || line.starts_with("trait ")) {
                continue;
            }
            let end = lines[start..].iter().position(|l| *l == "}").unwrap_or(0);
            let methods =
                lines[start..start + end].iter().filter(|l| l.starts_with("    fn ")).count();
            assert!(methods <= MAX_TRAIT_METHODS, "{name}:{} has {methods} methods", start + 1);
        }
    }
}

#[test]
fn documents_name_real_paths() {
    let root = root();
    for document in ["README.md", "ARCHITECTURE.md", "GLOSSARY.md"] {
        let text = fs::read_to_string(root.join(document)).expect("a root document");
        for (index, quoted) in text.split('`').enumerate() {
            let looks_like_path = index % 2 == 1
                && quoted.contains('/')
                && !quoted.contains(|c: char| c.is_whitespace() || "<>$*{}…=:|".contains(c))
                && !quoted.starts_with('/')
                && !quoted.starts_with("runs/")
                && !quoted.starts_with("tcp/");
            if looks_like_path {
                assert!(exists(&root, quoted), "{document} names `{quoted}`, which is not there");
            }
        }
    }
    let lines = fs::read_to_string(root.join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    assert!(lines.lines().count() <= 300, "ARCHITECTURE.md is a bird's eye: at most 300 lines");
}

fn exists(root: &Path, path: &str) -> bool {
    let path = path.trim_end_matches('/');
    root.join(path).exists()
        || root.join("services").join(path).exists()
        || ["rs"].iter().any(|end| root.join("services").join(format!("{path}.{end}")).exists())
}

/// They show what a program that uses Cullet looks like, which depends on one crate.
#[test]
fn examples_are_short_and_use_the_facade_alone() {
    let all =
        sources().into_iter().filter(|(name, _)| name.starts_with("services/cullet/examples"));
    let all: Vec<_> = all.collect();
    assert!(all.len() >= 5, "{all:?}");
    for (name, text) in all {
        assert!(text.contains("use cullet::"), "{name} does not use the facade");
        assert!(!text.contains("cullet_"), "{name} uses a crate below the facade");
        assert!(text.lines().count() <= 60, "{name} is no short program");
    }
}

/// `just` is a convenience: whoever does not have it reads the same commands.
#[test]
fn the_justfile_calls_what_contributing_names() {
    let text = fs::read_to_string(root().join("justfile")).expect("a justfile");
    let page = fs::read_to_string(root().join("CONTRIBUTING.md")).expect("CONTRIBUTING.md");
    let calls = text.lines().filter_map(|line| line.strip_prefix("    "));
    let calls: Vec<&str> = calls.filter(|call| !call.starts_with('@')).collect();
    assert!(calls.len() >= 5, "{calls:?}");
    for call in calls {
        assert!(page.contains(&format!("`{call}`")), "CONTRIBUTING.md does not name `{call}`");
    }
}

#[test]
fn the_project_speaks_of_itself_alone() {
    let root = root();
    let banned = ["/root/", "/home/"];
    for path in files(&root, &[".rs", ".md", ".toml", ".py", ".json", "run"]) {
        if path.ends_with("tidy.rs") {
            continue;
        }
        let Ok(text) = fs::read_to_string(&path) else {
            continue;
        };
        for word in banned {
            assert!(!text.contains(word), "{} speaks of `{word}`", path.display());
        }
    }
}
