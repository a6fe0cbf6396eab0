//! `docs/failures.md` has a row for each mode, whose first test is in this suite, named after the
//! mode, and has been seen to fail; each test that it cites exists.

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
        assert!(!["–", "-", "none"].contains(&cells[2].trim()), "F{mode:02} has no detector");
        let (path, name) = *cited(rows[0]).first().expect("a test");
        assert!(path.starts_with("tests/stability/"), "F{mode:02}: {path}");
        assert!(name.starts_with(&format!("f{mode:02}_")), "F{mode:02}: {name}");
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
    for row in modes.lines().filter(|line| line.starts_with("| F")) {
        let first = cited(row).first().copied().expect("a test");
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
        let before = text[..at].trim_end().lines().next_back().unwrap_or_default();
        assert!(before.contains("#[test]"), "{path}: {name} is no test: {before}");
    }
}
