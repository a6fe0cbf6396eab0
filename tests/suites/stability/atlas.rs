//! `docs/failures.md` has a row for each mode, each test that it cites exists, and one of each mode
//! has been seen to fail.

use cullet_tests::root;
use std::fs;

fn table() -> String {
    fs::read_to_string(root().join("docs/failures.md")).expect("the table")
}

/// The modes that can touch what is here.
fn modes() -> impl Iterator<Item = u32> {
    (1..=43).chain(73..=78)
}

#[test]
fn every_mode_has_a_row_and_a_test() {
    let table = table();
    for mode in modes() {
        let start = format!("| F{mode:02} ");
        let rows: Vec<&str> = table.lines().filter(|line| line.starts_with(&start)).collect();
        assert_eq!(rows.len(), 1, "F{mode:02} has {} rows", rows.len());
        let cells: Vec<&str> = rows[0].trim_matches('|').split(" | ").collect();
        assert_eq!(cells.len(), 5, "F{mode:02}: {cells:?}");
        assert!(cells.iter().all(|cell| !cell.trim().is_empty()), "F{mode:02}: {cells:?}");
        assert!(cells[4].contains("::"), "F{mode:02} cites no test");
    }
}

/// The tests that a text cites, by path and name.
fn cited(text: &str) -> Vec<(&str, &str)> {
    let words = text.split('`').skip(1).step_by(2).filter(|word| !word.contains(' '));
    words.filter_map(|word| word.split_once("::")).collect()
}

/// What no small test holds.
const WHOLE_RUNS: [&str; 1] = ["F78"];

#[test]
fn one_test_of_every_mode_has_been_seen_to_fail() {
    let table = table();
    let (modes, seen) = table.split_once("\n## Tests, ").expect("both tables");
    let seen = cited(seen);
    for row in modes.lines().filter(|line| line.starts_with("| F")) {
        let mode = &row[2..5];
        let known = cited(row).iter().any(|test| seen.contains(test));
        assert!(known != WHOLE_RUNS.contains(&mode), "{mode}: {known}");
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
        let before = text[..at].trim_end().lines().next_back().unwrap_or_default();
        assert!(before.contains("#[test]"), "{path}: {name} is no test: {before}");
    }
}
