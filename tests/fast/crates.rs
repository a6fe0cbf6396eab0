//! Which crate may depend on which, and where a heavy library is named.

use crate::tree::{NamedText, assert_none, planted, products, read, sources};
use cullet_tests::house::MAY_USE;

/// A library, and the only places that may name it.
const NAMED_ONLY_IN: &[(&str, &[&str])] = &[
    ("rapier3d_f64", &["services/world/src/rigid"]),
    ("parry3d_f64", &["services/world/src/rigid"]),
    ("manifold_rust", &["services/geometry/src/boolean"]),
    ("spade::", &["services/geometry/src/polygon.rs", "services/membrane/src/surface"]),
    ("bincode::", &["proto/src/codec.rs"]),
    ("zenoh::", &["services/pool/src", "services/worker/src/link"]),
    ("mcap::", &["services/record/src"]),
    ("noto_sans_mono_bitmap", &["services/picture/src/letters.rs"]),
    ("hyper::", &["services/web/src"]),
    ("axum::", &["services/web/src"]),
    ("tungstenite::", &["services/web/src"]),
    // Commands write through `cullet_files::output`, which spares recordings. Others write files of
    // their own: recordings, what is fetched and served, logs, knobs of the system.
    ("fs::write(", &["services/cullet/src/doctor.rs", "services/worker/src/job.rs"]),
    ("fs::copy(", &[]),
    (
        "File::create",
        &[
            "services/files/src/claim.rs",
            "services/files/src/output.rs",
            "services/lab/src/process.rs",
            "services/pool/src/client.rs",
            "services/record/src",
            "services/web/src/reports.rs",
        ],
    ),
];

/// The folders of crates, and their manifests.
pub(crate) fn manifests() -> Vec<(String, toml::Table)> {
    let texts = read(&["Cargo.toml"]);
    let named = texts.into_iter().map(|(name, text)| {
        let folder = name.trim_end_matches("Cargo.toml").trim_end_matches('/');
        (folder.to_owned(), text.parse().expect("a manifest parses"))
    });
    named.filter(|(folder, _)| folder == "proto" || folder.starts_with("services/")).collect()
}

/// Crates that use what the table does not allow, or are not in it, and rows of no crate.
fn check_dependencies(manifests: &[(String, toml::Table)]) -> Vec<String> {
    let there = |folder: &str| manifests.iter().any(|(name, _)| name == folder);
    let gone = MAY_USE.iter().filter(|(folder, _)| !there(folder));
    let mut faults: Vec<String> = gone
        .map(|(folder, _)| format!("there is no {folder}: take its row out of MAY_USE"))
        .collect();
    for (folder, table) in manifests {
        let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| name == folder) else {
            faults.push(format!("MAY_USE has no row for {folder}"));
            continue;
        };
        let used = table.get("dependencies").and_then(toml::Value::as_table);
        let names = used.into_iter().flatten().filter_map(|(name, _)| name.strip_prefix("cullet-"));
        let extra = names.filter(|name| !allowed.contains(name));
        faults.extend(extra.map(|name| format!("{folder} must not depend on {name}")));
    }
    faults
}

/// Crates beside `proto` that turn on the feature `wire` of others.
fn check_wire(manifests: &[(String, toml::Table)]) -> Vec<String> {
    let asks = |value: &toml::Value| {
        let features = value.get("features").and_then(toml::Value::as_array);
        features.is_some_and(|all| all.contains(&"wire".into()))
    };
    let mut faults = Vec::new();
    for (folder, table) in manifests.iter().filter(|(folder, _)| folder != "proto") {
        for kind in ["dependencies", "dev-dependencies"] {
            let some = table.get(kind).and_then(toml::Value::as_table);
            let asking = some.into_iter().flatten().filter(|(_, value)| asks(value));
            faults.extend(asking.map(|(name, _)| format!("{folder} turns on wire of {name}")));
        }
    }
    faults
}

/// Code that names a library elsewhere than where it lives.
fn check_libraries(products: &[NamedText]) -> Vec<String> {
    let mut faults = Vec::new();
    for (name, code) in products {
        for (library, places) in NAMED_ONLY_IN {
            let allowed = places.iter().any(|place| name.starts_with(place));
            if !allowed && code.contains(library) {
                faults.push(format!("{name} names `{library}`"));
            }
        }
    }
    faults
}

/// Examples that use more than the facade, or are long.
fn check_examples(examples: &[NamedText]) -> Vec<String> {
    let mut faults = Vec::new();
    for (name, text) in examples {
        let wrong = [
            (!text.contains("use cullet::"), "does not use the facade"),
            (text.contains("cullet_"), "uses a crate below the facade"),
            (text.lines().count() > 60, "is no short program"),
        ];
        faults.extend(wrong.iter().filter(|(is, _)| *is).map(|(_, what)| format!("{name} {what}")));
    }
    faults
}

#[test]
fn crates_depend_only_on_whom_they_may() {
    assert_none(&check_dependencies(&manifests()));
}

/// What is written and read of pure types is what crosses the wire: `proto` alone asks for it, and
/// the pure crates below that its types are made of.
#[test]
fn only_the_wire_turns_on_the_feature_wire() {
    assert_none(&check_wire(&manifests()));
}

#[test]
fn a_library_is_named_where_it_lives() {
    assert_none(&check_libraries(products()));
}

/// They show what a program that uses Cullet looks like, which depends on one crate.
#[test]
fn examples_are_short_and_use_the_facade_alone() {
    let all = sources().iter().filter(|(name, _)| name.starts_with("services/cullet/examples"));
    let all: Vec<NamedText> = all.cloned().collect();
    assert!(all.len() >= 5, "{all:?}");
    assert_none(&check_examples(&all));
}

#[test]
fn dependencies_that_are_not_allowed_are_found() {
    let manifest = |folder: &str, text: &str| (folder.to_owned(), text.parse().expect("TOML"));
    let manifests = [
        manifest(
            "services/world",
            "[dependencies]\ncullet-model = {}\ncullet-proto = {}\nlibm = {}",
        ),
        manifest("services/new", "[dependencies]"),
    ];
    let said = ["services/world must not depend on proto", "MAY_USE has no row for services/new"];
    let found = check_dependencies(&manifests);
    assert_eq!(found[MAY_USE.len() - 1..], said);
    assert!(found[0].starts_with("there is no proto: "), "{found:?}");
    let asks = "[dependencies.cullet-model]\nfeatures = [\"wire\"]";
    let tests = "[dev-dependencies.cullet-model]\nfeatures = [\"wire\"]";
    let manifests = [manifest("services/world", asks), manifest("proto", asks)];
    assert_eq!(check_wire(&manifests), ["services/world turns on wire of cullet-model"]);
    assert_eq!(check_wire(&[manifest("services/run", tests)]).len(), 1);
}

#[test]
fn libraries_and_examples_out_of_place_are_found() {
    let files = planted([
        ("services/run/src/lib.rs", "fn f() { zenoh::open(); }"),
        ("services/pool/src/net.rs", "fn f() { zenoh::open(); }"),
    ]);
    assert_eq!(check_libraries(&files), ["services/run/src/lib.rs names `zenoh::`"]);
    let long = format!("use cullet::Scene;{}", "\n".repeat(61));
    let files =
        planted([("a.rs", "use cullet_run::run;"), ("b.rs", &long), ("c.rs", "use cullet::A;")]);
    let said = [
        "a.rs does not use the facade",
        "a.rs uses a crate below the facade",
        "b.rs is no short program",
    ];
    assert_eq!(check_examples(&files), said);
}
