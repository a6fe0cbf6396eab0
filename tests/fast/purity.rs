//! What a pure crate may not touch, and where the program prints.

use crate::crates::manifests;
use crate::source::without_literals;
use crate::tree::{NamedText, assert_none, crate_of, planted, products};

/// Crates without a file, a socket, a clock, a thread or an order that changes.
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

/// What a pure crate does not name.
const BANNED: &[&str] = &[
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
/// Functions of numbers that the system answers, each in its way.
const OF_THE_SYSTEM: &[&str] =
    &["sin", "cos", "tan", "exp", "ln", "powf", "cbrt", "atan2", "acos", "asin"];

/// Code of pure crates that touches what it must not.
fn check_purity(products: &[NamedText]) -> Vec<String> {
    let mut faults = Vec::new();
    for (name, code) in products {
        if !crate_of(name).is_some_and(|folder| PURE.contains(&folder)) {
            continue;
        }
        let code = without_literals(&without_wire(code));
        for word in BANNED.iter().filter(|word| code.contains(**word)) {
            // There it is looked into by name, never walked through.
            if *word != "HashMap" || name != "services/dispatch/src/by_name.rs" {
                faults.push(format!("{name} is pure and must not use `{word}`"));
            }
        }
        for function in OF_THE_SYSTEM {
            let call = format!(".{function}(");
            if code.contains(&call) {
                faults.push(format!("{name}: `{call}` is the system's; use libm::{function}"));
            }
        }
    }
    faults
}

/// Pure crates that depend on what is not pure.
fn check_pure_manifests(manifests: &[(String, toml::Table)]) -> Vec<String> {
    let mut faults = Vec::new();
    for (folder, table) in manifests.iter().filter(|(name, _)| PURE.contains(&name.as_str())) {
        for heavy in ["serde", "tokio", "zenoh", "tracing", "mcap"] {
            let used = table.get("dependencies").and_then(|all| all.get(heavy));
            let optional = |used: &toml::Value| used.get("optional") == Some(&true.into());
            if !used.is_none_or(|used| heavy == "serde" && optional(used)) {
                faults.push(format!("{folder} is pure and must not depend on {heavy}"));
            }
        }
    }
    faults
}

/// Code without what only the feature `wire` adds to types that cross the wire.
fn without_wire(code: &str) -> String {
    let wire = |line: &&str| line.trim_start().starts_with("#[cfg_attr(feature = \"wire\",");
    code.lines().filter(|line| !wire(line)).collect::<Vec<_>>().join("\n")
}

/// Code that prints by itself.
fn check_prints(products: &[NamedText]) -> Vec<String> {
    let words = ["print!(", "println!(", "dbg!("];
    let prints = |code: &str| words.iter().any(|word| without_literals(code).contains(word));
    let faults = products.iter().filter(|(_, code)| prints(code));
    faults.map(|(name, _)| format!("{name} prints by itself")).collect()
}

#[test]
fn pure_crates_touch_nothing() {
    assert_none(&check_purity(products()));
    assert_none(&check_pure_manifests(&manifests()));
}

/// `println!` and `eprintln!` panic where nobody reads them, and pass text of others on as it is:
/// `logs` and `exit` in `services/cullet/src` do neither.
#[test]
fn the_program_prints_in_one_place() {
    assert_none(&check_prints(products()));
}

#[test]
fn what_the_wire_adds_is_told_from_the_rest() {
    let code = "#[cfg_attr(feature = \"wire\", derive(serde::Serialize))]\nstruct A;";
    assert_eq!(without_wire(code), "struct A;");
    let bare = "#[derive(serde::Serialize)]\nstruct A;";
    assert_eq!(without_wire(bare), bare);
}

#[test]
fn impure_code_is_found() {
    for word in BANNED {
        let text = format!("fn f() {{ {word} }}");
        let said = check_purity(&planted([("services/world/src/a.rs", &text)]));
        assert!(said.iter().any(|line| line.contains(&format!("`{word}`"))), "{said:?}");
        assert_eq!(check_purity(&planted([("services/run/src/a.rs", &text)])), [""; 0]);
    }
    let said = check_purity(&planted([("services/world/src/a.rs", "fn f() { x.sin() }")]));
    assert_eq!(said, ["services/world/src/a.rs: `.sin(` is the system's; use libm::sin"]);
    let known = planted([("services/dispatch/src/by_name.rs", "use std::collections::HashMap;")]);
    assert_eq!(check_purity(&known), [""; 0]);
    let text = planted([("services/world/src/a.rs", "const NAME: &str = \"std::fs\";")]);
    assert_eq!(check_purity(&text), [""; 0], "a word in a string is no use");
    let manifest = "[dependencies]\nserde = { optional = true }\ntokio = {}".parse().expect("TOML");
    let said = check_pure_manifests(&[("services/world".to_owned(), manifest)]);
    assert_eq!(said, ["services/world is pure and must not depend on tokio"]);
}

#[test]
fn prints_are_found() {
    let files = planted([
        ("a.rs", "fn f() { eprintln!(\"\"); }"),
        ("b.rs", "fn f() { print!(\"\"); }"),
        ("c.rs", "fn f() { g(\"println!(\"); }"),
        ("d.rs", "fn f() { dbg!(g()); }"),
    ]);
    assert_eq!(
        check_prints(&files),
        ["a.rs", "b.rs", "d.rs"].map(|name| format!("{name} prints by itself"))
    );
}
