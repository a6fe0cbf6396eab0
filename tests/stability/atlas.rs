//! `docs/failures.md` has an item for each mode, whose first test is in this suite, or of a sheet
//! next to the code, named after the mode, and has been seen to fail; each test that it cites
//! exists.

use cullet_tests::root;
use std::fs;

fn table() -> String {
    fs::read_to_string(root().join("docs/failures.md")).expect("the table")
}

/// The modes that can touch what is here. Those of sheets from F79 on have an m: shells have the
/// same numbers.
fn modes() -> impl Iterator<Item = String> {
    let shells = [60, 63, 64, 65, 68, 69, 71, 72, 96, 97, 99, 100];
    let shells = shells.into_iter().chain(79..=82).chain(84..=87);
    let plain = (1..=59).chain(73..=78).chain(shells).map(|mode: u32| format!("F{mode:02}"));
    let sheets = (79..=96).filter(|&mode| mode != 90).map(|mode: u32| format!("F{mode}m"));
    plain.chain(sheets)
}

/// Where the minimal reproduction of a mode is: that of a sheet's is next to the code.
fn suite(mode: &str) -> &'static str {
    let sheets = mode.ends_with('m') || (53..=59).any(|number| mode == format!("F{number}"));
    if sheets { "services/" } else { "tests/stability/" }
}

/// The items of a mode: from its head to the next head or heading.
fn items<'a>(table: &'a str, mode: &str) -> Vec<&'a str> {
    let start = format!("- **{mode} ");
    let heads = table.match_indices(&start).filter(|(at, _)| table[..*at].ends_with('\n'));
    heads
        .map(|(at, _)| {
            let rest = &table[at..];
            let end = rest[1..].find("\n- **").unwrap_or(rest.len() - 1);
            let end = end.min(rest.find("\n#").unwrap_or(rest.len()));
            &rest[..end]
        })
        .collect()
}

/// What an item says under a label.
fn entry<'a>(item: &'a str, label: &str) -> &'a str {
    let start = format!("\n  - {label}: ");
    let Some((_, rest)) = item.split_once(&start) else { return "" };
    rest.split("\n  - ").next().unwrap_or_default().trim()
}

#[test]
fn every_mode_has_an_item_and_a_test() {
    let table = table();
    for name in modes() {
        let items = items(&table, &name);
        assert_eq!(items.len(), 1, "{name} has {} items", items.len());
        for label in ["Symptom", "Detector", "Remedy", "Test"] {
            let text = entry(items[0], label);
            assert!(
                !["", "–.", "-.", "none."].contains(&text),
                "{name} has no {label}: {}",
                items[0]
            );
        }
        let (path, test) = *cited(entry(items[0], "Test")).first().expect("a test");
        assert!(path.starts_with(suite(&name)), "{name}: {path}");
        assert!(test.starts_with(&format!("{}_", name.to_lowercase())), "{name}: {test}");
    }
}

/// The tests that a text cites, by path and name.
fn cited(text: &str) -> Vec<(&str, &str)> {
    let words = text.split('`').skip(1).step_by(2).filter(|word| !word.contains(' '));
    words.filter_map(|word| word.split_once("::")).collect()
}

#[test]
fn the_first_test_of_every_mode_has_been_seen_to_fail() {
    let table = table();
    let (modes, seen) = table.split_once("\n## Tests, ").expect("both tables");
    let seen = cited(seen);
    for mode in self::modes() {
        let item = items(modes, &mode)[0];
        let first = cited(entry(item, "Test")).first().copied().expect("a test");
        assert!(seen.contains(&first), "{first:?}");
    }
}

#[test]
fn every_test_that_is_cited_exists() {
    let table = table();
    let cited = cited(&table);
    assert!(cited.len() > modes().count(), "{} tests are cited", cited.len());
    for (path, name) in cited {
        let text = fs::read_to_string(root().join(path)).unwrap_or_default();
        assert!(!text.is_empty(), "{path} is not there");
        let head = format!("fn {name}(");
        let at = text.find(&head).unwrap_or_else(|| panic!("{path} has no {name}"));
        let before = text[..at].trim_end().trim_end_matches("#[ignore = \"long\"]").trim_end();
        let before = before.lines().next_back().unwrap_or_default();
        assert!(before.contains("#[test]"), "{path}: {name} is no test: {before}");
    }
}
